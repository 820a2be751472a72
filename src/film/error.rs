//! How wrong a film is: the error of the picture, the standard error of each pixel, and which of these are not to be
//! trusted.
//!
//! Measure: relMSE, the mean over pixels and channels of (x - r)^2 / (r^2 + eps), eps = 0.01 mean(r)^2, and its root.
//! Range: films of at least two samples a pixel, with error bars of at least one round of batches.
//! Source: docs/accuracy.md. Tested below, in `tests/error_bars.rs` and `tests/determinism.rs`.

use super::Film;
use super::bars::{self, CentralMoments};
use crate::image::Image;
use crate::math::rgb::Rgb;
use crate::math::stats::{Moments, normal_quantile};

/// How far the picture is likely to be from the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorEstimate {
    /// Estimated root of relMSE, the mean over pixels and channels of (x - r)^2 / (r^2 + eps).
    pub rel_rmse: f64,
    /// With this confidence ...
    pub confidence: f64,
    /// ... the root of relMSE is below this.
    pub upper_bound: f64,
    /// The share of pixels whose estimate cannot be trusted: nothing arrived in them, but something in their
    /// neighbourhood.
    pub uncalibrated_fraction: f64,
}

impl Film {
    /// The estimated error of the picture; `None` before every pixel has two samples, or for a black picture.
    ///
    /// With error bars it is that of their batches. Without, it takes samples as independent; those of a low-discrepancy
    /// sampler err less: for them it is an upper bound.
    pub fn error(&self, confidence: f64) -> Option<ErrorEstimate> {
        let least = if self.has_bars() { bars::BATCHES } else { 2 };
        if self.tiles.iter().any(|tile| tile.samples < least) {
            return None;
        }
        let mean = self.mean().iter().sum::<f64>() / 3.0;
        let epsilon = 0.01 * mean * mean;
        if epsilon == 0.0 {
            return None;
        }
        let estimates = self.estimates();
        let means: Vec<[f64; 3]> = estimates.iter().map(|pixel| pixel.mean).collect();
        let limits = brightest_neighbours(&means, self.window.width as usize);
        let mut per_pixel = Moments::default();
        let mut squares = 0.0;
        for (pixel, limit) in estimates.iter().zip(limits) {
            // A pixel that outshines its neighbours may do so by chance: then it is them that it is measured by.
            let truth = |c: usize| pixel.mean[c].abs().min(limit[c]);
            let relative = |c: usize| pixel.variance[c] / (truth(c) * truth(c) + epsilon);
            let relative = (relative(0) + relative(1) + relative(2)) / 3.0;
            per_pixel.push(relative);
            squares += relative * relative;
        }
        // Of the estimate, and of the one picture about its expectation: the square of a normal number has twice the
        // squared variance.
        let of_estimate = per_pixel.standard_error().unwrap_or(f64::INFINITY);
        let of_picture2 = 2.0 * squares / (per_pixel.count() as f64).powi(2);
        let margin = normal_quantile(confidence) * of_estimate.hypot(of_picture2.sqrt());
        Some(ErrorEstimate {
            rel_rmse: per_pixel.mean().sqrt(),
            confidence,
            upper_bound: (per_pixel.mean() + margin).sqrt(),
            uncalibrated_fraction: self.uncalibrated_fraction(),
        })
    }

    /// The standard error of each pixel; `None` without error bars.
    pub fn standard_errors(&self) -> Option<Image> {
        self.has_bars().then(|| {
            let errors = self
                .estimates()
                .into_iter()
                .map(|pixel| Rgb::from(pixel.variance.map(|variance| variance.sqrt() as f32)));
            Image::new(self.window.width, self.window.height, errors.collect())
        })
    }

    /// Which pixels' error bars are not to be trusted, row by row; `None` without error bars.
    ///
    /// Decided by the neighbours within three pixels, not by the pixel's own samples: those would be lucky where they
    /// seem to be good.
    pub fn flags(&self) -> Option<Vec<bool>> {
        const REACH: usize = 3;
        if !self.has_bars() {
            return None;
        }
        let (width, height) = (self.window.width as usize, self.window.height as usize);
        let mut own = vec![CentralMoments::default(); width * height];
        let mut samples = vec![0; width * height];
        for tile in &self.tiles {
            let bars = tile.bars.as_ref()?;
            for (pixel, bars) in tile.window.pixels().zip(bars) {
                let index = self.index(pixel);
                own[index] = bars.central_moments(tile.samples);
                samples[index] = tile.samples;
            }
        }
        let unlit = self.unlit_among_lit();
        let flags = (0..own.len()).map(|index| {
            let (x, y) = (index % width, index / width);
            let rows = y.saturating_sub(REACH)..(y + REACH + 1).min(height);
            let columns = x.saturating_sub(REACH)..(x + REACH + 1).min(width);
            let count = rows.len() * columns.len();
            let sum = rows
                .flat_map(|row| columns.clone().map(move |column| row * width + column))
                .fold(CentralMoments::default(), |sum, i| sum + own[i]);
            let others = if count > 1 {
                (1.0 / (count - 1) as f64) * (sum - own[index])
            } else {
                own[index]
            };
            unlit[index] || !others.is_calibrated(samples[index])
        });
        Some(flags.collect())
    }

