//! The arguments of `battery`.
//!
//! Measure: stated at each flag.
//! Range: stated at each flag; a value outside it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/battery.rs` and `cli/tests/command/bad_flags.rs`.

use super::{ProgressMode, TracingArguments};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `battery`.
#[derive(Debug, Args)]
pub struct BatteryArguments {
    /// Row numbers of the catalogue in docs/hard-cases.md, such as 25 28. Default: all rows.
    #[arg(value_name = "ROW")]
    pub rows: Vec<u32>,
    /// Take 8 times as many samples, run the long rows at full length, and by default use a new seed each time.
    #[arg(long)]
    pub full: bool,
    /// Seed of the random numbers, from 0 to 2^64 - 1. Default: 0, or the current time with --full.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Ray tracing options.
    #[command(flatten)]
    pub tracing: TracingArguments,
    /// Output folder for battery.json and battery.html; created if missing.
    #[arg(short, long = "out", value_name = "DIR", default_value = "out/battery")]
    pub out: PathBuf,
    /// Print battery.json instead of the tables.
    #[arg(long)]
    pub json: bool,
    /// Progress display on standard error.
    #[arg(long, value_enum, default_value = "auto")]
    pub progress: ProgressMode,
    /// Suppress progress and the final summary line.
    #[arg(short, long)]
    pub quiet: bool,
}
