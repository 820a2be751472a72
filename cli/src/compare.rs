//! `etendue compare`: the error of an image relative to a reference, where it is, and a test for bias.
//!
//! Measure: as in `study/comparison.rs`.
//! Range: two images of the same size in any format that can be read. A file that is not an image, or has non-finite
//! pixels, fails like a file that cannot be read.
//! Source: docs/accuracy.md, "Comparing two images". Tested in `cli/tests/command/compare.rs`.

use super::args::{CompareArguments, Metric};
use super::output::format_percent;
use super::{Outcome, print};
use crate::report::compare::json::{CompareReport, JudgedMetric, MapReport};
use crate::report::compare::tables;
use crate::report::false_colour::{self, robust_scale};
use etendue::internals::image::atomic::{check_creatable, write_atomically};
use etendue::internals::image::{ColourSpace, LayeredImage, metrics, png_bytes_with_texts};
use etendue::{Error, ErrorKind, Result};
use etendue_lab::study::bias_test::{BiasTest, bias_test, same_random_numbers};
use etendue_lab::study::comparison::Metrics;
use std::io::Write;
use std::path::Path;

/// Compares two images.
pub fn run(arguments: &CompareArguments) -> Result<Outcome> {
    if let Some(path) = &arguments.map {
        check_map(path)?;
    }
    if arguments.metric == Metric::Flip && !cfg!(feature = "flip") {
        return Err(Error::usage(
            "this build is without FLIP; it has to be built with the feature `flip`",
        )
        .in_field("--metric"));
    }
    let [image, reference] = [&arguments.image, &arguments.reference].map(|path| read(path));
    let (image, reference) = (image?, reference?);
    let metrics = Metrics::of(&image, &reference, arguments.tile).map_err(as_unreadable)?;
    let bias = bias_test(&image, &reference, arguments.tile).map_err(as_unreadable)?;
    let flip = match arguments.quiet && arguments.metric != Metric::Flip {
        true => None,
        false => flip(&image, &reference, arguments.exposure)?,
    };
    let map = match &arguments.map {
        Some(path) => Some(write_map(arguments, path, &image, &reference)?),
        None => None,
    };
    let notes = notes(&image, &reference, bias.as_ref());
    let report = CompareReport {
        image: arguments.image.display().to_string(),
        reference: arguments.reference.display().to_string(),
        width: image.image.width(),
        height: image.image.height(),
        verdict: JudgedMetric::of(arguments, &metrics, flip),
        metrics,
        flip,
        bias,
        map,
        notes,
    };
    if arguments.json {
        print(report.to_json().as_bytes())?;
    } else if !arguments.quiet {
        print(tables::markdown(&report).as_bytes())?;
        for note in report.notes() {
            say!("{note}");
        }
    }
    Ok(if report.passed() {
        Outcome::Done
    } else {
        Outcome::Failed
    })
}

/// Returns the caveats of the bias test.
fn notes(image: &LayeredImage, reference: &LayeredImage, bias: Option<&BiasTest>) -> Vec<String> {
    let has_bars = |it: &LayeredImage| it.layer("se.R").is_some();
    if !has_bars(image) && !has_bars(reference) {
        return Vec::new();
    }
    let mut notes = Vec::from_iter(same_random_numbers(image, reference));
    let tested = bias.map_or(0.0, |bias| bias.tested);
    if tested < 0.5 {
        notes.push(format!(
            "the bias test excludes {} of the pixels: their standard errors are flagged as unreliable, or they \
             have no noise; more samples help",
            format_percent(1.0 - tested)
        ));
    }
    notes
}

/// Checks that a map can be written to `path`.
fn check_map(path: &Path) -> Result<()> {
    let extension = path.extension().unwrap_or_default();
    if !extension.eq_ignore_ascii_case("png") {
        return Err(Error::usage(format!(
            "cannot write a map as \"{}\": expected a name that ends in .png",
            path.display()
        ))
        .in_field("--map"));
    }
    check_creatable(path)
}

fn read(path: &Path) -> Result<LayeredImage> {
    LayeredImage::read(path, ColourSpace::Srgb).map_err(as_unreadable)
}

/// Turns a scene error into an I/O error: no scene is read here, so a file that is not an image counts as unreadable.
fn as_unreadable(error: Error) -> Error {
    match error.kind() {
        ErrorKind::Scene => error.of_kind(ErrorKind::Io),
        _ => error,
    }
}

/// Returns the mean of FLIP, if this build has it.
fn flip(image: &LayeredImage, reference: &LayeredImage, exposure: f32) -> Result<Option<f64>> {
    #[cfg(feature = "flip")]
    return etendue_lab::flip::flip(&image.image, &reference.image, exposure).map(Some);
    #[cfg(not(feature = "flip"))]
    {
        let _ = (image, reference, exposure);
        Ok(None)
    }
}

/// Writes the map of signed errors as PNG, with its legend in the text chunks.
fn write_map(
    arguments: &CompareArguments,
    path: &Path,
    image: &LayeredImage,
    reference: &LayeredImage,
) -> Result<MapReport> {
    let size = (image.image.width(), image.image.height());
    let errors = metrics::signed_errors(&image.image, &reference.image)?;
    let scale = arguments.scale.unwrap_or_else(|| robust_scale(&errors));
    let map = false_colour::map(&errors, size, scale, false_colour::signed);
    let report = MapReport {
        file: path.display().to_string(),
        scale,
    };
    let texts = [
        (
            "Title",
            format!(
                "{} against {}",
                arguments.image.display(),
                arguments.reference.display()
            ),
        ),
        ("Description", report.legend()),
        (
            "Software",
            concat!("etendue ", env!("CARGO_PKG_VERSION")).to_owned(),
        ),
    ];
    let bytes = png_bytes_with_texts(&map, 0.0, &texts);
    write_atomically(path, |file| file.write_all(&bytes))?;
    Ok(report)
}
