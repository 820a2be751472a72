//! Stratified points: correlated multi-jittered sampling, for a sample count that is known in advance.
//!
//! Every number has N equal strata, which are assigned to the N samples of a pixel, one each, in an order that is hashed
//! from pixel and decision. The first two numbers of a decision, and the last two, are a pair: its samples are also
//! distributed over a grid of about sqrt(N) x sqrt(N) cells, one each. Samples beyond the Nth begin a new set.
//!
//! Measure: uniform in [0, 1 - 2^-24], a multiple of 2^-24.
//! Range: any N from 1 to 65536; a larger or unknown N is divided into sets of 64. Where N = columns * rows has no
//! solution near sqrt(N), a few cells stay empty, and the second number of a pair has a few empty strata, too.
//! Source: Kensler 2013, "Correlated Multi-Jittered Sampling" (Pixar TM 13-01), with permutations of our own. Strata,
//! cells, uniformity and variance in `tests/sampling/sampler.rs`.

use super::{Batches, Decision, Sampler, hash, to_unit};
use crate::planted::planted;

/// Samples in a set where the sample count is unknown or above [`MAX_SET`].
const USUAL_SET: u32 = 64;

/// The largest number of samples in a set.
const MAX_SET: u32 = 1 << 16;

/// The stratified sampler.
#[derive(Debug, Clone)]
pub struct Stratified {
    seed: u64,
    batches: Batches,
    grid: CellGrid,
    /// Seed of the pixel and of the set.
    set_seed: u64,
    /// The sample's index in its set.
    index: u32,
}

impl Stratified {
    /// Creates a sampler for the given seed and samples per pixel, if these are known.
    pub fn new(seed: u64, samples: Option<u64>) -> Self {
        Self::in_batches(seed, samples, Batches::ONE)
    }

    /// Creates a sampler with separate sets for each batch, which has its part of the samples.
    pub fn in_batches(seed: u64, samples: Option<u64>, batches: Batches) -> Self {
        let known = samples.and_then(|n| u32::try_from(n.div_ceil(batches.0)).ok());
        let usable = known.filter(|n| (1..=MAX_SET).contains(n));
        Self {
            seed,
            batches,
            grid: CellGrid::new(usable.unwrap_or(USUAL_SET)),
            set_seed: 0,
            index: 0,
        }
    }
}

impl Sampler for Stratified {
    #[inline]
    fn start(&mut self, pixel: [u32; 2], sample: u64) {
        let samples = u64::from(self.grid.samples);
        let pixel_seed = hash::pixel_seed(self.seed, pixel);
        let (batch, sample) = self.batches.split(sample);
        self.set_seed = hash::combine(batch.seed(pixel_seed), sample / samples);
        self.index = (sample % samples) as u32;
    }

    #[inline]
    fn draw<const N: usize>(&mut self, decision: Decision) -> [f32; N] {
        const { assert!(N <= 4) };
        let slot = planted!("strata-shared-by-decisions", 0, decision.slot());
        let mut numbers = [0.0; N];
        for (pair, numbers) in (0..).zip(numbers.chunks_mut(2)) {
            let seed = hash::combine(self.set_seed, slot + 2 * pair);
            let jitter = hash::combine(seed, u64::from(self.index));
            let stratum = permute(self.index, self.grid.samples, seed);
            numbers[0] = place(stratum, self.grid.samples, jitter as u32);
            if let Some(second) = numbers.get_mut(1) {
                let strata = self.grid.columns * self.grid.rows;
                *second = place(
                    self.grid.partner(stratum, seed),
                    strata,
                    (jitter >> 32) as u32,
                );
            }
        }
        numbers
    }
}

/// The grid of cells of a pair.
#[derive(Debug, Clone, Copy)]
struct CellGrid {
    samples: u32,
    /// Cells along the second number.
    columns: u32,
    /// Cells along the first number; `columns * rows` is `samples` or a little more.
    rows: u32,
}

