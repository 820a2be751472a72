//! Error metrics of an image against a reference.
//!
//! Measure: `mse` in squared units of the pixels, relative errors without unit; all are means over pixels and channels.
//! Range: images of the same size; different sizes are an error of usage. The relative error is 0 for equal images
//! and infinite where the reference is black everywhere and the image is not.
//! Source: relMSE as in docs/accuracy.md, with an epsilon that follows the exposure; excluding the worst 0.1 % of the
//! pixels is customary in work on path guiding, such as Rath et al. 2020, "Variance-Aware Path Guiding". Tested
//! below.

use super::Image;
use super::tiles::ImageTile;
use crate::error::{Error, Result};
use serde::Serialize;

/// The share of pixels, the worst ones, that a trimmed error excludes.
pub const TRIMMED_SHARE: f64 = 1e-3;

/// The mean squared error: the mean of (x - r)^2.
pub fn mse(image: &Image, reference: &Image) -> Result<f64> {
    let errors = pixel_errors(image, reference, |x, r| (x - r) * (x - r))?;
    Ok(mean(&errors))
}

/// The relMSE: the mean of (x - r)^2 / (r^2 + eps) with eps = 0.01 mean(r)^2, so that it does not depend on the
/// exposure.
pub fn rel_mse(image: &Image, reference: &Image) -> Result<f64> {
    Ok(mean(&relative_errors(image, reference)?))
}

/// The relative squared error of each pixel, averaged over its channels. The mean over the pixels is [`rel_mse`].
pub fn relative_errors(image: &Image, reference: &Image) -> Result<Vec<f64>> {
    let epsilon = epsilon(reference);
    pixel_errors(image, reference, |x, r| relative(x, r, epsilon).powi(2))
}

/// The signed relative error of each pixel: the root of its [`relative_errors`], negative where it is darker than the
/// reference in the sum over the channels.
pub fn signed_errors(image: &Image, reference: &Image) -> Result<Vec<f64>> {
    let errors = relative_errors(image, reference)?;
    let epsilon = epsilon(reference);
    let signs = pixel_errors(image, reference, |x, r| relative(x, r, epsilon))?;
    let pairs = errors.into_iter().zip(signs);
    Ok(pairs
        .map(|(error, sign)| error.sqrt().copysign(sign))
        .collect())
}

/// The expected [`rel_mse`] of an exact image against a reference with these standard errors of R, G and B.
pub fn relative_noise(reference: &Image, standard_errors: [&[f32]; 3]) -> f64 {
    let epsilon = epsilon(reference);
    let mut sum = 0.0;
    for (index, pixel) in reference.pixels().iter().enumerate() {
        for (r, errors) in pixel.to_array().into_iter().zip(standard_errors) {
            let r = f64::from(r);
            sum += relative(r + f64::from(errors[index]), r, epsilon).powi(2);
        }
    }
    sum / (3 * reference.pixels().len()) as f64
}

/// The mean of the errors without the worst [`TRIMMED_SHARE`], rounded down to whole pixels.
pub fn trimmed_mean(mut errors: Vec<f64>) -> f64 {
    let kept = errors.len() - (TRIMMED_SHARE * errors.len() as f64) as usize;
    if kept < errors.len() {
        errors.select_nth_unstable_by(kept, f64::total_cmp);
        errors.truncate(kept);
    }
    mean(&errors)
}

/// The relative difference of each channel's mean from that of the reference; 0 where both are black, infinite where
/// only the reference is.
pub fn mean_differences(image: &Image, reference: &Image) -> [f64; 3] {
    let (image, reference) = (image.mean(), reference.mean());
    std::array::from_fn(|c| match image[c] - reference[c] {
        0.0 => 0.0,
        difference => difference / reference[c],
    })
}

/// A tile and its share in the error of the image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TileError {
    /// The tile.
    #[serde(flatten)]
    pub tile: ImageTile,
    /// The share of the tile in the sum of all errors.
    pub share: f64,
    /// The root of the mean error in the tile.
    pub root_mean: f64,
}

/// Tiles of `side` pixels a side, sorted by their share of errors like those of [`relative_errors`], worst first;
/// none if the sum of errors is 0 or infinite.
pub fn worst_tiles(errors: &[f64], image_width: u32, side: u32) -> Vec<TileError> {
    let total: f64 = errors.iter().sum();
    if total == 0.0 || !total.is_finite() {
        return Vec::new();
    }
    let height = (errors.len() / image_width as usize) as u32;
    let mut tiles: Vec<TileError> = ImageTile::all(image_width, height, side)
        .map(|tile| {
            let sum: f64 = tile.indices(image_width).map(|i| errors[i]).sum();
            let pixels = f64::from(tile.width) * f64::from(tile.height);
            TileError {
                tile,
                share: sum / total,
                root_mean: (sum / pixels).sqrt(),
            }
        })
        .collect();
    tiles.sort_by(|a, b| b.share.total_cmp(&a.share));
    tiles
}

/// The epsilon that keeps the relative error of dark pixels finite.
fn epsilon(reference: &Image) -> f64 {
    let mean = reference.mean().iter().sum::<f64>() / 3.0;
    0.01 * mean * mean
}

fn relative(x: f64, r: f64, epsilon: f64) -> f64 {
    // Avoids 0 / 0.
    if x == r {
        0.0
    } else {
        (x - r) / (r * r + epsilon).sqrt()
    }
}

/// The error of each pixel: the mean over its channels.
fn pixel_errors(
    image: &Image,
    reference: &Image,
    error: impl Fn(f64, f64) -> f64,
) -> Result<Vec<f64>> {
    check_sizes(image, reference)?;
    let pixels = image.pixels().iter().zip(reference.pixels());
    let errors = pixels.map(|(x, r)| {
        let channels = x.to_array().into_iter().zip(r.to_array());
        let sum: f64 = channels.map(|(x, r)| error(x.into(), r.into())).sum();
        sum / 3.0
    });
    Ok(errors.collect())
}

