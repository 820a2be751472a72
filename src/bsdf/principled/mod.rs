//! The metallic-roughness model of glTF, with refraction: a mixture of metal, a coat over a diffuse base, and glass.
//!
//! ```text
//! f = D V (F0 + (F90 - F0) (1 - wo.m)^5)                   microfacets of metal and coat together
//!   + metal F_ms (1 - E_o) (1 - E_i) / (pi (1 - E_mean))   multiple scattering of the metal
//!   + base / pi (1 - S_o) (1 - S_i) / (1 - S_mean)         diffuse base under a coat of albedo S
//!   + glass                                                as [`Dielectric`]
//! ```
//!
//! The diffuse base receives all light that the coat does not reflect, so that with a white base the albedo is 1, and
//! never more. Every term is reciprocal.
//!
//! Measure: f per steradian.
//! Range: `base_color`, `metallic`, `roughness`, `transmission` in [0, 1]; `ior` at least 1. Microfacet lobes are deltas
//! below roughness 0.01. The coat uses Schlick's approximation, which reflects at grazing angles also at `ior` 1, as in
//! glTF; glass uses the Fresnel equations. The opaque lobes scatter alike on both sides.
//! Source: glTF 2.0, appendix B, with the couplings of Kulla and Conty 2017. Tested in
//! `tests/scattering/bsdf.rs` and `tests/scattering/furnace.rs`.

pub mod lanes;
mod opaque;

use super::albedo::{AlbedoRow, RowPlace};
use super::conductor::multiple_scattering_colour;
use super::dielectric::Dielectric;
use super::fresnel::{normal_reflectance, schlick_mean};
use super::microfacet::{Ggx, SMOOTH_ALPHA};
use super::types::{BsdfSample, BsdfSampleInput, BsdfValue, Lobe, facing_up};
use crate::effects::{Effect, EffectSet};
use crate::math::{
    rgb::Rgb,
    vec::{Vec2, Vec3},
};
pub use opaque::LobeProbabilities;
use opaque::OpaqueLobes;
use std::f32::consts::FRAC_1_PI;

/// The parameters of a principled material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrincipledParameters {
    /// Albedo of the base, reflectance of the metal, tint of the glass.
    pub base_color: Rgb,
    /// 0 is dielectric, 1 is metal.
    pub metallic: f32,
    /// Roughness; 0 is smooth.
    pub roughness: f32,
    /// Refractive index of coat and glass, inside over outside.
    pub ior: f32,
    /// The fraction of the dielectric that is glass instead of coat and base.
    pub transmission: f32,
}

/// The principled BSDF at a point of a surface. [`Principled::coloured`] changes its colour at little cost.
#[derive(Debug, Clone, Copy)]
pub struct Principled {
    opaque: OpaqueLobes,
    /// Whether the microfacets are rough; otherwise they reflect as a mirror.
    is_rough: bool,
    albedo: AlbedoRow,
    /// Fractions of the surface that are metal, coat over base, and glass; they sum to one.
    metal_share: f32,
    coat_share: f32,
    glass_share: f32,
    glass: Dielectric,
}

impl Principled {
    /// Creates the BSDF of the given parameters.
    #[inline]
    pub fn new(parameters: &PrincipledParameters) -> Self {
        let &PrincipledParameters {
            base_color,
            metallic,
            roughness,
            ior,
            transmission,
        } = parameters;
        let facets = Ggx::from_roughness(roughness);
        let albedo = AlbedoRow::of(facets);
        let coat_f0 = normal_reflectance(ior);
        let coat_share = (1.0 - metallic) * (1.0 - transmission);
        let mean = albedo.mean();
        let (multiple_scale, pdf_scale) = albedo.scales();
        Self {
            opaque: OpaqueLobes {
                ggx: facets.unwrap_or(Ggx::new(SMOOTH_ALPHA)),
                f0: Rgb::BLACK,
                f90: metallic + coat_share,
                metal_ms: Rgb::BLACK,
                base: Rgb::BLACK,
                coat_f0,
                // A coat that reflects everything, by rounding, leaves no light for the base.
                base_scale: FRAC_1_PI / (1.0 - mean.reflected(coat_f0, 1.0)).max(f32::EPSILON),
                multiple_scale,
                pdf_scale,
            },
            is_rough: facets.is_some(),
            albedo,
            metal_share: metallic,
            coat_share,
            glass_share: (1.0 - metallic) * transmission,
            glass: Dielectric::new(ior, roughness, base_color),
        }
        .coloured(base_color)
    }

    /// Returns the BSDF with another base colour.
    #[inline]
    pub fn coloured(&self, base_color: Rgb) -> Self {
        let metal_ms = if self.metal_share > 0.0 {
            multiple_scattering_colour(schlick_mean(base_color), self.albedo.mean())
        } else {
            Rgb::BLACK
        };
        let coat = Rgb::grey(self.coat_share * self.opaque.coat_f0);
        Self {
            opaque: OpaqueLobes {
                f0: self.metal_share * base_color + coat,
                metal_ms: self.metal_share * metal_ms,
                base: self.coat_share * base_color,
                ..self.opaque
            },
            glass: self.glass.tinted(base_color),
            ..*self
        }
    }

    /// Refractive index of the glass, inside over outside.
    #[inline]
    pub fn ior(&self) -> f32 {
        self.glass.ior()
    }

    /// An estimate of the albedo of the opaque lobes by the brightest channel.
    #[inline]
    pub(super) fn brightness(&self) -> f32 {
        (self.opaque.f0 + self.opaque.base).max_channel().min(1.0)
    }

