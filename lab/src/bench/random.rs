//! Random numbers, points and directions for what the bench makes itself.
//!
//! Measure: uniform in [0, 1 - 2^-24] and what is made of that.
//! Range: any seed; the same seed gives the same numbers everywhere.
//! Source: O'Neill 2014 (PCG), in rand_pcg. Tested through `lab/tests/bench/scenes.rs`.

use etendue::internals::math::vec::{DVec3, Vec2, Vec3};
use etendue::internals::sampler::hash::combine;
use etendue::internals::sampling::warp::sample_sphere_uniform;
use rand_core::Rng;
use rand_pcg::Pcg32;

/// A stream of random numbers.
#[derive(Debug)]
pub struct Random(Pcg32);

impl Random {
    /// The stream of a block of work below a seed.
    pub fn new(seed: u64, block: u64) -> Self {
        let seed = combine(seed, block);
        Self(Pcg32::new(seed, combine(seed, 0)))
    }

    /// A uniform number.
    #[inline]
    pub fn uniform(&mut self) -> f32 {
        (self.0.next_u32() >> 8) as f32 * (1.0 / 16_777_216.0)
    }

    /// A uniform number in an interval.
    #[inline]
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.uniform())
    }

    /// A uniform index below `count`, which is at least 1 and no more than 2^24.
    #[inline]
    pub fn below(&mut self, count: usize) -> usize {
        (f64::from(self.uniform()) * count as f64) as usize
    }

    /// A uniform point of the cube from -1 to 1.
    #[inline]
    pub fn in_cube(&mut self) -> DVec3 {
        let mut coordinate = || self.between(-1.0, 1.0);
        DVec3::new(coordinate(), coordinate(), coordinate())
    }

    /// A uniform direction.
    #[inline]
    pub fn direction(&mut self) -> Vec3 {
        sample_sphere_uniform(Vec2::new(self.uniform(), self.uniform()))
    }
}
