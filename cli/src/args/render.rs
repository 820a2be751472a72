//! The arguments of `render`.
//!
//! Measure: stated at each flag.
//! Range: stated at each flag; a value outside it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/render.rs` and `cli/tests/command/bad_flags.rs`.

use super::state::StateArguments;
use super::values::{named, parse_exposure, parse_numbers, parse_share};
use super::{ProgressMode, SceneArguments, SettingsArguments, TracingArguments};
use crate::durations::parse_duration;
use clap::Args;
use etendue::internals::effects::Kernel;
use etendue::internals::post::denoise::Denoiser;
use etendue::internals::render::settings::Adaptive;
use std::path::PathBuf;
use std::time::Duration;

/// Arguments of `render`.
#[derive(Debug, Args)]
pub struct RenderArguments {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Output: an image (.exr, .png, .hdr or .pfm) or the state of the render (.etd); may be repeated. Default: the
    /// scene's name with .png.
    #[arg(short, long = "out", value_name = "FILE")]
    pub out: Vec<PathBuf>,
    /// Samples per pixel, at least 1; the mean over the pixels with --adaptive. Default: the scene's, or 64.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub spp: Option<u64>,
    /// Render time, such as 30s, 5m or 1h30m. With --spp, the limit that is reached first ends the render.
    #[arg(long, value_name = "DURATION", value_parser = parse_duration)]
    pub time: Option<Duration>,
    /// Render until the error is at most this, such as 1% or 0.01.
    ///
    /// The error is the root of relMSE. --spp and --max-time limit the render; exit code 5 if one of them ends it
    /// first.
    #[arg(long, value_name = "SHARE", value_parser = parse_share, conflicts_with = "time")]
    pub error: Option<f64>,
    /// Confidence level of the printed upper bound of the error, and of --error.
    #[arg(long, value_name = "SHARE", value_parser = parse_share, default_value = "95%")]
    pub confidence: f64,
    /// Maximum render time with --error.
    #[arg(long, value_name = "DURATION", value_parser = parse_duration, requires = "error")]
    pub max_time: Option<Duration>,
    /// Write per-pixel layers to EXR files.
    ///
    /// Layers: se (standard error; mean +- 2 se is a 95 % confidence interval), freedom (its degrees of freedom), flag
    /// (1 where se is not reliable), spp, half (the image from half of the samples), and albedo, normal and depth of
    /// the first hit. Sample counts are rounded up to a multiple of four.
    #[arg(long)]
    pub layers: bool,
    /// Adaptive sampling: more samples for pixels with more noise. Default: the scene's, or off.
    ///
    /// Adaptive renders neither splat their filter nor share paths, which gain more in most scenes.
    /// two-phase (also without a value): a pilot of at most a quarter of the samples estimates the noise. A pixel's
    /// sample count depends on the pilot of its neighbours, never on its own samples, so that the image is unbiased.
    /// greedy: a pixel stops when its own estimated relative error is below --error, as in other renderers; for
    /// comparison only. It is biased, since a pixel stops too early when its samples are alike by chance: pixels that
    /// are 20 with probability 0.05, stopped at 10 %, get a mean of 0.62 instead of 1, and pixels that are 200 with
    /// probability 0.005 get 0.08. off: the same sample count for each pixel.
    #[arg(long, value_name = "HOW", num_args = 0..=1, require_equals = true,
          default_missing_value = Adaptive::TwoPhase.name(),
          value_parser = named(Adaptive::ALL, Adaptive::name))]
    pub adaptive: Option<Adaptive>,
    /// Filter the noise of the image (biased).
    ///
    /// nlm (also without a value): non-local means over the two halves of the samples, guided by the features of the
    /// first hit; its bias vanishes as the noise does. oidn: Intel Open Image Denoise 2, if it is found (OIDN_DIR may
    /// name its folder). --error applies to the unfiltered image. Sample counts are rounded up as with --layers. EXR
    /// files keep the unfiltered image as the layer noisy; with --layers, se is the estimated error of the filtered
    /// image.
    #[arg(long, value_name = "FILTER", num_args = 0..=1, require_equals = true,
          default_missing_value = Denoiser::ALL[0].name(),
          value_parser = named(Denoiser::ALL, Denoiser::name))]
    pub denoise: Option<Denoiser>,
    /// The integrator, the sampler and their settings.
    #[command(flatten)]
    pub settings: SettingsArguments,
    /// Ray tracing options.
    #[command(flatten)]
    pub tracing: TracingArguments,
    /// Compiled render kernel; affects only the speed. Default: the smallest that has all effects of the scene.
    #[arg(long, value_parser = named(Kernel::ALL, Kernel::name))]
    pub kernel: Option<Kernel>,
    /// Folder to which the contribution of each strategy of bdpt or path is also written. Needs --spp.
    ///
    /// bdpt, which needs --max-bounces: sS-tT.exr, with S vertices from the light and T from the camera, is the strategy alone
    /// without weights; sS-tT-weighted.exr is its weighted share of the image. path: s0-weighted.exr is the light found by
    /// scattering, s1-weighted.exr by light sampling, and t1-weighted.exr by light paths.
    #[arg(long, value_name = "DIR")]
    pub bdpt_strategies: Option<PathBuf>,
    /// Seed of the random numbers, from 0 to 2^64 - 1. Default: the scene's, or 0.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Render only the pixels from (X0, Y0) up to but not including (X1, Y1); the origin is the upper left corner.
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = parse_numbers::<4>)]
    pub crop: Option<[u32; 4]>,
    /// Shards and checkpoints.
    #[command(flatten)]
    pub state: StateArguments,
    /// Exposure of PNG files in stops: pixel values are multiplied by 2^EV.
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true,
          value_parser = parse_exposure)]
    pub exposure: f32,
    /// Write the render statistics to a JSON file.
    #[arg(long, value_name = "FILE")]
    pub stats: Option<PathBuf>,
    /// Print the render statistics as one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Progress display on standard error.
    #[arg(long, value_enum, default_value = "auto")]
    pub progress: ProgressMode,
    /// Print only errors and warnings of non-finite samples.
    #[arg(short, long, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print a summary of the scene and the time of each phase.
    #[arg(short, long)]
    pub verbose: bool,
    /// Replay one sample of this pixel instead of rendering, and print the vertices of its path.
    #[arg(long, value_name = "X,Y", value_parser = parse_numbers::<2>, requires = "sample",
          conflicts_with_all = ["out", "json", "stats"])]
    pub pixel: Option<[u32; 2]>,
    /// Index of the sample to replay, from 0.
    #[arg(long, value_name = "N", requires = "pixel")]
    pub sample: Option<u64>,
}
