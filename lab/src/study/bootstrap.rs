//! The bootstrap: confidence intervals of numbers computed from independent replicates.
//!
//! Measure: that of the number.
//! Range: at least two replicates in each group. Quantiles are those of the replicas, which may be infinite: a time
//! that some replicas never reach has an open interval.
//! Source: Efron and Tibshirani 1993, chapter 13 (percentile intervals); Davison and Hinkley 1997, section 2.5, for the
//! widening by sqrt(n / (n - 1)) that corrects for few replicates. Tested below.

use etendue::internals::sampler::hash::combine;
use rand_core::Rng;
use rand_pcg::Pcg64;
use serde::Serialize;

/// Number of bootstrap replicas for an interval.
pub const REPLICAS: usize = 2000;

/// A number with its confidence interval of 95 %.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ranged {
    /// The number.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl Ranged {
    /// The number with the middle 95 % of its replicas; NaN replicas are left out.
    pub fn of(value: f64, replicas: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = replicas.into_iter().filter(|x| !x.is_nan()).collect();
        sorted.sort_by(f64::total_cmp);
        let [low, high] = match sorted.len() {
            0 => [f64::NAN; 2],
            count => [0.025, 0.975].map(|q: f64| sorted[(q * (count - 1) as f64).round() as usize]),
        };
        Self { value, low, high }
    }

    /// Widens the interval: its ends are `factor` times as far from the number, which is above 0, on a logarithmic scale.
    pub fn widened(self, factor: f64) -> Self {
        let end = |end: f64| self.value * (end / self.value).powf(factor);
        Self {
            low: end(self.low),
            high: end(self.high),
            ..self
        }
    }

    /// Whether the interval contains a number.
    pub fn holds(&self, number: f64) -> bool {
        self.low <= number && number <= self.high
    }
}

/// A random number generator for permutations and resampling.
#[derive(Debug, Clone)]
pub struct Dealer(Pcg64);

impl Dealer {
    /// The generator for a seed.
    pub fn new(seed: u64) -> Self {
        Self(Pcg64::new(u128::from(seed), u128::from(combine(seed, 3))))
    }

    /// A uniform integer below `count`, which is at least 1.
    pub fn below(&mut self, count: usize) -> usize {
        // The high half of a product: biased by at most count / 2^64.
        ((u128::from(self.0.next_u64()) * count as u128) >> 64) as usize
    }

    /// Shuffles items into a random order.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }

    /// Means of groups of replicates, resampled with replacement from each group. The standard deviation of means of n
    /// drawn from n is too small by sqrt((n - 1) / n), which is corrected, on a logarithmic scale where all are
    /// positive.
    pub fn means(&mut self, groups: &[Vec<f64>]) -> Vec<f64> {
        groups.iter().map(|group| self.mean(group)).collect()
    }

    fn mean(&mut self, group: &[f64]) -> f64 {
        let count = group.len();
        let mean = group.iter().sum::<f64>() / count as f64;
        if count < 2 {
            return mean;
        }
        let drawn: f64 = (0..count).map(|_| group[self.below(count)]).sum();
        let drawn = drawn / count as f64;
        let widening = (count as f64 / (count as f64 - 1.0)).sqrt();
        if mean > 0.0 && drawn > 0.0 {
            mean * (drawn / mean).powf(widening)
        } else {
            mean + widening * (drawn - mean)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue::internals::math::stats::Moments;

    #[test]
    fn shuffle_permutations_are_equally_likely() {
        let mut dealer = Dealer::new(3);
        let mut counts = [0_u32; 6];
        for _ in 0..60_000 {
            let mut items = [0, 1, 2];
            dealer.shuffle(&mut items);
            counts[items[0] * 2 + usize::from(items[1] > items[2])] += 1;
        }
        // Chi-square of 5 degrees of freedom: 30.9 at 1e-5.
        let chi: f64 = counts
            .iter()
            .map(|&n| (f64::from(n) - 1e4).powi(2) / 1e4)
            .sum();
        assert!(chi < 30.9, "{counts:?}");
    }

    #[test]
    fn replica_spread_matches_standard_error_of_the_mean() {
        let mut dealer = Dealer::new(5);
        let group: Vec<f64> = (0..8).map(|i| 10.0 + f64::from(i)).collect();
        let error = Moments::of(group.iter().copied())
            .standard_error()
            .expect("eight numbers");
        let replicas =
            Moments::of((0..20_000).map(|_| dealer.means(std::slice::from_ref(&group))[0]));
        let spread = replicas.variance().expect("many").sqrt();
        assert!((spread / error - 1.0).abs() < 0.03, "{spread} {error}");
    }

    #[test]
    fn interval_is_unbounded_with_infinite_replicas() {
        let replicas = (0..1000).map(|i| if i < 100 { f64::INFINITY } else { f64::from(i) });
        let ranged = Ranged::of(500.0, replicas);
        assert!(ranged.high.is_infinite() && ranged.low < 200.0);
        assert!(ranged.holds(500.0) && !ranged.holds(0.0));
    }
}
