//! The choices by which the path tracers of a course on Monte Carlo rendering differ, one table of them all.
//!
//! Each step of the course changes one choice: whether light that a surface emits is found by the toss of a coin, where
//! paths go, and who looks for lights. Every combination is an unbiased estimator of the same integral.
//!
//! Measure: probabilities.
//! Range: any combination. Lights that no scattered ray can meet are found by those that sample lights alone; see
//! [`Technique::samples_lights`].
//! Source: the ladder of a course after Kajiya 1986, "The Rendering Equation", and Veach 1997, chapters 8 and 9. Tested in
//! `tests/rendering/integrators.rs`.

use crate::light::types::PointRule;
use crate::math::measure::PdfSolidAngle;
use crate::planted::planted;
use crate::sampling::mis::power_heuristic;

/// Where a path arrives, how is the light counted that is emitted there?
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EmissionRule {
    /// Always, and the path goes on.
    Always,
    /// A coin decides between taking what is emitted, which ends the path, and going on; each is divided by its
    /// probability.
    Coin {
        /// The probability of taking it where something is emitted, below 1.
        lit: f32,
        /// The same where nothing is, below 1.
        unlit: f32,
    },
}

/// Where does a path go?
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DirectionRule {
    /// By the BSDF.
    Bsdf,
    /// Anywhere alike: on the side that it came from, or on both where the surface lets light through. Delta lobes, which
    /// no such direction finds, get every second sample of a surface that has them.
    Uniform,
}

/// Who looks for lights?
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LightRule {
    /// Nobody: scattered rays meet them.
    None,
    /// One ray looks for one light, and the other is for all but this light: where it meets it, its emission is rejected.
    /// The choice of the light needs no division, as either ray finds each light.
    PartitionedLights,
    /// One ray looks for one light, divided by the probability of the choice; scattered rays count no light that this
    /// finds.
    Alone,
    /// Both, each weighted by the power heuristic.
    Weighted,
}

/// How a path finds light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Technique {
    /// What counts where it arrives.
    pub emission: EmissionRule,
    /// Where it goes.
    pub directions: DirectionRule,
    /// Who looks for lights.
    pub lights: LightRule,
    /// Where on them.
    pub points: PointRule,
}

impl Technique {
    /// The first path tracer of the course: one half of the paths end at each surface with what it emits, the others go
    /// anywhere.
    pub const NAIVE: Self = Self {
        emission: EmissionRule::Coin {
            lit: 0.5,
            unlit: 0.5,
        },
        directions: DirectionRule::Uniform,
        lights: LightRule::None,
        points: PointRule::SolidAngle,
    };

    /// The same with a coin that knows what it is tossed for.
    pub const EMIT_OR_REFLECT: Self = Self {
        emission: EmissionRule::Coin {
            lit: 0.9,
            unlit: 0.0,
        },
        ..Self::NAIVE
    };

    /// No coin, and directions by the BSDF.
    pub const BSDF: Self = Self {
        emission: EmissionRule::Always,
        directions: DirectionRule::Bsdf,
        ..Self::NAIVE
    };

    /// A ray to one light, and a ray anywhere else.
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

    /// Next event estimation, and both ways of finding a light weighted against each other.
    pub const PATH: Self = Self {
        lights: LightRule::Weighted,
        ..Self::BSDF
    };

    /// Light at the first surface by uniform directions: 2 pi f cos L.
    pub const DIRECT_DIRECTIONAL: Self = Self {
        emission: EmissionRule::Always,
        ..Self::NAIVE
    };

    /// Light at the first surface by uniform points on a light: f L V cos cos' A / r^2.
    pub const DIRECT_AREA: Self = Self {
        points: PointRule::Area,
        ..Self::NEXT_EVENT
    };

    /// Whether it looks for lights: nothing else finds lights that are points or infinitely far directions.
    pub const fn samples_lights(&self) -> bool {
        !matches!(self.lights, LightRule::None)
    }

    /// The same where no ray is scattered: light sampling is alone.
    #[inline(always)]
    pub const fn by_lights_alone(self) -> Self {
        Self {
            lights: LightRule::Alone,
            ..self
        }
    }

    /// The weight of light that a ray scattered with density `p_bsdf` met. Light sampling there had the density
    /// `p_light`; `is_chosen` tells whether it was this light that it looked for.
    #[inline(always)]
    pub fn weight_of_scattering(
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

    /// The weight of light found by sampling lights with density `p_light`, where the BSDF could have found it too.
    #[inline(always)]
    pub fn weight_of_light(&self, p_light: PdfSolidAngle, p_bsdf: PdfSolidAngle) -> f32 {
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

/// Where an integrator has its technique from: from its type, so that it is compiled for it, or from a value.
pub trait TechniqueSource: Copy + Send + Sync {
    /// The technique.
    fn technique(&self) -> Technique;
}

/// [`Technique::PATH`], known when compiling.
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
