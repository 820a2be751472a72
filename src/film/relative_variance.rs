//! The relative variance of each pixel, over the squared truth, by either half of the batches: the terms of an
//! image's relMSE.
//!
//!   E = (e_even + e_odd) / 2,   e_half = mean of v_half / (r_other^2 + eps_other),
//!
//! with v_half the variance of the pixel's mean, estimated from the two batches of one half, and r_other the pixel's mean
//! in the other half. E[1 / (r_other^2 + eps)] exceeds 1 / (r^2 + eps), most where a half of few bright samples has none
//! of them. Therefore the noise of r_other, a mean over the pixels around, is added to r_other^2. It is estimated from the
//! same half as r_other: no sample enlarges its own denominator. Pixels count in that mean as far as their noise is
//! comparable to their own r^2 ([`COMPARABLE`]), as it is where bright samples are rare. At the edge of a lamp, which many
//! samples hit, it is not, and would hide the error of the dark pixels beside. Without the addition, the mean of the same
//! terms lies above relMSE, which an upper bound uses.
//!
//! Measure: relative variances, without unit.
//! Range: films with a sample in each batch of every pixel, neither half of which is black.
//! Source: docs/accuracy.md, "The error that is printed". Tested in `error.rs`.

use super::Film;
use super::batches::{BATCHES, BatchMeans, Half};
use crate::math::plane::Plane;
use crate::planted::planted;
use rayon::prelude::*;

/// The share of r^2 from which on noise counts in full; below, it counts by the square of its ratio to that share. Measured
/// in images of 64 and 256 spp: if noise always counts, relMSE is 9 to 16 % too small in scenes with small lamps (four-lights
/// and veach-mis), with 1/6 by 2 % at most. In the suzanne-room, where it is too large, it is then 4 % larger.
const COMPARABLE: f32 = 1.0 / 6.0;

/// The radius in pixels of the squares over which the noise of r is averaged.
const NOISE_RADIUS: usize = 2;

/// The edge in pixels of the blocks whose differences between halves give the uncertainty.
const BLOCK: usize = 8;

/// The least number of blocks; blocks are made smaller where there would be fewer.
const MIN_BLOCKS: usize = 32;

/// The least edge of a block as a multiple of the border size.
const MIN_EDGE_IN_BORDERS: usize = 4;

/// The least edge of a block in pixels: the pixels of an interleaved packet may share paths.
const MIN_EDGE: usize = 8;

/// The variance of each pixel's mean over the squared truth, by either half of the batches.
pub(super) struct RelativeVariances {
    width: usize,
    /// The border size of the film: the noise of pixels up to twice as far apart is correlated.
    border_size: usize,
    /// Means over the channels: the variance by the even batches, and by the odd ones.
    halves: [Vec<f64>; 2],
    /// relMSE with nothing added for the noise of r: larger than the truth on average.
    pub(super) upper_mean: f64,
    /// The largest term of relMSE that a single sample could account for.
    pub(super) largest_sample: f64,
    /// The largest term of a pixel and of those that share its samples in relMSE, by the variance of all batches.
    pub(super) largest_pixel: f64,
}

/// Square blocks of pixels, which contain nearly all correlation of neighbours.
pub(super) struct Blocks {
    width: usize,
    edge: usize,
    across: usize,
    /// Their number.
    pub(super) count: usize,
}

impl Blocks {
    /// The block of a pixel.
    pub(super) fn block_of(&self, index: usize) -> usize {
        index / self.width / self.edge * self.across + index % self.width / self.edge
    }
}

impl RelativeVariances {
    /// Estimates the relative variances of a film; `None` without a sample in each batch of every pixel, or if a half
    /// of the batches is black.
    pub(super) fn of(film: &Film) -> Option<Self> {
        if !film.has_all_batches() {
            return None;
        }
        let width = film.window.width as usize;
        let border_size = film.border_size() as usize;
        let count = film.pixel_count();
        let means = Half::ALL.map(|half| mean_of_half(film, half));
        if means.iter().any(|&mean| mean <= 0.0) {
            return None;
        }
        // Single precision suffices in units of the image's mean.
        let unit = 0.5 * (means[0] + means[1]);
        let epsilons = means.map(|mean| (0.01 * (mean / unit) * (mean / unit)) as f32);
        let channels = (0..3).into_par_iter().map(|c| {
            let channel = Channel::of(film, c, unit)?;
            Some(ChannelTerms::of(&channel, epsilons, border_size))
        });
        let channels: Vec<ChannelTerms> = channels.collect::<Option<_>>()?;
        let mean = |of: fn(&ChannelTerms) -> &Vec<f64>| -> Vec<f64> {
            let terms = |index| channels.iter().map(move |channel| of(channel)[index] / 3.0);
            (0..count).map(|index| terms(index).sum()).collect()
        };
        let halves = [
            mean(|channel| &channel.halves[0]),
            mean(|channel| &channel.halves[1]),
        ];
        let upper: f64 = channels.iter().map(|channel| channel.upper_mean).sum();
        let largest = |of| mean(of).into_iter().fold(0.0, f64::max) / count as f64;
        let largest_sample = largest(|channel| &channel.largest_sample);
        let largest_pixel = largest(|channel| &channel.of_pixel);
        Some(Self {
            width,
            border_size,
            halves,
            upper_mean: upper / 3.0,
            largest_sample,
            largest_pixel,
        })
    }

