//! Where the random numbers of a sample come from.
//!
//! A sample is a pure function of (seed, pixel, sample index), and each of its numbers is addressed by what it is for,
//! its [`Decision`], never by how many were drawn before. So no image depends on threads or tile order, and a decision
//! that is not taken shifts no other. Strata alone depend on one thing more: how many samples share them out.
//!
//! Measure: uniform in [0, 1 - 2^-24], a multiple of 2^-24.
//! Range: any seed and pixel, any sample index below 2^47, any bounce; no number repeats within these.
//! Source: pbrt, "Sampling Interface", for the division of labour. Tested in `tests/sampling/sampler.rs`.

use crate::planted::planted;
use std::ops::Range;

mod any;
pub mod hash;
pub mod independent;
pub mod primary;
pub mod sobol;
pub mod stratified;

pub use any::AnySampler;
pub use independent::Independent;
pub use primary::Primary;
pub use sobol::Sobol;
pub use stratified::Stratified;

/// What random numbers are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decision {
    /// The camera ray: two numbers for the film, two for the lens.
    Camera,
    /// When the ray is traced: one number.
    Time,
    /// In which way a path is made, where a sample makes one in one way: one number.
    Strategy,
    /// Whether a surface that is only partly there is met, after so many scattering events: one number.
    Alpha(u32),
    /// Whether a path ends with what a surface emits, after so many scattering events: one number.
    Emission(u32),
    /// Next event estimation at a scattering event: two for the point on a light, two for which light.
    Light(u32),
    /// The direction after a scattering event: two numbers for the direction, one for the lobe.
    Bsdf(u32),
    /// Whether the path goes on after a scattering event: one number.
    Roulette(u32),
    /// The beginning of a path from a light: two numbers for the point, two for which light.
    Source,
    /// Where it goes from there: two numbers.
    SourceDirection,
    /// As [`Bsdf`](Self::Bsdf), on a path from a light.
    LightPathBsdf(u32),
    /// As [`Alpha`](Self::Alpha), on a path from a light.
    LightPathAlpha(u32),
    /// As [`Roulette`](Self::Roulette), on a path from a light.
    LightPathRoulette(u32),
    /// The point of the lens that a scattering event on a path from a light is connected to: two numbers.
    Lens(u32),
}

/// Numbers reserved for the camera, and for each bounce.
const BLOCK: u64 = 8;

/// The first of the numbers for partly transparent surfaces, beyond those of any bounce: few scenes need them.
const ALPHA: u64 = 1 << 40;

/// The first of the numbers for coins, which few integrators toss.
const EMISSION: u64 = 1 << 41;

/// The first of the numbers for paths from the lights, which have blocks as those from the camera have.
const LIGHT_PATH: u64 = 1 << 42;

impl Decision {
    /// The decision's first number in the sample's own sequence of numbers.
    #[inline]
    fn slot(self) -> u64 {
        let bounce = |bounce: u32, offset: u64| BLOCK * (1 + u64::from(bounce)) + offset;
        match self {
            Self::Camera => 0,
            Self::Time => 4,
            Self::Strategy => 5,
            Self::Alpha(b) => ALPHA + u64::from(b),
            Self::Emission(b) => EMISSION + u64::from(b),
            Self::Light(b) => bounce(b, 0),
            Self::Bsdf(b) => bounce(b, planted!("light-and-bsdf-share-numbers", 0, 4)),
            Self::Roulette(b) => bounce(b, 7),
            Self::Source => LIGHT_PATH,
            Self::SourceDirection => LIGHT_PATH + 4,
            Self::LightPathBsdf(b) => LIGHT_PATH + bounce(b, 0),
            Self::LightPathAlpha(b) => LIGHT_PATH + bounce(b, 3),
            Self::LightPathRoulette(b) => LIGHT_PATH + bounce(b, 4),
            Self::Lens(b) => LIGHT_PATH + bounce(b, 5),
        }
    }
}

/// A division of the samples of a pixel into batches that know nothing of each other: sample i is in batch i mod n.
///
/// The points of a set that fills its domain evenly are not independent, so that their spread does not tell their error.
/// Several sets of which each has scrambles of its own are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Batches(u64);

impl Batches {
    /// All samples together.
    pub const ONE: Self = Self(1);

    /// So many batches, at least one.
    pub fn new(count: u64) -> Self {
        Self(count.max(1))
    }

    /// The seed of a sample's batch, and the sample's index in it.
    #[inline]
    fn split(self, pixel_seed: u64, sample: u64) -> (u64, u64) {
        if self == Self::ONE {
            return (pixel_seed, sample);
        }
        let seed = hash::combine(pixel_seed, BATCH + sample % self.0);
        (seed, sample / self.0)
    }
}

/// What batches are combined with to seeds: above all that pixels are.
const BATCH: u64 = 1 << 48;

/// A source of random numbers.
pub trait Sampler: Clone + Send + Sync {
    /// Turns to the given sample of the given pixel.
    fn start(&mut self, pixel: [u32; 2], sample: u64);

    /// The first `N` numbers, at most four, of a decision of the current sample.
    fn draw<const N: usize>(&mut self, decision: Decision) -> [f32; N];

    /// Samplers that are turned to each sample of a range of a pixel.
    fn started(&self, pixel: [u32; 2], samples: Range<u64>) -> impl Iterator<Item = Self> {
        samples.map(move |sample| {
            let mut sampler = self.clone();
            sampler.start(pixel, sample);
            sampler
        })
    }

    /// Adds them to others.
    fn start_each(&self, pixel: [u32; 2], samples: Range<u64>, started: &mut Vec<Self>) {
        started.extend(self.started(pixel, samples));
    }

    /// The numbers of a decision of each of some samplers, by their places: tells them one after the other.
    #[inline]
    fn draw_each<const N: usize>(
        samplers: &mut [Self],
        places: &[usize],
        decision: Decision,
        mut tell: impl FnMut([f32; N]),
    ) {
        for &place in places {
            tell(samplers[place].draw(decision));
        }
    }
}

/// The 24 high bits as a number in [0, 1).
#[inline(always)]
fn to_unit(bits: u32) -> f32 {
    let bits = planted!("one-is-drawn", bits as f32 / 256.0, (bits >> 8) as f32);
    bits * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decisions_never_share_a_number() {
        let mut taken = std::collections::HashSet::new();
        let mut take = |decision: Decision, count: u64| {
            for i in 0..count {
                assert!(taken.insert(decision.slot() + i), "{decision:?}");
            }
        };
        take(Decision::Camera, 4);
        take(Decision::Time, 1);
        take(Decision::Strategy, 1);
        take(Decision::Source, 4);
        take(Decision::SourceDirection, 2);
        for bounce in [0, 1, 2, u32::MAX - 1, u32::MAX] {
            take(Decision::Alpha(bounce), 1);
            take(Decision::Emission(bounce), 1);
            take(Decision::Light(bounce), 4);
            take(Decision::Bsdf(bounce), 3);
            take(Decision::Roulette(bounce), 1);
            take(Decision::LightPathBsdf(bounce), 3);
            take(Decision::LightPathAlpha(bounce), 1);
            take(Decision::LightPathRoulette(bounce), 1);
            take(Decision::Lens(bounce), 2);
        }
    }

    #[test]
    fn the_largest_number_is_below_one() {
        assert_eq!(to_unit(u32::MAX), crate::math::vec::ONE_MINUS_EPSILON);
        assert_eq!(to_unit(0), 0.0);
    }
}
