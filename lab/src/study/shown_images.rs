//! Images of a study: the variants after certain times, examples of certain errors, and the errors of pixels.
//!
//! Measure: radiance; relative errors as in relMSE, signed.
//! Range: images of the study's size.
//! Source: none needed. Tested below.

use super::reference::References;
use etendue::internals::image::Image;
use etendue::internals::math::rgb::Rgb;

/// All images of a study.
#[derive(Debug, Clone, Default)]
pub struct ShownImages {
    /// The mean of both references.
    pub reference: Option<Image>,
    /// The variants after certain times.
    pub at_times: Vec<AtTime>,
    /// Images with about the errors of [`EXAMPLES`], by any variant without bias, as far as there are any.
    pub examples: Vec<ImageWithError>,
    /// The relative standard error of each pixel, by variant.
    pub standard_errors: Vec<(usize, Vec<f64>)>,
}

/// The seconds after which images are shown.
pub const TIMES: [f64; 3] = [10.0, 60.0, 600.0];

/// Roots of relMSE of which examples are shown.
pub const EXAMPLES: [f64; 3] = [0.1, 0.03, 0.01];

/// One image of each variant that has one of nearly a certain time: within a factor of two.
#[derive(Debug, Clone)]
pub struct AtTime {
    /// The time in seconds, at the scene's own size.
    pub seconds: f64,
    /// The images.
    pub shown: Vec<ImageWithError>,
}

/// An image with its error.
#[derive(Debug, Clone)]
pub struct ImageWithError {
    /// Index of the variant.
    pub variant: usize,
    /// Samples per pixel.
    pub spp: u64,
    /// Rendering time in seconds.
    pub seconds: f64,
    /// Its relMSE.
    pub rel_mse: f64,
    /// The image.
    pub image: Image,
    /// The relative error of each pixel.
    pub errors: Vec<f64>,
}

/// The relative standard error of each pixel: the root of the mean over its channels.
pub fn relative_standard_errors(references: &References, errors: &Image) -> Vec<f64> {
    let pairs = errors.pixels().iter().zip(references.weights());
    let of_pixel = |(error, w): (&Rgb, &[f64; 3])| {
        let error = error.to_array().map(f64::from);
        let squares = (0..3).map(|c| w[c] * error[c] * error[c]);
        (squares.sum::<f64>() / 3.0).sqrt()
    };
    pairs.map(of_pixel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_standard_errors_match_formula() {
        let grey = |a: f32, b: f32| Image::new(2, 1, vec![Rgb::grey(a), Rgb::grey(b)]);
        let references = References::new(grey(1.0, 1.0), grey(1.0, 1.0)).expect("light");
        let bars = relative_standard_errors(&references, &grey(0.1, 0.2));
        let scale = 1.01_f64.sqrt().recip();
        assert!((bars[0] - 0.1 * scale).abs() < 1e-6 && (bars[1] - 0.2 * scale).abs() < 1e-6);
    }
}
