//! Mean and variance of each pixel from its own samples, without its neighbours.
//!
//! Measure: radiance, squared for variances.
//! Range: a pixel with too few samples has no variance estimate.
//! Source: none needed. Tested in `tests/rendering/adaptive_pixels.rs` and `tests/rendering/metropolis.rs`.

use super::Film;
use super::batches::{BATCHES, BatchMeans};
use crate::math::stats::Moments;

/// The estimates of a pixel.
#[derive(Debug, Clone, Copy, Default)]
pub struct PixelEstimate {
    /// The mean of each channel.
    pub mean: [f64; 3],
    /// The variance of that mean.
    pub variance: [f64; 3],
    /// The part of that variance which the pixel's samples have without the splats of light paths.
    pub sample_variance: [f64; 3],
}

impl PixelEstimate {
    /// The pixel's term of relMSE: the variance over the squared mean plus `epsilon`, averaged over the channels.
    pub fn relative_variance(&self, epsilon: f64) -> f64 {
        self.relative(self.variance, epsilon)
    }

    /// The part of that term which the pixel's own samples have.
    pub fn relative_sample_variance(&self, epsilon: f64) -> f64 {
        self.relative(self.sample_variance, epsilon)
    }

    fn relative(&self, variance: [f64; 3], epsilon: f64) -> f64 {
        let relative = |c: usize| variance[c] / (self.mean[c] * self.mean[c] + epsilon);
        let sum = relative(0) + relative(1) + relative(2);
        // A black image has no relative variance.
        if sum.is_finite() { sum / 3.0 } else { 0.0 }
    }
}

impl Film {
    /// The estimates of each pixel, row by row.
    pub fn estimates(&self) -> Vec<PixelEstimate> {
        let mut estimates: Vec<PixelEstimate> = (0..self.pixel_count())
            .map(|index| {
                let variance_of = |batches: BatchMeans| {
                    // A pixel without samples has neither mean nor variance: both stay 0.
                    let n = batches.samples().max(1) as f64;
                    batches.variance().unwrap_or_default().map(|it| it / n)
                };
                let variance = variance_of(self.batch_means(index));
                PixelEstimate {
                    mean: [0.0; 3],
                    variance,
                    sample_variance: match self.splats() {
                        Some(_) => variance_of(self.sample_batch_means(index)),
                        None => variance,
                    },
                }
            })
            .collect();
        for (index, mean, _) in self.means() {
            estimates[index].mean = mean;
        }
        estimates
    }

    /// The share of lit tiles whose mean has a relative standard error above a fifth, by the spread of batches. Where
    /// batches are Markov chains, these chains have not yet converged to the same mean.
    pub fn uncertain_tile_share(&self) -> f64 {
        const UNCERTAIN: f64 = 0.2;
        let (mut lit, mut uncertain) = (0, 0);
        for tile in &self.tiles {
            let mut batches = [0.0; BATCHES as usize];
            for pixel in tile.window.pixels() {
                let of_pixel = self.batch_means(self.index(pixel)).means;
                for (sum, batch) in batches.iter_mut().zip(of_pixel) {
                    *sum += batch.iter().sum::<f64>();
                }
            }
            let moments = Moments::of(batches);
            if moments.mean() > 0.0 {
                lit += 1;
                let error = moments.standard_error().unwrap_or(0.0);
                uncertain += u32::from(error > UNCERTAIN * moments.mean());
            }
        }
        f64::from(uncertain) / f64::from(lit.max(1))
    }

    /// The pixels around a pixel, at most `radius` rows and columns away, without the pixel itself.
    pub fn neighbours(&self, index: usize, radius: usize) -> impl Iterator<Item = usize> + use<> {
        let (width, height) = (self.window.width as usize, self.window.height as usize);
        let (x, y) = (index % width, index / width);
        let rows = y.saturating_sub(radius)..(y + radius + 1).min(height);
        let columns = x.saturating_sub(radius)..(x + radius + 1).min(width);
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
            .filter(move |&other| other != index)
    }
}
