//! Sums over the samples of one pixel, batch by batch.
//!
//! Measure: radiance; twice the precision of a double, so that the order of samples, and their division among several
//! films, changes no bit.
//! Range: finite samples only; the caller counts the others. 192 bytes. `math/exact_sum.rs` states the span of samples
//! up to which sums are exact.
//! Source: `batches.rs`. Tested below.

use super::batches::{BATCHES, BatchMeans, samples_of_batches};
use crate::math::exact_sum::ExactSums;
use crate::math::rgb::Rgb;
use crate::planted::planted;

/// Sums for each batch and each of `C` channels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sums<const C: usize> {
    batches: [ExactSums<C>; BATCHES as usize],
}

/// Sums of the samples of a pixel.
pub type PixelSums = Sums<3>;

impl<const C: usize> Default for Sums<C> {
    fn default() -> Self {
        Self {
            batches: [ExactSums::default(); BATCHES as usize],
        }
    }
}

impl<const C: usize> Sums<C> {
    /// The number of doubles that the sums consist of.
    pub const DOUBLES: usize = 2 * C * BATCHES as usize;

    /// Adds a number to each channel, for the sample with this index.
    #[inline(always)]
    pub fn add_terms(&mut self, index: u64, terms: [f64; C]) {
        self.batches[(index % BATCHES) as usize].add(terms);
    }

    /// Adds the terms of other sums.
    pub fn add_sums(&mut self, other: &Self) {
        for (batch, other) in self.batches.iter_mut().zip(&other.batches) {
            batch.add_sums(other);
        }
    }

    /// The sum of each batch and channel.
    pub fn values(&self) -> [[f64; C]; BATCHES as usize] {
        self.batches.map(|batch| batch.values())
    }

    /// The doubles that the sums consist of, those that hold the values before those that hold their errors.
    pub fn to_doubles(&self) -> impl Iterator<Item = f64> {
        let parts = [0, 1].into_iter();
        parts.flat_map(|part| self.batches.iter().flat_map(move |it| it.parts()[part]))
    }

    /// Adds one double of the [`to_doubles`](Self::to_doubles) of other sums. Adding all nonzero doubles adds these
    /// sums.
    #[inline]
    pub fn add_double(&mut self, index: usize, double: f64) {
        let sum = index % (Self::DOUBLES / 2);
        self.batches[sum / C].add_to(sum % C, double);
    }
}

impl PixelSums {
    /// Adds the sample with this index.
    #[inline]
    pub fn add(&mut self, index: u64, sample: Rgb) {
        let batch = &mut self.batches[(index % BATCHES) as usize];
        let terms = sample.to_array().map(f64::from);
        batch.add(planted!(
            "film-in-single-precision",
            {
                let sums = batch.values();
                std::array::from_fn(|c| f64::from((sums[c] + terms[c]) as f32) - sums[c])
            },
            terms
        ));
    }

    /// The mean of the first `n` samples.
    pub fn mean(&self, n: u64) -> [f64; 3] {
        let values = self.values();
        std::array::from_fn(|c| {
            let sum: f64 = values.iter().map(|batch| batch[c]).sum();
            sum / n.max(1) as f64
        })
    }

    /// The means of the batches of the first `n` samples.
    pub fn batch_means(&self, n: u64) -> BatchMeans {
        let counts = samples_of_batches(n);
        let values = self.values();
        BatchMeans {
            means: std::array::from_fn(|batch| {
                values[batch].map(|sum| sum / counts[batch].max(1) as f64)
            }),
            counts,
            are_black: values.map(|sums| sums == [0.0; 3]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overall_and_batch_means_match_the_samples() {
        let mut sums = PixelSums::default();
        for index in 0..6 {
            sums.add(index, Rgb::new(index as f32, 0.0, 2.0));
        }
        assert_eq!(sums.mean(6), [2.5, 0.0, 2.0]);
        let batches = sums.batch_means(6);
        assert_eq!(batches.counts, [2, 2, 1, 1]);
        assert_eq!(batches.means.map(|mean| mean[0]), [2.0, 3.0, 2.0, 3.0]);
    }

    #[test]
    fn partial_sums_merge_bit_identically_through_doubles() {
        let sample = |index: u64| Rgb::new(0.1 / index as f32, 1e7, (index % 7) as f32);
        let of = |indices: &[u64]| {
            let mut sums = PixelSums::default();
            indices.iter().for_each(|&i| sums.add(i, sample(i)));
            sums
        };
        let all: Vec<u64> = (1..200).collect();
        let mut parts = of(&all[77..]);
        for (index, double) in of(&all[..77]).to_doubles().enumerate() {
            parts.add_double(index, double);
        }
        assert_eq!(parts, of(&all));
        let mut again = of(&[]);
        for (index, double) in parts.to_doubles().enumerate() {
            again.add_double(index, double);
        }
        assert_eq!(again, parts);
    }

    #[test]
    fn mean_stays_accurate_over_many_equal_samples() {
        // In single precision this sum is off by 1 % after a million samples.
        let mut sums = PixelSums::default();
        let n = 1 << 24;
        for index in 0..n {
            sums.add(index, Rgb::grey(0.1));
        }
        assert!((sums.mean(n)[0] / f64::from(0.1_f32) - 1.0).abs() < 1e-9);
    }
}
