//! Batch means of a pixel, and estimates of variance and cumulants from their spread.
//!
//! The samples of a pixel are assigned to a few batches with independent random numbers. Samples of one batch are not
//! independent if they are stratified; batches are, so their spread gives the error for any sampler. With few
//! batches, each keeps most of the gain of stratification, and the variance of a pixel has three degrees of freedom,
//! which `error_bars.rs` moderates by its neighbours.
//!
//! Measure: radiance. Variances and cumulants are those of one sample, as if samples were independent: the variance of a
//! mean of n samples is an n-th of it.
//! Range: any number of samples; a batch without samples is ignored. Cumulants need samples in every batch.
//! Source: L'Ecuyer, Nakayama, Owen and Tuffin 2023, "Confidence Intervals for Randomized Quasi-Monte Carlo Estimators";
//! Fisher's k-statistics, as in Kendall and Stuart, "The Advanced Theory of Statistics", section 12.6. Tested below and in
//! `tests/rendering/error_bars.rs`.

/// The number of independent batches, to which the samples of a pixel are assigned in turn.
pub const BATCHES: u64 = 4;

/// [`BATCHES`] as a `usize`.
const COUNT: usize = BATCHES as usize;

/// The sample count of each batch among the first `n` samples of a pixel: sample i is in batch i mod [`BATCHES`].
pub fn samples_of_batches(n: u64) -> [u64; COUNT] {
    std::array::from_fn(|batch| (n + BATCHES - 1 - batch as u64) / BATCHES)
}

/// The means of the batches of one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatchMeans {
    /// The mean of each batch in each channel; 0 without a sample.
    pub means: [[f64; 3]; COUNT],
    /// The sample count of each batch.
    pub counts: [u64; COUNT],
    /// Whether no sample of the batch has any light.
    pub are_black: [bool; COUNT],
}

impl BatchMeans {
    /// The sample count of all batches.
    pub fn samples(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// The mean of all samples.
    pub fn mean(&self) -> [f64; 3] {
        std::array::from_fn(|c| {
            let sums = self.means.iter().zip(self.counts);
            let sum: f64 = sums.map(|(mean, count)| mean[c] * count as f64).sum();
            sum / self.samples().max(1) as f64
        })
    }

    /// The variance of one sample in each channel, estimated from the spread of the batch means; `None` if fewer than
    /// two batches have samples.
    pub fn variance(&self) -> Option<[f64; 3]> {
        let used = self.counts.iter().filter(|&&count| count > 0).count();
        let mean = self.mean();
        (used > 1).then(|| {
            std::array::from_fn(|c| {
                let squares = self.means.iter().zip(self.counts).map(|(batch, count)| {
                    let deviation = batch[c] - mean[c];
                    count as f64 * deviation * deviation
                });
                squares.sum::<f64>() / (used - 1) as f64
            })
        })
    }

    /// The cumulants of a batch mean's luminance, in units of one sample's variance; `None` unless all batches have
    /// samples.
    pub fn luminance_cumulants(&self) -> Option<Cumulants> {
        if self.counts.contains(&0) {
            return None;
        }
        let luminance = |[r, g, b]: [f64; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let mean = luminance(self.mean());
        // Batch sizes may differ by one sample: deviations are scaled to the same variance.
        let power = |exponent: i32| {
            let batches = self.means.iter().zip(self.counts);
            let powers = batches.map(|(batch, count)| {
                ((luminance(*batch) - mean) * (count as f64).sqrt()).powi(exponent)
            });
            powers.sum::<f64>() / COUNT as f64
        };
        let n = COUNT as f64;
        let (second, fourth) = (power(2), power(4));
        let variance = second * n / (n - 1.0);
        let cumulant = n * n * ((n + 1.0) * fourth - 3.0 * (n - 1.0) * second * second)
            / ((n - 1.0) * (n - 2.0) * (n - 3.0));
        Some(Cumulants {
            variance,
            fourth: cumulant,
            squared_variance: (variance * variance - cumulant / n) * (n - 1.0) / (n + 1.0),
        })
    }

    /// The difference between the two batch means of a half in each channel, and a factor: its product with the
    /// squared difference is an estimate of the variance of one sample. `None` unless both batches have samples.
    pub fn contrast(&self, half: Half) -> Option<([f64; 3], f64)> {
        let [a, b] = half.batches();
        let [n_a, n_b] = [self.counts[a] as f64, self.counts[b] as f64];
        (n_a > 0.0 && n_b > 0.0).then(|| {
            let differences = std::array::from_fn(|c| self.means[a][c] - self.means[b][c]);
            (differences, n_a * n_b / (n_a + n_b))
        })
    }

    /// The mean of the samples of a half.
    pub fn half_mean(&self, half: Half) -> [f64; 3] {
        let [a, b] = half.batches();
        let [n_a, n_b] = [self.counts[a] as f64, self.counts[b] as f64];
        std::array::from_fn(|c| {
            (n_a * self.means[a][c] + n_b * self.means[b][c]) / (n_a + n_b).max(1.0)
        })
    }
}

/// Half of the batches, independent of the other half.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Half {
    /// Batches 0 and 2.
    Even,
    /// Batches 1 and 3.
    Odd,
}

impl Half {
    /// Both halves.
    pub const ALL: [Self; 2] = [Self::Even, Self::Odd];

