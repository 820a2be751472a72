//! The arguments of `render`.
//!
//! Measure: stated at each flag.
//! Range: stated at each flag; a value outside it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/render.rs` and `cli/tests/command/bad_flags.rs`.

use super::state::StateArguments;
use super::values::{
    named, parse_distance, parse_exposure, parse_filter, parse_numbers, parse_roulette,
    parse_share, parse_size, parse_small,
};
use super::{ProgressMode, SceneArguments, TracingArguments};
use crate::durations::parse_duration;
use clap::Args;
use etendue::internals::effects::Kernel;
use etendue::internals::film::filter::{FilterDescription, FilterSampling};
use etendue::internals::integrator::Roulette;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::light::types::LightChoice;
use etendue::internals::post::denoise::Denoiser;
use etendue::internals::render::settings::SamplerKind;
use etendue::internals::render::settings::{Adaptive, LightPathRule, PathReuseRule};
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
    /// Integrator. Default: the scene's, or path.
    ///
    /// Path tracers, from the simplest to the best: naive (at each surface, a random choice between its emission, which
    /// ends the path, and a uniform direction), emit-or-reflect (a better choice probability), bsdf (no such choice;
    /// directions sampled from the BSDF), light-or-rest (a ray to one light, a uniform ray for all other light), nee
    /// (next event estimation), path (next event estimation with multiple importance sampling). bdpt: bidirectional
    /// path tracing, for caustics and hidden lamps. mlt: Metropolis light transport over bdpt. irradiance-cache: path
    /// with the indirect light of matte surfaces interpolated from few points, biased within --cache-error.
    /// direct-directional, direct-area: direct light only, by uniform directions or by uniform points on lights.
    /// ambient-occlusion: ambient occlusion only. auto: path, bdpt or mlt, chosen by a small pilot and printed with the
    /// reason; see `etendue plan`.
    #[arg(long, value_parser = named(IntegratorKind::ALL, IntegratorKind::name))]
    pub integrator: Option<IntegratorKind>,
    /// Sampler of the random numbers. Default: the scene's, or sobol.
    #[arg(long, value_parser = named(SamplerKind::ALL, SamplerKind::name))]
    pub sampler: Option<SamplerKind>,
    /// Ray tracing options.
    #[command(flatten)]
    pub tracing: TracingArguments,
    /// Compiled render kernel; affects only the speed. Default: the smallest that has all effects of the scene.
    #[arg(long, value_parser = named(Kernel::ALL, Kernel::name))]
    pub kernel: Option<Kernel>,
    /// Maximum number of scattering events: 0 shows emitters only, 1 is direct light. Biased. Default: the scene's, or
    /// no limit.
    #[arg(long, value_name = "N")]
    pub max_bounces: Option<u32>,
    /// Russian roulette. Affects noise and time, not the mean. Default: the scene's, or the integrator's.
    ///
    /// none: never. albedo: by what the last surface reflected. throughput: by the path throughput. window=1/N: by the
    /// path throughput times N, so that paths are longer; N is 2 unless given. The default is window for irradiance-cache
    /// and for path, there with N = 4 where a pilot counts at most 15 % more rays; none for naive, which ends paths itself,
    /// and for those that scatter at most once; else throughput.
    #[arg(long, value_name = "none|albedo|throughput|window[=1/N]", value_parser = parse_roulette)]
    pub roulette: Option<Roulette>,
    /// Light paths beside the camera paths of the integrator path. Affects noise and time, not the mean. Default: the
    /// scene's, or auto.
    ///
    /// They find caustics of glass and metal, also those of point lights. off: none. 1/4, 1/2, 1,
    /// 2: this number for each camera path. auto: 1/4 where a pilot shows that camera paths alone have more than 1.25 times
    /// the squared error, else off; off with --roulette none.
    #[arg(long, value_parser = named(LightPathRule::ALL, LightPathRule::name))]
    pub light_paths: Option<LightPathRule>,
    /// Number of neighbouring pixels that share the paths of the integrator path. Affects noise and time, not the mean.
    /// Default: the scene's, or auto.
    ///
    /// Indirect light that one path finds is taken by a group of 4 or 16 pixels, where matte surfaces see each other. The
    /// noise of these pixels is not independent. off: none. auto: the number with the least error in a pilot, if that pays;
    /// off with layers, adaptive sampling, light paths and --roulette none. With a number, --light-paths auto has none.
    #[arg(long, value_parser = named(PathReuseRule::ALL, PathReuseRule::name))]
    pub reuse: Option<PathReuseRule>,
    /// Selection of the light that is sampled, where there are several. Affects noise and time, not the mean. Default:
    /// contribution, but power for light-or-rest, nee and direct-area.
    ///
    /// contribution: in proportion to an estimate of what each light would contribute at the surface if nothing occluded
    /// it, from a tree of lights if there are more than 16. power: in proportion to power, everywhere alike.
    #[arg(long, value_parser = named(LightChoice::ALL, LightChoice::name))]
    pub light_choice: Option<LightChoice>,
    /// Reconstruction filter, with its radius in pixels if not the default: box (0.5), tent (1), gaussian (1.5), mitchell (2),
    /// blackman-harris (1.5). Default: the scene's, or gaussian.
    #[arg(long, value_name = "NAME[:RADIUS]", value_parser = parse_filter)]
    pub filter: Option<FilterDescription>,
    /// Estimator of the filter. Affects noise and time, not the mean.
    ///
    /// splatting: a sample contributes to every pixel that its filter covers; the noise of neighbouring pixels is correlated.
    /// importance: a sample belongs to one pixel, and its position is sampled from the filter. Box filters, radii above 4.5
    /// pixels, adaptive renders and mlt have importance sampling alone. Default: splatting; with --layers and --denoise
    /// importance, since what reads layers takes the noise of pixels as independent.
    #[arg(long, value_parser = named(FilterSampling::ALL, FilterSampling::name))]
    pub filter_sampling: Option<FilterSampling>,
    /// Folder to which the contribution of each strategy of bdpt or path is also written. Needs --spp.
    ///
    /// bdpt, which needs --max-bounces: sS-tT.exr, with S vertices from the light and T from the camera, is the strategy alone
    /// without weights; sS-tT-weighted.exr is its weighted share of the image. path: s0-weighted.exr is the light found by
    /// scattering, s1-weighted.exr by light sampling, and t1-weighted.exr by light paths.
    #[arg(long, value_name = "DIR")]
    pub bdpt_strategies: Option<PathBuf>,
    /// Maximum distance of occluders for ambient-occlusion, in scene units. Default: the scene's, or no limit.
    #[arg(long, value_name = "DISTANCE", value_parser = parse_distance)]
    pub occlusion_distance: Option<f64>,
    /// Maximum relative error of the indirect light of irradiance-cache, such as 5% or 0.05; 0 caches nothing. Default:
    /// the scene's, or 5%.
    #[arg(long, value_name = "SHARE", value_parser = parse_small)]
    pub cache_error: Option<f64>,
    /// Seed of the random numbers, from 0 to 2^64 - 1. Default: the scene's, or 0.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Image size in pixels. Default: the scene's.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
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
