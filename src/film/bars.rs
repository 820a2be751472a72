//! What the error bar of one pixel is made of: its samples in independent batches, and powers of all of them.
//!
//! The standard error of a pixel is that of the mean of its batches, which tells the truth for points that are spread
//! evenly, too: those of one batch are not independent, but batches are. Their mean is within t(15) standard errors of the
//! expectation, if batches are near enough to a normal distribution. That they are not is told by the variance of the
//! variance.
//!
//! Measure: radiance; powers of luminance.
//! Range: as many samples in each batch; finite ones.
//! Source: L'Ecuyer, Nakayama, Owen and Tuffin 2023, "Confidence Intervals for Randomized Quasi-Monte Carlo
//! Estimators"; the variance of the variance by Pederson, Forster and Booth 1997. Tested below and in
//! `tests/rendering/error_bars.rs`.

use crate::math::rgb::Rgb;
use crate::math::stats::Moments;

/// Independent batches that the samples of a pixel are dealt out to in turn.
pub const BATCHES: u64 = 16;

/// A variance is not to be trusted if its own relative variance is as large as this.
const LARGEST_VARIANCE_OF_VARIANCE: f64 = 0.1;

/// A mean is not nearly normal if its squared skewness is as large as this.
const LARGEST_SKEWNESS_SQUARED: f64 = 0.05;

/// Sums over the samples of one pixel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PixelBars {
    batches: [[f64; 3]; BATCHES as usize],
    /// Sums of luminance, its square, cube and fourth power.
    powers: [f64; 4],
}

impl PixelBars {
    /// Takes the sample with this index in.
    #[inline]
    pub fn add(&mut self, index: u64, sample: Rgb) {
        let batch = &mut self.batches[(index % BATCHES) as usize];
        for (sum, x) in batch.iter_mut().zip(sample.to_array()) {
            *sum += f64::from(x);
        }
        let x = f64::from(sample.luminance());
        let x2 = x * x;
        for (sum, power) in self.powers.iter_mut().zip([x, x2, x2 * x, x2 * x2]) {
            *sum += power;
        }
    }

    /// The mean of the samples of every second batch, of `n` in all batches: independent of that of the other batches.
    pub fn half_mean(&self, n: u64) -> [f64; 3] {
        let per_half = n.max(1) as f64 / 2.0;
        std::array::from_fn(|c| {
            let sum: f64 = self.batches.iter().step_by(2).map(|batch| batch[c]).sum();
            sum / per_half
        })
    }

    /// The variance of the mean of `n` samples, for each channel.
    pub fn variance_of_mean(&self, n: u64) -> [f64; 3] {
        variance_of_mean(&self.batch_means(n))
    }

    /// The means of `n` samples in each batch.
    pub fn batch_means(&self, n: u64) -> [[f64; 3]; BATCHES as usize] {
        let per_batch = n as f64 / BATCHES as f64;
        self.batches.map(|batch| batch.map(|sum| sum / per_batch))
    }

    /// The second, third and fourth central moment of `n` samples.
    pub fn central_moments(&self, n: u64) -> CentralMoments {
        let [a, b, c, d] = self.powers.map(|sum| sum / n.max(1) as f64);
        let second = (b - a * a).max(0.0);
        CentralMoments {
            second,
            third: c - 3.0 * a * b + 2.0 * a * a * a,
            fourth: (d - 4.0 * a * c + 6.0 * a * a * b - 3.0 * a * a * a * a).max(second * second),
        }
    }
}

/// The variance of the mean of batches with these means, for each channel.
pub fn variance_of_mean(batches: &[[f64; 3]; BATCHES as usize]) -> [f64; 3] {
    std::array::from_fn(|c| {
        let means = Moments::of(batches.iter().map(|batch| batch[c]));
        means.variance().expect("there are several batches") / BATCHES as f64
    })
}

/// The central moments of the batches that such means are of, of their luminance: without bias, but for the square of the
/// variance in the fourth.
pub fn moments_of_batches(batches: &[[f64; 3]; BATCHES as usize]) -> CentralMoments {
    let luminance = batches.map(|[r, g, b]| 0.2126 * r + 0.7152 * g + 0.0722 * b);
    let n = BATCHES as f64;
    let mean = luminance.iter().sum::<f64>() / n;
    let power = |power| {
        let powers = luminance.iter().map(|x| (x - mean).powi(power));
        powers.sum::<f64>() / n
    };
    let second = power(2) * n / (n - 1.0);
    let of_squares = 3.0 * (n - 1.0) * (2.0 * n - 3.0) * second * second;
    CentralMoments {
        second,
        third: power(3) * n * n / ((n - 1.0) * (n - 2.0)),
        fourth: (power(4) * n.powi(3) - of_squares) / ((n - 1.0) * (n * n - 3.0 * n + 3.0)),
    }
}

/// Means of powers of the deviation from the mean.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CentralMoments {
    /// Of the square: the variance.
    pub second: f64,
    /// Of the cube.
    pub third: f64,
    /// Of the fourth power.
    pub fourth: f64,
}

