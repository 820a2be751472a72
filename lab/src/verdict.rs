//! The acceptance test of a measured number against an exact one.
//!
//! Measure: the unit of the number.
//! Range: any numbers. Comparisons with NaN are false: a number or a standard error that is NaN fails.
//! Source: the acceptance rule |mean - exact| <= 5.2 SE + 4e-6 |exact|, in which 5.2 sigma is Šidák's correction for
//! 500 checks at a family-wise significance of 1e-4; and SE at most a power limit, since a run that is too noisy to
//! detect an error must not pass. Tested below.

use serde::Serialize;

/// The largest deviation of a correct mean, in standard errors.
const SIGMAS: f64 = 5.2;

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
    /// standard error above `power_limit` makes the result inconclusive.
    pub fn of(off: f64, tolerance: f64, standard_error: f64, power_limit: f64) -> Self {
        let is_close = off <= tolerance + SIGMAS * standard_error;
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
            let verdict = Verdict::of(off, 0.0, standard_error, 1.0);
            assert_eq!(verdict, expected, "{off} {standard_error}");
        }
        assert_eq!(Verdict::of(5.3, 0.2, 1.0, 1.0), Verdict::Passed);
    }
}
