//! Noise filtering: `etendue denoise`, and the last step of `etendue render --denoise`.
//!
//! Measure: linear radiance; errors as roots of relMSE.
//! Range: EXR files with the layers of `etendue render --layers`.
//! Source: docs/accuracy.md, "Noise filtering". Tested in `cli/tests/command/denoise.rs`.

use super::args::DenoiseArguments;
use super::durations::format_duration;
use super::output::format_percent;
use super::{Outcome, print};
use etendue::internals::image::{
    self, ColourSpace, Layer, LayeredImage, MetadataValue, WriteOptions,
};
use etendue::internals::post::denoise::{Denoiser, Filtered, NoisyImage};
use etendue::internals::render::settings::available_threads;
use etendue::internals::session::layers::channels;
use etendue::{Error, Result};
use serde::Serialize;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// A filtered image with its errors and the filter time.
pub struct Denoised {
    pub denoiser: Denoiser,
    pub filtered: Filtered,
    /// The error of the unfiltered image, if its render stated one.
    pub before: Option<f64>,
    pub elapsed: Duration,
}

/// The statistics of a filtered image.
#[derive(Debug, Clone, Serialize)]
pub struct DenoiseStats {
    pub filter: &'static str,
    /// Estimated roots of relMSE: of the unfiltered image, as its render stated it, and of the filtered image.
    pub rel_rmse_before: Option<f64>,
    pub rel_rmse_after: Option<f64>,
    pub seconds: f64,
}

impl Denoised {
    /// Filters an image with its layers on `threads` threads; `before` is the stated error of the unfiltered image.
    pub fn new(
        denoiser: Denoiser,
        picture: &LayeredImage,
        before: Option<f64>,
        threads: usize,
    ) -> Result<Self> {
        let start = Instant::now();
        let noisy = NoisyImage::new(picture)?;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| Error::render("cannot start the threads").because(error))?;
        let filtered = pool.install(|| denoiser.filter(&noisy))?;
        Ok(Self {
            denoiser,
            filtered,
            before,
            elapsed: start.elapsed(),
        })
    }

    /// Returns the layers of the output file: the unfiltered image, and with `all` also the input layers, whose
    /// standard errors are replaced by those of the filtered image.
    pub fn layers(&self, picture: &LayeredImage, all: bool) -> Vec<Layer> {
        let mut layers: Vec<Layer> = channels("noisy", &picture.image).collect();
        if all {
            let errors: Vec<Layer> = channels("se", &self.filtered.errors).collect();
            let is_replaced = |layer: &&Layer| errors.iter().all(|it| it.name != layer.name);
            layers.extend(picture.layers.iter().filter(is_replaced).cloned());
            layers.extend(errors);
        }
        layers
    }

    /// Describes the filter and the estimated error in words.
    pub fn description(&self) -> String {
        let error = match self.filtered.error {
            Some(error) => format!(", error then about {}", format_percent(error)),
            None => String::new(),
        };
        format!("filtered by {}{error}", self.denoiser.name())
    }

    pub fn stats(&self) -> DenoiseStats {
        DenoiseStats {
            filter: self.denoiser.name(),
            rel_rmse_before: self.before,
            rel_rmse_after: self.filtered.error,
            seconds: self.elapsed.as_secs_f64(),
        }
    }
}

/// The JSON output of `etendue denoise --json`.
#[derive(Serialize)]
struct DenoiseReport<'a> {
    version: &'static str,
    file: String,
    output: Vec<String>,
    width: u32,
    height: u32,
    #[serde(flatten)]
    stats: &'a DenoiseStats,
    bias: [&'static str; 1],
}

/// Filters a file according to the arguments.
pub fn run(arguments: &DenoiseArguments) -> Result<Outcome> {
    let outputs = outputs(arguments);
    for output in &outputs {
        image::check_writable(output)?;
    }
    let picture = LayeredImage::read(&arguments.file, ColourSpace::default())?;
    let threads = arguments
        .threads
        .map_or_else(available_threads, usize::from);
    let before = match picture.fact("relRmse") {
        Some(&MetadataValue::Real(error)) => Some(error),
        _ => None,
    };
    let denoised = Denoised::new(arguments.filter, &picture, before, threads)?;
    let options = WriteOptions {
        exposure: arguments.exposure,
        metadata: metadata(&picture, &denoised),
        layers: denoised.layers(&picture, true),
    };
    for output in &outputs {
        image::write(output, &denoised.filtered.image, &options)?;
    }
    let names: Vec<String> = outputs.iter().map(|it| it.display().to_string()).collect();
    if !arguments.quiet {
        let before = before.map_or(String::new(), |error| {
            format!("error {}, ", format_percent(error))
        });
        say!(
            "{}: {} x {} pixels in {}, {before}{}, biased by {}",
            names.join(", "),
            picture.image.width(),
            picture.image.height(),
            format_duration(denoised.elapsed),
            denoised.description(),
            denoised.denoiser.bias()
        );
    }
    if !arguments.json {
        return Ok(Outcome::Done);
    }
    let report = DenoiseReport {
        version: env!("CARGO_PKG_VERSION"),
        file: arguments.file.display().to_string(),
        output: names,
        width: picture.image.width(),
        height: picture.image.height(),
        stats: &denoised.stats(),
        bias: [denoised.denoiser.bias()],
    };
    let json = serde_json::to_string_pretty(&report).expect("plain data always serialises");
    print((json + "\n").as_bytes())
}

/// Returns the image files to write.
fn outputs(arguments: &DenoiseArguments) -> Vec<PathBuf> {
    if !arguments.out.is_empty() {
        return arguments.out.clone();
    }
    let mut name = arguments
        .file
        .file_stem()
        .unwrap_or("image".as_ref())
        .to_owned();
    name.push("-denoised.exr");
    vec![PathBuf::from(name)]
}

/// Returns the metadata of the input file with the filter's bias added, and with the error of the render replaced by
/// that of the filtered image.
fn metadata(picture: &LayeredImage, denoised: &Denoised) -> Vec<(String, MetadataValue)> {
    let mut metadata = picture.metadata.clone();
    let of_render = ["bias", "relRmse", "relRmseUpper", "relRmseAtLeast"];
    metadata.retain(|(name, _)| {
        let fact = name.strip_prefix("etendue.");
        fact.is_none_or(|fact| !of_render.contains(&fact))
    });
    let bias = match picture.fact("bias") {
        Some(MetadataValue::Text(before)) if before != "none" => {
            format!("{before}; {}", denoised.denoiser.bias())
        }
        _ => denoised.denoiser.bias().to_owned(),
    };
    metadata.push(("etendue.bias".to_owned(), MetadataValue::Text(bias)));
    if let Some(error) = denoised.filtered.error {
        metadata.push(("etendue.relRmse".to_owned(), MetadataValue::Real(error)));
    }
    metadata
}
