//! The principled bsdf of a Mitsuba scene as the principled material of glTF, and the model of Phong.
//!
//! Measure: parameters without unit.
//! Range: shares from 0 to 1, `eta` from 1 to 100; others are errors.
//! Source: Mitsuba 3 documentation, "BSDFs". Tested in `tests/loading/mitsuba.rs`.

use super::BsdfReader;
use crate::error::Result;
use crate::scene::description::{
    ClearCoatDescription, MaterialDescription, MaterialModel, NoteKind,
};
use crate::scene::load::mitsuba::object::XmlObject;

impl BsdfReader<'_> {
    pub(super) fn principled(
        &mut self,
        bsdf: &XmlObject,
        made: &mut MaterialDescription,
    ) -> Result<()> {
        let mut share = |name: &str, default: f64| -> Result<f32> {
            Ok(self.share(bsdf, name, default)? as f32)
        };
        let (metallic, roughness) = (share("metallic", 0.0)?, share("roughness", 0.5)?);
        let (transmission, specular) = (share("spec_trans", 0.0)?, share("specular", 0.5)?);
        let (coat, gloss) = (share("clearcoat", 0.0)?, share("clearcoat_gloss", 0.0)?);
        let mut lobes = vec!["sheen", "anisotropic", "spec_tint", "flatness"];
        if bsdf.get("sheen").is_none() {
            lobes.push("sheen_tint");
        }
        bsdf.note_unless_zero(&lobes, self.contents);
        let ior = match bsdf.number("eta")? {
            Some(eta) if (1.0..=100.0).contains(&eta) => eta as f32,
            Some(_) => return Err(bsdf.error_at("eta", "expected a number from 1 to 100")),
            // The reflectance at normal incidence is 0.08 times `specular`.
            None => {
                let root = (0.08 * specular).sqrt();
                (1.0 + root) / (1.0 - root)
            }
        };
        self.note(
            bsdf,
            NoteKind::Approximation,
            "replaced by the principled model of glTF",
        );
        if coat > 0.0 && transmission == 0.0 {
            // A quarter of the lobe, whose alpha is from 0.1 to 0.001.
            let alpha = 0.1 + gloss * (0.001 - 0.1);
            made.clear_coat = Some(ClearCoatDescription {
                weight: 0.25 * coat,
                roughness: alpha.sqrt(),
                ior: 1.5,
            });
        }
        made.model = MaterialModel::Principled {
            base_color: self.reflectance(bsdf, "base_color", 0.5)?,
            metallic,
            roughness,
            ior,
            transmission,
        };
        Ok(())
    }

    /// The model of Phong, of versions before 2.
    pub(super) fn phong(&mut self, bsdf: &XmlObject, made: &mut MaterialDescription) -> Result<()> {
        let diffuse = self.reflectance(bsdf, "diffuse_reflectance", 0.5)?;
        let specular = self.reflectance(bsdf, "specular_reflectance", 0.2)?;
        if (diffuse.brightest() + specular.brightest()).max_channel() > 1.0 {
            return Err(bsdf.error("expected reflectances of at most 1 together in every channel"));
        }
        let is_exponent = |x: f64| (0.0..=1e6).contains(&x);
        let exponent =
            bsdf.number_where("exponent", 30.0, "a number from 0 to 1e6", is_exponent)? as f32;
        made.model = MaterialModel::Phong {
            diffuse,
            specular,
            exponent,
        };
        Ok(())
    }
}
