//! Materials of a pbrt file.
//!
//! Measure: as in the description.
//! Range: every class of material of pbrt-v4. What differs here is noted.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt/materials.rs`.

use super::library::Library;
use super::params::Parameters;
use super::textured::{Mapping, Textured};
use crate::error::Result;
use crate::geometry::texture::Texture;
use crate::image::ColourSpace;
use crate::math::rgb::Rgb;
use crate::scene::description::{
    BumpMapDescription, ColourDescription, MaterialDescription, MaterialModel, NormalMapDescription,
};
use crate::scene::load::wording::unknown_name;
use std::collections::HashMap;
use std::sync::Arc;

/// A material as shapes refer to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PbrtMaterial {
    /// No surface: the border between two media.
    Interface,
    /// A material, by its index, and what its textures change of texture coordinates.
    Surface { index: usize, mapping: Mapping },
}

/// Materials with opacity, by the material without it and the opacity.
pub type AlphaMaterials = HashMap<(usize, String), usize>;

const CLASSES: &[&str] = &[
    "coatedconductor",
    "coateddiffuse",
    "conductor",
    "dielectric",
    "diffuse",
    "diffusetransmission",
    "hair",
    "interface",
    "measured",
    "mix",
    "subsurface",
    "thindielectric",
];

impl Library {
    /// Reads the parameters of a material of this class, and adds it under a name for messages.
    ///
    /// # Errors
    /// If a parameter is not as the class requires.
    pub fn make_material(
        &mut self,
        class: &str,
        name: &str,
        params: &Parameters,
        named: &HashMap<String, PbrtMaterial>,
    ) -> Result<PbrtMaterial> {
        let (mut mapping, mut clear_coat) = (None, None);
        let model = match class {
            "interface" | "none" | "" => {
                self.note_unused(params);
                return Ok(PbrtMaterial::Interface);
            }
            "mix" => return self.mix_materials(params, named),
            "diffuse" => MaterialModel::Diffuse {
                reflectance: self.textured(params, "reflectance", 0.5, &mut mapping)?,
            },
            "coateddiffuse" => self.coated_diffuse(params, &mut mapping)?,
            "conductor" => self.conductor(params, "", &mut mapping)?,
            "coatedconductor" => {
                let (metal, coat) = self.coated_conductor(params, &mut mapping)?;
                clear_coat = Some(coat);
                metal
            }
            "dielectric" => MaterialModel::Dielectric {
                ior: self.ior(params, "eta")?,
                roughness: self.roughness(params, "")?,
                tint: Rgb::WHITE.into(),
            },
            "thindielectric" => self.thin_dielectric(params)?,
            "diffusetransmission" => self.diffuse_transmission(params, &mut mapping)?,
            "subsurface" => self.subsurface(params, &mut mapping)?,
            "hair" | "measured" => {
                let what =
                    format!("material class `{class}` became diffuse with a reflectance of 0.5");
                self.approximated(&params.place, what);
                return Ok(self.add(name, params, grey(0.5), None));
            }
            _ => return Err(params.error(unknown_name("material class", class, CLASSES))),
        };
        let heights = self.heights(params, &mut mapping)?;
        let made = self.add(name, params, model, mapping);
        if let PbrtMaterial::Surface { index, .. } = made {
            self.contents.materials[index].clear_coat = clear_coat;
        }
        if let (Some(file), PbrtMaterial::Surface { index, .. }) = (params.text("normalmap")?, made)
        {
            let path = self.path(file);
            let texture = self.contents.textures.read(&path, ColourSpace::Linear, 1.0);
            let texture = texture.map_err(|error| self.about(params, "normalmap", &error))?;
            self.contents.materials[index].normal_map = Some(NormalMapDescription {
                texture: Arc::new(texture),
                strength: 1.0,
                is_right_handed: false,
            });
        } else if let (Some(texture), PbrtMaterial::Surface { index, .. }) = (heights, made) {
            let height = 1.0;
            self.contents.materials[index].bump_map = Some(BumpMapDescription { texture, height });
        }
        self.note_unused(params);
        Ok(made)
    }

