//! The metals of a Mitsuba scene as materials.
//!
//! Measure: refractive indices relative to vacuum, per channel of linear Rec. 709.
//! Range: the names of Mitsuba's metals, or indices of at least 0.
//! Source: Mitsuba 3 documentation, "BSDFs". Tested in `tests/loading/mitsuba.rs` and
//! `tests/loading/mitsuba_spectra.rs`.

use super::BsdfReader;
use crate::error::Result;
use crate::math::rgb::Rgb;
use crate::scene::description::{ColourDescription, MaterialDescription, MaterialModel, NoteKind};
use crate::scene::load::mitsuba::metals;
use crate::scene::load::mitsuba::object::XmlObject;
use crate::scene::load::mitsuba::spectra::ColourMeaning;
use crate::scene::load::mitsuba::texture;
use crate::scene::load::wording::unknown_name;

/// The least real part of a metal's refractive index: Fresnel's equations as we write them have no meaning for 0.
const MIN_ETA: f32 = 1e-4;

impl BsdfReader<'_> {
    /// Makes a material that of a metal.
    ///
    /// # Errors
    /// If the metal is unknown, or a value out of its range.
    pub(super) fn conductor(
        &mut self,
        bsdf: &XmlObject,
        made: &mut MaterialDescription,
    ) -> Result<()> {
        let roughness = self.roughness(bsdf)?;
        let name = bsdf.text("material")?;
        let has_index = bsdf.get("eta").is_some() || bsdf.get("k").is_some();
        let (eta, k) = match name {
            Some("none") | None if has_index => {
                (self.index(bsdf, "eta", 0.0)?, self.index(bsdf, "k", 1.0)?)
            }
            Some("none") | None if roughness == 0.0 => {
                made.model = MaterialModel::Mirror {
                    reflectance: self.reflectance(bsdf, "specular_reflectance", 1.0)?,
                };
                return Ok(());
            }
            // The Fresnel reflectance of these is 1 but for 0.02 %.
            Some("none") | None => (Rgb::BLACK, Rgb::WHITE),
            Some(_) if has_index => {
                let why = "expected either a metal's name or the indices `eta` and `k`";
                return Err(bsdf.error_at("material", why));
            }
            Some(name) => metals::metal(name).ok_or_else(|| {
                let known: Vec<&str> = metals::METALS.iter().map(|(name, _, _)| *name).collect();
                bsdf.error_at("material", &unknown_name("metal", name, &known))
            })?,
        };
        let tint = self.reflectance(bsdf, "specular_reflectance", 1.0)?;
        let tint = tint.constant().unwrap_or_else(|| {
            let text = "a texture of `specular_reflectance` is replaced by its mean";
            self.note(bsdf, NoteKind::Approximation, text);
            Rgb::grey(texture::mean(&tint) as f32)
        });
        made.model = MaterialModel::Conductor {
            eta: eta.map(|x| x.max(MIN_ETA)),
            k,
            roughness,
            tint,
        };
        Ok(())
    }

    /// The real or the imaginary part of the index.
    fn index(&mut self, bsdf: &XmlObject, name: &str, default: f32) -> Result<Rgb> {
        let index = self.colour(bsdf, name, Rgb::grey(default), ColourMeaning::Index)?;
        Ok(match index {
            ColourDescription::Constant(index) => index,
            ColourDescription::Texture(_) => {
                let text = format!("a texture of `{name}` is replaced by its mean");
                self.note(bsdf, NoteKind::Approximation, &text);
                Rgb::grey(texture::mean(&index) as f32)
            }
        })
    }
}
