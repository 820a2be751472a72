//! The total number of samples of each pixel, from what a pilot estimates at its neighbours.
//!
//! The image's relMSE is the mean of v/n over the pixels, with v the relative variance of one sample of a pixel and n
//! its count. For a given amount of work it is least where n is proportional to sqrt(v/c), with c the work of one
//! sample: the rays that it takes.
//!
//! **Why it is unbiased.** The pixels are coloured as a checkerboard. The count of a white pixel is decided by the pilot
//! of the black ones alone, and vice versa. Given all samples of the black pixels, the counts of the white ones are
//! constants, and each of these is a plain mean of a number of samples that does not depend on them: its expectation is
//! exact, and its error bar is that of any mean. So no sample of the pilot is lost, low-discrepancy points continue
//! where it ended, and an interruption leaves every pixel a plain mean, too. If a pixel's own pilot decided its count,
//! a mean over all of its samples would be too small: pixels with a rare bright sample would continue until it is
//! diluted.
//!
//! **Light paths** beside camera paths contribute to any pixel. Each sample of a pixel has its share of them, so their number
//! is that of all samples, which the level determines but for the rounding of single pixels. Given all light paths, the above
//! holds for the camera paths. A pixel's samples reduce the variance of its camera paths alone, which is the `v` of its share.
//!
//! **Why parts of a render fit together.** The count of a pixel is a function of the pilot and of the level, the mean
//! over the pixels, and never falls as the level rises. So a range of levels is a part of a render, for every pixel the
//! samples from its count at the first level up to that at the last, and any division into such ranges has the same
//! samples. Fractions of a round are rounded by a threshold that depends on the pixel's place alone.
//!
//! Measure: samples per pixel; shares have the mean 1 over each colour of the checkerboard.
//! Range: a window of at least one pixel. Pixels without neighbours get equal shares.
//! Source: Neyman 1934 for the square root, Cochran 1977, section 5.5, for the work; sample splitting after Cox 1975.
//! Tested in `tests/rendering/adaptive_pixels.rs`.

use crate::film::batches::BATCHES;
use crate::film::{Film, PixelEstimate};
use crate::planted::planted;
use crate::render::settings::MAX_SPP;

/// The largest distance of neighbours in rows and columns: 24 of the other colour.
const REACH: usize = 3;

/// The least share of a pixel, relative to the mean, before shares are scaled to the mean 1: the pilot may have missed
/// light in the pixel and in all its neighbours.
const MIN_SHARE: f64 = 0.125;

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
    colours: [PixelGroup; 2],
    /// All pixels.
    all_pixels: PixelGroup,
}

/// Pixels that share a mean.
#[derive(Debug, Clone)]
struct PixelGroup {
    pixels: Vec<usize>,
    /// The sum of the largest shares, from one of them to all.
    largest: Vec<f64>,
}

impl PixelGroup {
    fn new(pixels: Vec<usize>, shares: &[f64]) -> Self {
        let mut largest: Vec<f64> = pixels.iter().map(|&index| shares[index]).collect();
        largest.sort_unstable_by(|a, b| b.total_cmp(a));
        let mut sum = 0.0;
        for share in &mut largest {
            sum += *share;
            *share = sum;
        }
        Self { pixels, largest }
    }

    /// The samples per share at which the mean over these pixels is `level`: pixels that have more from the pilot than
    /// their share leave less to the others.
    ///
    /// It is the least, over all k, of the rates at which the k largest shares alone take what the pilot of the others
    /// leaves. No rate falls as the level rises, even rounded.
    fn rate(&self, pilot: u64, level: u64) -> f64 {
        let spare = level.saturating_sub(pilot) as f64 * self.pixels.len() as f64;
        let takers = (1_u64..).zip(&self.largest);
        let rates = takers.map(|(takers, sum)| (spare + pilot as f64 * takers as f64) / sum);
        let rate = rates.fold(f64::INFINITY, f64::min);
        if rate.is_finite() { rate } else { 0.0 }
    }
}

impl Allocation {
    /// The memory of an allocation, in bytes per pixel.
    pub const MEMORY: u64 = (4 * size_of::<f64>() + 2 * size_of::<usize>()) as u64;

    /// The allocation from a film after a pilot of `pilot` samples in every pixel, or more where it was interrupted.
    pub fn by_pilot(film: &Film, pilot: u64) -> Self {
        let width = film.window().width as usize;
        let estimates = film.estimates();
        let counts = film.sample_counts();
        let colours = coloured(estimates.len(), width);
        let mut own = vec![0.0; estimates.len()];
        let mut of_samples = own.clone();
        for pixels in &colours {
            // Each colour has an epsilon of its own: no number from one colour may depend on the other.
            let mean = pixels.iter().map(|&i| grey(&estimates[i])).sum::<f64>();
            let mean = mean / pixels.len().max(1) as f64;
            for &i in pixels {
                let (count, epsilon) = (counts[i] as f64, 0.01 * mean * mean);
                own[i] = count * estimates[i].relative_variance(epsilon);
                of_samples[i] = count * estimates[i].relative_sample_variance(epsilon);
            }
        }
        let neighbours = [&own, &of_samples].map(|own| estimated_from_neighbours(film, own));
        let [variances, of_samples] =
            planted!("pixels-ask-their-own-pilot", [own, of_samples], neighbours);
        let rays = film.ray_counts().into_iter().zip(&counts);
        let work: Vec<f64> = rays
            .map(|(rays, &count)| rays as f64 / count.max(1) as f64)
            .collect();
        let wanted = of_samples
            .iter()
            .zip(estimated_from_neighbours(film, &work));
        let wanted = wanted.map(|(v, work)| {
            // At least one ray is traced for a sample.
            let work = planted!("samples-cost-alike", 1.0, work.max(1.0));
            (v / work).sqrt()
        });
        let shares = shares(wanted.collect(), &colours);
        Self::of_parts(pilot, width, variances, shares)
    }

