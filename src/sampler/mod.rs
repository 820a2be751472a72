//! Samplers: the sources of the random numbers of a sample.
//!
//! A sample is a pure function of (seed, pixel, sample index), and each of its numbers is addressed by its [`Decision`],
//! never by the count of numbers drawn before. So no image depends on threads or tile order, and a decision that is not
//! taken shifts no other. The stratified sampler alone also depends on the sample count.
//!
//! Measure: uniform in [0, 1 - 2^-24], a multiple of 2^-24.
//! Range: any seed and pixel, any sample index below 2^47, any bounce; no number repeats within these.
//! Source: pbrt, "Sampling Interface", for the structure of the interface. Tested in `tests/sampling/sampler.rs`.

use crate::math::lanes::{ActiveLanes, LANES, Lanes};
use crate::planted::planted;

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

/// The purpose of random numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decision {
    /// The camera ray: two numbers for the film, two for the lens.
    Camera,
    /// The time of the ray: one number.
    Time,
    /// The strategy of a path, where a sample builds one path by one strategy: one number.
    Strategy,
    /// Whether a sample has a light path, where not every sample has one: one number.
    LightPath,
    /// The alpha test of a hit, after the given number of scattering events: one number.
    Alpha(u32),
    /// Whether a path ends with the emission of a hit, after the given number of scattering events: one number.
    Emission(u32),
    /// Next event estimation at a scattering event: two numbers for the point on a light, two for the selection of the light.
    Light(u32),
    /// The direction after a scattering event: two numbers for the direction, one for the lobe.
    Bsdf(u32),
    /// Russian roulette after a scattering event: one number.
    Roulette(u32),
    /// The start of a light subpath: two numbers for the point, two for the selection of the light.
    Source,
    /// The initial direction of a light subpath: two numbers, and one for the choice of a caustic target.
    SourceDirection,
    /// [`Bsdf`](Self::Bsdf) on a light subpath.
    LightPathBsdf(u32),
    /// [`Alpha`](Self::Alpha) on a light subpath.
    LightPathAlpha(u32),
    /// [`Roulette`](Self::Roulette) on a light subpath.
    LightPathRoulette(u32),
    /// The point on the lens for the connection of a scattering event on a light subpath: two numbers.
    Lens(u32),
}

/// Numbers reserved for the camera, and for each bounce.
const BLOCK: u64 = 8;

/// The first of the numbers for alpha tests, beyond those of any bounce: few scenes need them.
const ALPHA: u64 = 1 << 40;

/// The first of the numbers for [`Decision::Emission`], which few integrators need.
const EMISSION: u64 = 1 << 41;

/// The first of the numbers for light subpaths, which have the same blocks as camera subpaths.
const LIGHT_PATH: u64 = 1 << 42;

