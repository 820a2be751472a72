//! How wrong a picture is: the root of relMSE, estimated from its own batches, and a bound that it is below.
//!
//! relMSE is the mean over pixels and channels of (x - r)^2 / (r^2 + eps), eps = 0.01 mean(r)^2, with x the picture and r the
//! truth. The expectation of (x - r)^2 is the variance v of the pixel's mean. Were r replaced by x, a bright sample would
//! raise both v and x^2 and excuse itself. So v is taken from one half of the batches and r from the other, both ways:
//!
//!   E = (e_even + e_odd) / 2,   e_half = mean of v_half / (r_other^2 + eps_other).
//!
//! r_other is the other half's picture, smoothed as far as its own noise asks for (`local_truth.rs`). What noise is left in it
//! makes E too large, by nearly as much again if r comes from one batch of the other half instead of two, Q: the
//! noise doubles. E^2 / Q is free of that in the first order (Richardson).
//!
//! **The bound.** e_even and e_odd of a block of pixels know the same truth by different numbers: their differences tell the
//! variance of E without a model of how the error varies over the picture, and blocks hold what correlates neighbours. The
//! squared error of this one picture varies about its expectation by twice the variance that both halves' mean has, if
//! pixels are normal, and less where few bright samples rule, which are in x and in v alike. Together: 3/4 of the sum of
//! squared differences.
//!
//! **What cannot be told.** Where a few pixels rule the differences, so that E is not known to within [`UNRESOLVED`], or one
//! sample alone could be more than [`OUTSHINING`] times the whole squared error if it came by chance to where it is, a
//! truth with rare bright paths and one without cannot be told apart by these samples. Then there is no bound, and what is
//! said is a lower one.
//!
//! Measure: roots of relMSE, without unit.
//! Range: pictures with a sample in each batch of every pixel, neither half of which is black.
//! Source: docs/accuracy.md, "The error that is printed", has the measurements behind the constants. Tested below.

use super::Film;
use super::batches::{BATCHES, BatchMeans, Half};
use super::local_truth::{Smoothed, local_truth};
use crate::math::plane::Plane;
use crate::math::stats::student_quantile_of;
use crate::planted::planted;

/// How far the picture is likely to be from the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorEstimate {
    /// Estimated root of relMSE.
    pub rel_rmse: f64,
    /// The relative standard error of its square.
    pub uncertainty: f64,
    /// The probability that the root of relMSE is below [`upper_bound`](Self::upper_bound).
    pub confidence: f64,
    /// The bound of that confidence; infinite where there is none that the samples can tell.
    pub upper_bound: f64,
    /// Why there is no bound.
    pub doubt: Option<Doubt>,
}

/// Why a picture's samples do not tell how large its error is, and the root of relMSE that it has at least.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Doubt {
    /// Bright samples in a few pixels hold most of what is uncertain. The lower bound is that of the other pixels.
    FewPixels {
        /// The lower bound.
        at_least: f64,
        /// The share of these pixels.
        pixels: f64,
        /// The share of the squared error that they hold.
        share: f64,
    },
    /// A single sample may be more than the whole squared error as estimated.
    OneSample {
        /// The lower bound.
        at_least: f64,
        /// How many times as much.
        times: f64,
    },
    /// The error has not fallen as it should since an earlier look.
    Rising {
        /// The lower bound.
        at_least: f64,
        /// Samples per pixel at that look.
        samples: f64,
        /// The root of relMSE as estimated then.
        rel_rmse: f64,
    },
}

impl Doubt {
    /// The root of relMSE is at least this.
    pub fn at_least(&self) -> f64 {
        match *self {
            Self::FewPixels { at_least, .. }
            | Self::OneSample { at_least, .. }
            | Self::Rising { at_least, .. } => at_least,
        }
    }
}

/// The edge of the blocks whose differences tell the uncertainty, in pixels.
const BLOCK: usize = 8;

