//! The error of an image: the root of relMSE, estimated from its own batches, and an upper confidence bound.
//!
//! relMSE is the mean over pixels and channels of (x - r)^2 / (r^2 + eps), eps = 0.01 mean(r)^2, with x the image and
//! r the truth. The expectation of (x - r)^2 is the variance v of the pixel's mean. With x in place of r, a bright
//! sample would raise both v and x^2 and so hide its own error. Therefore v is taken from one half of the batches and
//! r from the other, both ways, and E is the mean of both (`relative_variance.rs`).
//!
//! **The bound.** It starts from an estimate that is not corrected for the noise of r, which lies above E on average.
//! e_even and e_odd of a block of pixels estimate the same value from different samples. Their differences give the
//! variance of E without a model of how the error varies over the image, and blocks contain the correlation of
//! neighbours, also of those that share samples: blocks grow with the border size. The squared error of this one
//! image varies about its expectation with twice the variance of the halves' mean, if pixels are normal, and less where
//! few bright samples dominate, which are in both x and v. Together: 3/4 of the sum of squared differences. A sample that
//! is there by chance adds a term that neither half can estimate; [`LARGEST_SAMPLE_SHARE`] times the largest of these
//! terms widens the bound, in quadrature.
//!
//! Four batches give a pixel's variance with three degrees of freedom: the squared error of a normal pixel is below ten
//! times its estimated variance with a confidence of 95 %, by the quantile of F(1, 3). Where one pixel has much of the
//! squared error, its block's difference may be small by chance, and does not show this uncertainty. Therefore
//! [`LARGEST_PIXEL_SHARE`] of that quantile times the largest term of a pixel widens the bound, in quadrature. Where
//! bright samples are so rare that the noise of r is large, the correction that the bound leaves out suffices: the bound
//! contains whichever of both is larger.
//!
//! Where the samples give no upper bound, there is a lower one (`doubt.rs`).
//!
//! Measure: roots of relMSE, without unit.
//! Range: images with a sample in each batch of every pixel, neither half of which is black.
//! Source: docs/accuracy.md, "The error that is printed", has the measurements behind the constants. Tested below.

use super::Film;
use super::batches::BATCHES;
use super::doubt::Doubt;
use super::relative_variance::RelativeVariances;
use crate::math::functions::hypot;
use crate::math::stats::{student_quantile, student_quantile_of};
use crate::planted::planted;

/// The estimated error of an image and its upper bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorEstimate {
    /// The estimated root of relMSE.
    pub rel_rmse: f64,
    /// The relative standard error of the estimated relMSE.
    pub uncertainty: f64,
    /// The bias that the noise of the denominators may have left in the estimated relMSE: how much larger it is with
    /// nothing done against it, over the estimated relMSE.
    pub bias: f64,
    /// The largest term that a single sample may have in relMSE, over the estimated relMSE.
    pub largest_sample: f64,
    /// The largest term of a pixel in relMSE, with those of the pixels that share its samples, over the estimated relMSE.
    pub largest_pixel: f64,
    /// The probability that the root of relMSE is below [`upper_bound`](Self::upper_bound).
    pub confidence: f64,
    /// The upper bound of the root of relMSE; infinite where the samples give none.
    pub upper_bound: f64,
    /// The reason why there is no upper bound.
    pub doubt: Option<Doubt>,
}

/// The relative bias of the squared error that the assumptions behind its estimate may cause, beyond
/// [`ErrorEstimate::bias`].
const MODEL_ERROR: f64 = 0.03;

/// The least value of the bound: radiance is computed in single precision, whose rounding does not appear as noise.
const ROUNDING: f64 = 1e-6;

/// The share of the largest single sample's term in the margin of the bound. Measured: with 1/8, bounds in scenes with
/// rare bright samples (shaded-lamps by `bdpt`) fail by up to 3 %.
const LARGEST_SAMPLE_SHARE: f64 = 1.0 / 6.0;

/// The factor of F's quantile for the largest pixel in the margin of the bound, less than 1 since the largest of many estimated
/// variances is likely to be too large. Measured with normal pixels, one of which has 5 to 35 % of the squared error: 91 to
/// 94 % of the bounds hold, and without this margin 83 to 90 %.
const LARGEST_PIXEL_SHARE: f64 = 0.4;

impl Film {
    /// The memory that [`Film::error`] takes for a while, in bytes per pixel, at most: planes of each channel, and relative
    /// variances in double precision. Images and error bars take less.
    pub const WORKING_MEMORY: u64 = 400;

