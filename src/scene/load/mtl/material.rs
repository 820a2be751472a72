//! The material of an entry of a material library (MTL).
//!
//! A material is converted by the first rule that applies:
//! - `Tf 1` without metal is glass: a dielectric of index `Ni`, tinted by `Kd`, as exported by Blender for transmission.
//!   Other exporters write `Tf 1 1 1` for opaque materials: without `Pr`, only `illum` 6 or 7 (refraction) makes glass;
//! - `Pr 1` without metal is diffuse. The faint sheen of Blender's model in that case is ignored. Materials without
//!   `Pr` whose `illum` is 0 or 1 (no highlights), or whose `Ks` is black, are diffuse, too;
//! - all others use the principled model with `Kd`, `Pm`, `Pr`, `Ni` and `Tf`.
//!
//! `Ke` makes the shape emit on the side of its geometric normal. `map_Kd` replaces `Kd`; `map_Ke` is multiplied by
//! `Ke`, and `map_d` by `d`, the opacity.
//!
//! Measure: reflectances in [0, 1], radiance for `Ke`.
//! Range: an index below 1 counts as 1 except in glass. Textures that are missing or of another format are left out, with a
//! note.
//! Source: Blender's exporter, `export_pbr_extensions`; without `Pr`, roughness = 1 - sqrt(Ns / 1000) as Blender
//! imports it, and 1 without `Ns`. Tested below and in `tests/loading/scene_files.rs`.

use super::{BUMPS, MtlMaterial};
use crate::error::{Error, Result};
use crate::geometry::texture::Texture;
use crate::image::ColourSpace;
use crate::math::rgb::Rgb;
use crate::scene::description::{
    ClearCoatDescription, ColourDescription, MaterialDescription, MaterialModel,
    NormalMapDescription, Note, NoteKind, Place,
};
use crate::scene::load::colour::TextureCache;
use crate::scene::load::wording::shown;
use std::path::Path;
use std::sync::Arc;

/// Extensions of images that no reader here decodes.
const OTHER_FORMATS: [&str; 9] = [
    "basis", "dds", "gif", "ktx", "ktx2", "psd", "tif", "tiff", "webp",
];

impl MtlMaterial {
    /// Returns notes on images that do not exist or are of a format that is not read, and are left out.
    pub fn omitted_images(&self) -> impl Iterator<Item = Note> {
        let omitted = self.pictures.iter().filter_map(|(key, (file, line))| {
            let reason = omission(file)?;
            Some((key, file, line, reason))
        });
        omitted.map(|(key, file, line, reason)| {
            let place = Place {
                line: Some(*line),
                ..self.place.clone()
            };
            let file = shown(&file.display().to_string());
            let text = format!("{key}: the image {file} is {reason}; left out");
            Note::at(place, NoteKind::Omission, text)
        })
    }

    /// Returns the emission of shapes of this material. A `map_Ke` without `Ke` is the radiance itself.
    ///
    /// # Errors
    /// If a texture cannot be read.
    pub fn emission(&self, textures: &mut TextureCache) -> Result<Option<ColourDescription>> {
        let read = |file: &Path| textures.read(file, ColourSpace::Srgb, 1.0);
        let Some(texture) = self.picture("map_Ke", read)? else {
            let constant = ColourDescription::Constant(self.emission);
            return Ok((!self.emission.is_black()).then_some(constant));
        };
        let factor = if self.emission.is_black() {
            Rgb::WHITE
        } else {
            self.emission
        };
        let texture = Arc::new(multiplied(texture, factor));
        Ok(Some(ColourDescription::Texture(texture)))
    }

