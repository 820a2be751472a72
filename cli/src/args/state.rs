//! The arguments of `render` for shards and checkpoints, and those of `merge`.
//!
//! Measure: stated at each flag.
//! Range: stated at each flag; a value outside it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/shards.rs` and `cli/tests/command/checkpoints.rs`.

use super::values::{named, parse_exposure, parse_shard, parse_share};
use crate::durations::parse_duration;
use clap::Args;
use etendue::internals::post::denoise::Denoiser;
use etendue::internals::state::Shard;
use std::path::PathBuf;
use std::time::Duration;

/// Arguments of `render` for shards and checkpoints.
#[derive(Debug, Args)]
pub struct StateArguments {
    /// Render a part of the samples to state files (-o FILE.etd), for `etendue merge`: K/N, the shard K of N, counted
    /// from 0, or A..B, the samples from A up to but not including B.
    ///
    /// --spp is that of the whole render. The merged image has the bits of one render, for any division.
    #[arg(long, value_name = "SHARD", value_parser = parse_shard)]
    pub shard: Option<Shard>,
    /// Distribute the samples of a render with --adaptive by this pilot, the state file of --shard 0..P, where P is a
    /// sixteenth of --spp within limits.
    ///
    /// With --shard K/N, a part of the samples after the pilot is rendered, otherwise all of them. The merged image of the
    /// pilot and all shards has the bits of one render.
    #[arg(long, value_name = "FILE")]
    pub pilot: Option<PathBuf>,
    /// Write the state of the render to this file every minute or --every, and at the end.
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Time between two checkpoints. They are made between passes, which are at least one sample per pixel.
    #[arg(long, value_name = "DURATION", value_parser = parse_duration, default_value = "60s", requires = "checkpoint")]
    pub every: Duration,
    /// Take the irradiance cache from this file, if it is there; else fill the cache and write it there, for other shards and
    /// for a render that is interrupted. With --integrator irradiance-cache.
    #[arg(long, value_name = "FILE")]
    pub cache: Option<PathBuf>,
    /// Take what pilots choose from this file, if it is there; else choose, and write it there, for other shards of the render.
    #[arg(long, value_name = "FILE")]
    pub choices: Option<PathBuf>,
    /// Continue a render from its checkpoint or state file, also to a larger --spp or to an --error.
    ///
    /// All flags that affect samples have to be those of the render that wrote it. --time counts from now.
    #[arg(long, value_name = "FILE")]
    pub resume: Option<PathBuf>,
    /// If the file of --resume is damaged, rename it to FILE.damaged and begin anew, as a task of a cluster has nobody to ask.
    ///
    /// Only with --checkpoint to the same file. A state of another render or version is refused as without this flag.
    #[arg(long, requires_all = ["resume", "checkpoint"])]
    pub set_damaged_aside: bool,
}

/// Arguments of `merge`.
#[derive(Debug, Args)]
pub struct MergeArguments {
    /// State files of one render, or folders of them, in any order.
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Output: an image (.exr, .png, .hdr or .pfm) or a state file (.etd); may be repeated.
    ///
    /// EXR files have the layers if the shards were rendered with --layers.
    #[arg(short, long = "out", value_name = "FILE", required = true)]
    pub out: Vec<PathBuf>,
    /// Rename damaged state files (.etd) to FILE.damaged, and merge as if they were missing, as a job of a cluster has nobody to ask.
    #[arg(long)]
    pub set_damaged_aside: bool,
    /// Merge what is there, although samples are missing.
    #[arg(long)]
    pub partial: bool,
    /// Exit with code 5 if the error is above this, such as 1% or 0.01, and print how many samples are still needed.
    #[arg(long, value_name = "SHARE", value_parser = parse_share)]
    pub error: Option<f64>,
    /// Confidence level of the printed upper bound of the error, and of --error.
    #[arg(long, value_name = "SHARE", value_parser = parse_share, default_value = "95%")]
    pub confidence: f64,
    /// Filter the noise of the image (biased), as `etendue render --denoise` does. Needs shards with --layers.
    #[arg(long, value_name = "FILTER", num_args = 0..=1, require_equals = true,
          default_missing_value = Denoiser::ALL[0].name(),
          value_parser = named(Denoiser::ALL, Denoiser::name))]
    pub denoise: Option<Denoiser>,
    /// Exposure of PNG files in stops: pixel values are multiplied by 2^EV.
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true,
          value_parser = parse_exposure)]
    pub exposure: f32,
    /// Print the result as one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Print only errors and warnings of non-finite samples.
    #[arg(short, long)]
    pub quiet: bool,
}