    /// The number of pixels.
    pub(super) fn count(&self) -> usize {
        self.halves[0].len()
    }

    /// The estimate of relMSE.
    pub(super) fn mean(&self) -> f64 {
        let both = 0.5 * (sum(&self.halves[0]) + sum(&self.halves[1]));
        both / self.count() as f64
    }

    /// The term of each block in the difference between the halves' estimates.
    pub(super) fn block_differences(&self) -> Vec<f64> {
        let blocks = self.blocks();
        let mut differences = vec![0.0; blocks.count];
        for index in 0..self.count() {
            differences[blocks.block_of(index)] += self.difference(index);
        }
        differences
    }

    /// The blocks of pixels.
    pub(super) fn blocks(&self) -> Blocks {
        let [width, height] = [self.width, self.halves[0].len() / self.width];
        let blocks = |edge: usize| width.div_ceil(edge) * height.div_ceil(edge);
        // Blocks of a few times the border size contain nearly all correlation of neighbours.
        let mut edge = BLOCK * self.border_size.max(1);
        let least = (MIN_EDGE_IN_BORDERS * self.border_size).max(MIN_EDGE);
        while edge > least && blocks(edge) < MIN_BLOCKS {
            edge /= 2;
        }
        Blocks {
            width,
            edge,
            across: width.div_ceil(edge),
            count: blocks(edge),
        }
    }

    /// The term of a pixel in the difference between the halves' estimates.
    pub(super) fn difference(&self, index: usize) -> f64 {
        let [even, odd] = [self.halves[0][index], self.halves[1][index]];
        (even - odd) / self.count() as f64
    }

    /// The term of a pixel in the estimate of relMSE.
    pub(super) fn part(&self, index: usize) -> f64 {
        let both = self.halves[0][index] + self.halves[1][index];
        0.5 * both / self.count() as f64
    }
}

/// The terms of one channel.
struct ChannelTerms {
    /// The relative variance of each pixel's mean, by either half.
    halves: [Vec<f64>; 2],
    /// The mean over halves and pixels with nothing added for the noise of r.
    upper_mean: f64,
    /// The squared contribution of each pixel's largest sample, relative to the least truth that the pixel would have
    /// without it, summed over the pixels that the sample may contribute to.
    largest_sample: Vec<f64>,
    /// The relative variance of each pixel's mean by all batches, summed over the pixels that its samples contribute to.
    of_pixel: Vec<f64>,
}

impl ChannelTerms {
    /// Computes the terms of a channel, given epsilon for either half and the border size of the film.
    fn of(channel: &Channel, epsilons: [f32; 2], border_size: usize) -> Self {
        let denominator = |half: Half, with_noise: bool| {
            let other = planted!("denominator-of-the-same-half", half, half.other()) as usize;
            let [truth, noise] = [&channel.halves[other], &channel.noises[other]];
            truth.like(|i| {
                let square = truth.values[i] * truth.values[i];
                let noise = if with_noise { noise.values[i] } else { 0.0 };
                square + noise + epsilons[other]
            })
        };
        let relative = |half: Half, denominator: &Plane| {
            let terms = channel.variances[half as usize].divided_by(denominator);
            terms.values.into_iter().map(f64::from).collect::<Vec<_>>()
        };
        let denominators = Half::ALL.map(|half| denominator(half, true));
        let halves = Half::ALL.map(|half| relative(half, &denominators[half as usize]));
        let upper = Half::ALL
            .map(|half| relative(half, &denominator(half, false)))
            .concat();
        let of_pixel = channel.variance.like(|i| {
            let [even, odd] =
                [0, 1].map(|half: usize| channel.variance.values[i] / denominators[half].values[i]);
            0.5 * (even + odd)
        });
        let epsilon = 0.5 * (epsilons[0] + epsilons[1]);
        let near = channel.whole.box_mean(1).box_min(1);
        let darkest = near.like(|i| near.values[i].max(channel.least.values[i]));
        // Nothing is added for noise, to which the sample itself may contribute.
        let denominator = darkest.like(|i| darkest.values[i] * darkest.values[i] + epsilon);
        let largest = channel.largest_sample.divided_by(&denominator);
        // The terms of all pixels that a sample contributes to add up.
        let pixels = (2 * border_size + 1).pow(2) as f64;
        let summed = |terms: Plane| -> Vec<f64> {
            let means = terms.box_mean(border_size).values.into_iter();
            means.map(|term| pixels * f64::from(term)).collect()
        };
        Self {
            halves,
            upper_mean: sum(&upper) / upper.len() as f64,
            largest_sample: summed(largest),
            of_pixel: summed(of_pixel),
        }
    }
}

