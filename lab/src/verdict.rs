//! The acceptance test of a measured number against an exact one.
//!
//! Measure: the unit of the number.
//! Range: any numbers. Comparisons with NaN are false: a number or a standard error that is NaN fails.
//! Source: the acceptance rule |mean - exact| <= t SE + 4e-6 |exact|, in which t is the quantile of Student's distribution
//! (5.2 for a known SE) by Šidák's correction for 500 checks at a family-wise significance of 1e-4; and SE at most a power
//! limit, since a run that is too noisy to detect an error must not pass. Tested below.

use etendue::internals::math::stats::student_quantile_of;
use serde::Serialize;

/// The probability that a correct mean lies more than the tolerated standard errors above the exact value, or below it.
const ONE_SIDED: f64 = 1e-7;

/// The relative error allowed for rounding to single precision in intermediate results.
pub const ROUNDING: f64 = 4e-6;

/// The result of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Within tolerance, with a standard error below the power limit.
    Passed,
    /// Significantly different from the exact value.
    Failed,
    /// Too noisy to decide; counts as a failure.
    Inconclusive,
}

impl Verdict {
    /// Judges a mean whose deviation from the exact value is `off`, where `tolerance` is allowed besides noise; a
    /// standard error above `power_limit` makes the result inconclusive. `freedom` is the number of degrees of freedom of
    /// the standard error, infinite for a known one.
    pub fn of(
        off: f64,
        tolerance: f64,
        standard_error: f64,
        freedom: f64,
        power_limit: f64,
    ) -> Self {
        let sigmas = student_quantile_of(freedom, 1.0 - ONE_SIDED);
        let is_close = off <= tolerance + sigmas * standard_error;
        match (is_close, standard_error <= power_limit) {
            (false, _) => Self::Failed,
            (true, true) => Self::Passed,
            (true, false) => Self::Inconclusive,
        }
    }

    /// The name of the verdict in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "FAILED",
            Self::Inconclusive => "INCONCLUSIVE",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_passes_only_if_close_and_its_standard_error_is_small() {
        for (off, standard_error, expected) in [
            (5.1, 1.0, Verdict::Passed),
            (5.3, 1.0, Verdict::Failed),
            (0.0, 1.1, Verdict::Inconclusive),
            (9.0, 1.1, Verdict::Failed),
            (0.0, 0.0, Verdict::Passed),
            (f64::NAN, 1.0, Verdict::Failed),
            (0.0, f64::NAN, Verdict::Failed),
        ] {
            let verdict = Verdict::of(off, 0.0, standard_error, f64::INFINITY, 1.0);
            assert_eq!(verdict, expected, "{off} {standard_error}");
        }
        let known = f64::INFINITY;
        assert_eq!(Verdict::of(5.3, 0.2, 1.0, known, 1.0), Verdict::Passed);
        // The quantile of 15 degrees of freedom is 8.99.
        assert_eq!(Verdict::of(8.9, 0.0, 1.0, 15.0, 1.0), Verdict::Passed);
        assert_eq!(Verdict::of(9.1, 0.0, 1.0, 15.0, 1.0), Verdict::Failed);
    }
}
