//! The arguments of `bench`.
//!
//! Measure: said at each flag.
//! Range: said at each flag; what is out of it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/bench.rs` and `cli/tests/command/bad_flags.rs`.

use super::ProgressMode;
use super::values::{backend, precision};
use crate::durations::parse_duration;
use clap::Args;
use etendue::internals::accel::{Backend, Precision};
use std::path::PathBuf;
use std::time::Duration;

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