    /// The two batches of the half.
    pub fn batches(self) -> [usize; 2] {
        match self {
            Self::Even => [0, 2],
            Self::Odd => [1, 3],
        }
    }

    /// The other half.
    pub fn other(self) -> Self {
        match self {
            Self::Even => Self::Odd,
            Self::Odd => Self::Even,
        }
    }
}

/// Unbiased estimates from four batches.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cumulants {
    /// The variance.
    pub variance: f64,
    /// The fourth cumulant: 0 for a normal distribution.
    pub fourth: f64,
    /// The square of the variance.
    pub squared_variance: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::hash;

    fn grey(means: [f64; COUNT], counts: [u64; COUNT]) -> BatchMeans {
        BatchMeans {
            means: means.map(|mean| [mean; 3]),
            counts,
            are_black: means.map(|mean| mean == 0.0),
        }
    }

    #[test]
    fn batch_sample_counts_match_round_robin_assignment() {
        for n in 0..40 {
            let mut counts = [0; COUNT];
            (0..n).for_each(|index| counts[index % COUNT] += 1);
            assert_eq!(samples_of_batches(n as u64), counts);
        }
    }

    #[test]
    fn batch_variance_estimates_the_per_sample_variance() {
        // The means of two samples each are 0, 1, 2, 3: their variance is 5/3, that of one sample twice as much.
        let batches = grey([0.0, 1.0, 2.0, 3.0], [2; COUNT]);
        for variance in batches.variance().expect("there are several batches") {
            assert!((variance - 10.0 / 3.0).abs() < 1e-12);
        }
        let cumulants = batches.luminance_cumulants().expect("there are four");
        assert!((cumulants.variance - 10.0 / 3.0).abs() < 1e-12);
        assert_eq!(grey([1.0, 0.0, 0.0, 0.0], [1, 0, 0, 0]).variance(), None);
        assert_eq!(
            grey([1.0, 3.0, 0.0, 0.0], [1, 1, 0, 0]).variance(),
            Some([2.0; 3])
        );
    }

    /// Sets of batches of these sizes, of transformed uniform numbers.
    fn sets(counts: [u64; COUNT], sets: u64, of_uniform: fn(f64) -> f64) -> Vec<BatchMeans> {
        let mut state = 0_u64;
        let mut sample = || {
            state += 1;
            let u = hash::mix(state.wrapping_mul(0x9e37_79b9_7f4a_7c15)) >> 11;
            of_uniform((u as f64 + 0.5) * f64::EPSILON / 2.0)
        };
        let mut set = || {
            let mut mean = |count| (0..count).map(|_| sample()).sum::<f64>() / count as f64;
            grey(counts.map(&mut mean), counts)
        };
        (0..sets).map(|_| set()).collect()
    }

    /// Over many sets of four batches, the mean estimates are those of the exponential distribution, whose variance
    /// is 1 and whose fourth cumulant is 6; of a mean of n, in units of a sample's variance, 6 / n.
    #[test]
    fn cumulant_estimates_are_unbiased() {
        const SETS: u64 = 200_000;
        for (counts, fourth) in [([1; COUNT], 6.0), ([3; COUNT], 2.0)] {
            let mut sum = Cumulants::default();
            for set in sets(counts, SETS, |u| -u.ln()) {
                let cumulants = set.luminance_cumulants().expect("four batches");
                sum.variance += cumulants.variance / SETS as f64;
                sum.fourth += cumulants.fourth / SETS as f64;
                sum.squared_variance += cumulants.squared_variance / SETS as f64;
            }
            // Five standard errors, by the spread of tenths of the sets.
            assert!((sum.variance - 1.0).abs() < 0.02, "{sum:?}");
            assert!((sum.squared_variance - 1.0).abs() < 0.05, "{sum:?}");
            assert!((sum.fourth - fourth).abs() < 0.15 * fourth + 0.1, "{sum:?}");
        }
    }

    #[test]
    fn half_contrasts_estimate_the_sample_variance() {
        const SETS: u64 = 100_000;
        let sets = sets([3, 3, 2, 2], SETS, |u| u);
        for half in Half::ALL {
            let squares = sets.iter().map(|set| {
                let (difference, share) = set.contrast(half).expect("both have samples");
                share * difference[0] * difference[0]
            });
            let variance = squares.sum::<f64>() / SETS as f64;
            // 1/12, with a standard error of a hundredth of the root of 2 / 1000.
            assert!((12.0 * variance - 1.0).abs() < 0.025, "{variance}");
        }
        assert_eq!(grey([1.0; COUNT], [2, 2, 0, 1]).contrast(Half::Even), None);
    }

    #[test]
    fn half_means_average_to_the_overall_mean() {
        let batches = grey([1.0, 2.0, 3.0, 7.0], [3, 3, 2, 2]);
        let whole = batches.mean()[0];
        assert!((whole - (3.0 + 6.0 + 6.0 + 14.0) / 10.0).abs() < 1e-12);
        let [even, odd] = Half::ALL.map(|half| batches.half_mean(half)[0]);
        assert!((0.5 * (even + odd) - whole).abs() < 1e-12);
        assert!((even - 9.0 / 5.0).abs() < 1e-12);
    }
}
