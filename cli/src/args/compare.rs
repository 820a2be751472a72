//! The arguments of `compare`.
//!
//! Measure: stated at each flag.
//! Range: stated at each flag; a value outside it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/compare.rs`.

use super::values::{named, parse_distance, parse_exposure, parse_limit};
use clap::Args;
use etendue::internals::image::tiles;
use std::path::PathBuf;

/// The error metric that a comparison is judged by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Metric {
    /// The root of relMSE.
    RelRmse,
    /// The root of relMSE without its worst 0.1 % of pixels.
    TrimmedRelRmse,
    /// The root of the mean squared difference.
    Rmse,
    /// The mean of FLIP.
    Flip,
}

impl Metric {
    /// All metrics.
    pub const ALL: &'static [Self] = &[Self::RelRmse, Self::TrimmedRelRmse, Self::Rmse, Self::Flip];

    /// The name on the command line.
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
    0 if the error is at most 1 %, 1 if it is more, 2 if the images cannot be compared, 4 if one cannot be read."
)]
pub struct CompareArguments {
    /// Image to compare: .exr, .png, .jpg, .hdr or .pfm. With the layers of `render --layers` it is also tested for
    /// bias.
    pub image: PathBuf,
    /// Reference image, of the same size; errors are relative to it.
    pub reference: PathBuf,
    /// Exit with code 1 if the error exceeds this, such as 1% or 0.01. Default: no limit.
    #[arg(long, value_name = "NUMBER", value_parser = parse_limit, allow_negative_numbers = true)]
    pub tolerance: Option<f64>,
    /// Error metric that --tolerance limits.
    ///
    /// rel-rmse: the root of relMSE, as in `render --error`. trimmed-rel-rmse: the same without the worst 0.1 % of the
    /// pixels. rmse: the root of the mean squared difference, in pixel units. flip: the mean of FLIP, the perceived
    /// difference.
    #[arg(long, value_parser = named(Metric::ALL, Metric::name), default_value = Metric::RelRmse.name())]
    pub metric: Metric,
    /// Write a PNG map of the relative error: blue where the image is too dark, red where it is too bright.
    #[arg(long, value_name = "FILE.png")]
    pub map: Option<PathBuf>,
    /// Relative error shown in the full colours of the map. Default: the 99 % quantile of the pixels.
    #[arg(long, value_name = "NUMBER", value_parser = parse_distance, requires = "map", allow_negative_numbers = true)]
    pub scale: Option<f64>,
    /// Exposure of both images for FLIP, in stops; FLIP compares them as PNG shows them.
    #[arg(long, value_name = "EV", default_value_t = 0.0, value_parser = parse_exposure,
          allow_negative_numbers = true)]
    pub exposure: f32,
    /// Side length in pixels of the tiles for which errors are reported.
    #[arg(long, value_name = "PIXELS", default_value_t = tiles::SIDE, value_parser = clap::value_parser!(u32).range(1..))]
    pub tile: u32,
    /// Print the result as one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Print only errors; the exit code gives the result.
    #[arg(short, long, conflicts_with = "json")]
    pub quiet: bool,
}
