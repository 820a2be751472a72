//! The arguments of `battery`.
//!
//! Measure: said at each flag.
//! Range: said at each flag; what is out of it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/battery.rs` and `cli/tests/command/bad_flags.rs`.

use super::{ProgressMode, TracingArguments};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `battery`.
#[derive(Debug, Args)]
pub struct BatteryArguments {
    /// Rows of the catalogue in docs/hard-cases.md, such as 25 28. Default: all.
    #[arg(value_name = "ROW")]
    pub rows: Vec<u32>,
    /// Eight times as many samples, the long rows at full length, and other random numbers each time.
    #[arg(long)]
    pub full: bool,
    /// Picks one of 2^64 sets of random numbers. Default: 0, or with --full the time.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// How rays are traced.
    #[command(flatten)]
    pub tracing: TracingArguments,
    /// Folder for battery.json and battery.html; made where it is missing.
    #[arg(short, long = "out", value_name = "DIR", default_value = "out/battery")]
    pub out: PathBuf,
    /// Print battery.json instead of the tables.
    #[arg(long)]
    pub json: bool,
    /// When to show progress.
    #[arg(long, value_enum, default_value = "auto")]
    pub progress: ProgressMode,
    /// Show no progress and print no last line.
    #[arg(short, long)]
    pub quiet: bool,
}
