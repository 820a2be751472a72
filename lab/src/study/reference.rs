//! Two independent references, neither of which is taken as exact.
//!
//! With references R1 and R2 and renders X1 and X2, all independent, the mean over pixels and channels of
//! w (X1 - R1)(X1 - R2) is an unbiased estimate of the squared error of X1, whatever the references' noise, and that of
//! w (X1 - R1)(X2 - R2) one of the squared bias. The weight w = 1 / (r^2 + eps), eps = 0.01 mean(r)^2, makes them relative;
//! r is the mean of both references.
//!
//! Measure: relMSE, without unit.
//! Range: images of one size, not all black. The noise of r in the weight changes the results by a relative amount of
//! about the references' own relMSE, equally for all variants; a squared bias by twice that over the bias.
//! Source: docs/accuracy.md, "The study". Tested below.

use etendue::internals::image::Image;
use etendue::internals::image::metrics::trimmed_mean;
use etendue::internals::image::tiles::ImageTile;
use rayon::prelude::*;
use std::ops::Range;

/// Number of pixels that one thread sums at a time.
const PART: usize = 8192;

/// The edge of the blocks of pixels whose noise is taken as independent, and the least number of blocks, for which small
/// images have smaller ones.
const BLOCK: f64 = 16.0;
const MIN_BLOCKS: f64 = 64.0;

/// The edge in pixels of the tiles over whose sums the correlation of neighbouring pixels is measured.
pub const TILE: u32 = 8;

/// Two references, and the weights that make errors relative.
#[derive(Debug, Clone)]
pub struct References {
    one: Image,
    two: Image,
    mean: Image,
    /// The weights of each channel of each pixel, not divided by their number.
    weights: Vec<[f64; 3]>,
}

/// The noise of the references.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct ReferenceNoise {
    /// The relMSE of each reference.
    pub rel_mse: f64,
    /// The standard deviation of the mean product of their errors, which all squared biases share.
    pub product_deviation: f64,
}

impl References {
    /// References of one size; `None` for black ones.
    pub fn new(one: Image, two: Image) -> Option<Self> {
        let pairs = one.pixels().iter().zip(two.pixels());
        let pixels = pairs.map(|(&a, &b)| 0.5 * (a + b)).collect();
        let mean = Image::new(one.width(), one.height(), pixels);
        let level = mean.mean().iter().sum::<f64>() / 3.0;
        let epsilon = 0.01 * level * level;
        let weight = |x: f32| 1.0 / (f64::from(x) * f64::from(x) + epsilon);
        let weights = mean.pixels().iter().map(|p| p.to_array().map(weight));
        let weights = weights.collect();
        (epsilon > 0.0).then_some(Self {
            one,
            two,
            mean,
            weights,
        })
    }

    /// The mean of both references.
    pub fn mean(&self) -> &Image {
        &self.mean
    }

    /// The weights of the channels of each pixel.
    pub fn weights(&self) -> &[[f64; 3]] {
        &self.weights
    }

    /// The mean of w (a - R1)(b - R2).
    pub fn product(&self, a: &Image, b: &Image) -> f64 {
        let count = self.weights.len();
        // Parts of a fixed size, so that the sum does not depend on the number of threads.
        let of_part = |part: usize| -> f64 {
            let pixels = part * PART..((part + 1) * PART).min(count);
            self.products(a, b, pixels).flatten().sum()
        };
        let parts = (0..count.div_ceil(PART)).into_par_iter().map(of_part);
        parts.collect::<Vec<f64>>().iter().sum::<f64>() / (3 * count) as f64
    }

    /// The relMSE of a render, and its mean without the largest 0.1 % of all pixels, which include the outliers.
    pub fn rel_mse(&self, image: &Image) -> [f64; 2] {
        let pixels = self.products(image, image, 0..self.weights.len());
        let pixels: Vec<f64> = pixels.map(|p| p.iter().sum::<f64>() / 3.0).collect();
        let all = pixels.iter().sum::<f64>() / pixels.len() as f64;
        [all, trimmed_mean(pixels)]
    }