impl CellGrid {
    fn new(samples: u32) -> Self {
        let root = samples.isqrt();
        let divisor = (1..=root).rev().find(|d| samples.is_multiple_of(*d));
        // Long cells stratify one number at the cost of the other; a few empty cells are better.
        let square = divisor.filter(|d| samples / d <= 2 * d);
        let columns = square.unwrap_or(root);
        let rows = samples.div_ceil(columns);
        Self {
            samples,
            columns,
            rows,
        }
    }

    /// The stratum of a pair's second number, one of `columns * rows`, given that of its first.
    ///
    /// Along the first number, `columns` successive strata form a row of cells. Each is assigned to a column of its own and,
    /// within the column, to the stratum reserved for the row.
    #[inline]
    fn partner(&self, stratum: u32, seed: u64) -> u32 {
        let column = permute(
            stratum % self.columns,
            self.columns,
            hash::combine(seed, 1 << 32),
        );
        let row = permute(
            stratum / self.columns,
            self.rows,
            hash::combine(seed, 1 << 33),
        );
        column * self.rows + row
    }
}

/// A jittered number in one of several equal strata.
#[inline]
fn place(stratum: u32, strata: u32, jitter: u32) -> f32 {
    let [stratum, strata, jitter] = [stratum, strata, jitter].map(u64::from);
    let rounded = ((stratum << 32 | jitter) / strata) >> 8;
    // A number rounded below the stratum's lower end is moved back in.
    let outside = rounded * strata < stratum << 24;
    to_unit((rounded + u64::from(outside)) as u32 * 256)
}

/// The image of `index` in a permutation of `0..count` that `seed` selects.
///
/// A bijection of the next power of two is applied until the result is below `count` (cycle walking), which is again a
/// bijection. The rotation at the end makes every place equally likely, whatever the quality of the bijection.
#[inline]
fn permute(index: u32, count: u32, seed: u64) -> u32 {
    let mask = count.next_power_of_two() - 1;
    let shift = (mask.count_ones() / 2).max(1);
    let keys = [seed as u32, (seed >> 32) as u32];
    let mut x = index;
    loop {
        for key in [
            keys[0],
            keys[1],
            keys[0].rotate_left(16),
            keys[1].rotate_left(16),
        ] {
            // A linear congruential step mod 2^k mixes into higher bits, the shift into lower bits.
            x = x.wrapping_add(key >> 8).wrapping_mul(key | 1) & mask;
            x ^= x >> shift;
        }
        if x < count {
            break;
        }
    }
    let rotation = ((hash::mix(seed) >> 32) * u64::from(count)) >> 32;
    ((u64::from(x) + rotation) % u64::from(count)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn permutations_are_bijective() {
        for count in (1..=130).chain([1000, 65_535, 65_536]) {
            for seed in 0..8 {
                let mut places: Vec<u32> = (0..count)
                    .map(|index| permute(index, count, hash::mix(seed)))
                    .collect();
                places.sort_unstable();
                assert!(places.into_iter().eq(0..count), "{count}, seed {seed}");
            }
        }
    }

    #[test]
    fn grids_hold_all_samples_and_are_nearly_square() {
        for (samples, columns, rows) in [
            (1, 1, 1),
            (2, 1, 2),
            (7, 2, 4),
            (16, 4, 4),
            (32, 4, 8),
            (97, 9, 11),
            (100, 10, 10),
        ] {
            let grid = CellGrid::new(samples);
            assert_eq!((grid.columns, grid.rows), (columns, rows), "{samples}");
        }
        for samples in 1..=MAX_SET {
            let CellGrid { columns, rows, .. } = CellGrid::new(samples);
            assert!(columns * rows >= samples && columns * rows < samples + columns);
            assert!(rows <= 2 * columns || samples <= 3, "{samples}");
        }
    }

    #[test]
    fn sample_set_size_is_the_sample_count_or_the_default() {
        let set = |samples| Stratified::new(0, samples).grid.samples;
        assert_eq!(set(None), 64);
        assert_eq!([1, 100, 65_536].map(|n| set(Some(n))), [1, 100, 65_536]);
        assert_eq!([0, 65_537, u64::MAX].map(|n| set(Some(n))), [64; 3]);
    }
}
