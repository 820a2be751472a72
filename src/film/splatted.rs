//! The sums of a tile whose samples contribute to every pixel that their filter covers: those of its own pixels and of a halo
//! around them.
//!
//! The weight of a contribution is the fourth channel. With S_b the mean over batch b of weight times radiance in a pixel, and
//! W_b that of the weights, whose expectation is 1, the pixel of the batch is
//!
//!   I_b = S_b - (W_b - 1) c_b,   c_b = S_a / W_a,
//!
//! with a the other batch of the same half, which is independent: W_b is a control variate, so that I_b has the expectation of
//! S_b for any c_b. Where radiance is constant, I_b is exact. Halves stay independent of each other.
//!
//! Measure: radiance times weights.
//! Range: finite samples. 256 bytes a pixel, the halo included.
//! Source: control variates as in Owen, "Monte Carlo Theory, Methods and Examples", section 8.9. Tested below and in
//! `tests/rendering/filters.rs`.

use super::Window;
use super::batches::{BATCHES, BatchMeans, samples_of_batches};
use super::footprint::Footprint;
use super::pixel::Sums;
use crate::math::lanes::{ActiveLanes, LANES, Lanes, vectorised};
use crate::math::rgb::Rgb;
use crate::planted::planted;

/// The sums of a pixel in red, green, blue and the weight.
pub type WeightedSums = Sums<4>;

/// The least mean weight of a batch that radiance is divided by.
const MIN_WEIGHT: f64 = 0.25;

/// Sums over the samples of some pixels, the sources, for all pixels that they contribute to.
#[derive(Debug, Clone, PartialEq)]
pub struct Splatted {
    /// The pixels whose samples are taken. They may be beyond the image's edge.
    sources: Window,
    /// The pixels that have sums, row by row.
    pixels: Window,
    sums: Vec<WeightedSums>,
}

/// The samples of a packet with one index.
#[derive(Debug, Clone, Copy)]
pub struct SplattedSamples {
    /// The samples that are added.
    pub active: ActiveLanes<LANES>,
    /// The columns and the rows of their pixels, which are sources.
    pub pixels: [Lanes<u32>; 2],
    /// Their positions in these pixels.
    pub positions: [Lanes<f32>; 2],
    /// Their radiance.
    pub radiance: Lanes<Rgb>,
}

impl Splatted {
    /// Builds empty sums for samples of these sources.
    pub fn new(sources: Window, border_size: u32) -> Self {
        let pixels = sources.grown(border_size);
        Self {
            sources,
            pixels,
            sums: vec![WeightedSums::default(); pixels.pixel_count() as usize],
        }
    }

    /// The pixels whose samples are taken.
    pub fn sources(&self) -> Window {
        self.sources
    }

    /// The sums, row by row.
    pub fn sums(&self) -> &[WeightedSums] {
        &self.sums
    }

    /// The sums, mutable.
    pub fn sums_mut(&mut self) -> &mut [WeightedSums] {
        &mut self.sums
    }

    /// The sums of a pixel, if it has any here.
    pub fn sums_of(&self, pixel: [u32; 2]) -> Option<&WeightedSums> {
        let is_here = self.pixels.contains(pixel);
        is_here.then(|| &self.sums[self.pixels.index(pixel)])
    }

    /// Adds samples with this index.
    pub fn add(&mut self, footprint: &Footprint, index: u64, samples: &SplattedSamples) {
        let border_size = footprint.border_size();
        let [x, y] = samples.pixels;
        // The pixel of the upper left corner of each footprint.
        let corners = std::array::from_fn(|lane| {
            let corner = [
                x[lane].wrapping_sub(border_size),
                y[lane].wrapping_sub(border_size),
            ];
            if samples.active.has(lane) {
                self.pixels.index(corner)
            } else {
                0
            }
        });
        let width = self.pixels.width as usize;
        add_samples(&mut self.sums, width, footprint, index, &corners, samples);
    }
}

vectorised! {
    /// Adds samples, given the place of the first pixel of each footprint.
    fn add_samples(
        sums: &mut [WeightedSums],
        width: usize,
        footprint: &Footprint,
        index: u64,
        corners: &Lanes<usize>,
        samples: &SplattedSamples,
    ) {
        // With a constant number of weights, loops are unrolled.
        match footprint.border_size() {
            1 => add_footprints::<3>(sums, width, footprint, index, corners, samples),
            2 => add_footprints::<5>(sums, width, footprint, index, corners, samples),
            3 => add_footprints::<7>(sums, width, footprint, index, corners, samples),
            _ => add_footprints::<9>(sums, width, footprint, index, corners, samples),
        }
    }
}

/// Adds samples whose footprint has `N` x `N` pixels.
#[inline(always)]
fn add_footprints<const N: usize>(
    sums: &mut [WeightedSums],
    width: usize,
    footprint: &Footprint,
    index: u64,
    corners: &Lanes<usize>,
    samples: &SplattedSamples,
) {
    for (lane, corner) in corners.iter().enumerate() {
        if !samples.active.has(lane) {
            continue;
        }
        let [r, g, b] = samples.radiance[lane].to_array();
        let at = |axis: usize| footprint.along_axis(samples.positions[axis][lane]);
        let [columns, rows] = [at(0), at(1)];
        for (row, of_row) in rows[..N].iter().enumerate() {
            let first = corner + row * width;
            for (sums, of_column) in sums[first..first + N].iter_mut().zip(&columns[..N]) {
                let weight = of_row * of_column;
                let terms = [weight * r, weight * g, weight * b, weight];
                sums.add_terms(index, terms.map(f64::from));
            }
        }
    }
}

