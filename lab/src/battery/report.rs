//! What a battery finds out, as it is written to `battery.json`.
//!
//! Measure: the unit of each case; seconds.
//! Range: a battery that was interrupted has the cases that were done by then, in their order.
//! Source: docs/hard-cases.md. Tested in `lab/tests/reports/battery.rs`.

use super::case::{Effort, Peers};
use super::claim::Claim;
use crate::bench::report::Machine;
use crate::verdict::Verdict;
use serde::Serialize;

/// All of a battery.
#[derive(Debug, Clone, Serialize)]
pub struct BatteryReport {
    /// Of the program.
    pub version: &'static str,
    /// What it ran on.
    pub machine: Machine,
    /// The library that traced rays.
    pub backend: &'static str,
    /// How carefully.
    pub precision: &'static str,
    /// How much was measured.
    pub effort: Effort,
    /// Which random numbers.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
    /// Whether all cases that were asked for are here.
    pub complete: bool,
    /// Case by case.
    pub results: Vec<CaseReport>,
    /// What was not measured, as it is known to fail.
    pub left_out: Vec<LeftOut>,
}

/// A case that was left out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// Its row in the catalogue.
    pub row: u32,
    /// What it is.
    pub name: String,
    /// Why it fails.
    pub why: &'static str,
}

/// One case.
#[derive(Debug, Clone, Serialize)]
pub struct CaseReport {
    /// Its row in the catalogue.
    pub row: u32,
    /// The subject that it belongs to.
    pub subject: &'static str,
    /// What it is.
    pub name: String,
    /// What is claimed.
    #[serde(flatten)]
    pub claim: Claim,
    /// What was measured; not a number if it could not be.
    pub ours: f64,
    /// What was measured less what is exact.
    pub error: f64,
    /// The standard error of what was measured.
    pub standard_error: Option<f64>,
    /// Whether the claim holds.
    pub verdict: Verdict,
    /// Why it could not be measured.
    pub failure: Option<String>,
    /// Time on one thread.
    pub seconds: f64,
    /// What others gave.
    pub peers: Option<Peers>,
}

impl BatteryReport {
    /// How many cases have a verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        let results = self.results.iter();
        results.filter(|result| result.verdict == verdict).count()
    }

    /// Whether everything that was asked for was measured and holds.
    pub fn all_passed(&self) -> bool {
        self.complete && self.count(Verdict::Passed) == self.results.len()
    }
}
