//! How wrong a film is: the error of the picture, the standard error of each pixel, and which of these are not to be
//! trusted.
//!
//! Measure: relMSE, the mean over pixels and channels of (x - r)^2 / (r^2 + eps), eps = 0.01 mean(r)^2, and its root.
//! Range: films of at least two samples a pixel, with error bars of at least one round of batches.
//! Source: docs/accuracy.md. Tested below, in `tests/rendering/error_bars.rs` and `tests/rendering/determinism.rs`.

use super::bars::{self, CentralMoments};
use super::{Film, Tile, sum};
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

/// The means of each channel in each batch.
type Batches = [[f64; 3]; bars::BATCHES as usize];

/// How far neighbours are that tell of a pixel's samples.
const NEAR: usize = 3;
/// How far those are whose doubts make a pixel doubtful.
const FAR: usize = 7;

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
        let limits = (0..means.len()).map(|index| {
            // Of a pixel without neighbours its own value.
            let near = self.around(index, 1).map(|other| means[other]);
            near.reduce(|a, b| std::array::from_fn(|c| a[c].max(b[c])))
                .unwrap_or(means[index])
        });
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
    ///
    /// A pixel's own samples tell it, but where [`flags`](Self::flags) doubts them: a pixel that missed a rare event has a low
    /// mean and a small spread at once. There it is at least that of the neighbours.
    pub fn standard_errors(&self) -> Option<Image> {
        let flags = self.flags()?;
        let estimates = self.estimates();
        let errors = estimates
            .iter()
            .zip(flags)
            .enumerate()
            .map(|(index, (own, flag))| {
                let mut variance = own.variance;
                let others: Vec<usize> = self.around(index, NEAR).collect();
                if flag && !others.is_empty() {
                    for (c, variance) in variance.iter_mut().enumerate() {
                        let sum: f64 = others
                            .iter()
                            .map(|&other| estimates[other].variance[c])
                            .sum();
                        *variance = variance.max(sum / others.len() as f64);
                    }
                }
                Rgb::from(variance.map(|variance| variance.sqrt() as f32))
            });
        let errors = errors.collect();
        Some(Image::new(self.window.width, self.window.height, errors))
    }

    /// Which pixels' error bars are not to be trusted, row by row; `None` without error bars.
    ///
    /// Decided by the neighbours, not by the pixel's own samples: those would be lucky where they seem to be good. A pixel
    /// is doubtful if its neighbours' samples, or their batches where light paths add to them, are too far from normal
    /// numbers, or if many pixels about it are doubtful: rare events that some have met, the others have yet to meet.
    pub fn flags(&self) -> Option<Vec<bool>> {
        /// Doubtful pixels among those farther about, from which share on they make others doubtful.
        const MANY: f64 = 0.2;
        let mut of_samples = vec![CentralMoments::default(); self.window.pixel_count() as usize];
        let mut samples = vec![0; of_samples.len()];
        for tile in &self.tiles {
            let pixels = tile.window.pixels().zip(tile.bars.as_ref()?);
            for (place, (pixel, bars)) in pixels.enumerate() {
                let index = self.index(pixel);
                samples[index] = tile.count(place);
                of_samples[index] = bars.central_moments(samples[index]);
            }
        }
        let of_batches = self.moments_of_batches();
        let doubtful: Vec<bool> = (0..of_samples.len())
            .map(|index| {
                let by_batches = of_batches
                    .as_ref()
                    .is_none_or(|all| self.near(index, all).of_batches_is_calibrated());
                !by_batches || !self.near(index, &of_samples).is_calibrated(samples[index])
            })
            .collect();
        let unlit = self.unlit_among_lit();
        let width = self.window.width as usize;
        let about = counts_within(&doubtful, width, FAR);
        let all = counts_within(&vec![true; doubtful.len()], width, FAR);
        let flags = (0..doubtful.len()).map(|index| {
            let others = about[index] - u32::from(doubtful[index]);
            let share = f64::from(others) / f64::from(all[index] - 1).max(1.0);
            unlit[index] || doubtful[index] || share > MANY
        });
        Some(flags.collect())
    }

    /// The moments of the batches of each pixel, where light paths add to its samples.
    fn moments_of_batches(&self) -> Option<Vec<CentralMoments>> {
        self.splats.as_ref()?;
        let mut moments = vec![CentralMoments::default(); self.window.pixel_count() as usize];
        for tile in &self.tiles {
            for (place, pixel) in tile.window.pixels().enumerate() {
                let batches = self.batches(tile, place, pixel)?;
                moments[self.index(pixel)] = bars::moments_of_batches(&batches);
            }
        }
        Some(moments)
    }

    /// The means of the batches of a pixel, which has this place in its tile: of its samples and of what light paths add to
    /// them. The two are not independent, but batches are. `None` without error bars.
    fn batches(&self, tile: &Tile, place: usize, pixel: [u32; 2]) -> Option<Batches> {
        let mut batches = tile.bars.as_ref()?[place].batch_means(tile.count(place).max(1));
        if let Some(splats) = &self.splats {
            let of_splats = splats.batch_means(self.index(pixel));
            for (batch, splats) in batches.iter_mut().zip(of_splats) {
                *batch = sum(*batch, splats);
            }
        }
        Some(batches)
    }

    /// The mean over the neighbours of a pixel, or its own where it has none.
    fn near(&self, index: usize, moments: &[CentralMoments]) -> CentralMoments {
        let none = (0, CentralMoments::default());
        let near = self.around(index, NEAR);
        match near.fold(none, |(count, sum), other| {
            (count + 1, sum + moments[other])
        }) {
            (0, _) => moments[index],
            (count, sum) => (1.0 / f64::from(count)) * sum,
        }
    }

    /// The pixels about one, at most `reach` rows and columns away, without itself.
    pub fn around(&self, index: usize, reach: usize) -> impl Iterator<Item = usize> + use<> {
        let (width, height) = (self.window.width as usize, self.window.height as usize);
        let (x, y) = (index % width, index / width);
        let rows = y.saturating_sub(reach)..(y + reach + 1).min(height);
        let columns = x.saturating_sub(reach)..(x + reach + 1).min(width);
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
            .filter(move |&other| other != index)
    }

    /// What is known of each pixel, row by row; nothing of one with fewer samples than that takes.
    pub fn estimates(&self) -> Vec<PixelEstimate> {
        let mut estimates = vec![PixelEstimate::default(); self.window.pixel_count() as usize];
        for (index, mean, _) in self.means() {
            estimates[index].mean = mean;
        }
        for tile in &self.tiles {
            for (i, pixel) in tile.window.pixels().enumerate() {
                let index = self.index(pixel);
                let (sums, samples) = (&tile.pixels[i], tile.count(i));
                let variance = match (self.batches(tile, i, pixel), &self.splats) {
                    (Some(batches), _) => Some(bars::variance_of_mean(&batches)),
                    (None, None) => sums.variance_of_mean(samples),
                    (None, Some(splats)) => sums
                        .variance_of_mean(samples)
                        .map(|own| sum(own, splats.variance_of_mean(index))),
                };
                estimates[index].variance = variance.unwrap_or_default();
            }
        }
        estimates
    }

    /// The share of lit tiles whose mean is uncertain by more than a fifth, by the spread of batches: where these are of Markov
    /// chains, they have not yet found the same. `None` without batches.
    pub fn disagreement(&self) -> Option<f64> {
        const UNCERTAIN: f64 = 0.2;
        let (mut lit, mut uncertain) = (0, 0);
        for tile in &self.tiles {
            let mut batches = [0.0; bars::BATCHES as usize];
            for (place, pixel) in tile.window.pixels().enumerate() {
                let of_pixel = self.batches(tile, place, pixel)?;
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
        Some(f64::from(uncertain) / f64::from(lit.max(1)))
    }

    /// The share of pixels without light that [`unlit_among_lit`](Self::unlit_among_lit) names.
    fn uncalibrated_fraction(&self) -> f64 {
        let doubtful = self.unlit_among_lit();
        doubtful.iter().filter(|&&is| is).count() as f64 / doubtful.len() as f64
    }

    /// The pixels without light among whose neighbours, up to four pixels away, there is some.
    fn unlit_among_lit(&self) -> Vec<bool> {
        const REACH: usize = 4;
        let mut lit = vec![false; self.window.pixel_count() as usize];
        for (index, mean, _) in self.means() {
            lit[index] = mean != [0.0; 3];
        }
        let near = counts_within(&lit, self.window.width as usize, REACH);
        let unlit = lit.iter().zip(near).map(|(lit, near)| !lit && near > 0);
        unlit.collect()
    }
}

/// What is known of a pixel.
#[derive(Debug, Clone, Copy, Default)]
pub struct PixelEstimate {
    /// The mean of each channel.
    pub mean: [f64; 3],
    /// The variance of that mean.
    pub variance: [f64; 3],
}

impl PixelEstimate {
    /// Its part of relMSE: the variance relative to the square of the mean, of the mean over the channels.
    pub fn relative_variance(&self, epsilon: f64) -> f64 {
        let relative = |c: usize| self.variance[c] / (self.mean[c] * self.mean[c] + epsilon);
        let sum = relative(0) + relative(1) + relative(2);
        // Of a black picture: nothing is known of it.
        if sum.is_finite() { sum / 3.0 } else { 0.0 }
    }
}

/// How many of the pixels of rows of `width` are set that are at most `reach` rows and columns away from each, itself included.
fn counts_within(mask: &[bool], width: usize, reach: usize) -> Vec<u32> {
    let counts = mask.iter().map(|&is| u32::from(is)).collect();
    let counts = sums_along(counts, width, 1, reach);
    sums_along(counts, mask.len() / width, width, reach)
}

/// The sums over `reach` entries on both sides of each, along lines of `length` entries that are `stride` apart.
fn sums_along(counts: Vec<u32>, length: usize, stride: usize, reach: usize) -> Vec<u32> {
    let mut sums = vec![0; counts.len()];
    for line in 0..counts.len() / length {
        let start = if stride == 1 { line * length } else { line };
        let at = |i: usize| start + i * stride;
        let mut sum: u32 = (0..reach.min(length)).map(|i| counts[at(i)]).sum();
        for i in 0..length {
            if i + reach < length {
                sum += counts[at(i + reach)];
            }
            sums[at(i)] = sum;
            if i >= reach {
                sum -= counts[at(i - reach)];
            }
        }
    }
    sums
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

    #[test]
    fn counts_are_those_of_the_squares_about_each_pixel() {
        let (width, height) = (13_usize, 9_usize);
        let mask: Vec<bool> = (0..width * height).map(|i| i * i % 7 < 3).collect();
        for reach in [0, 1, 4, 20] {
            for (index, count) in counts_within(&mask, width, reach).into_iter().enumerate() {
                let (x, y) = (index % width, index / width);
                let is_near =
                    |i: usize| (i % width).abs_diff(x) <= reach && (i / width).abs_diff(y) <= reach;
                let near = (0..mask.len()).filter(|&i| mask[i] && is_near(i)).count();
                assert_eq!(count as usize, near, "pixel {index}, reach {reach}");
            }
        }
    }
}