    /// The place in the table of albedos, if the surface is rough and opaque, so that its BSDF can be evaluated in lanes.
    #[inline]
    pub fn place_in_lanes(&self) -> Option<RowPlace> {
        self.albedo.place().filter(|_| self.glass_share == 0.0)
    }

    /// Whether all lobes are deltas.
    #[inline]
    pub fn is_delta(&self) -> bool {
        let opaque_is_delta = !self.is_rough && self.opaque.base.is_black();
        let glass_is_delta = self.glass_share == 0.0 || self.glass.is_delta();
        glass_is_delta && (opaque_is_delta || self.opaque.f90 == 0.0)
    }

    /// The effects that a kernel needs for this BSDF.
    pub fn effects(&self) -> EffectSet {
        let facets = if self.is_rough {
            Effect::Glossy
        } else {
            Effect::Specular
        };
        let glass = if self.glass.is_delta() {
            Effect::Specular
        } else {
            Effect::Glossy
        };
        let has_glass = self.glass_share > 0.0;
        EffectSet::NONE
            .with(facets)
            .with_if(glass, has_glass)
            .with_if(Effect::Transmission, has_glass)
    }

    /// Samples a lobe by its share of the albedo, then a direction; `probabilities` are the
    /// [`Principled::lobe_probabilities`] of `wo`.
    #[inline]
    pub fn sample(
        &self,
        wo: Vec3,
        probabilities: &LobeProbabilities,
        input: &BsdfSampleInput,
    ) -> Option<BsdfSample> {
        let BsdfSampleInput {
            lobe: u_lobe,
            u,
            cosine_direction,
        } = *input;
        if wo.z == 0.0 {
            return None;
        }
        if u_lobe < probabilities.glass {
            return self.sample_glass(wo, u_lobe / probabilities.glass, u, probabilities);
        }
        let up = Vec3::new(wo.x, wo.y, wo.z.abs());
        let (mut wi, lobe) = if u_lobe < probabilities.glass + probabilities.base {
            (cosine_direction, Lobe::Diffuse)
        } else if u_lobe < probabilities.glass + probabilities.base + probabilities.metal_ms {
            (self.sample_multiple(u), Lobe::GlossyReflection)
        } else if self.is_rough {
            let wi = self.opaque.ggx.sample_reflection(up, u);
            (wi, Lobe::GlossyReflection)
        } else {
            return self.sample_smooth(wo, probabilities);
        };
        if wi.z <= 0.0 {
            return None;
        }
        wi.z = wi.z.copysign(wo.z);
        self.weigh(wo, wi, lobe, probabilities)
    }

    /// Samples a direction by the multiple scattering of the metal.
    #[inline]
    pub fn sample_multiple(&self, u: Vec2) -> Vec3 {
        self.albedo.sample_multiple(u)
    }

    /// Computes each lobe's share of the albedo towards `wo`, by the brightest channel.
    #[inline]
    pub fn lobe_probabilities(&self, wo: Vec3) -> LobeProbabilities {
        self.opaque
            .lobe_probabilities(self.albedo.at(wo.z.abs()), self.glass_share)
    }

    /// Evaluates all lobes except deltas; `probabilities` are the [`Principled::lobe_probabilities`] of `wo`.
    #[inline]
    pub fn eval(&self, wo: Vec3, probabilities: &LobeProbabilities, wi: Vec3) -> BsdfValue {
        let mut value = BsdfValue::default();
        if let Some((wo, wi)) = facing_up(wo, wi) {
            let i = self.albedo.at(wi.z);
            let schlick = |cos| self.opaque.schlick(cos);
            value = self
                .opaque
                .eval(wo, wi, probabilities, i, self.is_rough, schlick);
        }
        if self.glass_share > 0.0 {
            let glass = self.glass.eval(wo, wi);
            value.f += self.glass_share * glass.f;
            value.pdf.0 += probabilities.glass * glass.pdf.0;
        }
        value
    }

    #[inline]
    fn sample_smooth(&self, wo: Vec3, probabilities: &LobeProbabilities) -> Option<BsdfSample> {
        (probabilities.facets > 0.0).then(|| BsdfSample {
            wi: Vec3::new(-wo.x, -wo.y, wo.z),
            weight: self.opaque.schlick(wo.z.abs()) / probabilities.facets,
            pdf: None,
            lobe: Lobe::SpecularReflection,
        })
    }

    #[inline]
    fn sample_glass(
        &self,
        wo: Vec3,
        u_lobe: f32,
        u: Vec2,
        probabilities: &LobeProbabilities,
    ) -> Option<BsdfSample> {
        let sample = self.glass.sample(wo, u_lobe, u)?;
        if sample.pdf.is_some() {
            return self.weigh(wo, sample.wi, sample.lobe, probabilities);
        }
        Some(BsdfSample {
            weight: (self.glass_share / probabilities.glass) * sample.weight,
            ..sample
        })
    }

    /// Builds the sample of direction `wi`, weighted over all lobes.
    #[inline]
    fn weigh(
        &self,
        wo: Vec3,
        wi: Vec3,
        lobe: Lobe,
        probabilities: &LobeProbabilities,
    ) -> Option<BsdfSample> {
        let value = self.eval(wo, probabilities, wi);
        (value.pdf.0 > 0.0).then(|| BsdfSample {
            wi,
            weight: (wi.z.abs() / value.pdf.0) * value.f,
            pdf: Some(value.pdf),
            lobe,
        })
    }
}
