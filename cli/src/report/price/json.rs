//! A price as JSON.
//!
//! Measure: as in `lab/src/price/report.rs`.
//! Range: any report; non-finite numbers are `null`.
//! Source: none needed. Tested in `cli/tests/command/price.rs`.

use super::text::advice_on;
use crate::recommendation::RecommendationReport;
use etendue_lab::bench::report::Machine;
use etendue_lab::price::report::PriceReport;
use serde::Serialize;

/// The JSON document.
#[derive(Serialize)]
struct PriceDocument<'a> {
    command: &'a str,
    machine: &'a Machine,
    #[serde(flatten)]
    report: &'a PriceReport,
    /// The choice of `auto`, as `etendue plan` prints it.
    auto: Option<RecommendationReport>,
    advice: Vec<String>,
}

/// Returns the report as one object.
pub fn of_report(report: &PriceReport, command: &str, machine: &Machine) -> String {
    let document = PriceDocument {
        command,
        machine,
        report,
        auto: report.recommendation.as_ref().map(Into::into),
        advice: advice_on(report),
    };
    let json = serde_json::to_string_pretty(&document).expect("plain data always serialises");
    json + "\n"
}