    /// Estimates the noise of the references from their difference.
    pub fn noise(&self) -> ReferenceNoise {
        let (mut sum, mut squares) = (0.0, 0.0);
        for ((a, b), w) in self
            .one
            .pixels()
            .iter()
            .zip(self.two.pixels())
            .zip(&self.weights)
        {
            let [a, b] = [a, b].map(|pixel| pixel.to_array().map(f64::from));
            // The mean of (R1 - R2)^2 is twice the variance of one; for normal numbers, the mean of its square is three
            // times the square of its mean. The channels of a pixel share its paths: their noise is taken as equal, as that
            // of white light is. For independent channels, the deviation is 1.29 times too large.
            let variances = (0..3).map(|c| 0.5 * w[c] * (a[c] - b[c]).powi(2));
            let variance: f64 = variances.sum();
            sum += variance;
            squares += variance * variance / 3.0;
        }
        let count = (3 * self.weights.len()) as f64;
        // The variance of the sum of products is that of w_i w_j C_ij^2 over all pairs of pixels, with C their covariance:
        // at most that of single pixels times the correlation, as the squares of correlations are at most themselves.
        ReferenceNoise {
            rel_mse: sum / count,
            product_deviation: (self.correlation() * squares).sqrt() / count,
        }
    }

    /// The variance of sums over tiles, over that of independent pixels: above 1, as a sample is splatted to several
    /// neighbours.
    pub fn correlation(&self) -> f64 {
        let width = self.one.width();
        let (mut of_sums, mut of_pixels) = (0.0, 0.0);
        for tile in ImageTile::all(width, self.one.height(), TILE) {
            let mut sums = [0.0; 3];
            for index in tile.indices(width) {
                let [a, b] = [&self.one, &self.two].map(|it| it.pixels()[index].to_array());
                for c in 0..3 {
                    let difference = f64::from(a[c]) - f64::from(b[c]);
                    let relative = self.weights[index][c].sqrt() * difference;
                    sums[c] += relative;
                    of_pixels += relative * relative;
                }
            }
            of_sums += sums.iter().map(|sum| sum * sum).sum::<f64>();
        }
        match of_pixels > 0.0 {
            true => f64::max(of_sums / of_pixels, 1.0),
            false => 1.0,
        }
    }

    /// The standard error of the mean luminance of both, from their differences in blocks of pixels: a splat adds to several
    /// neighbours, whose noise is thus not independent.
    pub fn luminance_error(&self) -> f64 {
        let (width, height) = (self.one.width(), self.one.height());
        let pixels = self.weights.len() as f64;
        let edge = (pixels / MIN_BLOCKS).sqrt().floor().clamp(1.0, BLOCK);
        let squares = ImageTile::all(width, height, edge as u32).map(|block| {
            let differences = block.indices(width).map(|index| {
                let [a, b] = [&self.one, &self.two].map(|it| it.pixels()[index]);
                0.5 * f64::from(a.luminance() - b.luminance())
            });
            differences.sum::<f64>().powi(2)
        });
        squares.sum::<f64>().sqrt() / pixels
    }

    /// The variance of the mean of both, by pixel and channel: from a single difference each, hence imprecise.
    pub fn variance_of_mean(&self) -> Vec<[f64; 3]> {
        let pairs = self.one.pixels().iter().zip(self.two.pixels());
        let of_pixel = |(a, b): (
            &etendue::internals::math::rgb::Rgb,
            &etendue::internals::math::rgb::Rgb,
        )| {
            let [a, b] = [a, b].map(|pixel| pixel.to_array().map(f64::from));
            std::array::from_fn(|c| 0.25 * (a[c] - b[c]).powi(2))
        };
        pairs.map(of_pixel).collect()
    }

