//! The primary sample space sampler: the random numbers of a sample as a point that a Markov chain mutates.
//!
//! A large step draws every number anew. A small step adds a nearly normal number to each, modulo 1. Its standard
//! deviation is the same for all numbers; it is drawn for each step, uniform in its logarithm over [`STEPS`]. Numbers are
//! updated lazily: one that was not drawn during several small steps is then moved once, by the sum of their variances.
//! The new value of a number is a function of the seed, the step and the decision, so that leaving a decision out changes
//! no other.
//!
//! Measure: uniform in [0, 1 - 2^-24], a multiple of 2^-24, if all steps are accepted.
//! Range: any decisions. A chain has neither pixels nor samples: [`Sampler::start`] changes nothing.
//! Source: Kelemen, Szirmay-Kalos, Antal and Csonka 2002, "A Simple and Robust Mutation Strategy for the Metropolis Light
//! Transport Algorithm". Tested below.

use super::{Decision, Sampler, hash, to_unit};
use crate::math::functions::powf;
use crate::planted::planted;
use std::mem;
use std::ops::Range;

/// The standard deviations of small steps.
pub const STEPS: Range<f64> = 0.003..0.03;

/// The probability of a large step.
pub const LARGE_STEPS: f64 = 0.3;

/// The slot of the chain's own random numbers, beyond those of any decision.
const CHAIN: u64 = 1 << 50;

/// The numbers reserved for one slot in one proposal.
const PER_SLOT: u64 = 1 << 8;

/// The index of the first number of [`Primary::draw_until`], after the others of the same slot.
const FIRST: u64 = 4;

/// log2 of the number of slots of one kind of decisions.
const KIND: u32 = 40;

/// The number of kinds of decisions: slots are below this times 2^[`KIND`].
const KINDS: usize = 5;

/// The state of a Markov chain in primary sample space.
#[derive(Debug, Clone)]
pub struct Primary {
    seed: u64,
    /// The seed of the current proposal, whether or not those before were accepted.
    attempt_seed: u64,
    attempts: u64,
    /// Coordinates by kind, as many as have been drawn.
    coordinates: [Vec<Coordinate>; KINDS],
    /// Slots and previous values of the coordinates that the current step has changed.
    before: Vec<(u64, Coordinate)>,
    /// The current step, which [`Coordinate`]s are compared with.
    now: ChainStep,
    /// The last accepted step.
    accepted: ChainStep,
    /// The last accepted large step.
    large: ChainStep,
    is_large: bool,
}

/// A step of the chain.
#[derive(Debug, Clone, Copy, Default)]
struct ChainStep {
    /// Counted from 1.
    number: u64,
    /// The sum of the variances of all small steps up to this one.
    variance: f64,
}

/// One number, as of the step in which it was last drawn.
#[derive(Debug, Clone, Copy, Default)]
struct Coordinate {
    value: f64,
    step: ChainStep,
}

impl Primary {
    /// Creates a chain at a uniformly distributed point.
    pub fn new(seed: u64) -> Self {
        let first = ChainStep {
            number: 1,
            variance: 0.0,
        };
        Self {
            seed,
            attempt_seed: hash::combine(seed, 0),
            attempts: 0,
            coordinates: Default::default(),
            before: Vec::new(),
            now: first,
            accepted: first,
            large: first,
            is_large: true,
        }
    }

    /// Starts a chain as [`Self::new`] does, in the memory of this one.
    pub fn restart(&mut self, seed: u64) {
        let mut anew = Self {
            coordinates: mem::take(&mut self.coordinates),
            before: mem::take(&mut self.before),
            ..Self::new(seed)
        };
        anew.coordinates.iter_mut().for_each(Vec::clear);
        anew.before.clear();
        *self = anew;
    }

