//! Materials of glTF: metallic-roughness becomes our principled model, which is the same; emission goes to the shapes.
//!
//! Measure: linear Rec. 709. The radiance of an emissive surface is `emissiveFactor` times `emissiveStrength`, in
//! W m^-2 sr^-1, as Blender reads it.
//! Range: factors outside of [0, 1] are clamped. Both sides scatter; one side emits unless `doubleSided` is set.
//! Transmission refracts, as in Blender, but by thin sheets (`thin.rs`). All textures of a material have the same texture
//! coordinates; one with others is replaced by its mean.
//! Source: glTF 2.0, chapter 3.9 and appendix B, and the extensions KHR_materials_*. Tested in
//! `tests/loading/gltf.rs`.

use super::buffers::Asset;
use super::material_textures::MaterialTextures;
use super::texture::{ImageCache, ImageUse, TextureReference};
use super::thin::sheet;
use crate::error::Result;
use crate::geometry::texture::Texture;
use crate::math::rgb::Rgb;
use crate::scene::description::{
    ClearCoatDescription, ColourDescription, MaterialDescription, MaterialModel,
    NormalMapDescription, Note, NoteKind, Place,
};
use gltf::Material;
use gltf::material::{AlphaMode, PbrSpecularGlossiness};
use std::sync::Arc;

/// A material as shapes need it.
#[derive(Debug, Clone)]
pub struct GltfMaterial {
    pub material: MaterialDescription,
    pub emission: Option<ColourDescription>,
    pub two_sided_emission: bool,
}

/// The colour of a surface's vertices: a factor of the base colour, or the base colour itself.
#[derive(Debug, Clone)]
pub struct VertexColour {
    pub factor: Rgb,
    pub alpha: f32,
    /// Replaces the base colour of a material without textures.
    pub texture: Option<ColourDescription>,
}

/// The largest reflectance at normal incidence that is taken for that of a dielectric.
const MAX_DIELECTRIC: f32 = 0.2;

/// Returns the factor of the base colour, and of alpha.
pub fn base_color_factor(material: &Material<'_>) -> [f32; 4] {
    match material.pbr_specular_glossiness() {
        Some(surface) => surface.diffuse_factor(),
        None => material.pbr_metallic_roughness().base_color_factor(),
    }
}

/// Reads one material.
pub struct MaterialReader<'a> {
    pub asset: &'a Asset<'a>,
    pub images: &'a mut ImageCache,
    pub material: &'a Material<'a>,
    pub textures: &'a MaterialTextures,
    /// Whether what the material transmits passes through a sheet.
    pub is_thin: bool,
    pub notes: &'a mut Vec<Note>,
}