    /// Returns the material, with its textures read.
    ///
    /// # Errors
    /// If a texture cannot be read, or glass has no refractive index.
    pub fn material(&self, textures: &mut TextureCache) -> Result<MaterialDescription> {
        let read = |file: &Path| textures.read_reflectance(file, ColourSpace::Srgb, 1.0);
        let base_color = self.picture("map_Kd", read)?;
        // Some programs write a transparency of 1 for opaque materials.
        let of_transparency = 1.0 - self.transparency % 1.0;
        let opacity = self.opacity.unwrap_or(of_transparency);
        let read = |file: &Path| match textures.read_alpha(file, opacity)? {
            Some(alpha) => Ok(alpha),
            None => textures.read_reflectance(file, ColourSpace::Linear, opacity),
        };
        let alpha = self.picture("map_d", read)?;
        let read = |file: &Path| textures.read(file, ColourSpace::Linear, 1.0);
        let normals = match self.picture("norm", read)? {
            Some(normals) => Some(normals),
            None => {
                let read = |file: &Path| textures.read(file, ColourSpace::Linear, 1.0);
                self.picture(BUMPS, read)?.filter(has_normals)
            }
        };

        let or_constant = |texture: Option<Texture>, constant| match texture {
            Some(texture) => ColourDescription::Texture(Arc::new(texture)),
            None => ColourDescription::Constant(constant),
        };
        let model = self.model(or_constant(base_color, self.diffuse))?;
        Ok(MaterialDescription {
            alpha: or_constant(alpha, Rgb::grey(opacity)),
            normal_map: normals.map(|texture| NormalMapDescription {
                texture: Arc::new(texture),
                strength: self.bump_strength,
                is_right_handed: false,
            }),
            clear_coat: self.clear_coat(&model),
            ..MaterialDescription::new(&self.name, self.place.clone(), model)
        })
    }

    /// Returns a note if the heights of the material are left out: their unit is not known.
    ///
    /// # Errors
    /// If the texture cannot be read.
    pub fn omitted_heights(&self, textures: &mut TextureCache) -> Result<Option<Note>> {
        let read = |file: &Path| textures.read(file, ColourSpace::Linear, 1.0);
        let is_used = self.pictures.contains_key("norm");
        let heights = self.picture(BUMPS, read)?;
        if heights.is_none_or(|it| has_normals(&it)) || is_used {
            return Ok(None);
        }
        let place = Place {
            line: self.pictures.get(BUMPS).map(|(_, line)| *line),
            ..self.place.clone()
        };
        let text = "map_Bump has heights, of no unit; left out: a scene file may have a bump_map";
        Ok(Some(Note::at(place, NoteKind::Omission, text)))
    }

    /// Returns the clear coat, if there is a base for it.
    fn clear_coat(&self, model: &MaterialModel) -> Option<ClearCoatDescription> {
        let [weight, roughness] = self.coat;
        (weight > 0.0 && model.takes_clear_coat()).then_some(ClearCoatDescription {
            weight,
            roughness,
            ior: 1.5,
        })
    }

    /// Returns the texture of a key, if it has one.
    fn picture(
        &self,
        key: &'static str,
        read: impl FnOnce(&Path) -> Result<Texture>,
    ) -> Result<Option<Texture>> {
        let Some((file, line)) = self
            .pictures
            .get(key)
            .filter(|(file, _)| omission(file).is_none())
        else {
            return Ok(None);
        };
        read(file).map(Some).map_err(|error| {
            let kind = error.kind();
            let error = Error::scene(error.to_string()).of_kind(kind);
            error.in_file(&self.place.file).at_line(*line).in_field(key)
        })
    }

    /// Returns the scattering model by the rules at the head of this file.
    fn model(&self, base_color: ColourDescription) -> Result<MaterialModel> {
        let Self {
            ior,
            metallic,
            illumination,
            ..
        } = *self;
        let from_shininess = 1.0 - (self.shininess / 1000.0).min(1.0).sqrt();
        let roughness = self.roughness.unwrap_or(from_shininess);
        let refracts = self.roughness.is_some() && self.transmission.is_some();
        let transmission = if refracts || matches!(illumination, Some(6 | 7)) {
            self.transmission.unwrap_or(1.0)
        } else {
            0.0
        };
        let no_highlights = self.roughness.is_none()
            && (self.has_no_highlights || matches!(illumination, Some(0 | 1)));
        let matte = no_highlights || roughness == 1.0;

        Ok(if metallic == 0.0 && transmission == 1.0 {
            if ior == 0.0 {
                let error = Error::scene("glass needs a refractive index `Ni` above 0");
                return Err(error
                    .in_file(&self.place.file)
                    .at_line(self.place.line.unwrap_or(1)));
            }
            MaterialModel::Dielectric {
                ior,
                roughness,
                tint: base_color,
            }
        } else if metallic == 0.0 && transmission == 0.0 && matte {
            MaterialModel::Diffuse {
                reflectance: base_color,
            }
        } else {
            MaterialModel::Principled {
                base_color,
                metallic,
                roughness,
                ior: ior.max(1.0),
                transmission,
            }
        })
    }
}

