//! A study as tables, as JSON, as CSV and as a page.

mod answers;
mod conclusions;
pub mod csv;
pub mod html;
mod images;
pub mod json;
mod plots;
#[cfg(test)]
mod sample;
pub mod tables;
pub mod wording;

use etendue::internals::render::auto::Recommendation;
use etendue_lab::bench::report::Machine;
use etendue_lab::study::report::StudyReport;
use etendue_lab::study::summary::Summary;

/// The content of the output: the report, the summaries, the machine and the command.
pub struct Findings<'a> {
    pub report: &'a StudyReport,
    pub summaries: Vec<(usize, Summary)>,
    pub machine: &'a Machine,
    pub command: &'a str,
    /// The integrator that `auto` selects, where several were compared.
    pub recommendation: Option<&'a Recommendation>,
}
