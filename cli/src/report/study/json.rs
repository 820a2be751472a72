//! A study as JSON: every render's numbers as they were measured, and what follows from them.
//!
//! Measure: as the report says.
//! Range: any report; what is not finite is `null`.
//! Source: none needed. Tested in `cli/tests/command/study.rs`.

use super::Findings;
use etendue_lab::bench::report::Machine;
use etendue_lab::study::report::StudyReport;
use etendue_lab::study::summary::Summary;
use serde::Serialize;

/// All that is written.
#[derive(Serialize)]
struct Document<'a> {
    command: &'a str,
    machine: &'a Machine,
    #[serde(flatten)]
    report: &'a StudyReport,
    /// For each variant that has enough renders.
    derived: Vec<&'a Summary>,
}

/// The report with its command, as one object.
pub fn of_findings(findings: &Findings<'_>) -> String {
    let document = Document {
        command: findings.command,
        machine: findings.machine,
        report: findings.report,
        derived: findings.summaries.iter().map(|(_, s)| s).collect(),
    };
    let json = serde_json::to_string_pretty(&document).expect("plain data always serialises");
    json + "\n"
}
