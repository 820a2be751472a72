//! The arguments of every verb, typed.
//!
//! Measure: said at each flag.
//! Range: said at each flag; what is out of it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `tests/command.rs`.

use super::durations::parse_duration;
use crate::accel::{AccelOptions, Backend, Precision, Quality};
use crate::effects::Kernel;
use crate::integrator::Roulette;
use crate::integrator::kind::IntegratorKind;
use crate::lesson::TOPICS;
use crate::lesson::topic::Topic;
use crate::render::settings::{SamplerKind, available_threads};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;
use std::time::Duration;

/// A Monte Carlo renderer that states how wrong its picture is.
#[derive(Debug, Parser)]
#[command(name = "etendue", version, propagate_version = true)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub verb: Verb,
}

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Render a scene to one or more image files.
    Render(Box<RenderArguments>),
    /// Print which effects a scene calls for, why, and which kernel renders it.
    Plan(PlanArguments),
    /// Trace the rays of real renders by each backend, and say which is faster, by how much, and whether they agree.
    Bench(BenchArguments),
    /// Show the classic course on Monte Carlo integration, topic by topic: numbers beside their exact values, and a page.
    Lesson(LessonArguments),
    /// Check this build on this machine against hard cases with exact answers. Exit code 0 only if all pass.
    Battery(BatteryArguments),
    /// Print versions, features and what this machine and its Embree can do.
    Info(InfoArguments),
    /// Print a completion script for a shell.
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
    /// Print the manual page, as roff: `etendue man | man -l -`.
    Man {
        /// Of this verb only.
        verb: Option<String>,
    },
}

/// Arguments of `plan`.
#[derive(Debug, Args)]
pub struct PlanArguments {
    /// The scene: a .toml file, or a bare .obj model.
    pub scene: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Render with and without each effect that is on, and print its share of the time and of the light.
    #[arg(long)]
    pub cost: bool,
    /// Samples per pixel of each of these renders.
    #[arg(long, value_name = "N", default_value_t = 16, requires = "cost",
          value_parser = clap::value_parser!(u64).range(1..))]
    pub spp: u64,
    /// Pairs of these renders for each number.
    #[arg(long, value_name = "N", default_value_t = 5, requires = "cost",
          value_parser = clap::value_parser!(u64).range(2..=1000))]
    pub rounds: u64,
    /// Size of these renders in pixels. Default: the scene's shape, about 20 000 pixels.
    #[arg(long, value_name = "WxH", value_parser = parse_size, requires = "cost")]
    pub size: Option<(u32, u32)>,
    /// How rays are traced.
    #[command(flatten)]
    pub tracing: TracingArguments,
}

/// Arguments of `bench`.
#[derive(Debug, Args)]
pub struct BenchArguments {
    /// Scenes: .toml files, bare .obj models, or names of the bench's own: cornell-box, suzanne-room, terrain, needles,
    /// stadium, soup. Default: all of its own.
    pub scenes: Vec<PathBuf>,
    /// A library to measure; may be repeated. Default: all of this build.
    #[arg(long = "backend", value_name = "NAME", value_parser = backend())]
    pub backends: Vec<Backend>,
    /// Runs for each number, interleaved, at least 9: it is their median, with the least and the greatest.
    #[arg(long, value_name = "N", default_value_t = 9,
          value_parser = clap::value_parser!(u64).range(9..=1000))]
    pub rounds: u64,
    /// Rays recorded of each kind, and traced again in each run.
    #[arg(long, value_name = "N", default_value_t = 131_072,
          value_parser = clap::value_parser!(u64).range(1..=1 << 28))]
    pub rays: u64,
    /// Rays of each scene for which the hits of the backends are compared; 0 for none.
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    pub compare: u64,
    /// Segments from inside to outside of each closed mesh, none of which may leak; 0 for none.
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    pub segments: u64,
    /// About how long one of our own renders takes that are held against the floor; each is run as often as --rounds says.
    #[arg(long, value_name = "DURATION", value_parser = parse_duration, default_value = "1s")]
    pub render_time: Duration,
    /// How our own render traces where it is held against the floor. fast by default, since speed is in question; a
    /// render's own default is robust. Rays are traced in both.
    #[arg(long, value_parser = precision(), default_value = Precision::Fast.name())]
    pub precision: Precision,
    /// Threads. Default: all that this process may use.
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Folder for bench.json and bench.html; made where it is missing.
    #[arg(short, long = "out", value_name = "DIR", default_value = "out/bench")]
    pub out: PathBuf,
    /// Print bench.json instead of the tables.
    #[arg(long)]
    pub json: bool,
    /// When to show progress.
    #[arg(long, value_enum, default_value = "auto")]
    pub progress: ProgressMode,
    /// Show no progress and print no notes.
    #[arg(short, long)]
    pub quiet: bool,
}

/// Arguments of `lesson`.
#[derive(Debug, Args)]
pub struct LessonArguments {
    /// Topics, each of which becomes a page. Default: only the table of contents is printed.
    #[arg(value_name = "TOPIC", value_parser = named(TOPICS, |topic| topic.name))]
    pub topics: Vec<Topic>,
    /// All topics, and an index of them.
    #[arg(long, conflicts_with = "topics")]
    pub all: bool,
    /// Picks one of 2^64 sets of random numbers.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Threads. Default: all that this process may use.
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Folder for the pages; made where it is missing.
    #[arg(short, long = "out", value_name = "DIR", default_value = "out/lesson")]
    pub out: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
    /// When to show progress.
    #[arg(long, value_enum, default_value = "auto")]
    pub progress: ProgressMode,
    /// Show no progress and print no notes.
    #[arg(short, long)]
    pub quiet: bool,
}

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

