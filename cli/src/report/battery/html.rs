//! A battery as one HTML page.
//!
//! Measure: as stated in the report.
//! Range: any report, also of an interrupted battery.
//! Source: docs/hard-cases.md. Tested in `cli/tests/command/battery.rs`.

use super::summary;
use super::tables::{all, conditions};
use crate::report::page::page;
use crate::report::prose::prose;
use etendue_lab::battery::report::BatteryReport;
use maud::html;

/// Builds the page.
pub fn of_report(report: &BatteryReport, command: &str) -> String {
    let body = html! {
        h1 { "The battery of hard cases" }
        p.headline { (summary(report)) "." }
        p { code { (command) } }
        p.caption { (conditions(report)) "." }
        p.caption {
            "A case passes if its mean is within 5.2 standard errors of the exact number, or within as many more as \
             Student's distribution asks of few replicates (9.0 of 16), and its standard error is below the case's limit; without a standard error every single number has to be exact up to the stated \
             rounding. A case with a larger standard error is inconclusive, which counts as a failure. Rows are those of \
             the catalogue in docs/hard-cases.md."
        }
        @for table in all(report) {
            section {
                h2 { (table.title) }
                p.caption { (prose(&table.caption)) }
                (table.html())
            }
        }
    };
    page("The battery of hard cases", &body)
}