impl MaterialReader<'_> {
    /// Returns the material of surfaces with this colour of vertices.
    ///
    /// # Errors
    /// If an image cannot be read, or an emission is not a finite colour of at least 0.
    pub fn surface(&mut self, vertices: &VertexColour) -> Result<GltfMaterial> {
        let base_color = match &vertices.texture {
            Some(texture) => texture.clone(),
            None => self.base_color(vertices.factor)?,
        };
        let unlit = self.material.unlit();
        let model = if unlit {
            self.note(
                NoteKind::Approximation,
                "is unlit: drawn as a lamp whose radiance is its colour, which lights its surroundings, too",
            );
            MaterialModel::Diffuse {
                reflectance: Rgb::BLACK.into(),
            }
        } else {
            let model = self.principled(base_color.clone())?;
            if self.is_thin {
                self.thin(model)
            } else {
                model
            }
        };
        let clear_coat = if unlit { None } else { self.clear_coat(&model) };
        let mut material = MaterialDescription {
            clear_coat,
            metallic_roughness_map: if unlit {
                None
            } else {
                self.metallic_roughness()?
            },
            normal_map: self.normals()?,
            ..MaterialDescription::new(self.name(), self.place(), model)
        };
        self.alpha(vertices.alpha, &mut material)?;
        Ok(GltfMaterial {
            material,
            emission: if unlit {
                Some(base_color)
            } else {
                self.emission()?
            },
            two_sided_emission: unlit || self.material.double_sided(),
        })
    }

    fn base_color(&mut self, factor: Rgb) -> Result<ColourDescription> {
        let [r, g, b, _] = base_color_factor(self.material);
        let tint = factor * Rgb::new(r, g, b).map(share);
        let texture = self.varying(&self.textures.base_color, ImageUse::Srgb, tint)?;
        Ok(texture.unwrap_or(ColourDescription::Constant(tint)))
    }

    fn principled(&mut self, base_color: ColourDescription) -> Result<MaterialModel> {
        if let Some(surface) = self.material.pbr_specular_glossiness() {
            return Ok(self.specular_glossiness(&surface, base_color));
        }
        let pbr = self.material.pbr_metallic_roughness();
        let ior = self.material.ior().unwrap_or(1.5);
        if ior < 1.0 || !ior.is_finite() {
            let text = format!("has the refractive index {ior}: drawn with 1");
            self.note(NoteKind::Approximation, &text);
        }
        Ok(MaterialModel::Principled {
            base_color,
            metallic: share(pbr.metallic_factor()),
            roughness: share(pbr.roughness_factor()),
            ior: if ior.is_finite() { ior.max(1.0) } else { 1.0 },
            transmission: self.transmission()?,
        })
    }

    /// Returns the model of KHR_materials_pbrSpecularGlossiness: a dielectric whose index has the specular reflectance, or
    /// metal where that is above any dielectric's.
    fn specular_glossiness(
        &mut self,
        surface: &PbrSpecularGlossiness<'_>,
        base_color: ColourDescription,
    ) -> MaterialModel {
        if surface.specular_glossiness_texture().is_some() {
            self.note(
                NoteKind::Approximation,
                "has a texture of specular colour and glossiness: the factors alone are used",
            );
        }
        let specular = Rgb::from(surface.specular_factor().map(share));
        let reflectance = specular.max_channel();
        let is_metal = reflectance > MAX_DIELECTRIC;
        let root = reflectance.sqrt();
        MaterialModel::Principled {
            base_color: if is_metal {
                specular.into()
            } else {
                base_color
            },
            metallic: f32::from(u8::from(is_metal)),
            roughness: 1.0 - share(surface.glossiness_factor()),
            ior: if is_metal {
                1.5
            } else {
                (1.0 + root) / (1.0 - root)
            },
            transmission: 0.0,
        }
    }

    /// Returns the clear coat, if it covers anything and there is a base for it.
    fn clear_coat(&mut self, model: &MaterialModel) -> Option<ClearCoatDescription> {
        let extension = self.material.extension_value("KHR_materials_clearcoat")?;
        let factor = |key: &str| {
            let factor = extension.get(key).and_then(|it| it.as_f64());
            share(factor.unwrap_or(0.0) as f32)
        };
        let coat = ClearCoatDescription {
            weight: factor("clearcoatFactor"),
            roughness: factor("clearcoatRoughnessFactor"),
            ior: 1.5,
        };
        if coat.weight == 0.0 {
            return None;
        }
        let textures = [
            "clearcoatTexture",
            "clearcoatRoughnessTexture",
            "clearcoatNormalTexture",
        ];
        if textures.iter().any(|key| extension.get(key).is_some()) {
            self.note(
                NoteKind::Approximation,
                "has textures of its clear coat, which are left out",
            );
        }
        let is_opaque = model.takes_clear_coat();
        if !is_opaque {
            self.note(
                NoteKind::Omission,
                "transmits light under a clear coat, which is left out",
            );
        }
        is_opaque.then_some(coat)
    }

    /// Returns the model of a sheet, or with a note that of solid glass.
    fn thin(&mut self, model: MaterialModel) -> MaterialModel {
        let is_mapped = self.textures.metallic_roughness.is_some();
        if let Some(sheet) = sheet(&model).filter(|_| !is_mapped) {
            return sheet;
        }
        self.note(
            NoteKind::Approximation,
            "transmits without a volume, which means a thin sheet: drawn as the surface of solid glass",
        );
        model
    }

    fn transmission(&mut self) -> Result<f32> {
        let Some(transmission) = self.material.transmission() else {
            return Ok(0.0);
        };
        let factor = share(transmission.transmission_factor());
        let Some(reference) = &self.textures.transmission else {
            return Ok(factor);
        };
        let tint = Rgb::grey(factor);
        let texture = self
            .images
            .texture(self.asset, reference, ImageUse::Linear, tint)?;
        let Some(texture) = texture else {
            return Ok(factor);
        };
        if let Some(constant) = texture.constant() {
            return Ok(share(constant.to_array()[0]));
        }
        self.note(
            NoteKind::Approximation,
            "has a texture of its transmission: the mean is used",
        );
        Ok(share(texture.mean().to_array()[0]))
    }

    fn metallic_roughness(&mut self) -> Result<Option<Arc<Texture>>> {
        let reference = &self.textures.metallic_roughness;
        let texture = self.varying(reference, ImageUse::Linear, Rgb::WHITE)?;
        Ok(match texture {
            Some(ColourDescription::Texture(texture)) => Some(texture),
            // Both parameters are constant: a map of one colour.
            Some(ColourDescription::Constant(factors)) => Some(Arc::new(Texture::Checker {
                colours: [factors; 2],
                repeat: crate::math::vec::Vec2::ONE,
            })),
            None => None,
        })
    }

    fn normals(&mut self) -> Result<Option<NormalMapDescription>> {
        let Some(normals) = self.material.normal_texture() else {
            return Ok(None);
        };
        let strength = normals.scale();
        if !strength.is_finite() {
            let message = format!("expected a finite scale, found {strength}");
            return Err(self.error("normalTexture", &message));
        }
        let texture = self.varying(&self.textures.normals, ImageUse::Linear, Rgb::WHITE)?;
        Ok(match texture {
            Some(ColourDescription::Texture(texture)) => Some(NormalMapDescription {
                texture,
                strength,
                is_right_handed: false,
            }),
            // The mean of normals is hardly tilted.
            _ => None,
        })
    }

    fn alpha(&mut self, of_vertices: f32, material: &mut MaterialDescription) -> Result<()> {
        let mode = self.material.alpha_mode();
        if mode == AlphaMode::Opaque {
            return Ok(());
        }
        let [.., factor] = base_color_factor(self.material);
        let tint = Rgb::grey(share(factor) * share(of_vertices));
        let texture = self.varying(&self.textures.base_color, ImageUse::Alpha, tint)?;
        material.alpha = texture.unwrap_or(ColourDescription::Constant(tint));
        if mode == AlphaMode::Mask {
            material.alpha_cutoff = Some(share(self.material.alpha_cutoff().unwrap_or(0.5)));
        }
        Ok(())
    }

    fn emission(&mut self) -> Result<Option<ColourDescription>> {
        let strength = self.material.emissive_strength().unwrap_or(1.0);
        let factor = Rgb::from(self.material.emissive_factor().map(|x| x * strength));
        let channels = factor.to_array();
        if !channels.iter().all(|x| *x >= 0.0 && x.is_finite()) {
            let message = format!("expected an emission of at least 0, found {channels:?}");
            return Err(self.error("emissiveFactor", &message));
        }
        if factor.is_black() {
            return Ok(None);
        }
        let texture = self.varying(&self.textures.emission, ImageUse::Srgb, factor)?;
        Ok(
            Some(texture.unwrap_or(ColourDescription::Constant(factor)))
                .filter(|it| !it.is_black()),
        )
    }

    /// Returns a texture, or its mean if it has other texture coordinates than the material's others.
    fn varying(
        &mut self,
        reference: &Option<TextureReference>,
        channels: ImageUse,
        tint: Rgb,
    ) -> Result<Option<ColourDescription>> {
        let Some(reference) = reference else {
            return Ok(None);
        };
        let Some(texture) = self.images.texture(self.asset, reference, channels, tint)? else {
            if channels != ImageUse::Alpha {
                self.note(
                    NoteKind::Omission,
                    "has a texture without an image of a format that is read",
                );
            }
            return Ok(None);
        };
        let is_constant = texture.constant().is_some();
        if reference.uv_set == self.textures.uv_set() || is_constant {
            if reference.is_nearest && !is_constant {
                self.note(
                    NoteKind::Approximation,
                    "has a texture whose sampler asks for the nearest texel: lookups are bilinear",
                );
            }
            return Ok(Some(ColourDescription::Texture(Arc::new(texture))));
        }
        self.note(
            NoteKind::Approximation,
            "has textures of several texture coordinates: the mean is used for those of other coordinates than the first",
        );
        Ok(Some(ColourDescription::Constant(texture.mean())))
    }

    fn name(&self) -> String {
        let index = self.material.index();
        let unnamed = || index.map_or("default".to_owned(), |index| format!("material {index}"));
        self.material.name().map_or_else(unnamed, str::to_owned)
    }

    fn place(&self) -> Place {
        Place::of_file(self.asset.path)
    }

    fn error(&self, key: &str, message: &str) -> crate::Error {
        let index = self.material.index().unwrap_or_default();
        self.asset
            .error(format!("materials[{index}].{key}"), message)
    }

    fn note(&mut self, kind: NoteKind, text: &str) {
        let text = format!(
            "material `{}` {text}",
            super::super::wording::shown(&self.name())
        );
        let note = Note::at(self.place(), kind, text);
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }
}

/// Clamps to [0, 1].
fn share(x: f32) -> f32 {
    // `max` makes 0 of a NaN.
    x.max(0.0).clamp(0.0, 1.0)
}
