//! Sums over the samples of one pixel, batch by batch.
//!
//! Measure: radiance; double precision, so that 10^8 equal samples still have their mean.
//! Range: finite samples only; the caller counts the others. 96 bytes.
//! Source: `batches.rs`. Tested below.

use super::batches::{BATCHES, BatchMeans, samples_of_batches};
use crate::math::rgb::Rgb;
use crate::planted::planted;

/// Sums of samples for each batch and channel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PixelSums {
    batches: [[f64; 3]; BATCHES as usize],
}

impl PixelSums {
    /// Adds the sample with this index.
    #[inline]
    pub fn add(&mut self, index: u64, sample: Rgb) {
        let batch = &mut self.batches[(index % BATCHES) as usize];
        for (sum, x) in batch.iter_mut().zip(sample.to_array().map(f64::from)) {
            *sum += planted!(
                "film-in-single-precision",
                f64::from((*sum + x) as f32) - *sum,
                x
            );
        }
    }

    /// The mean of the first `n` samples.
    pub fn mean(&self, n: u64) -> [f64; 3] {
        std::array::from_fn(|c| {
            let sum: f64 = self.batches.iter().map(|batch| batch[c]).sum();
            sum / n.max(1) as f64
        })
    }

    /// The means of the batches of the first `n` samples.
    pub fn batch_means(&self, n: u64) -> BatchMeans {
        let counts = samples_of_batches(n);
        BatchMeans {
            means: std::array::from_fn(|batch| {
                self.batches[batch].map(|sum| sum / counts[batch].max(1) as f64)
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
