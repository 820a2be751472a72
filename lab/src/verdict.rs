//! When a measured number passes for an exact one.
//!
//! Measure: the unit of the number.
//! Range: any numbers. Nothing compares with NaN: a number that is none, or whose standard error is none, fails.
//! Source: the acceptance rule |mean - exact| <= 5.2 SE + 4e-6 |exact|, in which 5.2 sigma is Šidák's correction for
//! 500 checks at a family-wise significance of 1e-4; and SE at most a power limit, since a run that cannot tell must not
//! pass. Tested below.

use serde::Serialize;

/// Standard errors that a right mean stays within.
const SIGMAS: f64 = 5.2;

/// What rounding to single precision on the way may take, relative.
pub const ROUNDING: f64 = 4e-6;

/// What came of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// As exact as it should be, and precise enough to know.
    Passed,
    /// Significantly off.
    Failed,
    /// Not precise enough to know; counts as a failure.
    Inconclusive,
}

impl Verdict {
    /// Judges a mean that is `off` by so much beside its noise, where `tolerance` is allowed; a standard error above
    /// `power_limit` says nothing.
    pub fn of(off: f64, tolerance: f64, standard_error: f64, power_limit: f64) -> Self {
        let is_close = off <= tolerance + SIGMAS * standard_error;
        match (is_close, standard_error <= power_limit) {
            (false, _) => Self::Failed,
            (true, true) => Self::Passed,
            (true, false) => Self::Inconclusive,
        }
    }

    /// In a word.
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
    fn a_mean_is_close_and_known_or_does_not_pass() {
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
