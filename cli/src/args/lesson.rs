//! The arguments of `lesson`.
//!
//! Measure: said at each flag.
//! Range: said at each flag; what is out of it is a usage error that names the flag.
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
