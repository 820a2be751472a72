//! The bsdfs of a Mitsuba scene as materials.
//!
//! Measure: reflectances without unit; Mitsuba's alpha is that of the microfacets, the square of our roughness.
//! Range: every bsdf of the documentation becomes the nearest material, with a note where the models differ; an unknown
//! type is an error.
//! Source: Mitsuba 3 documentation, "BSDFs". Tested in `tests/loading/mitsuba.rs` and by `scripts/against-mitsuba.py`.

mod conductor;
mod dielectric;
mod parameters;
mod principled;
mod wrappers;

use super::object::XmlObject;
use crate::error::Result;
use crate::math::rgb::Rgb;
use crate::math::vec::DAffine2;
use crate::scene::description::{MaterialDescription, MaterialModel, NoteKind};
use crate::scene::load::contents::SceneContents;
use crate::scene::load::wording::unknown_name;

/// A material, and the transform of texture coordinates that its textures require of the shape.
#[derive(Debug, Clone)]
pub struct MitsubaMaterial {
    pub material: usize,
    /// `None` if nothing in the material is textured.
    pub to_uv: Option<DAffine2>,
    /// Whether the surface is invisible.
    pub is_null: bool,
}

/// Reads a bsdf and adds its material.
///
/// # Errors
/// If the bsdf or a nested one is invalid.
pub fn material(bsdf: &XmlObject, contents: &mut SceneContents) -> Result<MitsubaMaterial> {
    let mut reader = BsdfReader {
        contents,
        to_uv: None,
    };
    let mut made = MaterialDescription {
        two_sided: false,
        ..MaterialDescription::new(
            bsdf.name.clone(),
            bsdf.place.clone(),
            reader.diffuse_grey(0.5),
        )
    };
    reader.read(bsdf, &mut made)?;
    if made.transmits() {
        made.two_sided = true;
    }
    Ok(MitsubaMaterial {
        to_uv: reader.to_uv,
        material: contents.add_material(made),
        is_null: bsdf.kind == "null",
    })
}

/// The types that are read.
const KNOWN: &[&str] = &[
    "diffuse",
    "dielectric",
    "thindielectric",
    "roughdielectric",
    "conductor",
    "roughconductor",
    "plastic",
    "roughplastic",
    "principled",
    "twosided",
    "mask",
    "normalmap",
    "bumpmap",
    "blendbsdf",
    "null",
    // Of versions before 2.
    "roughdiffuse",
    "phong",
    "coating",
    "roughcoating",
];

/// The BSDFs that have no counterpart.
const REPLACED: &[&str] = &[
    "hair",
    "measured",
    "measured_polarized",
    "pplastic",
    "principledthin",
    "circular",
    "polarizer",
    "retarder",
    // Of versions before 2.
    "ward",
    "difftrans",
    "hk",
    "irawan",
];

/// A bsdf and those nested in it as they are read.
struct BsdfReader<'a> {
    contents: &'a mut SceneContents,
    to_uv: Option<DAffine2>,
}

impl BsdfReader<'_> {
    fn diffuse_grey(&self, grey: f32) -> MaterialModel {
        MaterialModel::Diffuse {
            reflectance: Rgb::grey(grey).into(),
        }
    }

    fn read(&mut self, bsdf: &XmlObject, made: &mut MaterialDescription) -> Result<()> {
        match bsdf.kind.as_str() {
            "diffuse" | "roughdiffuse" => {
                if bsdf.kind == "roughdiffuse" {
                    self.share(bsdf, "alpha", 0.2)?;
                    let text = "its roughness is left out: it is diffuse";
                    self.note(bsdf, NoteKind::Approximation, text);
                }
                made.model = MaterialModel::Diffuse {
                    reflectance: self.reflectance(bsdf, "reflectance", 0.5)?,
                };
            }
            "dielectric" | "roughdielectric" | "thindielectric" => self.dielectric(bsdf, made)?,
            "conductor" | "roughconductor" => self.conductor(bsdf, made)?,
            "plastic" | "roughplastic" => self.plastic(bsdf, made)?,
            "principled" => self.principled(bsdf, made)?,
            "phong" => self.phong(bsdf, made)?,
            "coating" | "roughcoating" => self.coating(bsdf, made)?,
            "twosided" => self.two_sided(bsdf, made)?,
            "mask" => self.mask(bsdf, made)?,
            "normalmap" => self.normal_mapped(bsdf, made)?,
            "bumpmap" => self.bump_mapped(bsdf, made)?,
            "blendbsdf" => self.blend(bsdf, made)?,
            "null" => made.alpha = Rgb::BLACK.into(),
            other if REPLACED.contains(&other) => {
                self.note(
                    bsdf,
                    NoteKind::Approximation,
                    "not supported: replaced by diffuse grey",
                );
                return Ok(());
            }
            other => {
                return Err(bsdf.error(&unknown_name("bsdf", other, &[KNOWN, REPLACED].concat())));
            }
        }
        bsdf.note_unused(&["sample_visible", "nonlinear"], self.contents);
        Ok(())
    }

    fn note(&mut self, bsdf: &XmlObject, kind: NoteKind, text: &str) {
        self.contents.note(bsdf.note(kind, text));
    }
}