/// Blocks are smaller where there would be fewer of them than this.
const LEAST_BLOCKS: usize = 32;

/// What smoothing and extrapolation may leave of the squared error: the greatest bias of the gallery's pictures is 3 %.
const MODEL_ERROR: f64 = 0.03;

/// The relative standard error of the squared error from which on it counts as unknown.
const UNRESOLVED: f64 = 0.4;

/// Standard errors from the squared error to its lower bound: 95 %, one-sided.
const SURE: f64 = 1.645;

/// Pixels are few up to this share.
const MOST_PIXELS: f64 = 0.05;

/// How many times the whole squared error a single sample may be, at most.
const OUTSHINING: f64 = 2.0;

impl Film {
    /// The estimated error of the picture, with an upper bound of this confidence. `None` before every pixel has a sample in
    /// each batch, and for a picture of which half the samples are black.
    pub fn error(&self, confidence: f64) -> Option<ErrorEstimate> {
        let parts = RelativeVariances::of(self)?;
        let differences = parts.block_differences();
        let [second, fourth] = [2, 4].map(|power| {
            let powers = differences.iter().map(|difference| difference.powi(power));
            powers.sum::<f64>()
        });
        let mse = parts.mean();
        let estimate = |upper_bound, doubt| ErrorEstimate {
            rel_rmse: mse.sqrt(),
            uncertainty: if mse > 0.0 {
                (0.75 * second).sqrt() / mse
            } else {
                0.0
            },
            confidence,
            upper_bound,
            doubt,
        };
        if second == 0.0 {
            // All batches are alike.
            return Some(estimate(((1.0 + MODEL_ERROR) * mse).sqrt(), None));
        }
        let standard_error = (0.75 * second).sqrt();
        // Satterthwaite: as many degrees of freedom as equal blocks would be.
        let freedom = 3.0 * second * second / fourth;
        let doubt = parts.doubt(standard_error);
        let bound = match doubt {
            Some(_) => f64::INFINITY,
            None => {
                let margin = student_quantile_of(freedom, confidence) * standard_error;
                ((1.0 + MODEL_ERROR) * mse + margin).max(0.0).sqrt()
            }
        };
        Some(estimate(bound, doubt))
    }
}

/// The variance of each pixel's mean over the squared truth, as either half of the batches tells it.
struct RelativeVariances {
    width: usize,
    /// Means over the channels: the variance by the even batches, and by the odd ones.
    halves: [Vec<f64>; 2],
    /// What they are to be multiplied with, for the noise of the denominators.
    extrapolation: f64,
    /// The largest squared error that one sample of a pixel could be by itself, summed as relMSE is.
    largest_sample: f64,
}

impl RelativeVariances {
    fn of(film: &Film) -> Option<Self> {
        if !film.has_all_batches() {
            return None;
        }
        let width = film.window.width as usize;
        let count = film.pixel_count();
        let means = Half::ALL.map(|half| mean_of_half(film, half));
        if means.iter().any(|&mean| mean <= 0.0) {
            return None;
        }
        // Single precision serves, in units of the picture's mean.
        let unit = 0.5 * (means[0] + means[1]);
        let epsilons = means.map(|mean| (0.01 * (mean / unit) * (mean / unit)) as f32);
        let mut halves = [vec![0.0; count], vec![0.0; count]];
        let mut of_quarters = 0.0;
        let mut largest = vec![0.0; count];
        for c in 0..3 {
            let channel = Channel::of(film, c, unit)?;
            for (index, half) in Half::ALL.into_iter().enumerate() {
                let other = planted!("denominator-of-the-same-half", half, half.other());
                let epsilon = epsilons[other as usize];
                let variance = &channel.variances[half as usize];
                let (of_half, of_batches) = channel.truths(other);
                for (sum, relative) in halves[index]
                    .iter_mut()
                    .zip(relative(variance, &of_half, epsilon))
                {
                    *sum += relative / 3.0;
                }
                for truth in of_batches {
                    of_quarters += relative(variance, &truth, epsilon).sum::<f64>();
                }
            }
            let epsilon = 0.5 * (epsilons[0] + epsilons[1]);
            let darkest = channel.whole_truth().box_min(1);
            let darkest = darkest.like(|i| darkest.values[i].max(0.0));
            for (sum, relative) in
                largest
                    .iter_mut()
                    .zip(relative(&channel.largest_sample, &darkest, epsilon))
            {
                *sum += relative / 3.0;
            }
        }
        // Of three channels, two halves and two batches of each.
        let of_quarters = of_quarters / (12 * count) as f64;
        let of_halves = 0.5 * (sum(&halves[0]) + sum(&halves[1])) / count as f64;
        Some(Self {
            width,
            halves,
            extrapolation: if of_quarters > 0.0 {
                of_halves / of_quarters
            } else {
                1.0
            },
            largest_sample: largest.into_iter().fold(0.0, f64::max) / count as f64,
        })
    }

