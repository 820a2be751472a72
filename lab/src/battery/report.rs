//! The results of a battery, as written to `battery.json`.
//!
//! Measure: the unit of each case; seconds.
//! Range: a battery that was interrupted has the cases completed by then, in their order.
//! Source: docs/hard-cases.md. Tested in `lab/tests/reports/battery.rs`.

use super::case::{Effort, Peers};
use super::claim::Claim;
use crate::bench::report::Machine;
use crate::verdict::Verdict;
use serde::Serialize;

/// The report of a whole battery.
#[derive(Debug, Clone, Serialize)]
pub struct BatteryReport {
    /// Version of the program.
    pub version: &'static str,
    /// The machine that it ran on.
    pub machine: Machine,
    /// The backend that traced rays.
    pub backend: &'static str,
    /// Precision of its intersections.
    pub precision: &'static str,
    /// The effort.
    pub effort: Effort,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Number of threads.
    pub threads: usize,
    /// Whether all requested cases are included.
    pub complete: bool,
    /// The results of the cases.
    pub results: Vec<CaseReport>,
    /// Cases that were not measured, as they are known to fail.
    pub left_out: Vec<LeftOut>,
}

/// A case that was left out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// Its row in the catalogue.
    pub row: u32,
    /// The name of the case.
    pub name: String,
    /// The reason of its failure.
    pub why: &'static str,
}

/// The result of one case.
#[derive(Debug, Clone, Serialize)]
pub struct CaseReport {
    /// Its row in the catalogue.
    pub row: u32,
    /// The subject that it belongs to.
    pub subject: &'static str,
    /// The name of the case.
    pub name: String,
    /// The claim.
    #[serde(flatten)]
    pub claim: Claim,
    /// The independent measurements; none if it could not be measured.
    #[serde(skip)]
    pub numbers: Vec<f64>,
    /// The measured number; NaN if it could not be measured.
    pub ours: f64,
    /// The measured number minus the exact one.
    pub error: f64,
    /// The standard error of the measured number.
    pub standard_error: Option<f64>,
    /// Whether the claim holds.
    pub verdict: Verdict,
    /// The reason why it could not be measured.
    pub failure: Option<String>,
    /// Seconds on one thread.
    pub seconds: f64,
    /// Results of other renderers.
    pub peers: Option<Peers>,
}

impl BatteryReport {
    /// The number of cases with a given verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        let results = self.results.iter();
        results.filter(|result| result.verdict == verdict).count()
    }

    /// Whether all requested cases were measured and passed.
    pub fn all_passed(&self) -> bool {
        self.complete && self.count(Verdict::Passed) == self.results.len()
    }
}