    /// Estimates the error of the image, with an upper bound of this confidence. `None` before every pixel has a
    /// sample in each batch, and if either half of the batches is black.
    pub fn error(&self, confidence: f64) -> Option<ErrorEstimate> {
        let parts = RelativeVariances::of(self)?;
        let differences = parts.block_differences();
        let [second, fourth] = [2, 4].map(|power| {
            let powers = differences.iter().map(|difference| difference.powi(power));
            powers.sum::<f64>()
        });
        let mse = parts.mean();
        let relative = |term: f64| if mse > 0.0 { term / mse } else { 0.0 };
        let standard_error = (0.75 * second).sqrt();
        let allowances = Allowances {
            uncertainty: relative(standard_error),
            bias: relative(parts.upper_mean - mse),
            largest_sample: relative(parts.largest_sample),
            largest_pixel: relative(parts.largest_pixel),
        };
        let estimate = |upper_bound, doubt| ErrorEstimate {
            rel_rmse: mse.sqrt(),
            uncertainty: allowances.uncertainty,
            bias: allowances.bias,
            largest_sample: allowances.largest_sample,
            largest_pixel: allowances.largest_pixel,
            confidence,
            upper_bound,
            doubt,
        };
        if second == 0.0 {
            // All batches are equal.
            let bound = (parts.upper_mean + MODEL_ERROR * mse).sqrt();
            return Some(estimate(hypot(bound, ROUNDING), None));
        }
        // Degrees of freedom: those of as many equal blocks. Of n of them, the squares have this ratio 3 / (n + 2) on
        // average.
        let freedom = (3.0 * second * second / fourth - 2.0).max(1.0);
        let doubt = Doubt::of(&parts, standard_error);
        let bound = match doubt {
            Some(_) => f64::INFINITY,
            None => {
                let bound = mse * allowances.relative_bound(confidence, freedom);
                hypot(bound.max(0.0).sqrt(), ROUNDING)
            }
        };
        Some(estimate(bound, doubt))
    }
}

/// The sources of uncertainty of an image's squared error that its upper bound allows for, each over the estimated squared error.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Allowances {
    /// See [`ErrorEstimate::uncertainty`].
    pub(crate) uncertainty: f64,
    /// See [`ErrorEstimate::bias`].
    pub(crate) bias: f64,
    /// See [`ErrorEstimate::largest_sample`].
    pub(crate) largest_sample: f64,
    /// See [`ErrorEstimate::largest_pixel`].
    pub(crate) largest_pixel: f64,
}

impl Allowances {
    /// The bound of the squared error with this confidence over its estimate, whose standard error has `freedom` degrees of
    /// freedom.
    pub(crate) fn relative_bound(&self, confidence: f64, freedom: f64) -> f64 {
        let spread = student_quantile_of(freedom, confidence) * self.uncertainty;
        let margin = if spread > 0.0 {
            let spread = hypot(spread, LARGEST_SAMPLE_SHARE * self.largest_sample);
            // The quantile of F(1, 3) is the square of a two-sided quantile of Student's t.
            let quantile = student_quantile(BATCHES, confidence).powi(2);
            let share = planted!("variance-of-a-pixel-known", 0.0, LARGEST_PIXEL_SHARE);
            (self.bias + spread).max(hypot(spread, share * quantile * self.largest_pixel))
        } else {
            self.bias + spread
        };
        1.0 + MODEL_ERROR + margin
    }
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::{TestRandom, film};
    use super::*;

    const SIZE: (u32, u32) = (64, 48);

    /// A room: brighter to the right, with a border to a part that is a tenth as bright.
    fn light(pixel: usize) -> f64 {
        let (x, y) = (pixel % SIZE.0 as usize, pixel / SIZE.0 as usize);
        let slope = 0.2 + x as f64 / 64.0;
        if y < 20 { slope } else { 0.1 * slope }
    }

    /// Noise with a standard deviation equal to the mean.
    fn noisy(pixel: usize, numbers: &mut TestRandom) -> f64 {
        light(pixel) * (1.0 + numbers.normal())
    }

    /// One sample in a hundred carries half of the light.
    fn rare(pixel: usize, numbers: &mut TestRandom) -> f64 {
        let event = if numbers.uniform() < 0.01 { 50.0 } else { 0.0 };
        light(pixel) * (0.5 + 0.2 * numbers.normal() + event)
    }

