//! How many samples each pixel gets in all, by what a pilot shows of its neighbours.
//!
//! The picture's relMSE is the mean of v/n over the pixels, with v the relative variance of one sample of a pixel and n its
//! count. For a given amount of work it is least where n is proportional to sqrt(v/c), with c the work of one sample: the rays
//! that it takes.
//!
//! **Why it is unbiased.** The pixels are the fields of a chessboard. What a white one gets is decided by the pilot of the
//! black ones alone, and the other way round. Given all samples of the black pixels, the counts of the white ones are
//! constants, and each of these is a plain mean of so many samples, of which it knows nothing: its expectation is exact, and
//! its error bar is that of any mean. So no sample of the pilot is lost, points of low discrepancy go on where it ended, and
//! an interruption leaves every pixel a plain mean, too. Were a pixel's own pilot asked, a mean over all of its samples would
//! be too small: those who saw a rare bright sample would go on until it is diluted.
//!
//! Measure: samples per pixel; shares have the mean 1 over each colour of the chessboard.
//! Range: a window of at least one pixel. One that has no neighbours gets what there is evenly.
//! Source: Neyman 1934 for the square root, Cochran 1977, section 5.5, for the work; sample splitting after Cox 1975. Tested
//! in `tests/rendering/adaptive_pixels.rs`.

use crate::film::batches::BATCHES;
use crate::film::{Film, PixelEstimate};
use crate::planted::planted;

/// Neighbours up to so many rows and columns away are asked: 24 of the other colour.
const REACH: usize = 3;

/// No pixel gets less than this share of the mean, before shares are scaled to the mean 1: what the pilot has not seen
/// anywhere near is there all the same.
const LEAST_SHARE: f64 = 0.125;

/// The allocation.
#[derive(Debug, Clone)]
pub struct Allocation {
    /// Samples that every pixel has from the pilot.
    pilot: u64,
    /// Expected relative variance of one sample of each pixel.
    variances: Vec<f64>,
    /// What each pixel gets of what there is.
    shares: Vec<f64>,
    /// The pixels of either colour.
    colours: [Vec<usize>; 2],
}

impl Allocation {
    /// By a film that has `pilot` samples in every pixel.
    pub fn by_pilot(film: &Film, pilot: u64) -> Self {
        let width = film.window().width as usize;
        let estimates = film.estimates();
        let mut colours = [vec![], vec![]];
        for index in 0..estimates.len() {
            colours[colour(index, width)].push(index);
        }
        let mut own = vec![0.0; estimates.len()];
        for pixels in &colours {
            // Each colour has an epsilon of its own: no number that comes of one may tell of the other.
            let mean = pixels.iter().map(|&i| grey(&estimates[i])).sum::<f64>();
            let mean = mean / pixels.len().max(1) as f64;
            for &i in pixels {
                own[i] = pilot as f64 * estimates[i].relative_variance(0.01 * mean * mean);
            }
        }
        let neighbours = told_by_neighbours(film, &own);
        let variances = planted!("pixels-ask-their-own-pilot", own, neighbours);
        let rays = film.ray_counts().into_iter();
        let work: Vec<f64> = rays.map(|count| count as f64 / pilot as f64).collect();
        let wanted = variances.iter().zip(told_by_neighbours(film, &work));
        let wanted = wanted.map(|(v, work)| {
            // One ray at least is traced for a sample.
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

    /// What each pixel has when the mean over them is `level`, given what they have now.
    ///
    /// Where the parts of a round add up to one, a pixel gets it: the mean of either colour is met to within a round.
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

    /// Samples of a pixel at this number of samples per share.
    fn wanted(&self, index: usize, rate: f64) -> f64 {
        (rate * self.shares[index]).max(self.pilot as f64)
    }

    /// Samples per share at which the mean over these pixels is `level`: those that have more from the pilot than their
    /// share leave the less to the others.
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

    /// How many samples per pixel, given out evenly, would have the error of this level: by what the pilot tells.
    pub fn worth(&self, level: u64) -> f64 {
        let pixels: Vec<usize> = (0..self.shares.len()).collect();
        self.at(self.rate(&pixels, level)).1
    }

    /// The level with the error of so many samples per pixel given out evenly.
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

    /// The level at this number of samples per share, and what it is worth.
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
        // Nothing varies: samples are worth what they are.
        (level, if worth.is_finite() { worth } else { level })
    }
}

/// The colour of a pixel's field of the chessboard.
fn colour(index: usize, width: usize) -> usize {
    (index % width + index / width) % 2
}

/// For each pixel, the mean over its neighbours of the other colour, of which the nearer count more.
fn told_by_neighbours(film: &Film, own: &[f64]) -> Vec<f64> {
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

/// What a neighbour's word counts: the reciprocal of its squared distance.
fn nearness(index: usize, other: usize, width: usize) -> f64 {
    let along = (index % width).abs_diff(other % width) as f64;
    let across = (index / width).abs_diff(other / width) as f64;
    1.0 / (along * along + across * across)
}

/// What each pixel gets in proportion to what it wants, with the mean 1 over each colour.
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
