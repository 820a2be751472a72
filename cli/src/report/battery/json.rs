//! A battery as JSON: the report, its command, and the number of cases of each verdict.
//!
//! Measure: as stated in the report.
//! Range: any report; non-finite numbers are `null`.
//! Source: none needed. Tested in `cli/tests/command/battery.rs`.

use etendue_lab::battery::report::BatteryReport;
use etendue_lab::verdict::Verdict;
use serde::Serialize;

#[derive(Serialize)]
struct BatteryDocument<'a> {
    command: &'a str,
    passed: usize,
    failed: usize,
    inconclusive: usize,
    #[serde(flatten)]
    report: &'a BatteryReport,
}

/// Returns the report with its command as one object.
pub fn of_report(report: &BatteryReport, command: &str) -> String {
    let document = BatteryDocument {
        command,
        passed: report.count(Verdict::Passed),
        failed: report.count(Verdict::Failed),
        inconclusive: report.count(Verdict::Inconclusive),
        report,
    };
    let json = serde_json::to_string_pretty(&document).expect("plain data always serialises");
    json + "\n"
}