    /// The allocation of an image of this width with these variances and shares of its pixels, row by row.
    pub fn of_parts(pilot: u64, width: usize, variances: Vec<f64>, shares: Vec<f64>) -> Self {
        let colours = coloured(shares.len(), width);
        Self {
            pilot,
            variances,
            colours: colours.map(|pixels| PixelGroup::new(pixels, &shares)),
            all_pixels: PixelGroup::new((0..shares.len()).collect(), &shares),
            shares,
        }
    }

    /// The expected relative variance of one sample of each pixel, and its share of the samples.
    pub fn parts(&self) -> impl Iterator<Item = [f64; 2]> {
        let pixels = self.variances.iter().zip(&self.shares);
        pixels.map(|(&variance, &share)| [variance, share])
    }

    /// The samples of every pixel in the pilot.
    pub fn pilot(&self) -> u64 {
        self.pilot
    }

    /// A hash of all that counts depend on, in hexadecimal digits: allocations with equal identities have equal counts.
    pub fn identity(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&self.pilot.to_le_bytes());
        for number in self.shares.iter().chain(&self.variances) {
            hasher.update(&number.to_bits().to_le_bytes());
        }
        hasher.finalize().to_hex().to_string()
    }

    /// The count of each pixel when the mean over them is about `level`. It never falls as the level rises.
    pub fn counts(&self, level: u64) -> Vec<u64> {
        let mut counts = vec![level; self.shares.len()];
        if level <= self.pilot {
            return counts;
        }
        for group in &self.colours {
            let rate = group.rate(self.pilot, level);
            for (place, &index) in (0_u32..).zip(&group.pixels) {
                let wanted = self.wanted(index, rate) / BATCHES as f64;
                let rounds = (wanted + threshold(place)).floor();
                counts[index] = (rounds as u64).saturating_mul(BATCHES).min(MAX_SPP);
            }
        }
        counts
    }

    /// The samples of a pixel at this number of samples per share.
    fn wanted(&self, index: usize, rate: f64) -> f64 {
        (rate * self.shares[index]).max(self.pilot as f64)
    }

    /// The number of evenly distributed samples per pixel with the error of this level, by the pilot's estimates.
    pub fn equivalent_spp(&self, level: u64) -> f64 {
        self.at(self.all_pixels.rate(self.pilot, level)).1
    }

    /// The level with the error of `equivalent_spp` evenly distributed samples per pixel.
    pub fn level_of(&self, equivalent_spp: f64) -> f64 {
        if self.at(0.0).1 >= equivalent_spp {
            return self.pilot as f64;
        }
        let (mut low, mut high) = (0.0, self.pilot as f64);
        while self.at(high).1 < equivalent_spp && high < f64::MAX / 2.0 {
            (low, high) = (high, 2.0 * high);
        }
        /// Halvings that leave a thousandth.
        const HALVINGS: u32 = 10;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.at(middle).1 < equivalent_spp {
                low = middle;
            } else {
                high = middle;
            }
        }
        self.at(high).0
    }

    /// The level at this number of samples per share, and the evenly distributed samples per pixel that it is equivalent to.
    fn at(&self, rate: f64) -> (f64, f64) {
        let (mut level, mut error, mut variance) = (0.0, 0.0, 0.0);
        for (index, v) in self.variances.iter().enumerate() {
            let samples = self.wanted(index, rate);
            level += samples;
            error += v / samples;
            variance += v;
        }
        let level = level / self.shares.len() as f64;
        let equivalent_spp = variance / error;
        // Without variance, samples are equivalent to as many evenly distributed ones.
        (
            level,
            if equivalent_spp.is_finite() {
                equivalent_spp
            } else {
                level
            },
        )
    }
}

/// The part of a round, below 1, that is added to the count of the pixel at this place among those of its colour before
/// fractions are cut off. Multiples of the golden ratio are evenly distributed, wherever the pixels are.
fn threshold(place: u32) -> f64 {
    /// The golden ratio less 1, times 2^32.
    const GOLDEN: u32 = 0x9e37_79b9;
    f64::from(place.wrapping_mul(GOLDEN)) / 4_294_967_296.0
}

/// The pixels of each colour of the checkerboard.
fn coloured(pixels: usize, width: usize) -> [Vec<usize>; 2] {
    let mut colours = [vec![], vec![]];
    for index in 0..pixels {
        colours[colour(index, width)].push(index);
    }
    colours
}

/// The checkerboard colour of a pixel.
fn colour(index: usize, width: usize) -> usize {
    (index % width + index / width) % 2
}

/// The mean, for each pixel, over its neighbours of the other colour, with larger weights for nearer ones.
fn estimated_from_neighbours(film: &Film, own: &[f64]) -> Vec<f64> {
    let width = film.window().width as usize;
    let means = (0..own.len()).map(|index| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for other in film.neighbours(index, REACH) {
            let differs = colour(other, width) != colour(index, width);
            if planted!("neighbours-of-either-colour-tell", true, differs) {
                let weight = nearness(index, other, width);
                sum += weight * own[other];
                weights += weight;
            }
        }
        if weights > 0.0 { sum / weights } else { 0.0 }
    });
    means.collect()
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
        let least = MIN_SHARE * mean(&shares);
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
