//! A clear coat over metal or a principled surface.
//!
//! ```text
//! f = w D V F                                 the microfacets of the coat
//!   + f_base (1 - w max(S_o, S_i))            the base, lit through the coat
//! ```
//!
//! S is the directional albedo of the coat and w the fraction of the surface that it covers. The base keeps all light that
//! the coat does not reflect into the same direction, so that a white mirror under a smooth coat reflects everything, and
//! no base more: the integral of f cos_i is at most w S_o + (1 - w S_o). f is reciprocal.
//!
//! Measure: f per steradian.
//! Range: weight and roughness in [0, 1], `ior` at least 1; an opaque base. The microfacets of the coat are a delta below
//! roughness 0.01 and reflect by Schlick's approximation. Refraction does not change the directions that the base sees.
//! Source: the coat of glTF's KHR_materials_clearcoat, whose factor of the base, 1 - w F(wo.n), is not reciprocal. Tested in
//! `tests/scattering/bsdf.rs` and `tests/scattering/furnace.rs`.

use super::albedo::AlbedoRow;
use super::conductor::Conductor;
use super::fresnel::{normal_reflectance, schlick_weight};
use super::microfacet::Ggx;
use super::principled::Principled;
use super::types::{BsdfSample, BsdfSampleInput, BsdfValue, Lobe, effects_of_lobes, facing_up};
use crate::effects::EffectSet;
use crate::math::measure::PdfSolidAngle;
use crate::math::rgb::Rgb;
use crate::math::vec::{ONE_MINUS_EPSILON, Vec3};
use crate::planted::planted;

/// The coat alone.
#[derive(Debug, Clone, Copy)]
pub struct ClearCoat {
    weight: f32,
    f0: f32,
    facets: Option<Ggx>,
    albedo: AlbedoRow,
}

/// The surface below a coat.
#[derive(Debug, Clone, Copy)]
pub enum CoatedBase {
    /// Metal.
    Conductor(Conductor),
    /// An opaque principled surface.
    Principled(Principled),
}

/// A surface with its coat.
#[derive(Debug, Clone, Copy)]
pub struct Coated {
    coat: ClearCoat,
    base: CoatedBase,
}

impl ClearCoat {
    /// Creates the coat of this refractive index over the fraction `weight` of the surface.
    pub fn new(weight: f32, roughness: f32, ior: f32) -> Self {
        let facets = Ggx::from_roughness(roughness);
        Self {
            weight,
            f0: normal_reflectance(ior),
            facets,
            albedo: AlbedoRow::of(facets),
        }
    }

    /// Whether the coat is smooth, so that its lobe is a delta.
    #[inline]
    pub fn is_delta(&self) -> bool {
        self.facets.is_none()
    }

    /// The effect that a kernel needs for the coat.
    pub fn effects(&self) -> EffectSet {
        effects_of_lobes(self.is_delta())
    }

    /// The fraction of the light towards a direction of this cosine that the coat reflects.
    #[inline]
    fn reflected(&self, cos: f32) -> f32 {
        self.weight * self.albedo.at(cos).reflected(self.f0, 1.0).min(1.0)
    }

    /// The reflectance of a microfacet, times the weight.
    #[inline]
    fn fresnel(&self, cos: f32) -> Rgb {
        Rgb::grey(self.weight * (self.f0 + (1.0 - self.f0) * schlick_weight(cos)))
    }
}

impl CoatedBase {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfValue {
        match self {
            Self::Conductor(model) => model.eval(wo, wi),
            Self::Principled(model) => model.eval(wo, &model.lobe_probabilities(wo), wi),
        }
    }

    #[inline]
    fn sample(&self, wo: Vec3, numbers: &BsdfSampleInput) -> Option<BsdfSample> {
        match self {
            Self::Conductor(model) => model.sample(wo, numbers.lobe, numbers.u),
            Self::Principled(model) => model.sample(wo, &model.lobe_probabilities(wo), numbers),
        }
    }