    /// The texture of heights of a material, which pbrt uses where it has no map of normals. Sets the material's mapping, or
    /// notes that another texture has set it.
    fn heights(
        &mut self,
        params: &Parameters,
        mapping: &mut Option<Mapping>,
    ) -> Result<Option<Arc<Texture>>> {
        const NAME: &str = "displacement";
        let heights = self.float(params, NAME, 0.0)?;
        let ColourDescription::Texture(texture) = heights.colour else {
            return Ok(None);
        };
        if params.has("normalmap") {
            let what = "displacement was left out beside a normal map";
            self.omitted(&params.place_of(NAME), what);
        } else if *mapping.get_or_insert(heights.mapping) != heights.mapping {
            let what = "displacement has the mapping of the material's other texture";
            self.approximated(&params.place_of(NAME), what);
        }
        Ok(Some(texture))
    }

    fn add(
        &mut self,
        name: &str,
        params: &Parameters,
        model: MaterialModel,
        mapping: Option<Mapping>,
    ) -> PbrtMaterial {
        let description = MaterialDescription::new(name, params.place.clone(), model);
        PbrtMaterial::Surface {
            index: self.contents.add_material(description),
            mapping: mapping.unwrap_or_default(),
        }
    }

    /// A reflectance; sets the material's mapping to that of its texture.
    pub fn textured(
        &mut self,
        params: &Parameters,
        name: &str,
        default: f32,
        mapping: &mut Option<Mapping>,
    ) -> Result<ColourDescription> {
        let textured = self.reflectance(params, name, default)?;
        if textured.colour.constant().is_none() {
            *mapping = Some(textured.mapping);
        }
        Ok(textured.colour)
    }

    /// One of two materials by the share of each, or their mean if both are diffuse.
    fn mix_materials(
        &mut self,
        params: &Parameters,
        named: &HashMap<String, PbrtMaterial>,
    ) -> Result<PbrtMaterial> {
        let names = params.texts("materials")?;
        let [first, second] = names else {
            return Err(params.error_of("materials", "expected the names of two materials"));
        };
        let find = |name: &String| match named.get(name) {
            Some(PbrtMaterial::Surface { index, mapping }) => Ok((*index, *mapping)),
            Some(PbrtMaterial::Interface) => {
                Err(params.error_of("materials", "an interface cannot be mixed"))
            }
            None => {
                let mut names: Vec<&str> = named.keys().map(String::as_str).collect();
                names.sort_unstable();
                Err(params.error_of("materials", unknown_name("material", name, &names)))
            }
        };
        let (first, second) = (find(first)?, find(second)?);
        let amount = self.float(params, "amount", 0.5)?;
        let share = amount.mean().to_array()[0].clamp(0.0, 1.0);
        self.note_unused(params);
        if let (Some(a), Some(b), Some(_)) = (
            self.diffuse(first.0),
            self.diffuse(second.0),
            amount.colour.constant(),
        ) {
            let model = MaterialModel::Diffuse {
                reflectance: a.lerp(b, share).into(),
            };
            return Ok(self.add("mix", params, model, None));
        }
        let (index, mapping) = if share < 0.5 { first } else { second };
        let name = &self.contents.materials[index].name;
        let what = format!("a mix of materials became the one with the greater share, `{name}`");
        self.approximated(&params.place, what);
        Ok(PbrtMaterial::Surface { index, mapping })
    }

    /// The reflectance of a material that is diffuse, of one colour, and has no normal map.
    fn diffuse(&self, index: usize) -> Option<Rgb> {
        let material = &self.contents.materials[index];
        match &material.model {
            MaterialModel::Diffuse { reflectance }
                if material.normal_map.is_none() && material.bump_map.is_none() =>
            {
                reflectance.constant()
            }
            _ => None,
        }
    }

    /// The material with this opacity: a new one unless it is opaque or was asked for before.
    pub fn with_alpha(&mut self, index: usize, alpha: &Textured) -> usize {
        let mut material = self.contents.materials[index].clone();
        material.alpha = alpha.clone().clamped().colour;
        self.contents.add_material(material)
    }
}

/// A diffuse material.
fn grey(reflectance: f32) -> MaterialModel {
    MaterialModel::Diffuse {
        reflectance: Rgb::grey(reflectance).into(),
    }
}
