//! Pictures of a study: what variants come to in the same time and at the same error, and how far off they are.
//!
//! Measure: radiance; relative errors, signed, of luminance: (x - r) / sqrt(r^2 + eps), eps as in relMSE.
//! Range: pictures of the study's size.
//! Source: none needed. Tested below.

use super::reference::References;
use crate::image::Image;

/// All of them.
#[derive(Debug, Clone, Default)]
pub struct Pictures {
    /// The mean of both references.
    pub reference: Option<Image>,
    /// Each variant, given as much time as the quickest of their longest renders took.
    pub equal_time: Vec<Shown>,
    /// Each variant, given the samples that bring it to the least error that all of them reached.
    pub equal_error: Vec<Shown>,
    /// The relative standard error of each pixel, by variant.
    pub standard_errors: Vec<(usize, Vec<f32>)>,
}

/// A picture beside how far off it is.
#[derive(Debug, Clone)]
pub struct Shown {
    /// Which variant.
    pub variant: usize,
    /// Samples per pixel.
    pub spp: u64,
    /// Seconds that it took.
    pub seconds: f64,
    /// Its relMSE.
    pub rel_mse: f64,
    /// The picture.
    pub image: Image,
    /// The relative error of each pixel.
    pub errors: Vec<f32>,
}

/// The relative error of each pixel of a picture.
pub fn relative_errors(references: &References, image: &Image) -> Vec<f32> {
    let pairs = image.pixels().iter().zip(references.mean().pixels());
    let weights = luminance_weights(references);
    pairs
        .zip(weights)
        .map(|((x, r), w)| w * (x.luminance() - r.luminance()))
        .collect()
}

/// The relative standard error of each pixel; channels of a pixel err together.
pub fn relative_standard_errors(references: &References, errors: &Image) -> Vec<f32> {
    let weights = luminance_weights(references);
    let pairs = errors.pixels().iter().zip(weights);
    pairs.map(|(error, w)| w * error.luminance()).collect()
}

/// 1 / sqrt(r^2 + eps) of luminances.
fn luminance_weights(references: &References) -> impl Iterator<Item = f32> {
    let mean = references.mean();
    let level = mean.mean().iter().sum::<f64>() / 3.0;
    let epsilon = 0.01 * level * level;
    mean.pixels().iter().map(move |r| {
        let r = f64::from(r.luminance());
        (1.0 / (r * r + epsilon).sqrt()) as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rgb::Rgb;

    #[test]
    fn errors_are_relative_and_signed() {
        let grey = |a: f32, b: f32| Image::new(2, 1, vec![Rgb::grey(a), Rgb::grey(b)]);
        let references = References::new(grey(1.0, 1.0), grey(1.0, 1.0)).expect("light");
        let errors = relative_errors(&references, &grey(1.5, 0.75));
        let scale = 1.01_f32.sqrt().recip();
        assert!((errors[0] - 0.5 * scale).abs() < 1e-6 && (errors[1] + 0.25 * scale).abs() < 1e-6);
        let bars = relative_standard_errors(&references, &grey(0.1, 0.2));
        assert!((bars[1] - 0.2 * scale).abs() < 1e-6);
    }
}