    /// The root of relMSE, given the truth.
    fn true_error(film: &Film, light: impl Fn(usize) -> f64) -> f64 {
        let mean = (0..film.pixel_count()).map(&light).sum::<f64>() / film.pixel_count() as f64;
        let picture = film.develop();
        let squares = picture.pixels().iter().enumerate().map(|(pixel, x)| {
            let r = light(pixel);
            (f64::from(x.to_array()[0]) - r).powi(2) / (r * r + 0.01 * mean * mean)
        });
        (squares.sum::<f64>() / film.pixel_count() as f64).sqrt()
    }

    /// The mean estimated error over the mean true error of 60 images with this sample count, and the number of
    /// bounds that hold.
    fn estimated_over_true(sample: fn(usize, &mut TestRandom) -> f64, samples: u64) -> (f64, u32) {
        let (mut estimated, mut truth, mut held) = (0.0, 0.0, 0);
        for seed in 0..60 {
            let film = film(SIZE, samples, seed, sample);
            let error = film.error(0.95).expect("it has samples");
            let exact = true_error(&film, light);
            estimated += error.rel_rmse;
            truth += exact;
            held += u32::from(exact <= error.upper_bound);
        }
        (estimated / truth, held)
    }

    #[test]
    fn error_estimate_matches_true_error_and_bound_has_coverage() {
        // Of 60 bounds that hold with 95 %, fewer than 52 do with probability 2e-3; ours hold more often.
        for (samples, tolerance) in [(16, 0.12), (64, 0.04), (256, 0.04)] {
            let (ratio, held) = estimated_over_true(noisy, samples);
            println!("noisy, {samples}: {ratio:.3}, {held} of 60");
            assert!((ratio - 1.0).abs() < tolerance, "{samples}: {ratio}");
            assert!(held >= 54, "{samples}: {held} of 60");
        }
    }

    #[test]
    fn error_estimate_and_bound_hold_with_rare_bright_samples() {
        for samples in [64, 256] {
            let (ratio, held) = estimated_over_true(rare, samples);
            println!("rare, {samples}: {ratio:.3}, {held} of 60");
            assert!((ratio - 1.0).abs() < 0.1, "{samples}: {ratio}");
            assert!(held >= 54, "{samples}: {held} of 60");
        }
    }

    #[test]
    fn reported_bias_is_that_of_noise_comparable_to_the_truth() {
        let bias = |samples, sample: fn(usize, &mut TestRandom) -> f64| {
            let film = film(SIZE, samples, 7, sample);
            film.error(0.95).expect("it has samples").bias
        };
        // The noise of a half, 2 / 256 of the truth's square, is far below a sixth of it.
        assert!((0.0..0.001).contains(&bias(256, noisy)));
        // Seven of ten halves have no bright sample, so that their squared mean is a quarter of the truth's; nothing done against
        // it, the estimate is 2.9 times as large.
        let rare = bias(64, rare);
        assert!((1.0..3.0).contains(&rare), "{rare}");
    }

    #[test]
    fn noise_of_emitter_edges_does_not_hide_that_of_dark_neighbours() {
        // Half of each pixel's samples in every eighth column meet a lamp, forty times as bright as its surroundings.
        let is_edge = |pixel: usize| pixel % 8 == 3;
        let truth = |pixel: usize| if is_edge(pixel) { 20.0 } else { 1.0 };
        let edge = |pixel: usize, numbers: &mut TestRandom| match is_edge(pixel) {
            true if numbers.uniform() < 0.5 => 40.0,
            true => 0.0,
            false => 1.0 + numbers.normal(),
        };
        let (mut estimated, mut exact) = (0.0, 0.0);
        for seed in 0..10 {
            let film = film(SIZE, 64, seed, edge);
            estimated += film.error(0.95).expect("it has samples").rel_rmse;
            exact += true_error(&film, truth);
        }
        let ratio = estimated / exact;
        assert!((0.93..1.03).contains(&ratio), "{ratio}");
    }

    #[test]
    fn emitter_edge_is_not_mistaken_for_a_single_sample_outlier() {
        // Half of each pixel's samples in column 10 meet a lamp, a thousand times as bright as its surroundings.
        let is_edge = |pixel: usize| pixel % SIZE.0 as usize == 10;
        let edge = |pixel: usize, numbers: &mut TestRandom| match is_edge(pixel) {
            true if numbers.uniform() < 0.5 => 1000.0,
            true => 0.0,
            false => 1.0 + 0.1 * numbers.normal(),
        };
        for seed in 0..10 {
            let film = film(SIZE, 1024, seed, edge);
            let error = film.error(0.95).expect("it has samples");
            assert!(error.largest_sample < 1.0, "{error:?}");
            assert_eq!(error.doubt, None);
        }
    }

