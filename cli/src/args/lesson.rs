//! The arguments of `lesson`.
//!
//! Measure: stated at each flag.
//! Range: stated at each flag; a value outside it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/lesson.rs` and `cli/tests/command/bad_flags.rs`.

use super::ProgressMode;
use super::values::named;
use clap::Args;
use etendue_lab::lesson::TOPICS;
use etendue_lab::lesson::topic::Topic;
use std::path::PathBuf;

/// Arguments of `lesson`.
#[derive(Debug, Args)]
pub struct LessonArguments {
    /// Topics to run; each is written as a page. Default: only print the table of contents.
    #[arg(value_name = "TOPIC", value_parser = named(TOPICS, |topic| topic.name))]
    pub topics: Vec<Topic>,
    /// Run all topics, and write an index page.
    #[arg(long, conflicts_with = "topics")]
    pub all: bool,
    /// Seed of the random numbers, from 0 to 2^64 - 1.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Number of threads. Default: all that are available to this process.
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Output folder for the pages; created if missing.
    #[arg(short, long = "out", value_name = "DIR", default_value = "out/lesson")]
    pub out: PathBuf,
    /// Print the results as one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Progress display on standard error.
    #[arg(long, value_enum, default_value = "auto")]
    pub progress: ProgressMode,
    /// Suppress progress and the final summary line.
    #[arg(short, long)]
    pub quiet: bool,
}