/// Checks that two images have the same size, as a comparison pixel by pixel requires.
pub fn check_sizes(image: &Image, reference: &Image) -> Result<()> {
    let size = |image: &Image| (image.width(), image.height());
    if size(image) == size(reference) {
        return Ok(());
    }
    Err(Error::usage(format!(
        "cannot compare pictures of different sizes: {} x {} and {} x {} pixels; a crop can \
         only be compared with the same crop",
        image.width(),
        image.height(),
        reference.width(),
        reference.height()
    )))
}

fn mean(errors: &[f64]) -> f64 {
    errors.iter().sum::<f64>() / errors.len() as f64
}

#[cfg(test)]
mod tests {
    use super::super::tests::sample_image;
    use super::*;
    use crate::ErrorKind;
    use crate::math::rgb::Rgb;

    #[test]
    fn metrics_match_closed_form_for_a_constant_error() {
        let reference = Image::filled(3, 2, Rgb::grey(2.0));
        for (value, sign) in [(2.5, 1.0), (1.5, -1.0)] {
            let image = Image::filled(3, 2, Rgb::grey(value));
            assert_eq!(mse(&image, &reference).expect("same size"), 0.25);
            let relative = rel_mse(&image, &reference).expect("same size");
            let exact = 0.25 / (4.0 + 0.04);
            assert!((relative - exact).abs() < 1e-12);
            for signed in signed_errors(&image, &reference).expect("same size") {
                assert!((signed - sign * exact.sqrt()).abs() < 1e-12);
            }
            let difference = mean_differences(&image, &reference);
            assert_eq!(difference, [sign * 0.25; 3]);
        }
    }

    #[test]
    fn rel_mse_is_invariant_to_exposure() {
        let brighter = |image: &Image, gain: f32| {
            let pixels = image.pixels().iter().map(|&pixel| gain * pixel).collect();
            Image::new(image.width(), image.height(), pixels)
        };
        let reference = sample_image();
        let mut image = reference.clone();
        image.pixels_mut()[40] = Rgb::WHITE;
        let relative = rel_mse(&image, &reference).expect("same size");
        assert!(relative > 0.0);
        let scaled = rel_mse(&brighter(&image, 1024.0), &brighter(&reference, 1024.0));
        assert!((scaled.expect("same size") - relative).abs() < 1e-12 * relative);
    }

    #[test]
    fn squared_signed_errors_equal_relative_errors() {
        let reference = Image::filled(2, 1, Rgb::grey(1.0));
        let pixels = vec![Rgb::new(1.5, 0.75, 1.0), Rgb::new(0.5, 1.25, 1.0)];
        let image = Image::new(2, 1, pixels);
        let exact = (0.25 + 0.0625) / 3.0 / 1.01;
        let errors = relative_errors(&image, &reference).expect("same size");
        let signed = signed_errors(&image, &reference).expect("same size");
        for (i, sign) in [1.0, -1.0].into_iter().enumerate() {
            assert!((errors[i] - exact).abs() < 1e-12);
            assert!((signed[i] - sign * exact.sqrt()).abs() < 1e-12);
        }
    }

    #[test]
    fn metrics_handle_black_references_and_reject_size_mismatch() {
        let black = Image::filled(2, 2, Rgb::BLACK);
        assert_eq!(rel_mse(&black, &black).expect("same size"), 0.0);
        assert_eq!(mean_differences(&black, &black), [0.0; 3]);
        let grey = Image::filled(2, 2, Rgb::grey(0.1));
        assert_eq!(rel_mse(&grey, &black).expect("same size"), f64::INFINITY);
        assert_eq!(mean_differences(&grey, &black), [f64::INFINITY; 3]);
        let errors = relative_errors(&grey, &black).expect("same size");
        assert_eq!(worst_tiles(&errors, 2, 1), []);
        let other = Image::filled(4, 1, Rgb::BLACK);
        let error = mse(&other, &black).expect_err("another size");
        assert_eq!(error.kind(), ErrorKind::Usage);
    }

    #[test]
    fn trimmed_mean_excludes_only_the_worst_share() {
        // The two worst of 2500 pixels.
        let mut errors = vec![1.0; 2500];
        errors[17] = f64::INFINITY;
        errors[2400] = 1e9;
        assert_eq!(trimmed_mean(errors.clone()), 1.0);
        errors[3] = 2498.0;
        assert_eq!(trimmed_mean(errors), (2497.0 + 2498.0) / 2498.0);
        assert_eq!(trimmed_mean(vec![3.0; 999]), 3.0);
        assert_eq!(trimmed_mean(vec![3.0]), 3.0);
    }

    #[test]
    fn worst_tiles_are_sorted_by_error_share() {
        let mut errors = vec![0.0; 70 * 40];
        // Two errors in the tile at (64, 32), which has 6 x 8 pixels, and one in the first.
        errors[39 * 70 + 69] = 2.0;
        errors[33 * 70 + 64] = 1.0;
        errors[0] = 1.0;
        let tiles = worst_tiles(&errors, 70, 32);
        assert_eq!(tiles.len(), 6);
        assert_eq!((tiles[0].tile.x, tiles[0].tile.y), (64, 32));
        assert_eq!((tiles[0].share, tiles[0].root_mean), (0.75, 0.25));
        assert_eq!((tiles[1].tile.x, tiles[1].share), (0, 0.25));
        assert_eq!(tiles[2].share, 0.0);
    }
}