/// Arguments of `info`.
#[derive(Debug, Args)]
pub struct InfoArguments {
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// How rays are traced.
#[derive(Debug, Clone, Copy, Args)]
pub struct TracingArguments {
    /// The library that traces rays.
    #[arg(long, value_parser = backend(), default_value = Backend::ALL[0].name())]
    pub backend: Backend,
    /// robust is watertight along edges; fast saves about a third of the tracing and may miss an edge.
    #[arg(long, value_parser = precision(), default_value = Precision::Robust.name())]
    pub precision: Precision,
    /// Threads. Default: all that this process may use.
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
}

impl TracingArguments {
    /// How the acceleration structure is built.
    pub fn options(&self) -> AccelOptions {
        AccelOptions {
            backend: self.backend,
            precision: self.precision,
            quality: Quality::default(),
            threads: self.threads.map_or_else(available_threads, usize::from),
        }
    }
}

/// When to show progress.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ProgressMode {
    /// A bar on a terminal, else a line every 30 seconds.
    Auto,
    /// A line every 30 seconds.
    Plain,
    /// Nothing.
    None,
}

/// Arguments of `render`.
#[derive(Debug, Args)]
pub struct RenderArguments {
    /// The scene: a .toml file, or a bare .obj model.
    pub scene: PathBuf,
    /// Image to write: .exr, .png, .hdr or .pfm; may be repeated. Default: the scene's name with .png.
    #[arg(short, long = "out", value_name = "FILE")]
    pub out: Vec<PathBuf>,
    /// Samples per pixel, at least 1. Default: the scene's, or 64.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub spp: Option<u64>,
    /// Time to render, such as 30s, 5m or 1h30m. With --spp, whichever comes first.
    #[arg(long, value_name = "DURATION", value_parser = parse_duration)]
    pub time: Option<Duration>,
    /// The estimator. The path tracers of the course, from the first to the best: naive (a coin decides between emission and
    /// a direction anywhere), emit-or-reflect (a better coin), bsdf (no coin, directions by the BSDF), light-or-rest (a ray to
    /// a light, a ray anywhere else), nee (next event estimation), path (with multiple importance sampling). Direct light alone,
    /// by uniform directions or by uniform points on lights: direct-directional, direct-area. And ambient-occlusion.
    /// Default: the scene's, or path.
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
    /// How far, in the scene's units, something may be and still count for ambient-occlusion. Default: the scene's, or any
    /// distance.
    #[arg(long, value_name = "DISTANCE", value_parser = parse_distance)]
    pub occlusion_distance: Option<f64>,
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

/// Parses a backend of this build. Of Embree, which others have, a build without says so.
fn backend() -> impl TypedValueParser<Value = Backend> {
    let known = Backend::ALL
        .iter()
        .map(|backend| PossibleValue::new(backend.name()));
    let missing = (!cfg!(feature = "embree")).then(|| PossibleValue::new("embree").hide(true));
    PossibleValuesParser::new(known.chain(missing)).try_map(|chosen| {
        let mut all = Backend::ALL.iter().copied();
        all.find(|backend| backend.name() == chosen)
            .ok_or("this build is without Embree; it has to be built with the feature `embree`")
    })
}

fn precision() -> impl TypedValueParser<Value = Precision> {
    named(&[Precision::Robust, Precision::Fast], Precision::name)
}

/// Parses one of `values` by its name; clap lists the names and suggests the nearest.
fn named<T: Copy + Send + Sync + 'static>(
    values: &'static [T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(values.iter().map(|&value| name(value))).map(move |chosen| {
        let found = values.iter().find(|&&value| name(value) == chosen);
        *found.expect("clap lets only these names through")
    })
}

fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let expected =
        || "expected WIDTHxHEIGHT in pixels, each from 1 to 65536, such as 768x512".to_owned();
    let (width, height) = text.split_once('x').ok_or_else(expected)?;
    let side = |text: &str| {
        text.parse()
            .ok()
            .filter(|side| (1..=65536).contains(side))
            .ok_or_else(expected)
    };
    Ok((side(width)?, side(height)?))
}

fn parse_numbers<const N: usize>(text: &str) -> Result<[u32; N], String> {
    let numbers: Result<Vec<u32>, _> = text
        .split(',')
        .map(|number| number.trim().parse())
        .collect();
    numbers
        .ok()
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| format!("expected {N} whole numbers of pixels, separated by commas"))
}

fn parse_distance(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|distance: &f64| distance.is_finite() && *distance > 0.0)
        .ok_or_else(|| "expected a number above 0".to_owned())
}

fn parse_exposure(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|stops: &f32| stops.abs() <= 100.0)
        .ok_or_else(|| "expected a number of stops from -100 to 100".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_is_consistent() {
        use clap::CommandFactory;
        Arguments::command().debug_assert();
    }

    #[test]
    fn sizes_and_crops_are_parsed_strictly() {
        assert_eq!(parse_size("768x512"), Ok((768, 512)));
        for wrong in ["0x5", "768", "x", "70000x1", "-1x2", "1x2x3"] {
            assert!(parse_size(wrong).is_err(), "{wrong}");
        }
        assert_eq!(parse_numbers::<2>("3, 4"), Ok([3, 4]));
        assert!(parse_numbers::<2>("3,4,5").is_err());
        assert!(parse_numbers::<2>("3,-4").is_err());
    }
}