    #[test]
    fn error_estimate_holds_when_batches_miss_an_emitter_edge() {
        // One in four samples of column 10 meets a lamp: of its 192 batches of 16 samples, two miss it on average.
        let is_edge = |pixel: usize| pixel % SIZE.0 as usize == 10;
        let truth = |pixel: usize| if is_edge(pixel) { 251.0 } else { 1.0 };
        let edge = |pixel: usize, numbers: &mut TestRandom| match is_edge(pixel) {
            true if numbers.uniform() < 0.25 => 1001.0,
            _ => 1.0 + 0.1 * numbers.normal(),
        };
        for seed in 0..10 {
            let film = film(SIZE, 64, seed, edge);
            let error = film.error(0.95).expect("it has samples");
            let exact = true_error(&film, truth);
            let ratio = error.rel_rmse / exact;
            println!("{seed}: {ratio:.3}");
            assert!((0.7..1.6).contains(&ratio), "{error:?} of {exact}");
        }
    }

    #[test]
    fn bound_holds_where_one_pixel_has_much_of_the_error() {
        // A tenth of the squared error is in one pixel.
        let share = 0.1;
        let of_pixel = (share / (1.0 - share) * f64::from(SIZE.0 * SIZE.1 - 1)).sqrt();
        let normal = |pixel: usize, numbers: &mut TestRandom| {
            let deviation = if pixel == 700 { of_pixel } else { 1.0 };
            1000.0 + deviation * numbers.normal()
        };
        let images = 1000;
        let held = (0..images).filter(|&seed| {
            let film = film(SIZE, 4, seed, normal);
            let error = film.error(0.95).expect("it has samples");
            true_error(&film, |_| 1000.0) <= error.upper_bound
        });
        // 92 % hold; with the variance of that pixel taken as known, 86 %. Either is three standard deviations from 895 of 1000.
        let held = held.count();
        println!("{held} of {images}");
        assert!(held >= 895, "{held} of {images}");
    }

    #[test]
    fn one_bright_pixel_leaves_only_a_lower_error_bound() {
        let bright = |pixel: usize, numbers: &mut TestRandom| {
            let is_lamp = pixel == 700 && numbers.uniform() < 0.02;
            light(pixel)
                + if is_lamp {
                    1e4
                } else {
                    0.01 * numbers.normal()
                }
        };
        let truth = |pixel: usize| light(pixel) + if pixel == 700 { 200.0 } else { 0.0 };
        let (mut doubts, mut held) = (0, 0);
        for seed in 0..20 {
            let film = film(SIZE, 64, seed, bright);
            let error = film.error(0.95).expect("it has samples");
            let Some(doubt) = error.doubt else {
                continue;
            };
            doubts += 1;
            assert!(error.upper_bound.is_infinite());
            if let Doubt::FewPixels { pixels, share, .. } = doubt {
                assert!(pixels < 0.05 && share >= 0.5, "{doubt:?}");
            }
            // The other pixels remain: 0.01 over 8, relative to light from 0.02 to 1.2.
            let least = doubt.at_least();
            assert!((0.0003..0.06).contains(&least), "{doubt:?}");
            held += u32::from(least <= true_error(&film, truth));
        }
        // One sample in fifty is bright: most of the images have one.
        assert!(doubts >= 10 && held + 3 >= doubts, "{held} of {doubts}");
    }

    #[test]
    fn noise_free_image_has_no_error_and_black_image_no_estimate() {
        let exact = film(SIZE, 16, 0, |pixel, _| light(pixel));
        let error = exact.error(0.95).expect("it has samples");
        // Sums of equal numbers are rounded, and samples are exact only to single precision.
        assert!(
            error.rel_rmse < 1e-6 && (1e-6..2e-6).contains(&error.upper_bound),
            "{error:?}"
        );
        assert_eq!(error.doubt, None);
        assert!(film(SIZE, 16, 0, |_, _| 0.0).error(0.95).is_none());
        assert!(film(SIZE, 3, 0, |_, _| 1.0).error(0.95).is_none());
    }

    #[test]
    fn error_estimate_is_invariant_to_exposure() {
        let error = |scale: f64| {
            let film = film(SIZE, 32, 3, |pixel, numbers| scale * rare(pixel, numbers));
            film.error(0.9).expect("it has samples")
        };
        let [a, b] = [1.0, 1e-12].map(error);
        for (a, b) in [(a.rel_rmse, b.rel_rmse), (a.upper_bound, b.upper_bound)] {
            assert!((a / b - 1.0).abs() < 1e-4, "{a} {b}");
        }
    }
}
