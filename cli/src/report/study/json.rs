//! A study as JSON: the numbers of every render, and the derived summaries.
//!
//! Measure: as stated in the report.
//! Range: any report; non-finite numbers are `null`.
//! Source: none needed. Tested in `cli/tests/command/study.rs`.

use super::Findings;
use etendue_lab::bench::report::Machine;
use etendue_lab::study::report::StudyReport;
use etendue_lab::study::summary::Summary;
use serde::Serialize;

/// The JSON document.
#[derive(Serialize)]
struct StudyDocument<'a> {
    command: &'a str,
    machine: &'a Machine,
    #[serde(flatten)]
    report: &'a StudyReport,
    /// The summaries of the variants that have enough renders.
    derived: Vec<&'a Summary>,
}

/// Returns the report with its command as one object.
pub fn of_findings(findings: &Findings<'_>) -> String {
    let document = StudyDocument {
        command: findings.command,
        machine: findings.machine,
        report: findings.report,
        derived: findings.summaries.iter().map(|(_, s)| s).collect(),
    };
    let json = serde_json::to_string_pretty(&document).expect("plain data always serialises");
    json + "\n"
}
