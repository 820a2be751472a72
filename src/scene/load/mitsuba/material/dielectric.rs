//! The dielectrics and plastics of a Mitsuba scene as materials.
//!
//! Measure: refractive indices of the inside relative to the outside.
//! Range: the names of Mitsuba's media, or indices from 0.01 to 100; others are errors.
//! Source: Mitsuba 3 documentation, "BSDFs". Tested in `tests/loading/mitsuba.rs`.

use super::BsdfReader;
use crate::error::Result;
use crate::scene::description::{MaterialDescription, MaterialModel, NoteKind};
use crate::scene::load::mitsuba::metals;
use crate::scene::load::mitsuba::object::{Value, XmlObject};
use crate::scene::load::wording::unknown_name;

impl BsdfReader<'_> {
    pub(super) fn dielectric(
        &mut self,
        bsdf: &XmlObject,
        made: &mut MaterialDescription,
    ) -> Result<()> {
        self.factor(bsdf, "specular_reflectance")?;
        let ior = self.ior(bsdf, "bk7")?;
        let tint = self.reflectance(bsdf, "specular_transmittance", 1.0)?;
        made.model = match bsdf.kind.as_str() {
            "thindielectric" => MaterialModel::ThinDielectric { ior, tint },
            _ => MaterialModel::Dielectric {
                ior,
                roughness: self.roughness(bsdf)?,
                tint,
            },
        };
        Ok(())
    }

    pub(super) fn plastic(
        &mut self,
        bsdf: &XmlObject,
        made: &mut MaterialDescription,
    ) -> Result<()> {
        self.factor(bsdf, "specular_reflectance")?;
        let ior = self.ior(bsdf, "polypropylene")?;
        if ior < 1.0 {
            return Err(bsdf.error_at("int_ior", "expected an index above that outside"));
        }
        let text = "our plastic compensates the energy between coat and base in another way";
        self.note(bsdf, NoteKind::Approximation, text);
        made.model = MaterialModel::Plastic {
            reflectance: self.reflectance(bsdf, "diffuse_reflectance", 0.5)?,
            ior,
            roughness: self.roughness(bsdf)?,
        };
        Ok(())
    }

    pub(super) fn ior(&self, bsdf: &XmlObject, inside: &str) -> Result<f32> {
        let index = |name: &str, default: &str| -> Result<f64> {
            let index = match bsdf.get(name).map(|property| &property.value) {
                None => metals::medium(default),
                Some(Value::Number(number)) => Some(*number),
                Some(Value::Text(text)) => Some(metals::medium(text).ok_or_else(|| {
                    let known: Vec<&str> = metals::MEDIA.iter().map(|(name, _)| *name).collect();
                    bsdf.error_at(name, &unknown_name("medium", text, &known))
                })?),
                Some(_) => None,
            };
            let in_range = |n: &f64| (0.01..=100.0).contains(n);
            index
                .filter(in_range)
                .ok_or_else(|| bsdf.error_at(name, "expected a refractive index from 0.01 to 100"))
        };
        Ok((index("int_ior", inside)? / index("ext_ior", "air")?) as f32)
    }
}
