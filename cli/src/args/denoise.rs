//! The arguments of `denoise`.
//!
//! Measure: said at each flag.
//! Range: said at each flag; what is out of it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/denoise.rs`.

use super::values::{named, parse_exposure};
use clap::Args;
use etendue::internals::post::denoise::Denoiser;
use std::path::PathBuf;

/// Arguments of `denoise`.
#[derive(Debug, Args)]
pub struct DenoiseArguments {
    /// The picture: an .exr file that `etendue render --layers` wrote.
    pub file: PathBuf,
    /// Image to write: .exr, .png, .hdr or .pfm; may be repeated. An .exr keeps the unfiltered picture as the layer `noisy`, and
    /// `se` becomes the estimated error of the filtered one. Default: the file's name with -denoised.exr.
    #[arg(short, long = "out", value_name = "FILE")]
    pub out: Vec<PathBuf>,
    /// nlm: non-local means over the two halves of the samples; its bias vanishes as the noise does. oidn: Intel Open Image
    /// Denoise 2, where it is found (OIDN_DIR may name its folder).
    #[arg(long, value_parser = named(Denoiser::ALL, Denoiser::name), default_value = Denoiser::ALL[0].name())]
    pub filter: Denoiser,
    /// Exposure of PNG files in stops: pixel values times 2^EV.
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true,
          value_parser = parse_exposure)]
    pub exposure: f32,
    /// Threads. Default: all that this process may use.
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Print what was done as one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors.
    #[arg(short, long)]
    pub quiet: bool,
}
