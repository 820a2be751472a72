//! Sums over the samples of one pixel, batch by batch.
//!
//! Measure: radiance; twice the precision of a double, so that the order of samples, and their division among several
//! films, changes no bit.
//! Range: finite samples only; the caller counts the others. 192 bytes. `math/exact_sum.rs` states the span of samples
//! up to which sums are exact.
//! Source: `batches.rs`. Tested below.

use super::batches::{BATCHES, BatchMeans, samples_of_batches};
use crate::math::exact_sum::ExactSum;
use crate::math::rgb::Rgb;
use crate::planted::planted;

/// Sums of samples for each batch and channel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PixelSums {
    batches: [[ExactSum; 3]; BATCHES as usize],
}

impl PixelSums {
    /// The number of doubles that the sums consist of.
    pub const DOUBLES: usize = 6 * BATCHES as usize;

    /// Adds the sample with this index.
    #[inline]
    pub fn add(&mut self, index: u64, sample: Rgb) {
        let batch = &mut self.batches[(index % BATCHES) as usize];
        for (sum, x) in batch.iter_mut().zip(sample.to_array().map(f64::from)) {
            sum.add(planted!(
                "film-in-single-precision",
                f64::from((sum.value() + x) as f32) - sum.value(),
                x
            ));
        }
    }

    /// The sum of each batch and channel.
    pub fn values(&self) -> [[f64; 3]; BATCHES as usize] {
        self.batches.map(|batch| batch.map(ExactSum::value))
    }

    /// The doubles that the sums consist of, those that hold the values before those that hold their errors.
    pub fn to_doubles(&self) -> [f64; Self::DOUBLES] {
        let sums = self.batches.as_flattened();
        std::array::from_fn(|i| sums[i % sums.len()].parts()[i / sums.len()])
    }

    /// Adds the samples of which this double, one of [`to_doubles`](Self::to_doubles) of their sums, is a part. The samples
    /// are those of sums all of whose doubles, but those that are 0, were added.
    #[inline]
    pub fn add_double(&mut self, index: usize, double: f64) {
        let sums = self.batches.as_flattened_mut();
        let count = sums.len();
        sums[index % count].add(double);
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
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_have_a_mean_and_each_batch_its_own() {
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
    fn divided_samples_have_the_bits_of_all() {
        let sample = |index: u64| Rgb::new(0.1 / index as f32, 1e7, (index % 7) as f32);
        let of = |indices: &[u64]| {
            let mut sums = PixelSums::default();
            indices.iter().for_each(|&i| sums.add(i, sample(i)));
            sums
        };
        let all: Vec<u64> = (1..200).collect();
        let mut parts = of(&all[77..]);
        for (index, double) in of(&all[..77]).to_doubles().into_iter().enumerate() {
            parts.add_double(index, double);
        }
        assert_eq!(parts, of(&all));
        let mut again = of(&[]);
        for (index, double) in parts.to_doubles().into_iter().enumerate() {
            again.add_double(index, double);
        }
        assert_eq!(again, parts);
    }

    #[test]
    fn many_equal_samples_keep_their_mean() {
        // In single precision this sum is off by 1 % after a million samples.
        let mut sums = PixelSums::default();
        let n = 1 << 24;
        for index in 0..n {
            sums.add(index, Rgb::grey(0.1));
        }
        assert!((sums.mean(n)[0] / f64::from(0.1_f32) - 1.0).abs() < 1e-9);
    }
}
