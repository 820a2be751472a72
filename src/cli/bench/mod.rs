//! `etendue bench`: backends side by side, as tables, as JSON and as a page.
//!
//! Measure: that of `bench/report.rs`.
//! Range: scenes that load, and those of the bench's own. What is measured is written part by part, so that an end by
//! Ctrl-C keeps it.
//! Source: docs/bench.md. Tested in `tests/bench_command.rs`.

mod compare;
mod html;
mod json;
#[cfg(test)]
mod sample;
mod tables;
mod wording;

use super::Outcome;
use super::args::BenchArguments;
use crate::error::Result;

pub fn run(_arguments: &BenchArguments) -> Result<Outcome> {
    todo!()
}
