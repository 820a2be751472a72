//! The arguments of `plan`.
//!
//! Measure: stated at each flag.
//! Range: stated at each flag; a value outside it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/plan.rs` and `cli/tests/command/bad_flags.rs`.

use super::values::parse_share;
use super::{SceneArguments, SettingsArguments, TracingArguments};
use crate::durations::parse_duration;
use clap::Args;
use std::time::Duration;

/// Arguments of `plan`.
#[derive(Debug, Args)]
pub struct PlanArguments {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Print the plan as one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Render with and without each active effect, and print its share of the time and of the light.
    ///
    /// The renders are by path at its defaults, of at most about 20 000 pixels unless --size is given.
    #[arg(long)]
    pub cost: bool,
    /// Samples per pixel of each render for --cost.
    #[arg(long, value_name = "N", default_value_t = 16, requires = "cost",
          value_parser = clap::value_parser!(u64).range(1..))]
    pub spp: u64,
    /// Pairs of renders for each number of --cost.
    #[arg(long, value_name = "N", default_value_t = 5, requires = "cost",
          value_parser = clap::value_parser!(u64).range(2..=1000))]
    pub rounds: u64,
    /// Render a pilot, and print how many shards of what length bring the image to --error.
    ///
    /// It is for a render with the same flags, such as --integrator and --size.
    #[arg(long, requires = "error")]
    pub shards: bool,
    /// Error to reach, such as 1% or 0.01: the root of relMSE.
    #[arg(long, value_name = "SHARE", value_parser = parse_share, requires = "shards")]
    pub error: Option<f64>,
    /// Time that a shard should take on a machine like this one.
    #[arg(long, value_name = "DURATION", value_parser = parse_duration, default_value = "10m", requires = "shards")]
    pub shard_time: Duration,
    /// The settings of the render.
    #[command(flatten)]
    pub settings: SettingsArguments,
    /// Ray tracing options.
    #[command(flatten)]
    pub tracing: TracingArguments,
}
