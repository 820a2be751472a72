//! The types and conventions that all BSDF models share.
//!
//! - Directions are local and of unit length: z is the shading normal. `wo` points to where the path came from, `wi`
//!   to where light comes from; both point away from the surface.
//! - `f` does not contain the cosine. A sample's weight is f |cos(wi)| / pdf.
//! - `eta` is a ratio of refractive indices, inside over outside; inside is where z is negative.
//! - f is radiance transport: refraction carries the factor (n_o / n_i)^2 of radiance. Importance transport (for light
//!   paths) is this f with both directions exchanged.
//! - A delta lobe cannot be evaluated: `eval` leaves it out, and `sample` returns it without a density.
//!
//! Measure: f per steradian, densities per steradian.
//! Range: both directions anywhere on the sphere; exactly tangential ones scatter nothing.
//! Source: Veach 1997, chapter 5. Tested in `tests/scattering/bsdf.rs` and `tests/scattering/furnace.rs`.

use crate::effects::{Effect, EffectSet};
use crate::math::measure::PdfSolidAngle;
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3, Vector};
use crate::sampling::warp::sample_hemisphere_cosine;

/// The value of a BSDF for one pair of directions, and the density with which `sample` generates it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BsdfValue<V = Vec3> {
    /// f(wo, wi), without the cosine and without delta lobes.
    pub f: Rgb<V>,
    /// The density of `sample` at wi, given wo. Delta lobes take their share of the probability, but have no density.
    pub pdf: PdfSolidAngle,
}

/// Mirrors both directions to the upper side, for models that scatter alike on both; `None` if the directions are on
/// different sides or one is tangential.
#[inline]
pub fn facing_up(wo: Vec3, wi: Vec3) -> Option<(Vec3, Vec3)> {
    let up = |w: Vec3| Vec3::new(w.x, w.y, w.z.abs());
    is_same_side(wo, wi).then(|| (up(wo), up(wi)))
}

/// Whether two directions are on the same side, and neither is tangential.
#[inline(always)]
pub fn is_same_side<V: Vector>(wo: V, wi: V) -> bool {
    // Compare signs: the product underflows for two grazing directions.
    let (o, i) = (wo.z(), wi.z());
    ((o > 0.0) & (i > 0.0)) | ((o < 0.0) & (i < 0.0))
}

/// The random numbers for sampling a direction, in [0, 1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BsdfSampleInput {
    /// Number for the choice of the lobe, and for nothing else.
    pub lobe: f32,
    /// Numbers for the direction.
    pub u: Vec2,
    /// The cosine-weighted direction for `u`, which most BSDFs need. It is stored so that callers with many inputs can
    /// compute it in SIMD lanes.
    pub cosine_direction: Vec3,
}

impl BsdfSampleInput {
    /// Creates the input from one number for the lobe and two for the direction.
    #[inline]
    pub fn new(lobe: f32, u: Vec2) -> Self {
        Self {
            lobe,
            u,
            cosine_direction: sample_hemisphere_cosine(u),
        }
    }
}

/// A sampled direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BsdfSample<V = Vec3> {
    /// The incident direction, local.
    pub wi: V,
    /// f |cos(wi)| / pdf, over all lobes that could have produced `wi`.
    pub weight: Rgb<V>,
    /// The density of `wi`; `None` for a delta lobe.
    pub pdf: Option<PdfSolidAngle>,
    /// The sampled lobe.
    pub lobe: Lobe,
}

/// The kind of scattering of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lobe {
    /// Diffuse reflection.
    Diffuse,
    /// Reflection by a rough surface.
    GlossyReflection,
    /// Refraction through a rough surface.
    GlossyTransmission,
    /// Mirror reflection: a delta lobe.
    SpecularReflection,
    /// Refraction through a smooth surface: a delta lobe.
    SpecularTransmission,
}

impl Lobe {
    /// Whether the lobe transmits light through the surface.
    #[inline]
    pub fn is_transmission(self) -> bool {
        matches!(self, Self::GlossyTransmission | Self::SpecularTransmission)
    }
}

/// The effect that a delta lobe or a glossy lobe needs.
pub fn effects_of_lobes(is_delta: bool) -> EffectSet {
    EffectSet::NONE.with(if is_delta {
        Effect::Specular
    } else {
        Effect::Glossy
    })
}
