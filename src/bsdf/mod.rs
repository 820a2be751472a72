//! BSDFs: one file for each model, and the enum of all models.
//!
//! Measure: as in [`types`], which also holds the conventions.
//! Range: local unit directions anywhere on the sphere; opaque models scatter alike on both sides, and the caller handles
//! one-sided surfaces.
//! Source: named in each model's file. Tested in `tests/scattering/bsdf.rs` and `tests/scattering/furnace.rs`.

pub mod albedo;
pub mod coated;
pub mod conductor;
pub mod dielectric;
pub mod diffuse;
pub mod fresnel;
pub mod microfacet;
pub mod mirror;
pub mod phong;
pub mod principled;
pub mod types;

use crate::effects::{Effect, EffectSet, Effects, Switch, beyond_kernel};
use crate::math::vec::{Vec2, Vec3};
pub use coated::{ClearCoat, Coated, CoatedBase};
pub use conductor::Conductor;
pub use dielectric::Dielectric;
pub use diffuse::Diffuse;
pub use mirror::Mirror;
pub use phong::Phong;
use principled::LobeProbabilities;
pub use principled::{Principled, PrincipledParameters};
pub use types::{BsdfSample, BsdfSampleInput, BsdfValue, Lobe};

/// The BSDF at a point of a surface.
#[derive(Debug, Clone, Copy)]
pub enum Bsdf {
    /// Lambertian reflection.
    Diffuse(Diffuse),
    /// A perfect mirror.
    Mirror(Mirror),
    /// Metal, smooth or rough.
    Conductor(Conductor),
    /// Glass, smooth or rough.
    Dielectric(Dielectric),
    /// Lambertian reflection with a Phong lobe.
    Phong(Phong),
    /// The metallic-roughness model.
    Principled(Principled),
    /// A clear coat over metal or the metallic-roughness model.
    Coated(Coated),
}

impl Bsdf {
    /// Binds the BSDF to `wo`, for several evaluations or samples.
    #[inline]
    pub fn bind<E: Effects>(&self, wo: Vec3) -> BoundBsdf<'_> {
        let lobe_probabilities = match self {
            Self::Principled(model) if has_lobes::<E>() => Some(model.lobe_probabilities(wo)),
            _ => None,
        };
        BoundBsdf {
            bsdf: self,
            wo,
            lobe_probabilities,
        }
    }

    /// Evaluates [`BoundBsdf::eval`] for `wo`.
    #[inline]
    pub fn eval<E: Effects>(&self, wo: Vec3, wi: Vec3) -> BsdfValue {
        self.bind::<E>(wo).eval::<E>(wi)
    }

    /// Samples [`BoundBsdf::sample`] for `wo`.
    #[inline]
    pub fn sample<E: Effects>(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        self.bind::<E>(wo)
            .sample::<E>(&BsdfSampleInput::new(u_lobe, u))
    }

    /// Refractive index, inside over outside; 1 for opaque models.
    #[inline]
    pub fn ior(&self) -> f32 {
        match self {
            Self::Dielectric(model) => model.ior(),
            Self::Principled(model) => model.ior(),
            Self::Diffuse(_)
            | Self::Mirror(_)
            | Self::Conductor(_)
            | Self::Phong(_)
            | Self::Coated(_) => 1.0,
        }
    }

    /// Whether all lobes are deltas, so that [`Bsdf::eval`] is zero everywhere and light sampling contributes nothing.
    #[inline]
    pub fn is_delta<E: Effects>(&self) -> bool {
        if !E::Specular::ON {
            return false;
        }
        match self {
            Self::Diffuse(_) | Self::Phong(_) => false,
            Self::Mirror(_) => true,
            Self::Conductor(model) => model.is_delta(),
            Self::Dielectric(model) => model.is_delta(),
            Self::Principled(model) => model.is_delta(),
            Self::Coated(model) => model.is_delta(),
        }
    }

    /// The effects that a kernel needs for this BSDF.
    pub fn effects(&self) -> EffectSet {
        match self {
            Self::Diffuse(_) => EffectSet::NONE,
            Self::Mirror(_) => EffectSet::NONE.with(Effect::Specular),
            Self::Conductor(model) => model.effects(),
            Self::Dielectric(model) => {
                types::effects_of_lobes(model.is_delta()).with(Effect::Transmission)
            }
            Self::Phong(_) => EffectSet::NONE.with(Effect::Glossy),
            Self::Principled(model) => model.effects(),
            Self::Coated(model) => model.effects(),
        }
    }
}

/// A BSDF bound to one direction `wo`, so that terms shared by evaluation and sampling are computed once.
#[derive(Debug, Clone, Copy)]
pub struct BoundBsdf<'a> {
    bsdf: &'a Bsdf,
    wo: Vec3,
    /// The lobe probabilities of the principled model.
    lobe_probabilities: Option<LobeProbabilities>,
}

impl BoundBsdf<'_> {
    /// The BSDF.
    #[inline]
    pub fn bsdf(&self) -> &Bsdf {
        self.bsdf
    }

    /// The direction that the BSDF is bound to.
    #[inline]
    pub fn wo(&self) -> Vec3 {
        self.wo
    }

    /// Evaluates f(wo, wi) without the cosine, and the density of [`BoundBsdf::sample`] at `wi`, both without delta lobes. A
    /// kernel evaluates only the models that its effects include.
    #[inline]
    pub fn eval<E: Effects>(&self, wi: Vec3) -> BsdfValue {
        let wo = self.wo;
        match (self.bsdf, &self.lobe_probabilities) {
            (Bsdf::Diffuse(model), _) => model.eval(wo, wi),
            (Bsdf::Mirror(model), _) if has_lobes::<E>() => model.eval(),
            (Bsdf::Conductor(model), _) if has_lobes::<E>() => model.eval(wo, wi),
            (Bsdf::Dielectric(model), _) if E::Transmission::ON => model.eval(wo, wi),
            (Bsdf::Phong(model), _) if E::Glossy::ON => model.eval(wo, wi),
            (Bsdf::Principled(model), Some(probabilities)) => model.eval(wo, probabilities, wi),
            (Bsdf::Coated(model), _) if has_lobes::<E>() => model.eval(wo, wi),
            _ => beyond_kernel(),
        }
    }

    /// Samples an incident direction. `None` is a sample of zero contribution, which counts in the estimator.
    #[inline]
    pub fn sample<E: Effects>(&self, input: &BsdfSampleInput) -> Option<BsdfSample> {
        let (wo, BsdfSampleInput { lobe, u, .. }) = (self.wo, *input);
        match (self.bsdf, &self.lobe_probabilities) {
            (Bsdf::Diffuse(model), _) => model.sample(wo, input),
            (Bsdf::Mirror(model), _) if has_lobes::<E>() => model.sample(wo),
            (Bsdf::Conductor(model), _) if has_lobes::<E>() => model.sample(wo, lobe, u),
            (Bsdf::Dielectric(model), _) if E::Transmission::ON => model.sample(wo, lobe, u),
            (Bsdf::Phong(model), _) if E::Glossy::ON => model.sample(wo, input),
            (Bsdf::Principled(model), Some(probabilities)) => {
                model.sample(wo, probabilities, input)
            }
            (Bsdf::Coated(model), _) if has_lobes::<E>() => model.sample(wo, input),
            _ => beyond_kernel(),
        }
    }
}

/// Whether a kernel supports more than diffuse surfaces, so that a BSDF may have several lobes.
pub const fn has_lobes<E: Effects>() -> bool {
    E::Glossy::ON || E::Specular::ON
}
