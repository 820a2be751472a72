//! The total number of samples of each pixel, from what a pilot estimates at its neighbours.
//!
//! The image's relMSE is the mean of v/n over the pixels, with v the relative variance of one sample of a pixel and n
//! its count. For a given amount of work it is least where n is proportional to sqrt(v/c), with c the work of one
//! sample: the rays that it takes.
//!
//! **Why it is unbiased.** The pixels are coloured as a chessboard. The count of a white pixel is decided by the pilot
//! of the black ones alone, and vice versa. Given all samples of the black pixels, the counts of the white ones are
//! constants, and each of these is a plain mean of a number of samples that does not depend on them: its expectation is
//! exact, and its error bar is that of any mean. So no sample of the pilot is lost, low-discrepancy points continue
//! where it ended, and an interruption leaves every pixel a plain mean, too. If a pixel's own pilot decided its count,
//! a mean over all of its samples would be too small: pixels with a rare bright sample would continue until it is
//! diluted.
//!
//! Measure: samples per pixel; shares have the mean 1 over each colour of the chessboard.
//! Range: a window of at least one pixel. Pixels without neighbours get equal shares.
//! Source: Neyman 1934 for the square root, Cochran 1977, section 5.5, for the work; sample splitting after Cox 1975.
//! Tested in `tests/rendering/adaptive_pixels.rs`.

use crate::film::batches::BATCHES;
use crate::film::{Film, PixelEstimate};
use crate::planted::planted;

/// The largest distance of neighbours in rows and columns: 24 of the other colour.
const REACH: usize = 3;

/// The least share of a pixel, relative to the mean, before shares are scaled to the mean 1: the pilot may have missed
/// light in the pixel and in all its neighbours.
const LEAST_SHARE: f64 = 0.125;

/// The allocation of samples to the pixels.
#[derive(Debug, Clone)]
pub struct Allocation {
    /// The samples of every pixel in the pilot.
    pilot: u64,
    /// The expected relative variance of one sample of each pixel.
    variances: Vec<f64>,
    /// The share of each pixel in the samples.
    shares: Vec<f64>,
    /// The pixels of each colour.
    colours: [Vec<usize>; 2],
}

impl Allocation {
    /// The allocation from a film that has `pilot` samples in every pixel.
    pub fn by_pilot(film: &Film, pilot: u64) -> Self {
        let width = film.window().width as usize;
        let estimates = film.estimates();
        let mut colours = [vec![], vec![]];
        for index in 0..estimates.len() {
            colours[colour(index, width)].push(index);
        }
        let mut own = vec![0.0; estimates.len()];
        for pixels in &colours {
            // Each colour has an epsilon of its own: no number from one colour may depend on the other.
            let mean = pixels.iter().map(|&i| grey(&estimates[i])).sum::<f64>();
            let mean = mean / pixels.len().max(1) as f64;
            for &i in pixels {
                own[i] = pilot as f64 * estimates[i].relative_variance(0.01 * mean * mean);
            }
        }
        let neighbours = estimated_from_neighbours(film, &own);
        let variances = planted!("pixels-ask-their-own-pilot", own, neighbours);
        let rays = film.ray_counts().into_iter();
        let work: Vec<f64> = rays.map(|count| count as f64 / pilot as f64).collect();
        let wanted = variances.iter().zip(estimated_from_neighbours(film, &work));
        let wanted = wanted.map(|(v, work)| {
            // At least one ray is traced for a sample.
            let work = planted!("samples-cost-alike", 1.0, work.max(1.0));
            (v / work).sqrt()
        });
        let shares = shares(wanted.collect(), &colours);
        Self {
            pilot,
            variances,
            shares,
            colours,
        }
    }

    /// The count of each pixel when the mean over them is `level`, given their counts now.
    ///
    /// Fractions of a round are carried to the next pixel: the mean of either colour is met to within a round.
    pub fn counts(&self, now: &[u64], level: u64) -> Vec<u64> {
        let mut counts = now.to_vec();
        for pixels in &self.colours {
            let rate = self.rate(pixels, level);
            let mut left = 0.0;
            for &index in pixels {
                let wanted = self.wanted(index, rate) / BATCHES as f64 + left;
                let rounds = wanted.floor();
                left = wanted - rounds;
                counts[index] = counts[index].max(rounds as u64 * BATCHES);
            }
        }
        counts
    }