    fn count(&self) -> f64 {
        self.halves[0].len() as f64
    }

    /// The estimate of relMSE.
    fn mean(&self) -> f64 {
        let both = 0.5 * (sum(&self.halves[0]) + sum(&self.halves[1]));
        self.extrapolation * both / self.count()
    }

    /// What the blocks of the picture add to the difference of both halves' estimates.
    fn block_differences(&self) -> Vec<f64> {
        let [width, height] = [self.width, self.halves[0].len() / self.width];
        let blocks = |edge: usize| width.div_ceil(edge) * height.div_ceil(edge);
        let mut edge = BLOCK;
        while edge > 1 && blocks(edge) < LEAST_BLOCKS {
            edge /= 2;
        }
        let across = width.div_ceil(edge);
        let mut differences = vec![0.0; blocks(edge)];
        for index in 0..self.halves[0].len() {
            let block = index / width / edge * across + index % width / edge;
            differences[block] += self.difference(index);
        }
        differences
    }

    fn difference(&self, index: usize) -> f64 {
        let [even, odd] = [self.halves[0][index], self.halves[1][index]];
        self.extrapolation * (even - odd) / self.count()
    }

    /// What a pixel adds to the estimate.
    fn part(&self, index: usize) -> f64 {
        let both = self.halves[0][index] + self.halves[1][index];
        0.5 * self.extrapolation * both / self.count()
    }

    /// Whether few pixels have too much of the error for it to be known.
    ///
    /// The lower bound is the best of those that leave the pixels out that hold most of the error, as many as it takes.
    fn doubt(&self, standard_error: f64) -> Option<Doubt> {
        let mse = self.mean();
        let outshining = self.largest_sample / mse;
        let is_unresolved = standard_error > UNRESOLVED * mse;
        if !is_unresolved && outshining <= OUTSHINING {
            return None;
        }
        let mut pixels: Vec<usize> = (0..self.halves[0].len()).collect();
        // The largest first; equal ones in the order of the picture.
        pixels.sort_by(|&a, &b| self.part(b).total_cmp(&self.part(a)).then(a.cmp(&b)));
        let (mut rest, mut squares) = (0.0, 0.0);
        let (mut best, mut left_out, mut share) = (0.0, 0, 0.0);
        // From the smallest on: a sum less its largest part would leave nothing but rounding.
        for (place, &index) in pixels.iter().enumerate().rev() {
            rest += self.part(index);
            squares += self.difference(index).powi(2);
            let bound = rest - SURE * (0.75 * squares).sqrt();
            if bound > best {
                (best, left_out, share) = (bound, place, 1.0 - rest / mse);
            }
        }
        // What is left out may have ruled the extrapolation, which else makes an error smaller.
        let of_others = self.extrapolation.min(1.0) / self.extrapolation;
        let at_least = (of_others * best).sqrt();
        let are_few = left_out as f64 <= MOST_PIXELS * self.count();
        if is_unresolved && are_few && left_out > 0 {
            Some(Doubt::FewPixels {
                at_least,
                pixels: left_out as f64 / self.count(),
                share,
            })
        } else if outshining > OUTSHINING {
            Some(Doubt::OneSample {
                at_least,
                times: outshining,
            })
        } else {
            // A small picture, or light in a small part of it: the bound is wide, and holds.
            None
        }
    }
}

