//! A measured number with its exact value, and a technique with its efficiency.
//!
//! Measure: that of the number; costs in seconds a sample; efficiencies per second and per squared unit of the
//! estimate.
//! Range: standard errors are computed from at least 16 independent numbers; 0 is for deterministic numbers.
//! Source: the acceptance rule of `lab/src/verdict.rs`. Tested below.

use crate::verdict::{ROUNDING, Verdict};
use etendue::internals::math::stats::Moments;
use serde::Serialize;

/// A measured number with its exact value.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Number {
    /// Name of the number.
    pub name: String,
    /// The exact value.
    pub exact: f64,
    /// The measured value.
    pub ours: f64,
    /// The standard error of the measured value.
    pub standard_error: f64,
    /// The result of the comparison.
    pub verdict: Verdict,
}

impl Number {
    /// The mean of independent numbers; `power` is the greatest standard error for a conclusive test, relative to
    /// `exact`, or absolute where `exact` is 0.
    pub fn mean(name: impl Into<String>, exact: f64, numbers: &Moments, power: f64) -> Self {
        let standard_error = numbers.standard_error().unwrap_or(f64::NAN);
        // A single number has no standard error, with which no verdict is good.
        let freedom = (numbers.count() as f64 - 1.0).max(1.0);
        let ours = [numbers.mean(), standard_error, freedom];
        Self::judged(name.into(), exact, ours, power)
    }

    /// A deterministic number.
    pub fn certain(name: impl Into<String>, exact: f64, ours: f64) -> Self {
        Self::new(name, exact, ours, 0.0, 0.0)
    }

    /// A number with its standard error, which is taken as known; `power` as for [`Number::mean`].
    pub fn new(
        name: impl Into<String>,
        exact: f64,
        ours: f64,
        standard_error: f64,
        power: f64,
    ) -> Self {
        let ours = [ours, standard_error, f64::INFINITY];
        Self::judged(name.into(), exact, ours, power)
    }

    /// A number with its standard error and the degrees of freedom of that.
    fn judged(
        name: String,
        exact: f64,
        [ours, standard_error, freedom]: [f64; 3],
        power: f64,
    ) -> Self {
        let size = if exact == 0.0 { 1.0 } else { exact.abs() };
        let off = (ours - exact).abs();
        let tolerance = ROUNDING * size;
        let verdict = Verdict::of(off, tolerance, standard_error, freedom, power * size);
        Self {
            name,
            exact,
            ours,
            standard_error,
            verdict,
        }
    }
}

/// An estimator with its variance and cost.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredTechnique {
    /// Name of the technique.
    pub name: String,
    /// The mean of its samples.
    pub mean: f64,
    /// The standard error of the mean.
    pub standard_error: f64,
    /// The variance of one sample.
    pub variance: f64,
    /// The exact variance, where it is known; infinite where there is none.
    pub exact_variance: Option<f64>,
    /// Seconds a sample.
    pub cost: f64,
    /// 1 / (variance x cost); infinite without variance.
    pub efficiency: f64,
    /// The least and the greatest efficiency, if there were several runs.
    pub efficiency_range: Option<[f64; 2]>,
}

impl MeasuredTechnique {
    /// A technique with its measured samples and cost.
    pub fn new(name: impl Into<String>, samples: &Moments, cost: f64) -> Self {
        let rounding = (f64::EPSILON * samples.mean()).powi(2);
        let variance = match samples.variance() {
            // Samples that differ only by the rounding of their mean are equal.
            Some(variance) if variance <= rounding => 0.0,
            variance => variance.unwrap_or(f64::NAN),
        };
        Self {
            name: name.into(),
            mean: samples.mean(),
            standard_error: (variance / samples.count() as f64).sqrt(),
            variance,
            exact_variance: None,
            cost,
            efficiency: 1.0 / (variance * cost),
            efficiency_range: None,
        }
    }

    /// Adds the exact variance.
    pub fn exactly(self, variance: f64) -> Self {
        Self {
            exact_variance: Some(variance),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdict_distinguishes_failed_from_inconclusive() {
        let verdict = |ours, error| Number::new("it", 2.0, ours, error, 0.01).verdict;
        assert_eq!(verdict(2.05, 0.01), Verdict::Passed);
        assert_eq!(verdict(2.06, 0.01), Verdict::Failed);
        assert_eq!(verdict(2.05, 0.03), Verdict::Inconclusive);
        assert_eq!(verdict(f64::NAN, 0.01), Verdict::Failed);
        assert_eq!(verdict(2.0, f64::NAN), Verdict::Failed);
        assert_eq!(
            Number::certain("it", 0.5, 0.500_01).verdict,
            Verdict::Failed
        );
        assert_eq!(Number::certain("it", 0.5, 0.5).verdict, Verdict::Passed);
    }

    #[test]
    fn efficiency_is_inverse_of_variance_times_cost() {
        let samples = Moments::of([1.0, 3.0]);
        assert_eq!(MeasuredTechnique::new("it", &samples, 0.25).efficiency, 2.0);
        let constant = Moments::of([1.0, 1.0]);
        assert_eq!(
            MeasuredTechnique::new("it", &constant, 0.25).efficiency,
            f64::INFINITY
        );
    }
}