    fn products<'a>(
        &'a self,
        a: &'a Image,
        b: &'a Image,
        pixels: Range<usize>,
    ) -> impl Iterator<Item = [f64; 3]> + 'a {
        let images = [a, b, &self.one, &self.two];
        let [a, b, one, two] = images.map(|image| image.pixels()[pixels.clone()].iter());
        let all = a.zip(b).zip(one.zip(two)).zip(&self.weights[pixels]);
        all.map(|(((a, b), (r1, r2)), w)| {
            let [a, b, r1, r2] = [a, b, r1, r2].map(|pixel| pixel.to_array().map(f64::from));
            std::array::from_fn(|c| w[c] * (a[c] - r1[c]) * (b[c] - r2[c]))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::bootstrap::Dealer;
    use super::*;
    use etendue::internals::math::rgb::Rgb;
    use etendue::internals::math::stats::{Moments, normal_quantile};

    fn grey(values: &[f32]) -> Image {
        let pixels = values.iter().map(|&x| Rgb::grey(x)).collect();
        Image::new(values.len() as u32, 1, pixels)
    }

    #[test]
    fn rel_mse_matches_formula_and_black_references_give_none() {
        let references = References::new(grey(&[0.9, 2.1]), grey(&[1.1, 1.9])).expect("light");
        // r is 1 and 2, its mean 1.5.
        let epsilon = 0.01 * 1.5 * 1.5;
        let image = grey(&[1.5, 2.0]);
        let expected = (0.6 * 0.4 / (1.0 + epsilon) - 0.1 * 0.1 / (4.0 + epsilon)) / 2.0;
        let [all, trimmed] = references.rel_mse(&image);
        assert!((references.product(&image, &image) - expected).abs() < 1e-7);
        assert!((all - expected).abs() < 1e-7);
        // With two pixels, none are the worst 0.1 %.
        assert_eq!(trimmed, all);
        let noise = references.noise().rel_mse;
        let expected = 0.5 * (0.04 / (1.0 + epsilon) + 0.04 / (4.0 + epsilon)) / 2.0;
        assert!((noise - expected).abs() < 1e-7, "{noise} {expected}");
        assert!(References::new(grey(&[0.0]), grey(&[0.0])).is_none());
    }

    fn normal(dealer: &mut Dealer) -> f32 {
        let uniform = (dealer.below(1 << 40) as f64 + 0.5) / (1_u64 << 40) as f64;
        normal_quantile(uniform) as f32
    }

    /// A square image of mean 1 in which squares of this edge share their noise, as splats do.
    fn splatted(dealer: &mut Dealer, side: usize, edge: usize) -> Image {
        let across = side / edge;
        let splats: Vec<f32> = (0..across * across).map(|_| normal(dealer)).collect();
        let pixel = |i: usize| splats[i / side / edge * across + i % side / edge];
        let pixels = (0..side * side).map(|i| Rgb::grey(1.0 + 0.1 * pixel(i)));
        Image::new(side as u32, side as u32, pixels.collect())
    }

    #[test]
    fn shared_noise_of_grey_references_has_the_stated_deviation() {
        let mut dealer = Dealer::new(1);
        let exact = Image::filled(48, 48, Rgb::grey(1.0));
        for edge in [1, 2] {
            let (mut products, mut stated) = (Moments::default(), Moments::default());
            for _ in 0..1500 {
                let mut image = || splatted(&mut dealer, 48, edge);
                let references = References::new(image(), image()).expect("light");
                // The exact image has no error but that of the references.
                products.push(references.product(&exact, &exact));
                stated.push(references.noise().product_deviation.powi(2));
            }
            let ratio = stated.mean() / products.variance().expect("many");
            // The variance of 1500 numbers is known to 4 %, and a correlation below 1 counts as 1; independent channels
            // would have a third of the variance, independent pixels a quarter of that of edge 2.
            assert!((0.85..1.25).contains(&ratio), "{edge}: {ratio}");
        }
    }

    #[test]
    fn luminance_error_includes_noise_that_neighbours_share() {
        let mut dealer = Dealer::new(2);
        let (mut means, mut stated) = (Moments::default(), Moments::default());
        for _ in 0..300 {
            let mut image = || splatted(&mut dealer, 64, 2);
            let references = References::new(image(), image()).expect("light");
            means.push(references.mean().mean()[0]);
            stated.push(references.luminance_error().powi(2));
        }
        let ratio = stated.mean() / means.variance().expect("many");
        // The variance of 300 numbers is known to 8 %; independent pixels would have a quarter of it.
        assert!((0.7..1.4).contains(&ratio), "{ratio}");
    }
}
