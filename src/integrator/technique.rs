//! The choices by which the path tracers of a course on Monte Carlo rendering differ, in one table.
//!
//! Each step of the course changes one choice: whether emission is counted at random, how directions are sampled,
//! and how lights are found. Every combination is an unbiased estimator of the same integral.
//!
//! Measure: probabilities.
//! Range: any combination. Lights that no scattered ray can hit are found only by techniques that sample lights; see
//! [`Technique::samples_lights`].
//! Source: the ladder of a course after Kajiya 1986, "The Rendering Equation", and Veach 1997, chapters 8 and 9. Tested in
//! `tests/rendering/integrators.rs`.

use crate::light::types::PointRule;
use crate::math::measure::PdfSolidAngle;
use crate::planted::planted;
use crate::sampling::mis::power_heuristic;

/// The rule by which emission at a path's vertices is counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EmissionRule {
    /// Emission is always counted, and the path continues.
    Always,
    /// A random decision between counting the emission, which ends the path, and continuing; each case is divided by its
    /// probability.
    Termination {
        /// The probability of ending the path at a surface that emits, below 1.
        lit: f32,
        /// The probability of ending the path at a surface that does not emit, below 1.
        unlit: f32,
    },
}

/// The rule by which a path's directions are sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DirectionRule {
    /// BSDF sampling.
    Bsdf,
    /// Uniform directions: on the viewer's side, or on both sides of a transmissive surface. Delta lobes, which no such
    /// direction finds, get half of the samples of a surface that has them.
    Uniform,
}

/// The rule by which lights are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LightRule {
    /// Scattered rays hit lights; no light is sampled.
    None,
    /// One ray samples one light, and the scattered ray is for all others: where it hits the chosen light, its emission
    /// is rejected. The choice of the light needs no division by its probability, as each light is found by one of the
    /// two rays.
    PartitionedLights,
    /// One ray samples one light, divided by the probability of the choice; scattered rays count no emission that light
    /// sampling can find.
    Alone,
    /// Light sampling and scattered rays, each weighted by the power heuristic.
    Weighted,
}

/// The technique by which a path tracer finds light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Technique {
    /// The rule for emission.
    pub emission: EmissionRule,
    /// The rule for directions.
    pub directions: DirectionRule,
    /// The rule for lights.
    pub lights: LightRule,
    /// The rule for points on lights.
    pub points: PointRule,
}

impl Technique {
    /// The first path tracer of the course: half of the paths end at each surface with its emission, the others
    /// continue in a uniform direction.
    pub const NAIVE: Self = Self {
        emission: EmissionRule::Termination {
            lit: 0.5,
            unlit: 0.5,
        },
        directions: DirectionRule::Uniform,
        lights: LightRule::None,
        points: PointRule::SolidAngle,
    };

    /// The first path tracer, whose probability of counting the emission depends on whether the surface emits.
    pub const EMIT_OR_REFLECT: Self = Self {
        emission: EmissionRule::Termination {
            lit: 0.9,
            unlit: 0.0,
        },
        ..Self::NAIVE
    };

    /// Path tracing by BSDF sampling, which counts emission at every vertex.
    pub const BSDF: Self = Self {
        emission: EmissionRule::Always,
        directions: DirectionRule::Bsdf,
        ..Self::NAIVE
    };

    /// One ray to a sampled light, and a uniform direction for all other lights.
    pub const LIGHT_OR_REST: Self = Self {
        emission: EmissionRule::Always,
        lights: LightRule::PartitionedLights,
        ..Self::NAIVE
    };

    /// Next event estimation.
    pub const NEXT_EVENT: Self = Self {
        lights: LightRule::Alone,
        ..Self::BSDF
    };

    /// Next event estimation and BSDF sampling, combined by multiple importance sampling.
    pub const PATH: Self = Self {
        lights: LightRule::Weighted,
        ..Self::BSDF
    };

    /// Direct light at the first surface by uniform directions: 2 pi f cos L.
    pub const DIRECT_DIRECTIONAL: Self = Self {
        emission: EmissionRule::Always,
        ..Self::NAIVE
    };

    /// Direct light at the first surface by uniform points on a light: f L V cos cos' A / r^2.
    pub const DIRECT_AREA: Self = Self {
        points: PointRule::Area,
        ..Self::NEXT_EVENT
    };

    /// Whether lights are sampled: nothing else finds point lights and distant lights.
    pub const fn samples_lights(&self) -> bool {
        !matches!(self.lights, LightRule::None)
    }

    /// The technique where no ray is scattered: light sampling alone.
    #[inline(always)]
    pub const fn with_light_sampling_only(self) -> Self {
        Self {
            lights: LightRule::Alone,
            ..self
        }
    }

    /// The weight of emission that a ray scattered with density `p_bsdf` has hit. `p_light` is the density of light
    /// sampling for it; `is_chosen` tells whether light sampling chose this light.
    #[inline(always)]
    pub fn mis_weight_of_bsdf(
        &self,
        p_bsdf: PdfSolidAngle,
        p_light: impl FnOnce() -> PdfSolidAngle,
        is_chosen: impl FnOnce() -> bool,
    ) -> f32 {
        let is_counted = match self.lights {
            LightRule::None => true,
            LightRule::PartitionedLights => !is_chosen(),
            LightRule::Alone => p_light().0 == 0.0,
            LightRule::Weighted => return power_heuristic(p_bsdf, p_light()),
        };
        if is_counted { 1.0 } else { 0.0 }
    }

    /// The weight of light found by light sampling with density `p_light`, where BSDF sampling has the density
    /// `p_bsdf`.
    #[inline(always)]
    pub fn mis_weight_of_light(&self, p_light: PdfSolidAngle, p_bsdf: PdfSolidAngle) -> f32 {
        match self.lights {
            LightRule::Weighted => planted!(
                "heuristics-mixed",
                p_light.0 / (p_light.0 + p_bsdf.0),
                power_heuristic(p_light, p_bsdf)
            ),
            LightRule::None | LightRule::PartitionedLights | LightRule::Alone => 1.0,
        }
    }
}

/// The source of an integrator's technique: its type, so that the integrator is compiled for the technique, or a value.
pub trait TechniqueSource: Copy + Send + Sync {
    /// The technique.
    fn technique(&self) -> Technique;
}

/// [`Technique::PATH`], known at compile time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Weighted;

impl TechniqueSource for Weighted {
    #[inline(always)]
    fn technique(&self) -> Technique {
        Technique::PATH
    }
}

impl TechniqueSource for Technique {
    #[inline(always)]
    fn technique(&self) -> Technique {
        *self
    }
}
