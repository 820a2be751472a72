//! When a statistical test passes, fails, or says nothing.
//!
//! Measure: the unit of the estimated quantity; significance as a probability.
//! Range: standard errors come from at least 16 independent numbers.
//! Source: the acceptance rule: |mean - exact| <= 5.2 SE + 4e-6 |exact|, where 5.2 sigma is Šidák's correction for 500 checks at
//! a family-wise significance of 1e-4; and SE <= the power limit, for a run that cannot tell must not pass.

use etendue::math::stats::Moments;

/// The outcome of a test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// As exact as asked, and precise enough to know.
    Pass,
    /// Significantly off.
    Fail,
    /// Not precise enough to know; counts as a failure.
    Inconclusive,
}

/// Judges a mean with its standard error; `power` is the greatest standard error that counts, relative to `exact`.
pub fn judge(mean: f64, standard_error: f64, exact: f64, power: f64) -> Verdict {
    let tolerance = 5.2 * standard_error + 4e-6 * exact.abs();
    // NaN is not close to anything.
    let close = (mean - exact).abs() <= tolerance;
    if !close {
        Verdict::Fail
    } else if standard_error <= power * exact.abs() {
        Verdict::Pass
    } else {
        Verdict::Inconclusive
    }
}

/// Panics unless the mean of independent numbers is `exact`.
pub fn assert_mean(what: &str, numbers: &Moments, exact: f64, power: f64) {
    assert!(numbers.count() >= 16, "{what}: too few numbers");
    let standard_error = numbers.standard_error().expect("at least 16 numbers");
    let verdict = judge(numbers.mean(), standard_error, exact, power);
    assert_eq!(
        verdict,
        Verdict::Pass,
        "{what}: {:.8} +- {standard_error:.1e}, exact {exact:.8}, power limit {power:.1e}",
        numbers.mean(),
    );
}

/// The significance of each of `checks` independent checks, so that all together have `family`: 1 - (1 - family)^(1/n).
pub fn sidak(family: f64, checks: usize) -> f64 {
    -f64::exp_m1(f64::ln_1p(-family) / checks as f64)
}