    /// Returns the chain at the current point, with another seed for the steps that follow.
    pub fn reseeded(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Draws the number of a decision until it satisfies `is_wanted` (rejection sampling). The number must not have been
    /// drawn before.
    pub fn draw_until(&mut self, decision: Decision, is_wanted: impl Fn(f32) -> bool) {
        let slot = decision.slot();
        let mut drawn = (0..).map(|i| self.number(slot, FIRST + i));
        if let Some(value) = drawn.find(|&value| is_wanted(unit(value))) {
            let step = self.now;
            *self.coordinate(slot) = Coordinate { value, step };
        }
    }

    /// Proposes another point, to which the numbers drawn from now on belong.
    pub fn propose(&mut self) {
        self.before.clear();
        self.attempts += 1;
        self.attempt_seed = hash::combine(self.seed, self.attempts);
        self.is_large = self.number(CHAIN, 0) < LARGE_STEPS;
        self.now.number += 1;
        if !self.is_large {
            let ratio = STEPS.end / STEPS.start;
            let deviation = STEPS.start * powf(ratio, self.number(CHAIN, 2));
            self.now.variance += deviation * deviation;
        }
    }

    /// Accepts the proposed point.
    pub fn accept(&mut self) {
        self.accepted = self.now;
        if self.is_large {
            self.large = self.now;
        }
        self.before.clear();
    }

    /// Rejects the proposed point and restores the one before.
    pub fn reject(&mut self) {
        let forgotten = planted!("rejected-steps-stay", 1, 0);
        while self.before.len() > forgotten
            && let Some((slot, coordinate)) = self.before.pop()
        {
            *self.coordinate(slot) = coordinate;
        }
        self.before.clear();
        self.now = self.accepted;
    }

    /// The random number for the acceptance of the current step.
    pub fn acceptance_number(&self) -> f64 {
        self.number(CHAIN, 1)
    }

    fn bits(&self, slot: u64, which: u64) -> u64 {
        hash::combine(self.attempt_seed, slot * PER_SLOT + which)
    }

    /// A uniform random number of the current proposal.
    fn number(&self, slot: u64, which: u64) -> f64 {
        (self.bits(slot, which) >> 11) as f64 * f64::EPSILON / 2.0
    }

    /// A number of mean 0 and variance 1: the sum of four uniform ones, which is nearly normal. Only its symmetry is
    /// required.
    fn normal(&self, slot: u64) -> f64 {
        let bits = self.bits(slot, 2);
        let sum: u64 = (0..4).map(|i| bits >> (16 * i) & 0xffff).sum();
        // Each of the four is an integer below 2^16, of mean 32767.5 and variance (2^32 - 1) / 12.
        (sum as f64 - 131_070.0) * (3.0_f64 / 4_294_967_295.0).sqrt()
    }

    fn coordinate(&mut self, slot: u64) -> &mut Coordinate {
        let of_kind = &mut self.coordinates[(slot >> KIND) as usize];
        let place = (slot & ((1 << KIND) - 1)) as usize;
        if place >= of_kind.len() {
            of_kind.resize(place + 1, Coordinate::default());
        }
        &mut of_kind[place]
    }

    fn value(&mut self, slot: u64) -> f64 {
        let (now, large) = (self.now, self.large);
        let before = *self.coordinate(slot);
        if before.step.number == now.number {
            return before.value;
        }
        self.before.push((slot, before));
        let Coordinate { mut value, step } = before;
        let mut slept = now.variance - step.variance;
        if step.number < large.number {
            value = self.number(slot, 0);
            slept = now.variance - large.variance;
        }
        if self.is_large && now.number > large.number {
            value = self.number(slot, 1);
        } else if slept > 0.0 {
            let moved = value + slept.sqrt() * self.normal(slot);
            value = moved - moved.floor();
        }
        *self.coordinate(slot) = Coordinate { value, step: now };
        value
    }
}

impl Sampler for Primary {
    fn start(&mut self, _pixel: [u32; 2], _sample: u64) {}

