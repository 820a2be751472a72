//! Reads the material libraries (MTL) of OBJ files, including Blender's physically based keys.
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
//! Range: an index below 1 counts as 1 except in glass. Keys without meaning here (`Ka`, `Ps`, ...) are ignored;
//! missing and unsupported textures and unknown keys are reported in a note.
//! Source: Blender's exporter, `export_pbr_extensions`; without `Pr`, roughness = 1 - sqrt(Ns / 1000) as Blender
//! imports it, and 1 without `Ns`. Tested in `tests/loading/scene_files.rs`.

mod values;

use super::colour::Textures;
use super::contents::Contents;
use super::wording::{shown, unknown_name};
use super::{beside, read_any_text};
use crate::error::{Error, Result};
use crate::geometry::texture::Texture;
use crate::image::{ColourSpace, Image};
use crate::math::rgb::Rgb;
use crate::scene::description::{
    ColourDescription, MaterialDescription, MaterialModel, NormalMapDescription, Note, NoteKind,
    Place,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use values::{colour, number, split_options};

/// Supported keys.
const READ: &[&str] = &[
    "newmtl", "Kd", "Ke", "Ks", "Ni", "Ns", "d", "Tf", "illum", "map_Kd", "map_Ke", "map_d",
    "norm", "Pr", "Pm", "Tr",
];

/// Supported keys whose values are textures.
const PICTURES: &[&str] = &["map_Kd", "map_Ke", "map_d", "norm"];

/// Known keys that are ignored.
const PASSED_OVER: &[&str] = &[
    "Ka",
    "Ps",
    "Pc",
    "Pcr",
    "aniso",
    "anisor",
    "sharpness",
    "map_aat",
];

/// Known textures that are not supported.
const NOT_DRAWN: &[&str] = &[
    "map_Ka", "map_Ks", "map_Ns", "map_Pr", "map_Pm", "map_Ps", "map_Tr", "map_Bump", "map_bump",
    "bump", "disp", "decal", "refl",
];

/// A material as written in the library.
#[derive(Debug)]
pub struct Entry {
    name: String,
    place: Place,
    diffuse: Rgb,
    /// The texture files by key, with their lines.
    pictures: BTreeMap<&'static str, (PathBuf, usize)>,
    opacity: Option<f32>,
    /// 1 - opacity by `Tr`, which counts without an opacity.
    transparency: f32,
    emission: Rgb,
    ior: f32,
    transmission: Option<f32>,
    metallic: f32,
    roughness: Option<f32>,
    shininess: f32,
    /// Whether `Ks` is black.
    has_no_highlights: bool,
    illumination: Option<u32>,
}

/// Reads a library and adds its materials to `known`, by name.
///
/// # Errors
/// If a line is invalid.
pub fn read(
    path: &Path,
    known: &mut BTreeMap<String, Entry>,
    contents: &mut Contents,
) -> Result<()> {
    let text = read_any_text(path)?;
    let mut current: Option<Entry> = None;
    for (line, content) in (1..).zip(text.lines()) {
        let mut words = content.split_whitespace();
        let Some(key) = words.next().filter(|key| !key.starts_with('#')) else {
            continue;
        };
        let rest = content.trim_start()[key.len()..].trim();
        let at = |error: Error| error.in_file(path).at_line(line).in_field(shown(key));
        if key == "newmtl" {
            if rest.is_empty() {
                return Err(at(Error::scene("expected a name")));
            }
            let next = Entry::new(rest, path, line);
            known.extend(
                current
                    .replace(next)
                    .map(|entry| (entry.name.clone(), entry)),
            );
            continue;
        }
        let Some(entry) = &mut current else {
            return Err(at(Error::scene("expected newmtl first")));
        };
        if let Some(note) = entry.set(key, rest, line).map_err(at)? {
            let place = Place {
                file: path.to_path_buf(),
                line: Some(line),
            };
            contents.note(Note::at(place, NoteKind::Omission, note));
        }
    }
    known.extend(current.map(|entry| (entry.name.clone(), entry)));
    Ok(())
}

impl Entry {
    fn new(name: &str, path: &Path, line: usize) -> Self {
        Self {
            name: name.to_owned(),
            place: Place {
                file: path.to_path_buf(),
                line: Some(line),
            },
            diffuse: Rgb::grey(0.8),
            pictures: BTreeMap::new(),
            opacity: None,
            transparency: 0.0,
            emission: Rgb::BLACK,
            ior: 1.5,
            transmission: None,
            metallic: 0.0,
            roughness: None,
            shininess: 0.0,
            has_no_highlights: false,
            illumination: None,
        }
    }

    /// Reads one line; returns a note for the user, if any.
    fn set(&mut self, key: &str, rest: &str, line: usize) -> Result<Option<String>> {
        let mut note = None;
        match key {
            "Kd" => self.diffuse = colour(rest, 1.0)?,
            "Ke" => self.emission = colour(rest, f32::MAX)?,
            "Ni" => self.ior = number(rest, f32::MAX)?,
            "Ns" => self.shininess = number(rest, f32::MAX)?,
            "Tf" => self.transmission = Some(colour(rest, 1.0)?.max_channel()),
            "Pr" => self.roughness = Some(number(rest, 1.0)?),
            "Pm" => self.metallic = number(rest, 1.0)?,
            // Other values than black have no meaning here, so that they may be of any kind.
            "Ks" => self.has_no_highlights = colour(rest, f32::MAX).is_ok_and(Rgb::is_black),
            "illum" => {
                let model = rest.parse();
                let expected =
                    |_| Error::scene(format!("expected a whole number, found {}", shown(rest)));
                self.illumination = Some(model.map_err(expected)?);
            }
            "d" => self.opacity = Some(number(rest, 1.0)?),
            "Tr" => self.transparency = number(rest, 1.0)?,
            _ if PASSED_OVER.contains(&key) => {}
            _ if NOT_DRAWN.contains(&key) => {
                note = Some(format!("{key} is not supported by this version; left out"));
            }
            _ => {
                let Some(picture) = PICTURES.iter().find(|picture| **picture == key) else {
                    return Ok(Some(unknown_name("key", key, READ)));
                };
                let (options, file) = split_options(rest);
                if file.is_empty() {
                    return Ok(Some("an image without a file; left out".to_owned()));
                }
                let path = found(&self.place.file, file);
                if !options.is_empty() {
                    note = Some(format!(
                        "the options {} of an image are not supported",
                        shown(options)
                    ));
                }
                self.pictures.insert(picture, (path, line));
            }
        }
        Ok(note)
    }

    /// Returns notes on images that do not exist, and are left out.
    pub fn missing_images(&self) -> impl Iterator<Item = Note> {
        let missing = self
            .pictures
            .iter()
            .filter(|(_, (file, _))| !file.is_file());
        missing.map(|(key, (file, line))| {
            let place = Place {
                line: Some(*line),
                ..self.place.clone()
            };
            let file = shown(&file.display().to_string());
            let text = format!("{key}: the image {file} is missing; left out");
            Note::at(place, NoteKind::Omission, text)
        })
    }

    /// Returns the emission of shapes of this material. A `map_Ke` without `Ke` is the radiance itself.
    ///
    /// # Errors
    /// If a texture cannot be read.
    pub fn emission(&self, textures: &mut Textures) -> Result<Option<ColourDescription>> {
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
    pub fn material(&self, textures: &mut Textures) -> Result<MaterialDescription> {
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
        let normals = self.picture("norm", read)?;

        let or_constant = |texture: Option<Texture>, constant| match texture {
            Some(texture) => ColourDescription::Texture(Arc::new(texture)),
            None => ColourDescription::Constant(constant),
        };
        let model = self.model(or_constant(base_color, self.diffuse))?;
        Ok(MaterialDescription {
            alpha: or_constant(alpha, Rgb::grey(opacity)),
            normal_map: normals.map(|texture| NormalMapDescription {
                texture: Arc::new(texture),
                strength: 1.0,
            }),
            ..MaterialDescription::new(&self.name, self.place.clone(), model)
        })
    }

    /// Returns the texture of a key, if it has one.
    fn picture(
        &self,
        key: &'static str,
        read: impl FnOnce(&Path) -> Result<Texture>,
    ) -> Result<Option<Texture>> {
        let Some((file, line)) = self.pictures.get(key).filter(|(file, _)| file.is_file()) else {
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

/// The file of an image: of this name, or else of its last part, since libraries name folders of the computer that they
/// were written on.
fn found(library: &Path, name: &str) -> PathBuf {
    let written = beside(library, name);
    let last = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let near = beside(library, last);
    if !written.is_file() && near.is_file() {
        near
    } else {
        written
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
        Texture::Image { image, scale } => {
            let pixels = image.pixels().iter().map(|&texel| factor * texel);
            let image = Image::new(image.width(), image.height(), pixels.collect());
            Texture::Image {
                image: Arc::new(image),
                scale,
            }
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn model(lines: &str) -> MaterialModel {
        let mut entry = Entry::new("m", Path::new("m.mtl"), 1);
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

    #[test]
    fn invalid_values_are_rejected() {
        let mut entry = Entry::new("m", Path::new("m.mtl"), 1);
        for (key, rest) in [
            ("Kd", "1 1"),
            ("Kd", "1 1 1 1"),
            ("Kd", "2 0 0"),
            ("Kd", "x 0 0"),
            ("Kd", ""),
            ("Ke", "-1 0 0"),
            ("Ke", "1e39 0 0"),
            ("Ke", "nan 0 0"),
            ("Ni", "inf"),
            ("Pr", "1.5"),
            ("d", ""),
            ("illum", "2.5"),
        ] {
            assert!(entry.set(key, rest, 2).is_err(), "{key} {rest}");
        }
    }
}
