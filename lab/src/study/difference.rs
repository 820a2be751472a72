//! Welch's test: whether the means of many noisy numbers differ.
//!
//! Each number comes with a standard error from a few batches, so that the standard error of their mean is itself an
//! estimate: the degrees of freedom of the test account for its uncertainty.
//!
//! Measure: the unit of the numbers; p-values as probabilities.
//! Range: independent numbers that are nearly normal, at least one pair. Differences within the rounding of single
//! precision are ignored.
//! Source: Welch 1947, "The Generalization of Student's Problem when Several Different Population Variances are
//! Involved", with degrees of freedom close to those of Satterthwaite 1946; Šidák 1967. Tested below and, on images, in
//! `study/bias_test.rs`.

use crate::verdict::ROUNDING;
use etendue::internals::math::stats::{student_p_value, student_quantile_of};
use serde::Serialize;

/// A number with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UncertainNumber {
    /// The number.
    pub value: f64,
    /// Its standard error; 0 for exact numbers.
    pub standard_error: f64,
}

/// Sums over pairs of numbers whose means are compared.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Difference {
    count: u64,
    a: f64,
    b: f64,
    variance: f64,
    /// The sum of the squared variances over their degrees of freedom.
    of_variance: f64,
}

/// The comparison of the means of the pairs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeanDifference {
    /// The mean of the second numbers.
    pub reference: f64,
    /// The mean of the first minus that of the second.
    pub difference: f64,
    /// The standard error of the difference.
    pub standard_error: f64,
    /// The degrees of freedom of the standard error.
    pub freedom: f64,
    /// The p-value: the probability of a difference as large if the expected values are equal.
    pub p: f64,
}

impl Difference {
    /// Adds one pair, whose standard errors have `freedom` degrees of freedom.
    pub fn push(&mut self, a: UncertainNumber, b: UncertainNumber, freedom: f64) {
        self.count += 1;
        self.a += a.value;
        self.b += b.value;
        for error in [a.standard_error, b.standard_error] {
            let variance = error * error;
            self.variance += variance;
            // The square of an estimated variance is too large by (f + 2) / f on average.
            self.of_variance += variance * variance / (freedom + 2.0);
        }
    }

    /// The sums over both sets of pairs.
    pub fn merge(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            a: self.a + other.a,
            b: self.b + other.b,
            variance: self.variance + other.variance,
            of_variance: self.of_variance + other.of_variance,
        }
    }

    /// The number of pairs.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Tests the difference of the means; `None` without a pair.
    pub fn test(&self) -> Option<MeanDifference> {
        let n = (self.count > 0).then_some(self.count as f64)?;
        let freedom = match self.variance * self.variance / self.of_variance {
            ratio if ratio.is_nan() => f64::INFINITY,
            ratio => ratio - 2.0,
        };
        let (difference, reference) = ((self.a - self.b) / n, self.b / n);
        let standard_error = self.variance.sqrt() / n;
        let beyond_rounding = (difference.abs() - ROUNDING * reference.abs()).max(0.0);
        let p = if beyond_rounding == 0.0 {
            1.0
        } else {
            student_p_value(beyond_rounding / standard_error, freedom)
        };
        Some(MeanDifference {
            reference,
            difference,
            standard_error,
            freedom,
            p,
        })
    }
}

impl MeanDifference {
    /// Whether the test is meaningful: there is a difference or noise.
    pub fn is_meaningful(&self) -> bool {
        self.difference != 0.0 || self.standard_error != 0.0
    }

    /// The difference relative to the reference's mean: 0 if there is none, infinite for a mean of 0.
    pub fn relative(&self) -> f64 {
        self.of_reference(self.difference)
    }

    /// The standard error of [`relative`](Self::relative), for an exact mean of the reference.
    pub fn relative_error(&self) -> f64 {
        self.of_reference(self.standard_error)
    }

    /// The smallest difference, relative to the reference's mean, that a test at this significance detects with
    /// probability `power`.
    pub fn detectable(&self, significance: f64, power: f64) -> f64 {
        let errors = student_quantile_of(self.freedom, 1.0 - 0.5 * significance)
            + student_quantile_of(self.freedom, power);
        errors * self.relative_error()
    }

    fn of_reference(&self, number: f64) -> f64 {
        if number == 0.0 {
            0.0
        } else {
            number / self.reference.abs()
        }
    }
}

/// The significance of each of `tests` independent tests for a joint significance of `family`: 1 - (1 - family)^(1/n).
pub fn sidak(family: f64, tests: usize) -> f64 {
    -f64::exp_m1(f64::ln_1p(-family) / tests.max(1) as f64)
}

