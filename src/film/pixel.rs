//! Sums over the samples of one pixel.
//!
//! Measure: radiance; double precision, so that 10^8 equal samples still have their mean.
//! Range: finite samples only; the caller counts the others.
//! Source: the variance of a mean, sum (x - mean)^2 / (n (n - 1)). Tested below.

use crate::math::rgb::Rgb;
use crate::planted::planted;

/// Sums of samples and of their squares, for each channel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PixelSums {
    sum: [f64; 3],
    sum_of_squares: [f64; 3],
}

impl PixelSums {
    /// Takes one sample in.
    #[inline]
    pub fn add(&mut self, sample: Rgb) {
        let channels = sample.to_array().map(f64::from);
        for ((sum, squares), x) in self
            .sum
            .iter_mut()
            .zip(&mut self.sum_of_squares)
            .zip(channels)
        {
            *sum += planted!(
                "film-in-single-precision",
                f64::from((*sum + x) as f32) - *sum,
                x
            );
            *squares += x * x;
        }
    }

    /// The mean of `n` samples.
    pub fn mean(&self, n: u64) -> [f64; 3] {
        self.sum.map(|sum| sum / n.max(1) as f64)
    }

    /// The variance of that mean, if the samples are independent; `None` for fewer than two.
    pub fn variance_of_mean(&self, n: u64) -> Option<[f64; 3]> {
        let count = n as f64;
        (n > 1).then(|| {
            std::array::from_fn(|c| {
                let deviations = self.sum_of_squares[c] - self.sum[c] * self.sum[c] / count;
                deviations.max(0.0) / (count * (count - 1.0))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_samples_have_a_mean_and_a_variance() {
        let mut sums = PixelSums::default();
        sums.add(Rgb::new(1.0, 0.0, 2.0));
        assert_eq!(sums.variance_of_mean(1), None);
        sums.add(Rgb::new(3.0, 0.0, 2.0));
        assert_eq!(sums.mean(2), [2.0, 0.0, 2.0]);
        assert_eq!(sums.variance_of_mean(2), Some([1.0, 0.0, 0.0]));
    }

    #[test]
    fn many_equal_samples_keep_their_mean() {
        // In single precision this sum is off by 1 % after a million samples.
        let mut sums = PixelSums::default();
        let n = 1 << 22;
        for _ in 0..n {
            sums.add(Rgb::grey(0.1));
        }
        assert!((sums.mean(n)[0] / f64::from(0.1_f32) - 1.0).abs() < 1e-9);
    }
}
