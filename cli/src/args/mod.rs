//! The typed arguments of the command: one file per verb; this file has what several verbs share.
//!
//! Measure: stated at each flag.
//! Range: stated at each flag; a value outside it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/render.rs`.

mod battery;
mod bench;
mod compare;
mod convert;
mod denoise;
mod lesson;
mod measurement;
mod plan;
mod price;
mod render;
mod scene;
mod settings;
mod state;
mod study;
mod values;

pub use battery::BatteryArguments;
pub use bench::BenchArguments;
pub use compare::{CompareArguments, Metric};
pub use convert::ConvertArguments;
pub use denoise::DenoiseArguments;
pub use lesson::LessonArguments;
pub use measurement::MeasurementArguments;
pub use plan::PlanArguments;
pub use price::PriceArguments;
pub use render::RenderArguments;
pub use scene::{Fidelity, SceneArguments};
pub use settings::SettingsArguments;
pub use state::{MergeArguments, StateArguments};
pub use study::StudyArguments;

use clap::{Args, Parser, Subcommand};
use etendue::internals::accel::{AccelOptions, Backend, Precision, Quality};
use etendue::internals::render::settings::available_threads;
use values::{backend, precision, quality};

/// A Monte Carlo renderer that estimates the error of its images.
#[derive(Debug, Parser)]
#[command(name = "etendue", version, propagate_version = true)]
pub struct Arguments {
    /// The verb to run.
    #[command(subcommand)]
    pub verb: Verb,
}

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Render a scene to one or more image files.
    Render(Box<RenderArguments>),
    /// Merge the shards of a render, which other machines may have rendered, to an image or a state file.
    Merge(MergeArguments),
    /// Print which effects a scene needs, why, and which kernel and integrator suit it.
    Plan(PlanArguments),
    /// Measure within half a minute what accuracy costs in a scene: the time to some errors, where the error comes from,
    /// and what would make it cheaper.
    Price(PriceArguments),
    /// Measure error against time for several ways to render a scene: time to an error, bias, and the cost of a smaller
    /// error.
    Study(StudyArguments),
    /// Write a scene or a model of any format that is read as a scene file (.toml), with its meshes and images beside it.
    Convert(ConvertArguments),
    /// Compare an image with a reference: error, where it differs, and a test for bias; for scripts, like `idiff`.
    Compare(CompareArguments),
    /// Filter the noise of an image that `render --layers` wrote, and estimate the remaining error.
    Denoise(DenoiseArguments),
    /// Trace the rays of real renders with each backend: which is faster, by how much, and whether the hits agree.
    Bench(BenchArguments),
    /// Run the course on Monte Carlo integration, topic by topic: numbers beside their exact values, and a page.
    Lesson(LessonArguments),
    /// Check this build on this machine against hard cases with exact answers; exit code 0 only if all pass.
    Battery(BatteryArguments),
    /// Print the version, the features, and the capabilities of this machine and its Embree.
    Info(InfoArguments),
    /// Print a completion script for a shell.
    Completions {
        /// Shell to complete for.
        shell: clap_complete::Shell,
    },
    /// Print the manual page, as roff: `etendue man | man -l -`.
    Man {
        /// Verb to describe. Default: the whole command.
        verb: Option<String>,
    },
}

/// Arguments of `info`.
#[derive(Debug, Args)]
pub struct InfoArguments {
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// Ray tracing options.
#[derive(Debug, Clone, Copy, Args)]
pub struct TracingArguments {
    /// Library that traces the rays.
    #[arg(long, value_parser = backend(), default_value = Backend::ALL[0].name())]
    pub backend: Backend,
    /// Ray tracing precision: robust is watertight along edges; fast saves about a quarter of the tracing time and may
    /// miss an edge.
    #[arg(long, value_parser = precision(), default_value = Precision::Robust.name())]
    pub precision: Precision,
    /// Build quality of the acceleration structure. Default: medium for embree, high for the others.
    ///
    /// `etendue bench` measures which is faster for a scene. With embree in robust precision, high is the same as
    /// medium.
    #[arg(long, value_parser = quality())]
    pub quality: Option<Quality>,
    /// Number of threads. Default: all that are available to this process.
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
}

impl TracingArguments {
    /// The options for building the acceleration structure.
    pub fn options(&self) -> AccelOptions {
        AccelOptions {
            backend: self.backend,
            precision: self.precision,
            quality: self.quality,
            threads: self.threads.map_or_else(available_threads, usize::from),
        }
    }
}

/// The progress display.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ProgressMode {
    /// A bar on a terminal; otherwise a line every 30 seconds.
    Auto,
    /// A line every 30 seconds.
    Plain,
    /// No progress.
    None,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn command_line_definition_is_consistent() {
        use clap::CommandFactory;
        Arguments::command().debug_assert();
    }
}
