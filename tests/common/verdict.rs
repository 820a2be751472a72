//! The battery's acceptance rule: when a statistical test passes, fails, or is inconclusive.
//!
//! Measure: the unit of the estimated quantity; significance as a probability.
//! Range: standard errors come from at least 16 independent numbers.
//! Source: `battery/claim.rs`, which is tested there.

use etendue::internals::math::stats::Moments;
use etendue_lab::battery::claim::Claim;
use etendue_lab::verdict::Verdict;

/// Panics unless the mean of independent numbers is `exact`; `power` is the largest standard error that is accepted, relative
/// to `exact`.
pub fn assert_mean(what: &str, numbers: &Moments, exact: f64, power: f64) {
    let judged = Claim::mean(exact, power).judge_mean(numbers);
    assert_eq!(
        judged.verdict,
        Verdict::Passed,
        "{what}: {:.8} +- {:.1e}, exact {exact:.8}, power limit {power:.1e}",
        judged.ours,
        judged.standard_error.unwrap_or(f64::NAN),
    );
}

/// The significance level of each of `checks` independent checks, so that all together have the level `family`:
/// 1 - (1 - family)^(1/n).
pub fn sidak(family: f64, checks: usize) -> f64 {
    -f64::exp_m1(f64::ln_1p(-family) / checks as f64)
}
