//! The arguments of `bench`.
//!
//! Measure: stated at each flag.
//! Range: stated at each flag; a value outside it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/bench.rs` and `cli/tests/command/bad_flags.rs`.

use super::values::{backend, precision};
use super::{Fidelity, ProgressMode};
use crate::durations::parse_duration;
use clap::Args;
use etendue::internals::accel::{Backend, Precision};
use std::path::PathBuf;
use std::time::Duration;

/// Arguments of `bench`.
#[derive(Debug, Args)]
pub struct BenchArguments {
    /// Scenes: files of the formats that `render` reads, or names of the benchmark's own scenes: cornell-box,
    /// suzanne-room, terrain, needles, stadium, soup. Default: all of the benchmark's own scenes.
    pub scenes: Vec<PathBuf>,
    /// The faithfulness with which files have to be read.
    #[command(flatten)]
    pub fidelity: Fidelity,
    /// Backend to measure; may be repeated. Default: all backends of this build.
    #[arg(long = "backend", value_name = "NAME", value_parser = backend())]
    pub backends: Vec<Backend>,
    /// Interleaved runs for each number, at least 9; the median is reported with the minimum and the maximum.
    #[arg(long, value_name = "N", default_value_t = 9,
          value_parser = clap::value_parser!(u64).range(9..=1000))]
    pub rounds: u64,
    /// Number of rays recorded of each kind; each run traces all of them again.
    #[arg(long, value_name = "N", default_value_t = 131_072,
          value_parser = clap::value_parser!(u64).range(1..=1 << 28))]
    pub rays: u64,
    /// Number of rays per scene for which the hits of the backends are compared; 0 disables the comparison.
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    pub compare: u64,
    /// Number of segments from inside to outside of each closed mesh, none of which should leak; 0 disables the test.
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    pub segments: u64,
    /// Approximate duration of each Etendue render; --rounds renders are compared with the floor, the time that their
    /// rays alone take.
    #[arg(long, value_name = "DURATION", value_parser = parse_duration, default_value = "1s")]
    pub render_time: Duration,
    /// Precision of these Etendue renders; rays are measured in both precisions.
    ///
    /// The default is fast, because speed is measured; `etendue render` defaults to robust.
    #[arg(long, value_parser = precision(), default_value = Precision::Fast.name())]
    pub precision: Precision,
    /// Number of threads. Default: all that are available to this process.
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Output folder for bench.json and bench.html; created if missing.
    #[arg(short, long = "out", value_name = "DIR", default_value = "out/bench")]
    pub out: PathBuf,
    /// Print bench.json instead of the tables.
    #[arg(long)]
    pub json: bool,
    /// Progress display on standard error.
    #[arg(long, value_enum, default_value = "auto")]
    pub progress: ProgressMode,
    /// Suppress progress, notes and the final summary line.
    #[arg(short, long)]
    pub quiet: bool,
}