impl Decision {
    /// The index of the decision's first number in the sample's own sequence of numbers.
    #[inline]
    fn slot(self) -> u64 {
        let bounce = |bounce: u32, offset: u64| BLOCK * (1 + u64::from(bounce)) + offset;
        match self {
            Self::Camera => 0,
            Self::Time => 4,
            Self::Strategy => 5,
            Self::LightPath => 6,
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

/// A division of the samples of a pixel into independent batches: sample i is in batch i mod n.
///
/// The points of a low-discrepancy set are not independent, so that their variance does not estimate the error. Several
/// sets with scrambles of their own are independent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Batches(u64);

impl Batches {
    /// One batch of all samples.
    pub const ONE: Self = Self(1);

    /// Creates a division into `count` batches, at least one.
    pub fn new(count: u64) -> Self {
        Self(count.max(1))
    }

    /// The seed of a sample's batch, and the sample's index in it.
    #[inline]
    fn split(self, sample: u64) -> (Batch, u64) {
        if self == Self::ONE {
            return (Batch(None), sample);
        }
        (Batch(Some(BATCH + sample % self.0)), sample / self.0)
    }
}

/// The batch of a sample: the value that selects its seed, unless there is one batch only.
#[derive(Debug, Clone, Copy)]
struct Batch(Option<u64>);

impl Batch {
    /// The seed of the batch in a pixel.
    #[inline(always)]
    fn seed(self, pixel_seed: u64) -> u64 {
        match self.0 {
            None => pixel_seed,
            Some(value) => hash::combine(pixel_seed, value),
        }
    }
}

/// The first of the values that select a batch's seed, above all others that a pixel's seed is combined with.
const BATCH: u64 = 1 << 48;

/// The states of the samplers of sixteen paths, from which the numbers of several decisions are drawn.
#[derive(Debug, Clone, Copy)]
pub struct LaneStates([Lanes<u64>; 2]);

impl LaneStates {
    /// Gathers the states of the active lanes, each from the sampler at its place.
    #[inline]
    pub fn gather<S: Sampler>(
        samplers: &[S],
        active: &ActiveLanes<LANES>,
        places: &Lanes<u32>,
    ) -> Self {
        let mut states = Self([[0; LANES]; 2]);
        for lane in active.each() {
            let place = planted!("lanes-share-a-sampler", places[0], places[lane]);
            let [a, b] = samplers[place as usize].lane_state();
            (states.0[0][lane], states.0[1][lane]) = (a, b);
        }
        states
    }
}

/// A source of random numbers.
pub trait Sampler: Clone + Send + Sync {
    /// Starts the given sample of the given pixel.
    fn start(&mut self, pixel: [u32; 2], sample: u64);

    /// Draws the first `N` numbers, at most four, of a decision of the current sample.
    fn draw<const N: usize>(&mut self, decision: Decision) -> [f32; N];

    /// Returns a sampler for each of sixteen pixels, whose columns and rows are given, started at the same sample.
    fn start_lanes(&self, pixels: &[Lanes<u32>; 2], sample: u64) -> [Self; LANES] {
        let [x, y] = pixels;
        std::array::from_fn(|lane| {
            let mut sampler = self.clone();
            sampler.start([x[lane], y[lane]], sample);
            sampler
        })
    }

    /// The state from which numbers are drawn in lanes.
    #[inline(always)]
    fn lane_state(&self) -> [u64; 2] {
        [0; 2]
    }

    /// Draws the numbers of a decision for the active lanes, each from the sampler at its place, whose states have been
    /// gathered. The numbers of the other lanes are arbitrary.
    #[inline]
    fn draw_lanes<const N: usize>(
        samplers: &mut [Self],
        active: &ActiveLanes<LANES>,
        places: &Lanes<u32>,
        _states: &LaneStates,
        decision: Decision,
        numbers: &mut [Lanes<f32>; N],
    ) {
        for lane in active.each() {
            let drawn: [f32; N] = samplers[places[lane] as usize].draw(decision);
            store_each(numbers, lane, drawn);
        }
    }
}

/// Sets the numbers of a lane.
#[inline(always)]
fn store_each<const N: usize>(numbers: &mut [Lanes<f32>; N], lane: usize, drawn: [f32; N]) {
    for (numbers, number) in numbers.iter_mut().zip(drawn) {
        numbers[lane] = number;
    }
}

/// Converts the 24 high bits to a number in [0, 1).
#[inline(always)]
fn to_unit(bits: u32) -> f32 {
    let bits = planted!("one-is-drawn", bits as f32 / 256.0, (bits >> 8) as f32);
    bits * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decisions_use_disjoint_random_number_slots() {
        let mut taken = std::collections::HashSet::new();
        let mut take = |decision: Decision, count: u64| {
            for i in 0..count {
                assert!(taken.insert(decision.slot() + i), "{decision:?}");
            }
        };
        take(Decision::Camera, 4);
        take(Decision::Time, 1);
        take(Decision::Strategy, 1);
        take(Decision::LightPath, 1);
        take(Decision::Source, 4);
        take(Decision::SourceDirection, 3);
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
    fn largest_uniform_number_is_one_minus_epsilon() {
        assert_eq!(to_unit(u32::MAX), crate::math::vec::ONE_MINUS_EPSILON);
        assert_eq!(to_unit(0), 0.0);
    }
}
