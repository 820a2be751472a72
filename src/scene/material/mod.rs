//! Materials: evaluate their textures at a hit to yield a BSDF.
//!
//! Measure: as in `bsdf/types.rs`.
//! Range: materials that `load` accepts.
//! Source: none needed. Tested in `tests/loading/scene_files.rs` and `tests/scattering/materials.rs`.

mod colour;
mod textured_bsdf;

use super::description::MaterialDescription;
use super::shape_traits::ShapeTraits;
use super::surface_detail::SurfaceDetail;
use crate::bsdf::Bsdf;
use crate::bsdf::albedo::RowPlace;
use crate::bsdf::principled::lanes::RoughBsdf;
use crate::effects::{Effect, EffectSet, Effects, Switch, beyond_kernel};
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use colour::Colour;
use std::borrow::Cow;
use textured_bsdf::{TexturedBsdf, mapped};

/// A material prepared for lookups. Everything that does not depend on textures is precomputed.
#[derive(Debug, Clone)]
pub struct Material {
    bsdf: TexturedBsdf,
    transmits: bool,
    one_sided: bool,
    /// Opacity; `None` if the surface is opaque.
    alpha: Option<Colour>,
    /// The alpha from which the surface is present, if it is not present in part.
    alpha_cutoff: Option<f32>,
    detail: Option<SurfaceDetail>,
}

impl Material {
    /// Returns the material of a description, whose lengths are multiplied by `unit`.
    pub fn new(description: &MaterialDescription, unit: f32) -> Self {
        let alpha = Colour::new(&description.alpha);
        let present_from = description.alpha_cutoff.unwrap_or(1.0);
        let all_there =
            matches!(&alpha, Colour::Constant(alpha) if alpha.luminance() >= present_from);
        let bsdf = TexturedBsdf::new(&description.model).mapped(description);
        let bsdf = bsdf.coated(description.clear_coat.as_ref());
        Self {
            transmits: bsdf.effects().has(Effect::Transmission),
            bsdf: bsdf.folded(),
            one_sided: !description.two_sided,
            alpha: (!all_there).then_some(alpha),
            alpha_cutoff: description.alpha_cutoff,
            detail: SurfaceDetail::new(description, unit),
        }
    }

    /// The reflectance at a texture coordinate, if the BSDF is diffuse.
    #[inline]
    pub fn diffuse_reflectance<E: Effects>(&self, uv: Vec2) -> Option<Rgb> {
        match &self.bsdf {
            TexturedBsdf::Uniform(Bsdf::Diffuse(bsdf)) => Some(bsdf.reflectance()),
            TexturedBsdf::Diffuse(colour) if E::Textures::ON => Some(colour.at(uv)),
            _ => None,
        }
    }

    /// The BSDF at a texture coordinate with its place in the table of albedos, if it is rough, opaque and evaluated in lanes.
    #[inline]
    pub fn rough_bsdf<E: Effects>(&self, uv: Vec2) -> Option<(RoughBsdf<'_>, RowPlace)> {
        match &self.bsdf {
            TexturedBsdf::Uniform(Bsdf::Principled(bsdf)) => {
                let place = bsdf.place_in_lanes()?;
                Some((RoughBsdf::Principled(Cow::Borrowed(bsdf)), place))
            }
            TexturedBsdf::Uniform(Bsdf::Conductor(bsdf)) => {
                Some((RoughBsdf::Conductor(bsdf), bsdf.place_in_lanes()?))
            }
            TexturedBsdf::Principled(bsdf, colour) if E::Textures::ON => {
                let place = bsdf.place_in_lanes()?;
                let bsdf = bsdf.coloured(colour.at(uv));
                Some((RoughBsdf::Principled(Cow::Owned(bsdf)), place))
            }
            TexturedBsdf::PrincipledMapped(parameters, colour, map) if E::Textures::ON => {
                let bsdf = mapped(parameters, colour.at(uv), map.at(uv));
                let place = bsdf.place_in_lanes()?;
                Some((RoughBsdf::Principled(Cow::Owned(bsdf)), place))
            }
            _ => None,
        }
    }

    /// Whether all lobes of the BSDF are deltas, see [`Bsdf::is_delta`]. Textures do not change it.
    #[inline]
    pub fn is_delta<E: Effects>(&self) -> bool {
        self.bsdf.is_delta::<E>()
    }

    /// Whether the material has an opacity below 1 anywhere.
    #[inline]
    pub fn has_alpha(&self) -> bool {
        self.alpha.is_some()
    }

    /// Returns the effects that the material requires of a kernel.
    pub fn effects(&self) -> EffectSet {
        self.bsdf
            .effects()
            .with_if(Effect::Textures, self.is_textured())
            .with_if(Effect::OneSided, self.one_sided)
            .with_if(Effect::Alpha, self.alpha.is_some())
            .with_if(Effect::NormalMaps, self.detail.is_some())
            .with_if(Effect::ShadingNormals, self.detail.is_some())
    }

    /// The traits of a shape with this material that follow from it.
    pub fn traits(&self) -> ShapeTraits {
        ShapeTraits::default()
            .with_if(ShapeTraits::ONE_SIDED, self.one_sided)
            .with_if(ShapeTraits::TRANSMISSIVE, self.transmits)
            .with_if(ShapeTraits::TEXTURED, self.is_textured())
            .with_if(ShapeTraits::ALPHA, self.alpha.is_some())
            .with_if(ShapeTraits::NORMAL_MAPPED, self.detail.is_some())
    }

    /// Whether the material needs texture coordinates.
    pub fn is_textured(&self) -> bool {
        let alpha_varies = self.alpha.as_ref().is_some_and(Colour::is_textured);
        self.bsdf.is_textured() || alpha_varies || self.detail.is_some()
    }

    /// Returns the BSDF at a texture coordinate.
    #[inline]
    pub fn bsdf<E: Effects>(&self, uv: Vec2) -> Cow<'_, Bsdf> {
        match &self.bsdf {
            TexturedBsdf::Uniform(bsdf) => Cow::Borrowed(bsdf),
            textured if E::Textures::ON => Cow::Owned(textured.bsdf(uv)),
            _ => beyond_kernel(),
        }
    }

    /// Whether the material transmits light, so that its two sides differ.
    #[inline]
    pub fn transmits(&self) -> bool {
        self.transmits
    }

    /// Whether the back absorbs everything.
    #[inline]
    pub fn is_one_sided(&self) -> bool {
        self.one_sided
    }

    /// Returns alpha (opacity) at a texture coordinate, in [0, 1]; `None` if the surface is opaque.
    #[inline]
    pub fn alpha(&self, uv: impl FnOnce() -> Vec2) -> Option<f32> {
        let alpha = match self.alpha.as_ref()? {
            Colour::Constant(alpha) => *alpha,
            varying => varying.at(uv()),
        };
        let alpha = alpha.luminance().clamp(0.0, 1.0);
        Some(match self.alpha_cutoff {
            Some(cutoff) => f32::from(u8::from(alpha >= cutoff)),
            None => alpha,
        })
    }

    /// Whether the surface has alpha below 1.
    pub fn is_masked(&self) -> bool {
        self.alpha.is_some()
    }

    /// Returns the map that tilts shading normals, if any.
    #[inline]
    pub fn detail(&self) -> Option<&SurfaceDetail> {
        self.detail.as_ref()
    }
}
