//! Two images of the same scene: metrics of their difference and its distribution over the image.
//!
//! Measure: as in `image/metrics.rs`.
//! Range: images of the same size.
//! Source: docs/accuracy.md, "Comparing two images". Tested below and in `cli/tests/command/compare.rs`.

use super::standard_errors::Bars;
use etendue::Result;
use etendue::internals::image::LayeredImage;
use etendue::internals::image::metrics::{self, TileError};
use serde::Serialize;

/// The metrics that are computed from the pixels alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Metrics {
    /// The mean of (x - r)^2.
    pub mse: f64,
    /// The root of the MSE.
    pub rmse: f64,
    /// The mean of (x - r)^2 / (r^2 + eps).
    pub rel_mse: f64,
    /// The root of relMSE: the error that `render --error` refers to.
    pub rel_rmse: f64,
    /// The mean of relMSE without the worst 0.1 % of pixels.
    pub trimmed_rel_mse: f64,
    /// The part of relMSE expected from the reference's own noise, by its standard errors.
    pub reference_noise: Option<f64>,
    /// The means of R, G and B over those of the reference, minus one.
    pub mean_differences: [f64; 3],
    /// Tiles sorted by their share of relMSE, the worst first.
    pub tiles: Vec<TileError>,
}

impl Metrics {
    /// The metrics of an image against a reference, with tiles of `side` pixels a side.
    ///
    /// # Errors
    /// If their sizes differ, or a standard error is negative or not finite.
    pub fn of(image: &LayeredImage, reference: &LayeredImage, side: u32) -> Result<Self> {
        let bars = Bars::of(reference)?.errors;
        let (image, reference) = (&image.image, &reference.image);
        let mse = metrics::mse(image, reference)?;
        let errors = metrics::relative_errors(image, reference)?;
        let rel_mse = errors.iter().sum::<f64>() / errors.len() as f64;
        Ok(Self {
            mse,
            rmse: mse.sqrt(),
            rel_mse,
            rel_rmse: rel_mse.sqrt(),
            reference_noise: bars.map(|errors| metrics::relative_noise(reference, errors)),
            mean_differences: metrics::mean_differences(image, reference),
            tiles: metrics::worst_tiles(&errors, image.width(), side),
            trimmed_rel_mse: metrics::trimmed_mean(errors),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::synthetic::rendered;

    #[test]
    fn reference_noise_is_half_of_rel_mse_at_equal_noise() {
        let metrics = Metrics::of(&rendered(1, 0.0), &rendered(2, 0.0), 8).expect("same size");
        // Both images have the same noise: half of the square is the reference's, within the noise of 2880 squares.
        let share = metrics.reference_noise.expect("it has bars") / metrics.rel_mse;
        assert!((share - 0.5).abs() < 0.1, "{share}");
        assert_eq!(metrics.rel_rmse, metrics.rel_mse.sqrt());
        let alone = LayeredImage::from(rendered(2, 0.0).image);
        let metrics = Metrics::of(&rendered(1, 0.0), &alone, 8).expect("same size");
        assert_eq!(metrics.reference_noise, None);
    }
}