    /// An estimate of the albedo by the brightest channel.
    #[inline]
    fn brightness(&self) -> f32 {
        match self {
            Self::Conductor(model) => model.tint.max_channel(),
            Self::Principled(model) => model.brightness(),
        }
    }

    fn is_delta(&self) -> bool {
        match self {
            Self::Conductor(model) => model.is_delta(),
            Self::Principled(model) => model.is_delta(),
        }
    }
}

impl Coated {
    /// Creates the BSDF of a base and its coat.
    #[inline]
    pub fn new(base: CoatedBase, coat: ClearCoat) -> Self {
        Self { coat, base }
    }

    /// Whether all lobes are deltas.
    #[inline]
    pub fn is_delta(&self) -> bool {
        self.coat.is_delta() && self.base.is_delta()
    }

    /// The effects that a kernel needs for this BSDF.
    pub fn effects(&self) -> EffectSet {
        let base = match &self.base {
            CoatedBase::Conductor(model) => model.effects(),
            CoatedBase::Principled(model) => model.effects(),
        };
        base | self.coat.effects()
    }

    /// The probability of sampling the coat, given its albedo towards `wo`.
    #[inline]
    fn share(&self, reflected: f32) -> f32 {
        let base = (1.0 - reflected) * self.base.brightness();
        reflected / (reflected + base).max(f32::MIN_POSITIVE)
    }

    /// Evaluates all lobes except deltas.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfValue {
        let Some((up_o, up_i)) = facing_up(wo, wi) else {
            return BsdfValue::default();
        };
        let [o, i] = [up_o, up_i].map(|w| self.coat.reflected(w.z));
        let share = self.share(o);
        let base = self.base.eval(wo, wi);
        let mut f = planted!("coat-of-one-direction", 1.0 - o, 1.0 - o.max(i)) * base.f;
        let mut pdf = (1.0 - share) * base.pdf.0;
        if let Some(ggx) = self.coat.facets {
            let facets = ggx.reflection_terms(up_o, up_i);
            f += facets.d_v * self.coat.fresnel(facets.cos);
            pdf += share * facets.pdf;
        }
        BsdfValue {
            f,
            pdf: PdfSolidAngle(pdf),
        }
    }

    /// Samples the coat or the base by their shares of the albedo, then a direction.
    #[inline]
    pub fn sample(&self, wo: Vec3, numbers: &BsdfSampleInput) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let up = Vec3::new(wo.x, wo.y, wo.z.abs());
        let o = self.coat.reflected(up.z);
        let share = self.share(o);
        if numbers.lobe < share {
            let Some(ggx) = self.coat.facets else {
                return Some(BsdfSample {
                    wi: Vec3::new(-wo.x, -wo.y, wo.z),
                    weight: self.coat.fresnel(up.z) / share,
                    pdf: None,
                    lobe: Lobe::SpecularReflection,
                });
            };
            let mut wi = ggx.sample_reflection(up, numbers.u);
            if wi.z <= 0.0 {
                return None;
            }
            wi.z = wi.z.copysign(wo.z);
            return self.weigh(wo, wi, Lobe::GlossyReflection);
        }
        let lobe = (numbers.lobe - share) / (1.0 - share);
        let sample = self.base.sample(
            wo,
            &BsdfSampleInput {
                lobe: lobe.min(ONE_MINUS_EPSILON),
                ..*numbers
            },
        )?;
        if sample.pdf.is_some() {
            return self.weigh(wo, sample.wi, sample.lobe);
        }
        // A mirror direction: the coat has the same albedo in both.
        Some(BsdfSample {
            weight: ((1.0 - o) / (1.0 - share)) * sample.weight,
            ..sample
        })
    }

    /// The sample of direction `wi`, weighted over all lobes.
    #[inline]
    fn weigh(&self, wo: Vec3, wi: Vec3, lobe: Lobe) -> Option<BsdfSample> {
        let value = self.eval(wo, wi);
        (value.pdf.0 > 0.0).then(|| BsdfSample {
            wi,
            weight: (wi.z.abs() / value.pdf.0) * value.f,
            pdf: Some(value.pdf),
            lobe,
        })
    }
}
