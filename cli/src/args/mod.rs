//! The arguments of the command, typed: one file a verb, and here what verbs share.
//!
//! Measure: said at each flag.
//! Range: said at each flag; what is out of it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/render.rs`.

mod battery;
mod bench;
mod compare;
mod denoise;
mod lesson;
mod plan;
mod render;
mod study;
mod values;

pub use battery::BatteryArguments;
pub use bench::BenchArguments;
pub use compare::{CompareArguments, Metric};
pub use denoise::DenoiseArguments;
pub use lesson::LessonArguments;
pub use plan::PlanArguments;
pub use render::RenderArguments;
pub use study::StudyArguments;

use clap::{Args, Parser, Subcommand};
use etendue::internals::accel::{AccelOptions, Backend, Precision, Quality};
use etendue::internals::render::settings::available_threads;
use values::{backend, precision, quality};

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
    /// Plot error against time for ways to render a scene: which is quickest to an error, whether it is right, and what
    /// better costs.
    Study(StudyArguments),
    /// Say how far one picture is from another, where, and whether they tend to the same: for people, and for scripts as
    /// `idiff` is used.
    Compare(CompareArguments),
    /// Filter the noise of a picture that `render --layers` wrote, and say how wrong it is then.
    Denoise(DenoiseArguments),
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
    /// How well the structure is built that rays are traced through: `etendue bench` says which is quicker for a scene.
    /// Embree's high makes no difference in robust precision. Default: medium for embree, high for the others.
    #[arg(long, value_parser = quality())]
    pub quality: Option<Quality>,
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
            quality: self.quality,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_is_consistent() {
        use clap::CommandFactory;
        Arguments::command().debug_assert();
    }
}