/// One channel of a film in units of the picture's mean.
struct Channel {
    batches: [Plane; BATCHES as usize],
    halves: [Smoothed; 2],
    whole: Smoothed,
    /// The variance of the pixel's mean, by either half.
    variances: [Plane; 2],
    /// The square of what the largest sample of a pixel can add to its mean, as the batches tell it.
    largest_sample: Plane,
}

impl Channel {
    fn of(film: &Film, c: usize, unit: f64) -> Option<Self> {
        let width = film.window.width as usize;
        let height = film.window.height as usize;
        let empty = || Plane::filled(width, height, 0.0);
        let mut batches = [(); BATCHES as usize].map(|()| empty());
        let mut halves = [empty(), empty()];
        let mut of_halves = [empty(), empty()];
        let mut variances = [empty(), empty()];
        let (mut whole, mut of_whole, mut largest) = (empty(), empty(), empty());
        let square = unit * unit;
        for index in 0..film.pixel_count() {
            let pixel = film.batch_means(index);
            let n = pixel.samples() as f64;
            for (plane, mean) in batches.iter_mut().zip(pixel.means) {
                plane.values[index] = (mean[c] / unit) as f32;
            }
            for half in Half::ALL {
                let (difference, share) = pixel.contrast(half)?;
                let of_sample = share * difference[c] * difference[c] / square;
                let of_half: u64 = half.batches().map(|batch| pixel.counts[batch]).iter().sum();
                let at = half as usize;
                variances[at].values[index] = (of_sample / n) as f32;
                of_halves[at].values[index] = (of_sample / of_half as f64) as f32;
                halves[at].values[index] = (pixel.half_mean(half)[c] / unit) as f32;
            }
            whole.values[index] = (pixel.mean()[c] / unit) as f32;
            of_whole.values[index] = (pixel.variance()?[c] / n / square) as f32;
            largest.values[index] = (largest_sample(&pixel, c) / unit).powi(2) as f32;
        }
        let [even, odd] = halves;
        let [of_even, of_odd] = of_halves;
        Some(Self {
            batches,
            halves: [Smoothed::new(even, &of_even), Smoothed::new(odd, &of_odd)],
            whole: Smoothed::new(whole, &of_whole),
            variances,
            largest_sample: largest,
        })
    }

    /// The truth as a half tells it, and as each of its two batches does.
    fn truths(&self, half: Half) -> (Plane, [Plane; 2]) {
        let smoothed = &self.halves[half as usize];
        let of_half = local_truth(&smoothed.picture, smoothed, 1.0);
        // A batch has half of the samples.
        let of_batches = half
            .batches()
            .map(|batch| local_truth(&self.batches[batch], smoothed, 2.0));
        (of_half, of_batches)
    }

    /// The truth as all batches tell it.
    fn whole_truth(&self) -> Plane {
        local_truth(&self.whole.picture, &self.whole, 1.0)
    }
}

/// What the largest sample of a pixel can have added to its mean: as much as its batches differ by.
fn largest_sample(pixel: &BatchMeans, c: usize) -> f64 {
    let means = pixel.means.iter().map(|mean| mean[c]);
    let (least, most) = means.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), x| {
        (least.min(x), most.max(x))
    });
    (most - least) / BATCHES as f64
}

/// Variances over the squares of the truth.
fn relative<'a>(
    variance: &'a Plane,
    truth: &'a Plane,
    epsilon: f32,
) -> impl Iterator<Item = f64> + 'a {
    let pairs = variance.values.iter().zip(&truth.values);
    pairs.map(move |(variance, truth)| f64::from(variance / (truth * truth + epsilon)))
}

