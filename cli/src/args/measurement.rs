//! The arguments of verbs that measure one scene for a given time: `price` and `study`.
//!
//! Measure: stated at each flag.
//! Range: stated at each flag; a value outside it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/price.rs` and `cli/tests/command/study.rs`.

use super::{ProgressMode, SceneArguments, TracingArguments};
use clap::Args;

/// The arguments that `price` and `study` share.
#[derive(Debug, Args)]
pub struct MeasurementArguments {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Seed of all random numbers, from 0 to 2^64 - 1.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Print the report as one JSON object instead of text.
    #[arg(long)]
    pub json: bool,
    /// Progress display on standard error.
    #[arg(long, value_enum, default_value = "auto")]
    pub progress: ProgressMode,
    /// Suppress progress and notes on standard error.
    #[arg(short, long)]
    pub quiet: bool,
    /// Ray tracing options, for settings that are not compared.
    #[command(flatten)]
    pub tracing: TracingArguments,
}

impl MeasurementArguments {
    /// The progress display, of which `--quiet` leaves nothing.
    pub fn progress_mode(&self) -> ProgressMode {
        match self.quiet {
            true => ProgressMode::None,
            false => self.progress,
        }
    }
}
