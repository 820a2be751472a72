//! Indirect light at a surface, which light sampling there does not find: traced by continuing the path, or cached.
//!
//! Measure: radiance.
//! Range: any surface.
//! Source: Ward, Rubinstein and Clear 1988, who separate indirect from direct light. Tested in
//! `tests/rendering/irradiance_cache.rs`.

use crate::bsdf::Bsdf;
use crate::effects::Effects;
use crate::math::rgb::Rgb;
use crate::scene::interaction::Interaction;

/// The source of a path tracer's indirect light.
pub trait Indirect: Copy + Send + Sync {
    /// Whether indirect light is ever cached.
    const CACHES: bool = true;

    /// Returns the radiance of the light that light sampling does not find at this surface, reflected back along the
    /// path, if it is cached: the path then ends. `bounce` is the number of scattering events before, `is_limited`
    /// whether that number is limited.
    fn reflected<E: Effects>(
        &self,
        at: &Interaction<E>,
        bsdf: &Bsdf,
        bounce: u32,
        is_limited: bool,
    ) -> Option<Rgb>;
}

/// Indirect light without a cache: every path continues.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Uncached;

impl Indirect for Uncached {
    const CACHES: bool = false;

    #[inline(always)]
    fn reflected<E: Effects>(&self, _: &Interaction<E>, _: &Bsdf, _: u32, _: bool) -> Option<Rgb> {
        None
    }
}