impl CentralMoments {
    /// Whether an error bar from `n` samples with these moments covers as often as it says.
    pub fn is_calibrated(&self, n: u64) -> bool {
        self.is_nearly_normal(n, 1.0)
    }

    /// The same of batches whose means have these moments. What the variance of normal numbers varies by in any case,
    /// Student's distribution knows.
    pub fn of_batches_is_calibrated(&self) -> bool {
        self.is_nearly_normal(BATCHES, 3.0)
    }

    fn is_nearly_normal(&self, n: u64, known: f64) -> bool {
        let n = n as f64;
        if self.second == 0.0 {
            return true;
        }
        let variance2 = self.second * self.second;
        let of_variance = (self.fourth / variance2 - known) / n;
        let skewness2 = self.third * self.third / (variance2 * self.second * n);
        of_variance < LARGEST_VARIANCE_OF_VARIANCE && skewness2 < LARGEST_SKEWNESS_SQUARED
    }
}

impl std::ops::Add for CentralMoments {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            second: self.second + other.second,
            third: self.third + other.third,
            fourth: self.fourth + other.fourth,
        }
    }
}

impl std::ops::Sub for CentralMoments {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self {
            second: self.second - other.second,
            third: self.third - other.third,
            fourth: self.fourth - other.fourth,
        }
    }
}

impl std::ops::Mul<CentralMoments> for f64 {
    type Output = CentralMoments;
    fn mul(self, moments: CentralMoments) -> CentralMoments {
        CentralMoments {
            second: self * moments.second,
            third: self * moments.third,
            fourth: self * moments.fourth,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::hash;

    fn bars(samples: impl IntoIterator<Item = f32>) -> (PixelBars, u64) {
        let mut bars = PixelBars::default();
        let mut n = 0;
        for x in samples {
            bars.add(n, Rgb::grey(x));
            n += 1;
        }
        (bars, n)
    }

    #[test]
    fn batches_that_are_alike_have_no_error() {
        // Each batch has one 0 and one 2: whatever their spread, the mean is exact.
        let (bars, n) = bars((0..32).map(|i| if i < 16 { 0.0 } else { 2.0 }));
        assert_eq!(bars.variance_of_mean(n), [0.0; 3]);
        let moments = bars.central_moments(n);
        let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(close(moments.second, 1.0) && close(moments.third, 0.0));
        assert!(close(moments.fourth, 1.0));
    }

    #[test]
    fn the_variance_is_that_of_the_mean_of_the_batches() {
        // Batch i has the mean i: variance 16 * 17 / 12, of the mean a 16th of it.
        let (bars, n) = bars((0..64).map(|i| (i % 16) as f32));
        for variance in bars.variance_of_mean(n) {
            assert!((variance - 17.0 / 12.0).abs() < 1e-12);
        }
    }

    /// Over many sets of 16 numbers, the moments are those of the distribution that they are from: exponential, with a
    /// variance of 1, 2 and 9, which is no normal one.
    #[test]
    fn moments_of_batches_are_those_of_their_distribution() {
        let mut sum = CentralMoments::default();
        let (sets, mut state) = (40_000, 0_u64);
        for _ in 0..sets {
            let batches = [(); BATCHES as usize].map(|()| {
                state += 1;
                let u = (hash::mix(state.wrapping_mul(0x9e37_79b9_7f4a_7c15)) >> 11) as f64;
                [-(1.0 - u * f64::EPSILON / 2.0).ln(); 3]
            });
            sum = sum + moments_of_batches(&batches);
        }
        let mean = (1.0 / f64::from(sets)) * sum;
        // Deviations of the means of 640,000 numbers; the fourth is a little low, as the square of the variance is high.
        assert!((mean.second - 1.0).abs() < 0.02, "{mean:?}");
        assert!((mean.third - 2.0).abs() < 0.1, "{mean:?}");
        assert!((mean.fourth - 9.0).abs() < 1.5, "{mean:?}");
        assert!(!mean.of_batches_is_calibrated());
        let normal = CentralMoments {
            second: 1.0,
            third: 0.0,
            fourth: 3.0,
        };
        assert!(normal.of_batches_is_calibrated());
    }

    #[test]
    fn a_half_has_every_second_batch() {
        // Batch i has the mean i: those of even index 7, the others 8.
        let (bars, n) = bars((0..64).map(|i| (i % 16) as f32));
        assert_eq!(bars.half_mean(n), [7.0; 3]);
    }

    #[test]
    fn rare_events_are_not_trusted_until_there_are_many() {
        // One in a hundred: the variance of the variance is about 100 / n.
        let rare = |n: u64| bars((0..n).map(|i| if i % 100 == 7 { 1.0 } else { 0.0 }));
        for (n, is_calibrated) in [(200, false), (800, false), (4000, true)] {
            let (bars, n) = rare(n);
            assert_eq!(
                bars.central_moments(n).is_calibrated(n),
                is_calibrated,
                "{n}"
            );
        }
    }
}
