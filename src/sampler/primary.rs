//! Numbers that are proposed as changes of those before: the random numbers of a sample as a point in a space of its own, in
//! which a Markov chain walks.
//!
//! A large step draws every number anew. A small step adds to each a normal number of standard deviation [`STEP`], around the
//! end of the interval and in again at its beginning. What is not asked for is not drawn: a number that has slept through n
//! small steps gets one of deviation sqrt(n) times as large, which is the same. What a number becomes is a function of the seed,
//! the step and what the number is for, so that leaving a decision out moves no other.
//!
//! Measure: uniform in [0, 1 - 2^-24], a multiple of 2^-24, if steps were all accepted.
//! Range: any decisions. A chain has neither pixels nor samples: [`Sampler::start`] changes nothing.
//! Source: Kelemen, Szirmay-Kalos, Antal and Csonka 2002, "A Simple and Robust Mutation Strategy for the Metropolis Light
//! Transport Algorithm". Tested below.

use super::{Decision, Sampler, hash, to_unit};
use crate::planted::planted;
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::hash::{BuildHasherDefault, Hasher};

/// The standard deviation of a small step.
pub const STEP: f64 = 0.01;

/// How often a step is large.
pub const LARGE_STEPS: f64 = 0.3;

/// What is drawn for the chain itself: beyond the numbers of any decision.
const CHAIN: u64 = 1 << 50;

/// What tells the numbers that are drawn until one is wanted from others for the same decision.
const FIRST: u64 = 4;

/// A point in the space of a sample's random numbers, and how it moves.
#[derive(Debug, Clone)]
pub struct Primary {
    seed: u64,
    /// Proposals so far, whatever became of them.
    attempt: u64,
    coordinates: HashMap<u64, Coordinate, BuildHasherDefault<SlotHasher>>,
    /// What the coordinates were that the present step has changed.
    before: Vec<(u64, Coordinate)>,
    /// The number of the present step, counted from 1.
    step: u64,
    /// The last large step that was accepted.
    last_large: u64,
    is_large: bool,
}

/// One number, after the step in which it was last asked for.
#[derive(Debug, Clone, Copy, Default)]
struct Coordinate {
    value: f64,
    step: u64,
}

impl Primary {
    /// A point that is uniform: where a chain may begin.
    pub fn new(seed: u64) -> Self {
        Self {
            seed,
            attempt: 0,
            coordinates: HashMap::default(),
            before: Vec::new(),
            step: 1,
            last_large: 1,
            is_large: true,
        }
    }

    /// The same point, to go on by random numbers of another seed.
    pub fn reseeded(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Draws the number of a decision, which nobody has asked for, until it is a wanted one: as if chance had made it so.
    pub fn draw_until(&mut self, decision: Decision, is_wanted: impl Fn(f32) -> bool) {
        let slot = decision.slot();
        let drawn = (0..).map(|i| self.number(slot, FIRST + i));
        let value = drawn.into_iter().find(|&value| is_wanted(unit(value)));
        let step = self.step;
        if let Some(value) = value {
            self.coordinates.insert(slot, Coordinate { value, step });
        }
    }

    /// Proposes another point, which the numbers drawn from now on are of.
    pub fn propose(&mut self) {
        self.step += 1;
        self.attempt += 1;
        self.is_large = self.number(CHAIN, 0) < LARGE_STEPS;
        self.before.clear();
    }

    /// Stays at the point that was proposed.
    pub fn accept(&mut self) {
        if self.is_large {
            self.last_large = self.step;
        }
        self.before.clear();
    }

    /// Goes back to the point before.
    pub fn reject(&mut self) {
        let forgotten = planted!("rejected-steps-stay", 1, 0);
        for (slot, coordinate) in self.before.drain(forgotten.min(self.before.len())..) {
            self.coordinates.insert(slot, coordinate);
        }
        self.before.clear();
        self.step -= 1;
    }

    /// The number that decides whether a step is accepted.
    pub fn verdict(&self) -> f64 {
        self.number(CHAIN, 1)
    }

    /// A number of this attempt.
    fn number(&self, slot: u64, which: u64) -> f64 {
        let attempt = hash::combine(self.seed, self.attempt);
        let bits = hash::combine(hash::combine(attempt, slot), which);
        (bits >> 11) as f64 * f64::EPSILON / 2.0
    }

    fn value(&mut self, slot: u64) -> f64 {
        let mut coordinate = self.coordinates.get(&slot).copied().unwrap_or_default();
        if coordinate.step < self.step {
            self.before.push((slot, coordinate));
            if coordinate.step < self.last_large {
                coordinate.value = self.number(slot, 0);
                coordinate.step = self.last_large;
            }
            let steps = self.step - coordinate.step;
            if steps > 0 {
                coordinate.value = if self.is_large {
                    self.number(slot, 1)
                } else {
                    let deviation = STEP * (steps as f64).sqrt();
                    let moved = coordinate.value + deviation * self.normal(slot);
                    moved - moved.floor()
                };
            }
            coordinate.step = self.step;
            self.coordinates.insert(slot, coordinate);
        }
        coordinate.value
    }

    /// A normal number (Box and Muller).
    fn normal(&self, slot: u64) -> f64 {
        let (u, v) = (1.0 - self.number(slot, 2), self.number(slot, 3));
        (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
    }
}

impl Sampler for Primary {
    fn start(&mut self, _pixel: [u32; 2], _sample: u64) {}

    fn draw<const N: usize>(&mut self, decision: Decision) -> [f32; N] {
        let first = decision.slot();
        std::array::from_fn(|i| unit(self.value(first + i as u64)))
    }
}

/// A coordinate as a random number.
fn unit(value: f64) -> f32 {
    to_unit((value * 4_294_967_296.0) as u32)
}

/// Hashes the slots of numbers.
#[derive(Debug, Clone, Copy, Default)]
pub struct SlotHasher(u64);

impl Hasher for SlotHasher {
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = hash::mix(self.0 ^ u64::from(byte));
        }
    }

    fn write_u64(&mut self, slot: u64) {
        self.0 = hash::mix(self.0 ^ slot);
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(primary: &mut Primary) -> [[f32; 3]; 3] {
        [0, 1, 7].map(|bounce| primary.draw(Decision::Bsdf(bounce)))
    }

    #[test]
    fn a_point_is_the_same_whenever_it_is_asked_for_and_after_a_rejection() {
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

    /// Whatever is accepted without looking stays uniform, also what is seldom asked for.
    #[test]
    fn steps_leave_numbers_uniform() {
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
        // 20 steps of which 30 % are large leave nothing of where a chain was: a correlation of 0.7^20 / 12.
        let deviation = (chains as f64).sqrt() / 12.0;
        assert!(beside.abs() < 5.0 * deviation, "{beside} {deviation}");
    }

    #[test]
    fn small_steps_are_normal_with_their_deviation_however_long_a_number_slept() {
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
                if chain.last_large > 1 {
                    continue;
                }
                let [after]: [f32; 1] = chain.draw(Decision::Time);
                let moved = f64::from(after - before);
                // Around the end.
                let moved = moved - moved.round();
                sum += moved;
                sum_of_squares += moved * moved;
                count += 1.0;
            }
            let variance: f64 = sum_of_squares / count;
            let expected = STEP * STEP * f64::from(sleeps);
            let mean: f64 = sum / count;
            assert!(mean.abs() < 5.0 * (expected / count).sqrt(), "{mean}");
            assert!((variance / expected - 1.0).abs() < 5.0 * (2.0 / count).sqrt());
        }
    }
}
