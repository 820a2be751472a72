//! The claim of a case about a number, and the test of a measurement against it.
//!
//! Measure: the unit of the number. A case is measured as independent numbers of the same expectation, one a replicate.
//! Range: a claim about a mean needs at least [`REPLICATES`] numbers; with fewer, or with a standard error above the
//! claim's limit, a measurement is inconclusive, which counts as a failure.
//! Source: the acceptance rule of `lab/src/verdict.rs`. Tested below.

use crate::verdict::{ROUNDING, Verdict};
use etendue::internals::math::stats::Moments;
use serde::Serialize;

/// The minimum number of replicates for a standard error.
pub const REPLICATES: u64 = 16;

/// The side of the exact number on which a measurement may lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Relation {
    /// Equal to the exact number.
    Equal,
    /// Equal to the exact number or less.
    AtMost,
}

/// A claim, and the precision with which it has to be tested.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Claim {
    /// Equal, or at most.
    pub relation: Relation,
    /// The exact number.
    pub exact: f64,
    /// The allowed deviation besides noise.
    pub tolerance: f64,
    /// The greatest standard error for a conclusive test; `None` where there is no noise, and every single number has
    /// to be within the tolerance.
    pub power_limit: Option<f64>,
}

/// A measurement tested against a claim.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judged {
    /// The mean; without noise, the number with the largest deviation.
    pub ours: f64,
    /// Standard error of the mean; `None` for fewer than two numbers.
    pub standard_error: Option<f64>,
    /// The result of the test.
    pub verdict: Verdict,
}

impl Claim {
    /// Claims that a mean is `exact`, to be known to a relative standard error of `power`.
    pub fn mean(exact: f64, power: f64) -> Self {
        Self {
            relation: Relation::Equal,
            exact,
            tolerance: ROUNDING * exact.abs(),
            power_limit: Some(power * exact.abs()),
        }
    }

    /// Claims that a mean is at most `exact`.
    pub fn at_most(exact: f64, power: f64) -> Self {
        Self {
            relation: Relation::AtMost,
            ..Self::mean(exact, power)
        }
    }

    /// Claims that every number is `exact` within a relative `tolerance`, without noise.
    pub fn without_noise(exact: f64, tolerance: f64) -> Self {
        Self {
            relation: Relation::Equal,
            exact,
            tolerance: tolerance * exact.abs(),
            power_limit: None,
        }
    }

    /// Claims that every number is `exact` to the last bit: a count, or black.
    pub fn exactly(exact: f64) -> Self {
        Self::without_noise(exact, 0.0)
    }

    /// Adds an absolute error of the model itself.
    pub fn within(self, error: f64) -> Self {
        Self {
            tolerance: self.tolerance + error,
            ..self
        }
    }

    /// The deviation of a number on the wrong side.
    fn excess(&self, number: f64) -> f64 {
        match self.relation {
            Relation::Equal => (number - self.exact).abs(),
            Relation::AtMost => number - self.exact,
        }
    }

    /// Tests numbers against the claim.
    pub fn judge(&self, numbers: &[f64]) -> Judged {
        let moments = Moments::of(numbers.iter().copied());
        if self.power_limit.is_some() {
            return self.judge_mean(&moments);
        }
        let farthest = self.farthest(numbers);
        let holds = !numbers.is_empty() && self.excess(farthest) <= self.tolerance;
        Judged {
            ours: farthest,
            standard_error: moments.standard_error(),
            verdict: if holds {
                Verdict::Passed
            } else {
                Verdict::Failed
            },
        }
    }

    /// Tests the mean of numbers against a claim about a mean.
    pub fn judge_mean(&self, moments: &Moments) -> Judged {
        let standard_error = moments.standard_error();
        let known = standard_error.filter(|_| moments.count() >= REPLICATES);
        let power_limit = self.power_limit.unwrap_or(f64::INFINITY);
        let off = self.excess(moments.mean());
        let verdict = known.map_or(Verdict::Inconclusive, |error| {
            let freedom = moments.count() as f64 - 1.0;
            Verdict::of(off, self.tolerance, error, freedom, power_limit)
        });
        Judged {
            ours: moments.mean(),
            standard_error,
            verdict,
        }
    }

    /// The number with the largest deviation; NaN if any is.
    fn farthest(&self, numbers: &[f64]) -> f64 {
        let farther = |a: f64, b: &f64| {
            let keeps = a.is_nan() || self.excess(a) >= self.excess(*b);
            if keeps { a } else { *b }
        };
        numbers
            .first()
            .map_or(f64::NAN, |&first| numbers.iter().fold(first, farther))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers around 1, with a standard error of about a thousandth.
    fn numbers() -> Vec<f64> {
        (0..16)
            .map(|i| 1.0 + 0.004 * (f64::from(i) * 2.4).sin())
            .collect()
    }

    fn verdict(claim: Claim) -> Verdict {
        claim.judge(&numbers()).verdict
    }

    #[test]
    fn correct_claims_pass_and_wrong_claims_fail() {
        assert_eq!(verdict(Claim::mean(1.0, 2e-3)), Verdict::Passed);
        assert_eq!(verdict(Claim::mean(1.01, 2e-3)), Verdict::Failed);
        assert_eq!(verdict(Claim::mean(0.99, 2e-3)), Verdict::Failed);
        assert_eq!(verdict(Claim::at_most(1.01, 2e-3)), Verdict::Passed);
        assert_eq!(verdict(Claim::at_most(0.99, 2e-3)), Verdict::Failed);
        assert_eq!(
            verdict(Claim::mean(1.01, 2e-3).within(0.01)),
            Verdict::Passed
        );
    }

    #[test]
    fn excessive_noise_or_too_few_samples_are_inconclusive() {
        assert_eq!(verdict(Claim::mean(1.0, 1e-4)), Verdict::Inconclusive);
        let few = &numbers()[..15];
        let claim = Claim::mean(1.0, 1.0);
        assert_eq!(claim.judge(few).verdict, Verdict::Inconclusive);
        assert_eq!(claim.judge(&[]).verdict, Verdict::Inconclusive);
        // A deviation beyond all noise fails, even if the standard error is above the limit.
        assert_eq!(verdict(Claim::mean(2.0, 1e-4)), Verdict::Failed);
    }

    #[test]
    fn noise_free_claim_fails_if_any_value_is_off() {
        assert_eq!(verdict(Claim::without_noise(1.0, 5e-3)), Verdict::Passed);
        let judged = Claim::without_noise(1.0, 1e-3).judge(&[1.0, 0.5, 1.1]);
        assert_eq!((judged.ours, judged.verdict), (0.5, Verdict::Failed));
        assert_eq!(Claim::exactly(0.0).judge(&[0.0]).verdict, Verdict::Passed);
        assert_eq!(Claim::exactly(0.0).judge(&[]).verdict, Verdict::Failed);
    }

    #[test]
    fn any_nan_sample_fails_the_claim() {
        for at in 0..16 {
            let mut numbers = numbers();
            numbers[at] = f64::NAN;
            for claim in [Claim::without_noise(1.0, 1.0), Claim::mean(1.0, 1.0)] {
                assert_eq!(claim.judge(&numbers).verdict, Verdict::Failed, "{at}");
            }
        }
    }
}