/// One channel of a film in units of the image's mean.
struct Channel {
    /// The image of either half, and of the whole.
    halves: [Plane; 2],
    whole: Plane,
    /// The variance of the pixel's mean, estimated by either half.
    variances: [Plane; 2],
    /// The variance of the pixel's mean, estimated by all batches.
    variance: Plane,
    /// The variance of the mean of either half, as far as it is comparable to the squared mean, over the pixels around each.
    noises: [Plane; 2],
    /// The squared contribution of a pixel's largest sample to its mean, estimated from the batches.
    largest_sample: Plane,
    /// Half of the least of a pixel's batch means: a lower estimate of its truth, if one batch is high by a single sample.
    least: Plane,
}

impl Channel {
    fn of(film: &Film, c: usize, unit: f64) -> Option<Self> {
        let width = film.window.width as usize;
        let height = film.window.height as usize;
        let empty = || Plane::filled(width, height, 0.0);
        let mut halves = [empty(), empty()];
        let mut variances = [empty(), empty()];
        let (mut whole, mut variance) = (empty(), empty());
        let (mut largest, mut least) = (empty(), empty());
        for index in 0..film.pixel_count() {
            let pixel = film.batch_means(index);
            let n = pixel.samples() as f64;
            for half in Half::ALL {
                let (difference, share) = pixel.contrast(half)?;
                let of_sample = share * (difference[c] / unit).powi(2);
                variances[half as usize].values[index] = (of_sample / n) as f32;
                halves[half as usize].values[index] = (pixel.half_mean(half)[c] / unit) as f32;
            }
            whole.values[index] = (pixel.mean()[c] / unit) as f32;
            variance.values[index] = (pixel.variance()?[c] / n / (unit * unit)) as f32;
            let [lowest, highest] = range(&pixel, c);
            let contribution = (highest - lowest) / BATCHES as f64;
            largest.values[index] = (contribution / unit).powi(2) as f32;
            least.values[index] = (0.5 * lowest / unit).max(0.0) as f32;
        }
        let of_half = |half: usize| {
            whole.like(|i| {
                // A half has twice the noise of the whole.
                let noise = 2.0 * variances[half].values[i];
                comparable(noise, halves[half].values[i])
            })
        };
        let noises = planted!(
            "denominator-with-its-own-noise",
            [of_half(1), of_half(0)],
            [0, 1].map(|half| of_half(half).box_mean(NOISE_RADIUS))
        );
        Some(Self {
            halves,
            whole,
            variances,
            variance,
            noises,
            largest_sample: largest,
            least,
        })
    }
}

/// The part of the variance of a pixel's mean that counts as noise of r, see [`COMPARABLE`].
fn comparable(noise: f32, mean: f32) -> f32 {
    let full = planted!("noise-of-edges-counts", 0.0, COMPARABLE) * mean * mean;
    if noise < full {
        noise * (noise / full).powi(2)
    } else {
        noise
    }
}

/// The smallest and the largest batch mean of a pixel in a channel. A single sample contributes at most their difference
/// over the number of batches to the pixel's mean.
fn range(pixel: &BatchMeans, c: usize) -> [f64; 2] {
    let means = pixel.means.iter().map(|mean| mean[c]);
    means.fold([f64::INFINITY, f64::NEG_INFINITY], |[min, max], x| {
        [min.min(x), max.max(x)]
    })
}

/// The mean over pixels and channels of the image of a half of the batches.
fn mean_of_half(film: &Film, half: Half) -> f64 {
    let pixels = 0..film.pixel_count();
    let sum: f64 = pixels
        .map(|index| film.batch_means(index).half_mean(half).iter().sum::<f64>())
        .sum();
    sum / (3 * film.pixel_count()) as f64
}

fn sum(numbers: &[f64]) -> f64 {
    numbers.iter().sum()
}