/// The mean over pixels and channels of the picture that a half of the batches makes.
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

#[cfg(test)]
mod tests {
    use super::super::synthetic::{Numbers, film};
    use super::*;

    const SIZE: (u32, u32) = (64, 48);

    /// A room: brighter to the right, with a border to a part that is a tenth as bright.
    fn light(pixel: usize) -> f64 {
        let (x, y) = (pixel % SIZE.0 as usize, pixel / SIZE.0 as usize);
        let slope = 0.2 + x as f64 / 64.0;
        if y < 20 { slope } else { 0.1 * slope }
    }

    /// Noise as wide as the light itself.
    fn noisy(pixel: usize, numbers: &mut Numbers) -> f64 {
        light(pixel) * (1.0 + numbers.normal())
    }

    /// One sample in a hundred brings half of the light.
    fn rare(pixel: usize, numbers: &mut Numbers) -> f64 {
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

    /// Of 60 pictures at each count of samples: what is said over what is true, in the mean, and how many bounds hold.
    fn told(sample: fn(usize, &mut Numbers) -> f64, samples: u64) -> (f64, u32) {
        let (mut said, mut truth, mut held) = (0.0, 0.0, 0);
        for seed in 0..60 {
            let film = film(SIZE, samples, seed, sample);
            let error = film.error(0.95).expect("it has samples");
            let exact = true_error(&film, light);
            said += error.rel_rmse;
            truth += exact;
            held += u32::from(exact <= error.upper_bound);
        }
        (said / truth, held)
    }

    #[test]
    fn what_is_said_is_true_and_the_bound_holds() {
        // Of 60 bounds that hold with 95 %, fewer than 52 do with probability 2e-3; ours hold more often.
        for (samples, tolerance) in [(16, 0.1), (64, 0.04), (256, 0.04)] {
            let (ratio, held) = told(noisy, samples);
            println!("noisy, {samples}: {ratio:.3}, {held} of 60");
            assert!((ratio - 1.0).abs() < tolerance, "{samples}: {ratio}");
            assert!(held >= 54, "{samples}: {held} of 60");
        }
    }

    #[test]
    fn rare_bright_samples_do_not_excuse_themselves() {
        for samples in [64, 256] {
            let (ratio, held) = told(rare, samples);
            println!("rare, {samples}: {ratio:.3}, {held} of 60");
            assert!((ratio - 1.0).abs() < 0.1, "{samples}: {ratio}");
            assert!(held >= 54, "{samples}: {held} of 60");
        }
    }

    #[test]
    fn one_bright_pixel_leaves_no_bound() {
        let bright = |pixel: usize, numbers: &mut Numbers| {
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
                assert!(pixels < 0.01 && share > 0.3, "{doubt:?}");
            }
            // What is left are the other pixels: 0.01 over 8, relative to light from 0.02 to 1.2.
            let least = doubt.at_least();
            assert!((0.0003..0.06).contains(&least), "{doubt:?}");
            held += u32::from(least <= true_error(&film, truth));
        }
        // One sample in fifty: most of the pictures have one.
        assert!(doubts >= 10 && held + 3 >= doubts, "{held} of {doubts}");
    }

    #[test]
    fn exact_pictures_have_no_error_and_black_halves_no_estimate() {
        let exact = film(SIZE, 16, 0, |pixel, _| light(pixel));
        let error = exact.error(0.95).expect("it has samples");
        // Sums of equal numbers are rounded.
        assert!(
            error.rel_rmse < 1e-6 && error.upper_bound < 1e-6,
            "{error:?}"
        );
        assert_eq!(error.doubt, None);
        assert!(film(SIZE, 16, 0, |_, _| 0.0).error(0.95).is_none());
        assert!(film(SIZE, 3, 0, |_, _| 1.0).error(0.95).is_none());
    }

    #[test]
    fn exposure_changes_nothing() {
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