    /// The samples of a pixel at this number of samples per share.
    fn wanted(&self, index: usize, rate: f64) -> f64 {
        (rate * self.shares[index]).max(self.pilot as f64)
    }

    /// The samples per share at which the mean over these pixels is `level`: pixels that have more from the pilot than
    /// their share leave less to the others.
    fn rate(&self, pixels: &[usize], level: u64) -> f64 {
        let spare = level.saturating_sub(self.pilot) as f64 * pixels.len() as f64;
        let mut rate = f64::INFINITY;
        loop {
            let takes = |&&index: &&usize| rate * self.shares[index] > self.pilot as f64;
            let takers: Vec<usize> = pixels.iter().filter(takes).copied().collect();
            let sum: f64 = takers.iter().map(|&index| self.shares[index]).sum();
            let next = (spare + self.pilot as f64 * takers.len() as f64) / sum;
            if takers.is_empty() || next >= rate {
                return if rate.is_finite() { rate } else { 0.0 };
            }
            rate = next;
        }
    }

    /// The number of evenly distributed samples per pixel with the error of this level, by the pilot's estimates.
    pub fn worth(&self, level: u64) -> f64 {
        let pixels: Vec<usize> = (0..self.shares.len()).collect();
        self.at(self.rate(&pixels, level)).1
    }

    /// The level with the error of `worth` evenly distributed samples per pixel.
    pub fn level_of(&self, worth: f64) -> f64 {
        if self.at(0.0).1 >= worth {
            return self.pilot as f64;
        }
        let (mut low, mut high) = (0.0, self.pilot as f64);
        while self.at(high).1 < worth && high < f64::MAX / 2.0 {
            (low, high) = (high, 2.0 * high);
        }
        /// Halvings that leave a thousandth.
        const HALVINGS: u32 = 10;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.at(middle).1 < worth {
                low = middle;
            } else {
                high = middle;
            }
        }
        self.at(high).0
    }

    /// The level at this number of samples per share, and its worth in evenly distributed samples.
    fn at(&self, rate: f64) -> (f64, f64) {
        let (mut level, mut error, mut variance) = (0.0, 0.0, 0.0);
        for (index, v) in self.variances.iter().enumerate() {
            let samples = self.wanted(index, rate);
            level += samples;
            error += v / samples;
            variance += v;
        }
        let level = level / self.shares.len() as f64;
        let worth = variance / error;
        // Without variance, the worth of samples is their number.
        (level, if worth.is_finite() { worth } else { level })
    }
}

/// The chessboard colour of a pixel.
fn colour(index: usize, width: usize) -> usize {
    (index % width + index / width) % 2
}

/// The mean, for each pixel, over its neighbours of the other colour, with larger weights for nearer ones.
fn estimated_from_neighbours(film: &Film, own: &[f64]) -> Vec<f64> {
    let width = film.window().width as usize;
    let told = (0..own.len()).map(|index| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for other in film.around(index, REACH) {
            let tells = colour(other, width) != colour(index, width);
            if planted!("neighbours-of-either-colour-tell", true, tells) {
                let weight = nearness(index, other, width);
                sum += weight * own[other];
                weights += weight;
            }
        }
        if weights > 0.0 { sum / weights } else { 0.0 }
    });
    told.collect()
}

/// The mean over the channels.
fn grey(pixel: &PixelEstimate) -> f64 {
    pixel.mean.iter().sum::<f64>() / 3.0
}

/// The weight of a neighbour: the reciprocal of its squared distance.
fn nearness(index: usize, other: usize, width: usize) -> f64 {
    let along = (index % width).abs_diff(other % width) as f64;
    let across = (index / width).abs_diff(other / width) as f64;
    1.0 / (along * along + across * across)
}

/// The share of each pixel, in proportion to the wanted samples, with the mean 1 over each colour.
fn shares(mut shares: Vec<f64>, colours: &[Vec<usize>; 2]) -> Vec<f64> {
    for pixels in colours {
        let mean = |shares: &[f64]| {
            pixels.iter().map(|&index| shares[index]).sum::<f64>() / pixels.len().max(1) as f64
        };
        let least = LEAST_SHARE * mean(&shares);
        for &index in pixels {
            shares[index] = shares[index].max(least);
        }
        let mean = mean(&shares);
        for &index in pixels {
            shares[index] = if mean > 0.0 {
                shares[index] / mean
            } else {
                1.0
            };
        }
    }
    shares
}