    fn draw<const N: usize>(&mut self, decision: Decision) -> [f32; N] {
        let first = decision.slot();
        std::array::from_fn(|i| unit(self.value(first + i as u64)))
    }
}

/// Converts a coordinate to a random number.
fn unit(value: f64) -> f32 {
    to_unit((value * 4_294_967_296.0) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(primary: &mut Primary) -> [[f32; 3]; 3] {
        [0, 1, 7].map(|bounce| primary.draw(Decision::Bsdf(bounce)))
    }

    #[test]
    fn primary_samples_are_reproducible_and_restored_on_rejection() {
        let mut chain = Primary::new(3);
        let mut here = numbers(&mut chain);
        assert_eq!(numbers(&mut Primary::new(3)), here);
        chain.accept();
        for step in 0..1000 {
            assert_eq!(numbers(&mut chain), here);
            chain.propose();
            let there = numbers(&mut chain);
            assert_eq!(numbers(&mut chain), there);
            assert!(there != here);
            if step % 3 == 0 {
                chain.accept();
                here = there;
            } else {
                chain.reject();
            }
        }
    }

    #[test]
    fn restarted_chain_has_the_numbers_of_a_new_one() {
        let mut chain = Primary::new(3);
        for _ in 0..5 {
            chain.propose();
            numbers(&mut chain);
        }
        chain.restart(4);
        let mut new = Primary::new(4);
        for _ in 0..100 {
            assert_eq!(numbers(&mut chain), numbers(&mut new));
            for chain in [&mut chain, &mut new] {
                chain.accept();
                chain.propose();
            }
        }
    }

    /// Numbers stay uniform if every step is accepted, also those that are seldom drawn.
    #[test]
    fn accepted_mutations_preserve_the_uniform_distribution() {
        let mut often = [0_u32; 16];
        let mut seldom = [0_u32; 16];
        let mut beside = 0.0;
        let chains = 4000;
        for seed in 0..chains {
            let mut chain = Primary::new(seed);
            let [u, _]: [f32; 2] = chain.draw(Decision::SourceDirection);
            chain.accept();
            let [first]: [f32; 1] = chain.draw(Decision::Time);
            for _ in 0..20 {
                chain.propose();
                let [_]: [f32; 1] = chain.draw(Decision::Time);
                chain.accept();
            }
            let [last]: [f32; 1] = chain.draw(Decision::Time);
            let [v, _]: [f32; 2] = chain.draw(Decision::SourceDirection);
            often[(16.0 * last) as usize] += 1;
            seldom[(16.0 * v) as usize] += 1;
            beside += f64::from((u - 0.5) * (v - 0.5) + 0.0 * first);
        }
        let chi_square = |cells: [u32; 16]| {
            let expected = chains as f64 / 16.0;
            let squares = cells.iter().map(|&it| (f64::from(it) - expected).powi(2));
            squares.sum::<f64>() / expected
        };
        // The 1e-5 quantile of chi-square with 15 degrees of freedom is 50.5.
        assert!(chi_square(often) < 50.5 && chi_square(seldom) < 50.5);
        // 20 steps of which 30 % are large leave almost no correlation with the first point: 0.7^20 / 12.
        let deviation = (chains as f64).sqrt() / 12.0;
        assert!(beside.abs() < 5.0 * deviation, "{beside} {deviation}");
    }

    #[test]
    fn small_steps_have_expected_variance_when_updated_lazily() {
        // The mean of the variance, whose logarithm is uniform.
        let [min, max] = [STEPS.start, STEPS.end].map(|deviation| deviation * deviation);
        let of_one_step = (max - min) / (max / min).ln();
        for sleeps in [1, 9] {
            let (mut sum, mut sum_of_squares, mut count) = (0.0, 0.0, 0.0);
            for seed in 0..8000 {
                let mut chain = Primary::new(seed);
                let [before]: [f32; 1] = chain.draw(Decision::Time);
                chain.accept();
                for _ in 0..sleeps {
                    chain.propose();
                    chain.accept();
                }
                if chain.large.number > 1 {
                    continue;
                }
                let [after]: [f32; 1] = chain.draw(Decision::Time);
                let moved = f64::from(after - before);
                // Numbers wrap around at 1.
                let moved = moved - moved.round();
                sum += moved;
                sum_of_squares += moved * moved;
                count += 1.0;
            }
            let variance: f64 = sum_of_squares / count;
            let expected = of_one_step * f64::from(sleeps);
            let mean: f64 = sum / count;
            assert!(mean.abs() < 5.0 * (expected / count).sqrt(), "{mean}");
            // The kurtosis of steps of such different sizes is below 10.
            assert!((variance / expected - 1.0).abs() < 5.0 * (9.0 / count).sqrt());
        }
    }
}
