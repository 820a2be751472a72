//! The arguments of `render`.
//!
//! Measure: said at each flag.
//! Range: said at each flag; what is out of it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/render.rs` and `cli/tests/command/bad_flags.rs`.

use super::values::{
    named, parse_distance, parse_exposure, parse_numbers, parse_share, parse_size, parse_small,
};
use super::{ProgressMode, TracingArguments};
use crate::durations::parse_duration;
use clap::Args;
use etendue::internals::effects::Kernel;
use etendue::internals::integrator::Roulette;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::post::denoise::Denoiser;
use etendue::internals::render::settings::Adaptive;
use etendue::internals::render::settings::SamplerKind;
use std::path::PathBuf;
use std::time::Duration;

/// Arguments of `render`.
#[derive(Debug, Args)]
pub struct RenderArguments {
    /// The scene: a .toml file, or a bare .obj model.
    pub scene: PathBuf,
    /// Image to write: .exr, .png, .hdr or .pfm; may be repeated. Default: the scene's name with .png.
    #[arg(short, long = "out", value_name = "FILE")]
    pub out: Vec<PathBuf>,
    /// Samples per pixel, at least 1; in the mean over the pixels with --adaptive. Default: the scene's, or 64.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub spp: Option<u64>,
    /// Time to render, such as 30s, 5m or 1h30m. With --spp, whichever comes first.
    #[arg(long, value_name = "DURATION", value_parser = parse_duration)]
    pub time: Option<Duration>,
    /// Render until the error, the root of relMSE, is at most this, such as 1% or 0.01. --spp and --max-time limit it; exit code
    /// 5 if they came first.
    #[arg(long, value_name = "SHARE", value_parser = parse_share, conflicts_with = "time")]
    pub error: Option<f64>,
    /// The probability with which the error asked for is kept.
    #[arg(long, value_name = "SHARE", value_parser = parse_share, default_value = "95%")]
    pub confidence: f64,
    /// Time to render at most, with --error.
    #[arg(long, value_name = "DURATION", value_parser = parse_duration, requires = "error")]
    pub max_time: Option<Duration>,
    /// Write layers to EXR files: se (standard error; two of them make an interval of 95 %), freedom (its degrees of freedom), flag
    /// (1 where se is not to be trusted), spp, half (the picture from half of the samples), and albedo, normal and depth of what
    /// is seen first. Samples are rounded up to a multiple of four.
    #[arg(long)]
    pub layers: bool,
    /// Give more samples to pixels with more noise. two-phase: a pilot, up to a quarter of them, shows where; a pixel's count
    /// is decided by its neighbours' pilot, never by its own samples, so that nothing is biased. greedy: the rule of other
    /// renderers, to compare with: a pixel stops when its own relative error is below --error, too early where its samples are
    /// alike by chance. Biased: of pixels that are 20 with probability 0.05, stopped at 10 %, the mean is
    /// 0.62 instead of 1; of 200 with 0.005 it is 0.08. off: the same number for each. Default: the scene's, or off.
    #[arg(long, value_name = "HOW", num_args = 0..=1, require_equals = true,
          default_missing_value = Adaptive::TwoPhase.name(),
          value_parser = named(Adaptive::ALL, Adaptive::name))]
    pub adaptive: Option<Adaptive>,
    /// Filter the noise of the picture. Biases; with --error, the error asked for is that of the unfiltered picture. nlm:
    /// non-local means over the two halves of the samples, guided by what is seen first; its bias vanishes as the noise does.
    /// oidn: Intel Open Image Denoise 2, where it is found (OIDN_DIR may name its folder). Samples are rounded up
    /// as with --layers. EXR files keep the unfiltered picture as the layer noisy; with --layers, se is then the estimated error of the
    /// filtered one.
    #[arg(long, value_name = "FILTER", num_args = 0..=1, require_equals = true,
          default_missing_value = Denoiser::ALL[0].name(),
          value_parser = named(Denoiser::ALL, Denoiser::name))]
    pub denoise: Option<Denoiser>,
    /// The estimator. The path tracers of the course, from the first to the best: naive (a coin decides between emission and
    /// a direction anywhere), emit-or-reflect (a better coin), bsdf (no coin, directions by the BSDF), light-or-rest (a ray to
    /// a light, a ray anywhere else), nee (next event estimation), path (with multiple importance sampling). Paths from the
    /// camera and from the lights, connected in every way: bdpt, for caustics and hidden lamps; mlt walks through such paths and
    /// stays where there is light. Path with the indirect light of matte surfaces told from few of their points, biased
    /// within --cache-error: irradiance-cache. Direct light alone, by uniform directions or by uniform points on lights:
    /// direct-directional, direct-area. And ambient-occlusion. auto: path, bdpt or mlt, whichever suits the scene by a small
    /// pilot, which is said with its reason; see etendue plan. Default: the scene's, or path.
    #[arg(long, value_parser = named(IntegratorKind::ALL, IntegratorKind::name))]
    pub integrator: Option<IntegratorKind>,
    /// Where random numbers come from. Default: the scene's, or sobol.
    #[arg(long, value_parser = named(SamplerKind::ALL, SamplerKind::name))]
    pub sampler: Option<SamplerKind>,
    /// How rays are traced.
    #[command(flatten)]
    pub tracing: TracingArguments,
    /// The compiled code that renders. It changes nothing but the speed. Default: the smallest that has all effects of the scene.
    #[arg(long, value_parser = named(Kernel::ALL, Kernel::name))]
    pub kernel: Option<Kernel>,
    /// Scattering events at most: 0 shows emitters only, 1 is direct light. Biases. Default: the scene's, or no limit.
    #[arg(long, value_name = "N")]
    pub max_bounces: Option<u32>,
    /// When paths end by chance: never, by what the last surface reflected, or by what the path has left. It changes noise and
    /// time, not the mean. Default: the scene's, or the integrator's own: throughput; none for naive, which has a coin, and for those that scatter once at most.
    #[arg(long, value_parser = named(Roulette::ALL, Roulette::name))]
    pub roulette: Option<Roulette>,
    /// Also write what each strategy of bdpt contributes into this folder: sS-tT.exr, with S vertices from the light and T from
    /// the camera, as if it were alone, and sS-tT-weighted.exr, its share of the picture. Needs --max-bounces
    #[arg(long, value_name = "DIR")]
    pub bdpt_strategies: Option<PathBuf>,
    /// How far, in the scene's units, something may be and still count for ambient-occlusion. Default: the scene's, or any
    /// distance.
    #[arg(long, value_name = "DISTANCE", value_parser = parse_distance)]
    pub occlusion_distance: Option<f64>,
    /// The share of indirect light up to which irradiance-cache may be wrong, such as 5% or 0.05; 0 caches nothing. Default: the
    /// scene's, or 5%.
    #[arg(long, value_name = "SHARE", value_parser = parse_small)]
    pub cache_error: Option<f64>,
    /// Picks one of 2^64 sets of random numbers. Default: the scene's, or 0.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Size of the picture in pixels. Default: the scene's.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
    /// Render only the pixels from (x0, y0) up to but not including (x1, y1); the origin is the upper left corner.
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = parse_numbers::<4>)]
    pub crop: Option<[u32; 4]>,
    /// Exposure of PNG files in stops: pixel values times 2^EV.
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true,
          value_parser = parse_exposure)]
    pub exposure: f32,
    /// Write the statistics of the render to a JSON file.
    #[arg(long, value_name = "FILE")]
    pub stats: Option<PathBuf>,
    /// Print the statistics of the render as one JSON object.
    #[arg(long)]
    pub json: bool,
    /// When to show progress.
    #[arg(long, value_enum, default_value = "auto")]
    pub progress: ProgressMode,
    /// Print nothing but errors.
    #[arg(short, long, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print what the scene consists of and where the time goes.
    #[arg(short, long)]
    pub verbose: bool,
    /// Replay one sample of this pixel instead of rendering, and print the vertices of its path.
    #[arg(long, value_name = "X,Y", value_parser = parse_numbers::<2>, requires = "sample",
          conflicts_with_all = ["out", "json", "stats"])]
    pub pixel: Option<[u32; 2]>,
    /// The sample to replay, counted from 0.
    #[arg(long, value_name = "N", requires = "pixel")]
    pub sample: Option<u64>,
}