/// Multiplies a texture by a colour; the scale of a texture itself is grey.
fn multiplied(texture: Texture, factor: Rgb) -> Texture {
    let [grey, ..] = factor.to_array();
    match texture {
        Texture::Image { image, scale } if factor == Rgb::grey(grey) => Texture::Image {
            image,
            scale: scale * grey,
        },
        Texture::Image { image, scale } => Texture::Image {
            image: Arc::new(image.map(|texel| factor * texel)),
            scale,
        },
        Texture::Placed {
            image,
            tint,
            uv_map,
        } => Texture::Placed {
            image,
            tint: factor * tint,
            uv_map,
        },
        Texture::Checker { colours, repeat } => Texture::Checker {
            colours: colours.map(|colour| factor * colour),
            repeat,
        },
    }
}

/// Whether an image is one of normals, which on the mean point away from the surface, and not of heights, which are grey.
fn has_normals(texture: &Texture) -> bool {
    let [x, y, z] = texture.mean().to_array().map(|c| 2.0 * c - 1.0);
    z > 0.3 && z > x.abs() + 0.2 && z > y.abs() + 0.2
}

/// The reason why an image is left out, if it is.
fn omission(file: &Path) -> Option<&'static str> {
    let extension = file.extension().unwrap_or_default().to_ascii_lowercase();
    if !file.is_file() {
        Some("missing")
    } else if OTHER_FORMATS.iter().any(|&other| extension == other) {
        Some("of a format that is not read")
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(lines: &str) -> MaterialModel {
        let mut entry = MtlMaterial::new("m", Path::new("m.mtl"), 1);
        for line in lines.split(';') {
            let (key, rest) = line.trim().split_once(' ').expect("a key and its value");
            entry.set(key, rest, 2).expect(line);
        }
        entry
            .model(ColourDescription::Constant(entry.diffuse))
            .expect(lines)
    }

    #[test]
    fn blender_transmission_is_dielectric_but_tf_alone_is_not() {
        for glass in [
            "Tf 1 1 1;Pr 0;Ni 1.5",
            "illum 7;Ni 1.5;Ns 1000",
            "illum 6;Tf 1;Ni 1.5;Ns 1000",
        ] {
            assert!(
                matches!(
                    model(glass),
                    MaterialModel::Dielectric {
                        ior: 1.5,
                        roughness: 0.0,
                        ..
                    }
                ),
                "{glass}"
            );
        }
        assert!(matches!(
            model("Tf 1 1 1;illum 2"),
            MaterialModel::Diffuse { .. }
        ));
        assert!(matches!(
            model("Tf .25 .25 .25;Pr 0.5;Ni 0"),
            MaterialModel::Principled {
                transmission: 0.25,
                ior: 1.0,
                ..
            }
        ));
    }

    #[test]
    fn rough_non_metals_and_those_without_highlights_are_diffuse() {
        for matte in [
            "Pr 1",
            "Kd 1 1 1",
            "Ns 0",
            "Ns 900;illum 1",
            "Ns 900;illum 2;Ks 0 0 0",
        ] {
            assert!(
                matches!(model(matte), MaterialModel::Diffuse { .. }),
                "{matte}"
            );
        }
        assert!(matches!(
            model("Ns 250;illum 2"),
            MaterialModel::Principled {
                roughness: 0.5,
                metallic: 0.0,
                ..
            }
        ));
        assert!(matches!(
            model("Pr 1;Pm 1"),
            MaterialModel::Principled {
                roughness: 1.0,
                metallic: 1.0,
                ..
            }
        ));
    }
}