/// The pixels whose samples a tile takes: its own, and at the edge of the film's window those beyond that contribute to it.
pub fn sources(window: Window, tile: Window, border_size: u32) -> Window {
    let beyond = |start: u32, end: u32, first: u32, last: u32| {
        [start == first, end == last].map(|is_edge| {
            if is_edge {
                planted!("no-samples-beyond-the-edge", 0, border_size)
            } else {
                0
            }
        })
    };
    let ends = |window: Window| [window.x + window.width, window.y + window.height];
    let ([right, bottom], [last_column, last_row]) = (ends(tile), ends(window));
    let [left, more_right] = beyond(tile.x, right, window.x, last_column);
    let [above, below] = beyond(tile.y, bottom, window.y, last_row);
    Window {
        x: tile.x.wrapping_sub(left),
        y: tile.y.wrapping_sub(above),
        width: tile.width + left + more_right,
        height: tile.height + above + below,
    }
}

/// The batch means of a pixel, given the sums of the tiles that contribute to it and the sample count of each, and the sample
/// count of its own tile.
pub fn batch_means<'a>(
    tiles: impl Iterator<Item = (&'a WeightedSums, u64)> + Clone,
    samples: u64,
) -> BatchMeans {
    let counts = samples_of_batches(samples);
    let is_even = tiles.clone().all(|(_, of_tile)| of_tile == samples);
    let mut means = [[0.0; 4]; BATCHES as usize];
    let mut add = |sums: &WeightedSums, counts: [u64; BATCHES as usize]| {
        for ((mean, sum), count) in means.iter_mut().zip(sums.values()).zip(counts) {
            for (mean, sum) in mean.iter_mut().zip(sum) {
                *mean += sum / count.max(1) as f64;
            }
        }
    };
    if planted!("splats-by-the-pixels-own-count", true, is_even) {
        // Exact sums, so that the division into tiles changes no bit.
        let mut all = WeightedSums::default();
        tiles.for_each(|(sums, _)| all.add_sums(sums));
        add(&all, counts);
    } else {
        tiles.for_each(|(sums, of_tile)| add(sums, samples_of_batches(of_tile)));
    }
    BatchMeans {
        means: std::array::from_fn(|batch| controlled(&means, batch, counts)),
        counts,
        are_black: means.map(|[r, g, b, _]| [r, g, b] == [0.0; 3]),
    }
}

/// The mean of a batch with its control variate, if the other batch of its half has samples.
fn controlled(
    means: &[[f64; 4]; BATCHES as usize],
    batch: usize,
    counts: [u64; BATCHES as usize],
) -> [f64; 3] {
    // Batches 0 and 2 are a half, and 1 and 3.
    let other = (batch + 2) % BATCHES as usize;
    let ([r, g, b, weight], [other_r, other_g, other_b, divisor]) = (means[batch], means[other]);
    if counts[batch] == 0 {
        return [0.0; 3];
    }
    if counts[other] == 0 {
        return [r, g, b];
    }
    let divisor = if divisor > MIN_WEIGHT { divisor } else { 1.0 };
    let control = |mean: f64, other: f64| mean - (weight - 1.0) * (other / divisor);
    [
        control(r, other_r),
        control(g, other_g),
        control(b, other_b),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sums(batches: [[f64; 4]; BATCHES as usize]) -> WeightedSums {
        let mut sums = WeightedSums::default();
        for (index, terms) in (0..).zip(batches) {
            sums.add_terms(index, terms);
        }
        sums
    }

    #[test]
    fn constant_radiance_is_exact_for_unequal_weights() {
        let grey = |weight: f64| [0.5 * weight, 2.0 * weight, 0.0, weight];
        let sums = sums([0.7, 1.4, 1.1, 0.3].map(grey));
        let batches = batch_means([(&sums, 4)].into_iter(), 4);
        for mean in batches.means {
            for (mean, exact) in mean.into_iter().zip([0.5, 2.0, 0.0]) {
                assert!((mean - exact).abs() < 1e-15, "{batches:?}");
            }
        }
        assert_eq!(batches.are_black, [false; 4]);
    }

    #[test]
    fn tile_sums_are_normalised_by_their_own_sample_count() {
        let of = |x: f64, weight: f64| sums([[x, x, x, weight]; 4]);
        // Half of the pixel's weight by 8 samples, two of each batch, half by 16 of four times the radiance.
        let [a, b] = [of(1.0, 1.0), of(8.0, 2.0)];
        let batches = batch_means([(&a, 8), (&b, 16)].into_iter(), 8);
        assert_eq!(batches.means, [[2.5; 3]; 4]);
    }

    #[test]
    fn batch_without_light_is_black_despite_its_control_variate() {
        let lit = [1.0, 1.0, 1.0, 1.2];
        let sums = sums([[0.0, 0.0, 0.0, 0.8], lit, lit, lit]);
        let batches = batch_means([(&sums, 4)].into_iter(), 4);
        assert_eq!(batches.are_black, [true, false, false, false]);
        assert!(batches.means[0][0] > 0.0);
    }
}
