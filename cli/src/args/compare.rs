//! The arguments of `compare`.
//!
//! Measure: said at each flag.
//! Range: said at each flag; what is out of it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/compare.rs`.

use super::values::{named, parse_distance, parse_exposure, parse_limit};
use clap::Args;
use etendue::internals::image::tiles;
use std::path::PathBuf;

/// The number that a comparison is judged by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Metric {
    /// The root of relMSE.
    RelRmse,
    /// The same without its worst 0.1 % of pixels.
    TrimmedRelRmse,
    /// The root of the mean squared difference.
    Rmse,
    /// The mean of FLIP.
    Flip,
}

impl Metric {
    /// All of them.
    pub const ALL: &'static [Self] = &[Self::RelRmse, Self::TrimmedRelRmse, Self::Rmse, Self::Flip];

    /// As it is written on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::RelRmse => "rel-rmse",
            Self::TrimmedRelRmse => "trimmed-rel-rmse",
            Self::Rmse => "rmse",
            Self::Flip => "flip",
        }
    }
}

/// Arguments of `compare`.
#[derive(Debug, Args)]
#[command(
    after_help = "In a script: `etendue compare new.exr reference.exr -q --tolerance 1%` prints nothing; exit code \
    0 if the error is at most 1 %, 1 if it is more, 2 if the pictures cannot be compared, 4 if one cannot be read."
)]
pub struct CompareArguments {
    /// The picture: .exr, .png, .jpg, .hdr or .pfm. With the layers of `render --layers` it is tested for bias, too.
    pub image: PathBuf,
    /// The reference, of the same size: what the error is relative to.
    pub reference: PathBuf,
    /// Exit with code 1 if the error is above this, such as 1% or 0.01. Default: no limit.
    #[arg(long, value_name = "NUMBER", value_parser = parse_limit, allow_negative_numbers = true)]
    pub tolerance: Option<f64>,
    /// The error that --tolerance limits: the root of relMSE, which `render --error` speaks of; the same without its worst 0.1 %
    /// of pixels; the root of the mean squared difference, in units of the pixels; or FLIP, what is seen of it.
    #[arg(long, value_parser = named(Metric::ALL, Metric::name), default_value = Metric::RelRmse.name())]
    pub metric: Metric,
    /// Write where the picture is too dark (blue) or too bright (red), relative to the reference, as PNG.
    #[arg(long, value_name = "FILE.png")]
    pub map: Option<PathBuf>,
    /// The relative error that has the map's full colours. Default: the one that 99 % of the pixels keep to.
    #[arg(long, value_name = "NUMBER", value_parser = parse_distance, requires = "map", allow_negative_numbers = true)]
    pub scale: Option<f64>,
    /// Stops by which both pictures are made brighter for FLIP, which sees them as PNG shows them.
    #[arg(long, value_name = "EV", default_value_t = 0.0, value_parser = parse_exposure,
          allow_negative_numbers = true)]
    pub exposure: f32,
    /// The side of the tiles in which errors are looked for.
    #[arg(long, value_name = "PIXELS", default_value_t = tiles::SIDE, value_parser = clap::value_parser!(u32).range(1..))]
    pub tile: u32,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors: the exit code says it.
    #[arg(short, long, conflicts_with = "json")]
    pub quiet: bool,
}