/// The probability that the least of `tests` independent p-values is at most `least`: 1 - (1 - p)^n.
pub fn family_p_value(least: f64, tests: usize) -> f64 {
    if least >= 1.0 {
        return 1.0;
    }
    -f64::exp_m1(tests as f64 * f64::ln_1p(-least))
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue::internals::math::stats::{Moments, normal_quantile};
    use rand_core::Rng;
    use rand_pcg::Pcg64;

    const BATCHES: usize = 16;

    fn exact(value: f64) -> UncertainNumber {
        UncertainNumber {
            value,
            standard_error: 0.0,
        }
    }

    /// Simulates pairs as in renders: batches around the true value, with a spread of their own.
    fn simulated(rng: &mut Pcg64, pairs: usize, bias: f64) -> MeanDifference {
        let mut normal = || {
            let bits = rng.next_u64() >> 11;
            normal_quantile((bits as f64 + 0.5) / (1_u64 << 53) as f64)
        };
        let mut estimate = |mean: f64, sigma: f64| {
            let batches = Moments::of((0..BATCHES).map(|_| mean + sigma * normal()));
            UncertainNumber {
                value: batches.mean(),
                standard_error: batches.standard_error().expect("there are several"),
            }
        };
        let mut difference = Difference::default();
        for pair in 0..pairs {
            // From dark and quiet to bright and noisy.
            let mean = 1.0 + pair as f64;
            let a = estimate(mean * (1.0 + bias), 0.2 * mean);
            let b = estimate(mean, 0.1 * mean);
            difference.push(a, b, (BATCHES - 1) as f64);
        }
        difference.test().expect("there are pairs")
    }

    fn p_values(pairs: usize, bias: f64, trials: usize) -> Vec<f64> {
        let mut rng = Pcg64::new(pairs as u128, 1);
        let mut values: Vec<f64> = (0..trials)
            .map(|_| simulated(&mut rng, pairs, bias).p)
            .collect();
        values.sort_by(f64::total_cmp);
        values
    }

    /// The greatest distance between the distribution of sorted numbers and the uniform one.
    fn kolmogorov_distance(sorted: &[f64]) -> f64 {
        let n = sorted.len() as f64;
        let distances = sorted.iter().enumerate().map(|(i, p)| {
            let (below, above) = (p - i as f64 / n, (i + 1) as f64 / n - p);
            below.max(above)
        });
        distances.fold(0.0, f64::max)
    }

    #[test]
    fn p_values_are_uniform_under_the_null_hypothesis() {
        // 3000 trials stay within 2.23 / sqrt(3000) = 0.041 except once in 10 000. The normal distribution in place of
        // Student's would differ by about as much in the tail that matters, which is therefore tested separately.
        let trials = 3000;
        for pairs in [1, 2, 5, 40] {
            let values = p_values(pairs, 0.0, trials);
            let distance = kolmogorov_distance(&values);
            assert!(
                distance < 2.23 / (trials as f64).sqrt(),
                "{pairs}: {distance}"
            );
            // Below 1 %: 30 are expected, with a standard deviation of 5.4; if the standard errors were taken as exact,
            // one pair would have 60.
            let few = values.iter().filter(|&&p| p < 0.01).count();
            assert!((10..=46).contains(&few), "{pairs}: {few}");
        }
    }

    #[test]
    fn detection_rate_matches_the_stated_power() {
        let mut rng = Pcg64::new(7, 7);
        let (pairs, significance, power) = (50, 0.05, 0.9);
        let smallest = simulated(&mut rng, pairs, 0.0).detectable(significance, power);
        assert!((0.01..0.1).contains(&smallest), "{smallest}");
        let trials = 1000;
        let values = p_values(pairs, smallest, trials);
        let found = values.iter().filter(|&&p| p < significance).count();
        // 0.9 with a standard deviation of 0.0095; the standard error from which `smallest` is computed is known to
        // within 4 %.
        let share = found as f64 / trials as f64;
        assert!((0.84..0.95).contains(&share), "{share}");
    }

    #[test]
    fn degrees_of_freedom_are_exact_for_one_and_for_many_pairs() {
        let noisy = UncertainNumber {
            value: 1.0,
            standard_error: 0.1,
        };
        let mut one = Difference::default();
        one.push(noisy, exact(1.25), 15.0);
        let test = one.test().expect("a pair");
        assert!((test.freedom - 15.0).abs() < 1e-9);
        assert_eq!(test.difference, -0.25);
        assert!((test.p - 0.024_6).abs() < 1e-4, "t(15) = 2.5: {}", test.p);
        let mut many = Difference::default();
        for _ in 0..100 {
            many = many.merge(one);
        }
        let test = many.test().expect("pairs");
        assert!((test.freedom - (1700.0 - 2.0)).abs() < 1e-6);
        assert!((test.standard_error - 0.01).abs() < 1e-12);
    }

    #[test]
    fn exact_values_differ_only_beyond_rounding() {
        let test = |a: f64, b: f64| {
            let mut difference = Difference::default();
            difference.push(exact(a), exact(b), 15.0);
            difference.test().expect("a pair").p
        };
        assert_eq!(test(1.0, 1.0), 1.0);
        assert_eq!(test(0.0, 0.0), 1.0);
        assert_eq!(test(1.0 + 1e-6, 1.0), 1.0);
        assert_eq!(test(1.0 + 1e-5, 1.0), 0.0);
        assert_eq!(Difference::default().test(), None);
    }

    #[test]
    fn black_reference_gives_zero_or_infinite_relative_difference() {
        let test = |a: f64| {
            let mut difference = Difference::default();
            difference.push(exact(a), exact(0.0), 15.0);
            difference.test().expect("a pair")
        };
        let black = test(0.0);
        assert!(!black.is_meaningful() && test(0.1).is_meaningful());
        assert_eq!((black.relative(), black.detectable(0.05, 0.9)), (0.0, 0.0));
        assert_eq!(test(-0.1).relative(), f64::NEG_INFINITY);
    }

    #[test]
    fn family_p_value_inverts_sidak_correction() {
        assert!((sidak(0.05, 1) - 0.05).abs() < 1e-15);
        assert!((family_p_value(sidak(0.05, 300), 300) - 0.05).abs() < 1e-12);
        assert_eq!(family_p_value(0.0, 10), 0.0);
        assert_eq!(family_p_value(1.0, 10), 1.0);
    }
}
