//! Mean, variance and standard error of a stream of numbers, and quantiles of the normal and Student's t
//! distributions.
//!
//! Measure: the unit of the numbers, squared for the variance.
//! Range: variance needs two numbers, with fewer it is `None`.
//! Source: Welford 1962; merging by Chan, Golub and LeVeque 1983; quantiles by the statrs crate. Tested below.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// The degrees of freedom from which on Student's t is replaced by the normal distribution. They agree to within a
/// relative 2e-3 of the tail beyond five standard errors, and more closely than quantiles can be computed.
const NORMAL_FREEDOM: f64 = 1e5;

/// The quantile of the standard normal distribution at this probability.
///
/// # Panics
/// If `probability` is not a probability.
pub fn normal_quantile(probability: f64) -> f64 {
    Normal::standard().inverse_cdf(probability)
}

/// The two-sided quantile, at this probability, of Student's t with `freedom` degrees of freedom, scaled to variance
/// 1: 1.96 to 2.0 for 95 % and four degrees or more.
///
/// # Panics
/// If `freedom` is not above 2, or `probability` is not a probability.
pub fn standardised_student_quantile(freedom: f64, probability: f64) -> f64 {
    assert!(freedom > 2.0, "there is a variance");
    let scale = match freedom < NORMAL_FREEDOM {
        true => ((freedom - 2.0) / freedom).sqrt(),
        false => 1.0,
    };
    scale * student_quantile_of(freedom, 0.5 + 0.5 * probability)
}

/// The two-sided quantile of Student's t for a mean of `count` normal numbers: the half-width of its confidence
/// interval of this probability, in standard errors.
///
/// # Panics
/// If there are fewer than two numbers, or `probability` is not a probability.
pub fn student_quantile(count: u64, probability: f64) -> f64 {
    student_quantile_of(count as f64 - 1.0, 0.5 + 0.5 * probability)
}

/// The one-sided quantile of Student's t with `freedom` degrees of freedom at this probability.
///
/// # Panics
/// If `freedom` is not above 0, or `probability` is not a probability.
pub fn student_quantile_of(freedom: f64, probability: f64) -> f64 {
    match student(freedom) {
        Some(t) => t.inverse_cdf(probability),
        None => normal_quantile(probability),
    }
}

/// The two-sided p-value of `t` under Student's t with `freedom` degrees of freedom.
///
/// # Panics
/// If `freedom` is not above 0.
pub fn student_p_value(t: f64, freedom: f64) -> f64 {
    let tail = match student(freedom) {
        _ if t.is_infinite() => 0.0,
        Some(distribution) => distribution.sf(t.abs()),
        None => Normal::standard().sf(t.abs()),
    };
    2.0 * tail
}

/// The standard normal number with the tail probability that `t` has under Student's t with `freedom` degrees of
/// freedom, scaled to variance 1.
///
/// # Panics
/// If `freedom` is not above 2.
pub fn normal_score(t: f64, freedom: f64) -> f64 {
    let scale = standardised_student_quantile(freedom, 0.5) / student_quantile_of(freedom, 0.75);
    let tail = 0.5 * student_p_value(t / scale, freedom);
    -normal_quantile(tail).copysign(-t)
}

/// The distribution of Student's t; `None` if its degrees of freedom are so many that it is treated as normal.
fn student(freedom: f64) -> Option<StudentsT> {
    let t = || StudentsT::new(0.0, 1.0, freedom).expect("there are degrees of freedom");
    (freedom < NORMAL_FREEDOM).then(t)
}

/// The median, minimum and maximum of several numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// The median; for an even count the upper of the two middle numbers.
    pub median: f64,
    /// The minimum.
    pub min: f64,
    /// The maximum.
    pub max: f64,
}

impl Spread {
    /// The spread of some numbers.
    ///
    /// # Panics
    /// If there are none.
    pub fn of(mut numbers: Vec<f64>) -> Self {
        numbers.sort_by(f64::total_cmp);
        Self {
            median: numbers[numbers.len() / 2],
            min: numbers[0],
            max: numbers[numbers.len() - 1],
        }
    }
}

