//! The parameters of a bsdf: colours and textures, reflectances, shares, roughness.
//!
//! Measure: reflectances and shares without unit; Mitsuba's alpha is that of the microfacets, the square of our roughness.
//! Range: reflectances and shares from 0 to 1, others are errors; what our models do not have is replaced, with a note.
//! Source: Mitsuba 3 documentation, "BSDFs". Tested in `tests/loading/mitsuba.rs`.

use super::BsdfReader;
use crate::error::Result;
use crate::math::rgb::Rgb;
use crate::scene::description::{ColourDescription, NoteKind};
use crate::scene::load::mitsuba::object::{Value, XmlObject};
use crate::scene::load::mitsuba::spectra::ColourMeaning;
use crate::scene::load::mitsuba::texture;

impl BsdfReader<'_> {
    /// A colour or a texture.
    pub(super) fn colour(
        &mut self,
        bsdf: &XmlObject,
        name: &str,
        default: Rgb,
        kind: ColourMeaning,
    ) -> Result<ColourDescription> {
        let Some(property) = bsdf.get(name) else {
            return Ok(default.into());
        };
        let Value::Object(texture) = &property.value else {
            return Ok(property.colour(kind)?.into());
        };
        self.texture(texture, kind)
    }

    /// A texture; the transform of the first texture's coordinates holds for all.
    pub(super) fn texture(
        &mut self,
        texture: &XmlObject,
        kind: ColourMeaning,
    ) -> Result<ColourDescription> {
        let (colour, to_uv) = texture::texture(texture, kind, self.contents)?;
        if let Some(to_uv) = to_uv {
            let known = *self.to_uv.get_or_insert(to_uv);
            if known != to_uv {
                self.note(
                    texture,
                    NoteKind::Approximation,
                    "gets the `to_uv` of the material's first texture",
                );
            }
        }
        Ok(colour)
    }

    /// A texture of which only the mean counts, so that the transform of its coordinates does not hold for others.
    pub(super) fn mean_of(
        &mut self,
        read: impl FnOnce(&mut Self) -> Result<ColourDescription>,
    ) -> Result<ColourDescription> {
        let kept = self.to_uv.take();
        let colour = read(self);
        self.to_uv = kept;
        colour
    }

    /// A colour whose channels are at most 1.
    pub(super) fn reflectance(
        &mut self,
        bsdf: &XmlObject,
        name: &str,
        default: f32,
    ) -> Result<ColourDescription> {
        let colour = self.colour(bsdf, name, Rgb::grey(default), ColourMeaning::Colour)?;
        if colour.brightest().max_channel() <= 1.0 {
            return Ok(colour);
        }
        Err(bsdf.error_at(name, "expected a reflectance of at most 1 in every channel"))
    }

    /// A factor that our model has not: notes it unless it is 1.
    pub(super) fn factor(&mut self, bsdf: &XmlObject, name: &str) -> Result<()> {
        let factor = self.mean_of(|reader| reader.reflectance(bsdf, name, 1.0))?;
        if factor.constant() != Some(Rgb::WHITE) {
            self.note(
                bsdf,
                NoteKind::Approximation,
                &format!("`{name}` is not supported: taken as 1"),
            );
        }
        Ok(())
    }

    /// A number from 0 to 1, or the mean of a texture, with a note.
    pub(super) fn share(&mut self, bsdf: &XmlObject, name: &str, default: f64) -> Result<f64> {
        let default = Rgb::grey(default as f32);
        let colour =
            self.mean_of(|reader| reader.colour(bsdf, name, default, ColourMeaning::Colour))?;
        let share = match colour.constant() {
            Some(share) => f64::from(share.luminance()),
            None => {
                self.note(
                    bsdf,
                    NoteKind::Approximation,
                    &format!("`{name}` is replaced by its mean"),
                );
                texture::mean(&colour)
            }
        };
        if (0.0..=1.0).contains(&share) {
            Ok(share)
        } else {
            Err(bsdf.error_at(name, "expected a number from 0 to 1"))
        }
    }

    /// Roughness from `alpha`, of which a texture counts by its mean and two axes by their geometric mean.
    pub(super) fn roughness(&mut self, bsdf: &XmlObject) -> Result<f32> {
        if !bsdf.kind.starts_with("rough") {
            return Ok(0.0);
        }
        let of_bsdf = bsdf.text("distribution")?.unwrap_or("beckmann");
        if of_bsdf != "ggx" {
            self.note(
                bsdf,
                NoteKind::Approximation,
                &format!("distribution `{of_bsdf}` is replaced by GGX"),
            );
        }
        let mut alpha_of = |name: &str, default: f64| self.share(bsdf, name, default);
        let alpha = alpha_of("alpha", 0.1)?;
        let (u, v) = (alpha_of("alpha_u", alpha)?, alpha_of("alpha_v", alpha)?);
        if u != v {
            self.note(
                bsdf,
                NoteKind::Approximation,
                "anisotropy is not supported: the geometric mean is used",
            );
        }
        Ok((u * v).sqrt().sqrt() as f32)
    }
}
