//! Light at a surface that light sampling does not find there: a path may be followed for it, or it may be known.
//!
//! Measure: radiance.
//! Range: any surface.
//! Source: Ward, Rubinstein and Clear 1988, who part the indirect light from the direct. Tested in
//! `tests/rendering/irradiance_cache.rs`.

use crate::bsdf::Bsdf;
use crate::effects::Effects;
use crate::math::rgb::Rgb;
use crate::scene::interaction::Interaction;

/// What a path tracer knows of indirect light.
pub trait Indirect: Copy + Send + Sync {
    /// Radiance back along the path, of light that no light sampling finds at this surface, if it is known there: the path
    /// then ends. `bounce` counts the scattering events before, `is_limited` tells whether they are limited.
    fn reflected<E: Effects>(
        &self,
        at: &Interaction<E>,
        bsdf: &Bsdf,
        bounce: u32,
        is_limited: bool,
    ) -> Option<Rgb>;
}

/// It is known nowhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Traced;

impl Indirect for Traced {
    #[inline(always)]
    fn reflected<E: Effects>(&self, _: &Interaction<E>, _: &Bsdf, _: u32, _: bool) -> Option<Rgb> {
        None
    }
}
