//! Mean and variance of a stream of numbers, and what they say about the mean.
//!
//! Measure: the unit of the numbers, squared for the variance.
//! Range: variance needs two numbers, before that it is `None`.
//! Source: Welford 1962; merging by Chan, Golub and LeVeque 1983; quantiles by the statrs crate. Tested below.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Beyond so many degrees of freedom Student's t is the normal distribution: to within a relative 2e-3 of the tail that
/// lies beyond five standard errors, and nearer than its quantiles can be computed.
const NORMAL_FREEDOM: f64 = 1e5;

/// The number below which a standard normal number is with this probability.
///
/// # Panics
/// If it is no probability.
pub fn normal_quantile(probability: f64) -> f64 {
    Normal::standard().inverse_cdf(probability)
}

/// How many standard deviations a number is at most away from 0 with this probability, if it has Student's t distribution of
/// `freedom` degrees of freedom, scaled to variance 1: 1.96 to 2.0 for 95 % and four degrees or more.
///
/// # Panics
/// If `freedom` is not above 2, or it is no probability.
pub fn standardised_student_quantile(freedom: f64, probability: f64) -> f64 {
    assert!(freedom > 2.0, "there is a variance");
    let scale = match freedom < NORMAL_FREEDOM {
        true => ((freedom - 2.0) / freedom).sqrt(),
        false => 1.0,
    };
    scale * student_quantile_of(freedom, 0.5 + 0.5 * probability)
}

/// How many standard errors a mean of `count` normal numbers is at most away from its expectation, with this probability:
/// the two-sided quantile of Student's t.
///
/// # Panics
/// If there are fewer than two numbers, or it is no probability.
pub fn student_quantile(count: u64, probability: f64) -> f64 {
    student_quantile_of(count as f64 - 1.0, 0.5 + 0.5 * probability)
}

/// The number below which Student's t of so many degrees of freedom is with this probability.
///
/// # Panics
/// If `freedom` is not above 0, or it is no probability.
pub fn student_quantile_of(freedom: f64, probability: f64) -> f64 {
    match student(freedom) {
        Some(t) => t.inverse_cdf(probability),
        None => normal_quantile(probability),
    }
}

/// The probability that Student's t of so many degrees of freedom is at least this far from 0.
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

/// The standard normal number that is exceeded as often as `t` is by Student's t of `freedom` degrees of freedom, scaled to
/// variance 1.
///
/// # Panics
/// If `freedom` is not above 2.
pub fn normal_score(t: f64, freedom: f64) -> f64 {
    let scale = standardised_student_quantile(freedom, 0.5) / student_quantile_of(freedom, 0.75);
    let tail = 0.5 * student_p_value(t / scale, freedom);
    -normal_quantile(tail).copysign(-t)
}

/// Student's t, unless it has so many degrees of freedom that it is normal.
fn student(freedom: f64) -> Option<StudentsT> {
    let t = || StudentsT::new(0.0, 1.0, freedom).expect("there are degrees of freedom");
    (freedom < NORMAL_FREEDOM).then(t)
}

/// Median, least and greatest of several numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// The middle one; of an even count the upper of the two.
    pub median: f64,
    /// The least.
    pub min: f64,
    /// The greatest.
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
    /// The moments of all the numbers.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut moments = Self::default();
        for value in values {
            moments.push(value);
        }
        moments
    }

    /// Takes one number in.
    pub fn push(&mut self, x: f64) {
        self.count += 1;
        let delta = x - self.mean;
        self.mean += delta / self.count as f64;
        self.m2 += delta * (x - self.mean);
    }

    /// The moments of both streams together.
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

    /// How many numbers.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Their mean, 0 for none.
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
    fn a_die_has_its_mean_and_variance() {
        let die = Moments::of((1..=6).map(f64::from));
        assert_eq!(die.mean(), 3.5);
        assert!((die.variance().expect("six numbers") - 3.5).abs() < 1e-12);
        assert_eq!(Moments::of([1.0]).variance(), None);
    }

    #[test]
    fn quantiles_are_those_of_the_tables() {
        assert!((normal_quantile(0.975) - 1.959_963_984_540).abs() < 1e-8);
        assert!((student_quantile(16, 0.95) - 2.131_449_545_6).abs() < 1e-8);
        // 2.7764 and 3.1824, times the roots of 1/2 and 1/3.
        assert!((standardised_student_quantile(4.0, 0.95) - 1.963_2).abs() < 1e-4);
        assert!((standardised_student_quantile(3.0, 0.95) - 1.837_4).abs() < 1e-4);
        assert!((standardised_student_quantile(1e6, 0.95) - 1.959_96).abs() < 1e-4);
    }

    #[test]
    fn p_values_undo_quantiles_and_become_normal_without_a_jump() {
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
    fn merging_is_as_good_as_one_stream() {
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
