//! The arguments of `denoise`.
//!
//! Measure: stated at each flag.
//! Range: stated at each flag; a value outside it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/denoise.rs`.

use super::values::{named, parse_exposure};
use clap::Args;
use etendue::internals::post::denoise::Denoiser;
use std::path::PathBuf;

/// Arguments of `denoise`.
#[derive(Debug, Args)]
pub struct DenoiseArguments {
    /// Image to filter: an .exr file written by `etendue render --layers`.
    pub file: PathBuf,
    /// Output image: .exr, .png, .hdr or .pfm; may be repeated. Default: the file's name with -denoised.exr.
    ///
    /// An .exr keeps the unfiltered image as the layer `noisy`; `se` becomes the estimated error of the filtered image.
    #[arg(short, long = "out", value_name = "FILE")]
    pub out: Vec<PathBuf>,
    /// Noise filter.
    ///
    /// nlm: non-local means over the two halves of the samples; its bias vanishes as the noise does. oidn: Intel Open
    /// Image Denoise 2, if it is found (OIDN_DIR may name its folder).
    #[arg(long, value_parser = named(Denoiser::ALL, Denoiser::name), default_value = Denoiser::ALL[0].name())]
    pub filter: Denoiser,
    /// Exposure of PNG files in stops: pixel values are multiplied by 2^EV.
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true,
          value_parser = parse_exposure)]
    pub exposure: f32,
    /// Number of threads. Default: all that are available to this process.
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Print the result as one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Print only errors.
    #[arg(short, long)]
    pub quiet: bool,
}