/// Count, mean and sum of squared deviations.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Moments {
    count: u64,
    mean: f64,
    m2: f64,
}

impl Moments {
    /// Computes the moments of all numbers.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut moments = Self::default();
        for value in values {
            moments.push(value);
        }
        moments
    }

    /// Adds one number.
    pub fn push(&mut self, x: f64) {
        self.count += 1;
        let delta = x - self.mean;
        self.mean += delta / self.count as f64;
        self.m2 += delta * (x - self.mean);
    }

    /// Merges the moments of two streams.
    pub fn merge(self, other: Self) -> Self {
        if self.count == 0 {
            return other;
        }
        if other.count == 0 {
            return self;
        }
        let count = self.count + other.count;
        let delta = other.mean - self.mean;
        let weight = other.count as f64 / count as f64;
        Self {
            count,
            mean: self.mean + delta * weight,
            m2: self.m2 + other.m2 + delta * delta * self.count as f64 * weight,
        }
    }

    /// The count of the numbers.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The mean of the numbers, 0 for none.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// The unbiased sample variance.
    pub fn variance(&self) -> Option<f64> {
        (self.count > 1).then(|| self.m2 / (self.count - 1) as f64)
    }

    /// The standard error of the mean of independent numbers.
    pub fn standard_error(&self) -> Option<f64> {
        self.variance().map(|v| (v / self.count as f64).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_match_the_mean_and_variance_of_a_die() {
        let die = Moments::of((1..=6).map(f64::from));
        assert_eq!(die.mean(), 3.5);
        assert!((die.variance().expect("six numbers") - 3.5).abs() < 1e-12);
        assert_eq!(Moments::of([1.0]).variance(), None);
    }

    #[test]
    fn quantiles_match_published_tables() {
        assert!((normal_quantile(0.975) - 1.959_963_984_540).abs() < 1e-8);
        assert!((student_quantile(16, 0.95) - 2.131_449_545_6).abs() < 1e-8);
        // 2.7764 and 3.1824, times the roots of 1/2 and 1/3.
        assert!((standardised_student_quantile(4.0, 0.95) - 1.963_2).abs() < 1e-4);
        assert!((standardised_student_quantile(3.0, 0.95) - 1.837_4).abs() < 1e-4);
        assert!((standardised_student_quantile(1e6, 0.95) - 1.959_96).abs() < 1e-4);
    }

    #[test]
    fn p_values_invert_quantiles_and_join_the_normal_continuously() {
        for freedom in [1.0, 15.0, 1e3, 0.999 * NORMAL_FREEDOM, f64::INFINITY] {
            for p in [0.5, 0.05, 1e-3, 1e-6] {
                let t = student_quantile_of(freedom, 1.0 - 0.5 * p);
                for t in [t, -t] {
                    let again = student_p_value(t, freedom);
                    assert!((again / p - 1.0).abs() < 1e-4, "{freedom} {p}: {again}");
                }
            }
        }
        let [before, after] = [0.999, 1.001].map(|x| student_p_value(5.0, x * NORMAL_FREEDOM));
        assert!((before / after - 1.0).abs() < 2e-3, "{before} {after}");
        assert_eq!(student_p_value(f64::INFINITY, 15.0), 0.0);
    }

    #[test]
    fn merged_moments_match_a_single_pass() {
        let numbers: Vec<f64> = (0..100).map(|i| f64::from(i).sin() + 1e6).collect();
        let whole = Moments::of(numbers.iter().copied());
        let parts = Moments::of(numbers[..37].iter().copied())
            .merge(Moments::of(numbers[37..].iter().copied()))
            .merge(Moments::default());
        assert_eq!(whole.count(), parts.count());
        assert!((whole.mean() - parts.mean()).abs() < 1e-8);
        let (a, b) = (
            whole.variance().expect("100"),
            parts.variance().expect("100"),
        );
        assert!((a - b).abs() < 1e-8);
    }
}
