//! A battery run as tables, as JSON and as a page.

pub mod html;
pub mod json;
pub mod tables;

use etendue_lab::battery::report::BatteryReport;
use etendue_lab::verdict::Verdict;

/// Summarises the verdicts in a few words.
pub fn summary(report: &BatteryReport) -> String {
    let count = |verdict| report.count(verdict);
    let mut words = format!(
        "{} of {} cases passed",
        count(Verdict::Passed),
        report.results.len()
    );
    for (verdict, name) in [
        (Verdict::Failed, "failed"),
        (Verdict::Inconclusive, "inconclusive"),
    ] {
        if count(verdict) > 0 {
            words += &format!(", {} {name}", count(verdict));
        }
    }
    if !report.left_out.is_empty() {
        words += &format!(", {} left out as known to fail", report.left_out.len());
    }
    if !report.complete {
        words += ", interrupted";
    }
    words
}
