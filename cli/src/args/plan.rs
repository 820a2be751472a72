//! The arguments of `plan`.
//!
//! Measure: stated at each flag.
//! Range: stated at each flag; a value outside it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/plan.rs` and `cli/tests/command/bad_flags.rs`.

use super::values::parse_size;
use super::{SceneArguments, TracingArguments};
use clap::Args;

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
    /// Image size of the renders for --cost, in pixels. Default: the scene's aspect ratio, at most about 20 000 pixels.
    #[arg(long, value_name = "WxH", value_parser = parse_size, requires = "cost")]
    pub size: Option<(u32, u32)>,
    /// Ray tracing options.
    #[command(flatten)]
    pub tracing: TracingArguments,
}