    /// What is known of each pixel, row by row; nothing of one with fewer samples than that takes.
    fn estimates(&self) -> Vec<PixelEstimate> {
        let mut estimates = vec![PixelEstimate::default(); self.window.pixel_count() as usize];
        for tile in &self.tiles {
            for (i, pixel) in tile.window.pixels().enumerate() {
                let sums = &tile.pixels[i];
                let variance = match &tile.bars {
                    Some(bars) => Some(bars[i].variance_of_mean(tile.samples)),
                    None => sums.variance_of_mean(tile.samples),
                };
                estimates[self.index(pixel)] = PixelEstimate {
                    mean: sums.mean(tile.samples),
                    variance: variance.unwrap_or_default(),
                };
            }
        }
        estimates
    }

    /// The share of pixels without light that [`unlit_among_lit`](Self::unlit_among_lit) names.
    fn uncalibrated_fraction(&self) -> f64 {
        let doubtful = self.unlit_among_lit();
        doubtful.iter().filter(|&&is| is).count() as f64 / doubtful.len() as f64
    }

    /// The pixels without light among whose neighbours, up to four pixels away, there is some.
    fn unlit_among_lit(&self) -> Vec<bool> {
        const REACH: usize = 4;
        let (width, height) = (self.window.width as usize, self.window.height as usize);
        let mut lit = vec![false; width * height];
        for (index, _, mean, _) in self.means() {
            lit[index] = mean != [0.0; 3];
        }
        let mut near = lit.clone();
        spread(&mut near, width, 1, REACH);
        spread(&mut near, height, width, REACH);
        lit.iter()
            .zip(&near)
            .map(|(lit, near)| !lit && *near)
            .collect()
    }
}

/// What is known of a pixel.
#[derive(Debug, Clone, Copy, Default)]
struct PixelEstimate {
    mean: [f64; 3],
    /// Of the mean.
    variance: [f64; 3],
}

/// The brightest of the up to eight neighbours of each pixel, channel by channel; of a pixel without neighbours its own
/// value.
fn brightest_neighbours(pixels: &[[f64; 3]], width: usize) -> Vec<[f64; 3]> {
    let height = pixels.len() / width;
    let around = |i: usize, length: usize| i.saturating_sub(1)..(i + 2).min(length);
    (0..pixels.len())
        .map(|index| {
            let (x, y) = (index % width, index / width);
            let near = around(y, height)
                .flat_map(|row| around(x, width).map(move |column| row * width + column));
            near.filter(|&other| other != index)
                .map(|other| pixels[other])
                .reduce(|a, b| std::array::from_fn(|c| a[c].max(b[c])))
                .unwrap_or(pixels[index])
        })
        .collect()
}

/// Spreads `true` by `reach` along one axis: `length` entries, `stride` apart.
fn spread(mask: &mut [bool], length: usize, stride: usize, reach: usize) {
    let lines = mask.len() / length;
    for line in 0..lines {
        let start = if stride == 1 { line * length } else { line };
        let before: Vec<bool> = (0..length).map(|i| mask[start + i * stride]).collect();
        for i in 0..length {
            let around = i.saturating_sub(reach)..(i + reach + 1).min(length);
            mask[start + i * stride] = before[around].contains(&true);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Window;
    use super::*;

    #[test]
    fn a_dark_pixel_beside_a_lit_one_is_not_trusted() {
        let mut film = Film::new(
            Window {
                x: 0,
                y: 0,
                width: 20,
                height: 1,
            },
            32,
        );
        for tile in film.tiles_mut() {
            tile.samples = 2;
            tile.pixels[0].add(Rgb::WHITE);
        }
        // The four pixels next to the lit one.
        assert_eq!(film.uncalibrated_fraction(), 0.2);
    }
}
