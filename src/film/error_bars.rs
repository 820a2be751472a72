//! The error bar of each pixel: the standard error of its mean, the degrees of freedom of its confidence interval,
//! and a flag if it is unreliable.
//!
//! Four batches give a variance estimate s^2 with three degrees of freedom, which alone makes wide confidence
//! intervals. Neighbouring pixels have similar variances: if the variances around a pixel follow a scaled inverse
//! chi-square distribution with d0 degrees of freedom, the pixel's own variance, given s^2, has the expectation
//!
//!   v = ((d0 - 2) m + d s^2) / (d0 - 2 + d),
//!
//! with m the mean of s^2 over the neighbours. The error of the pixel's mean follows Student's t with d0 + d degrees
//! of freedom, scaled to variance v. Where neighbours have similar variances, d0 is large and v is close to m; where
//! they do not, v is close to the pixel's own s^2.
//!
//! d0 is fitted to the neighbours' mean of s: the ratio (mean of s)^2 / (mean of s^2) is the product of this ratio
//! for the distribution of true standard deviations and for the noise of s. Where rare bright samples dominate, s^2
//! is less certain than for normal samples: with the excess kurtosis k of a batch mean, d = 2 / (2/3 + k/4). The
//! pixel's mean is not normal then either. A t distribution with 4 + 6/k' degrees of freedom has excess kurtosis k'.
//! The pixel's mean has k' = k/4; matching a fifth of this reproduces the centre and the tails of the distributions
//! of pixels in the gallery.
//!
//! **Flags.** A pixel is flagged if its neighbours' means have an excess kurtosis above 12, or if more than a fifth of
//! its neighbours are black in all batches and most others are black in some of them. Black neighbours of pixels that
//! are lit in every batch are an edge of the image's content, not missed light. The pixel's own samples are not used: a
//! pixel that missed a rare contribution would appear to be the most reliable. Where samples contribute to several pixels,
//! neighbours that share any of its samples are not used either.
//!
//! Measure: radiance; an interval is mean ± se q, with q by [`standardised_student_quantile`].
//! Range: a pixel without a sample in each batch is flagged. Pixels at the border have fewer neighbours.
//! Source: Smyth 2004, "Linear Models and Empirical Bayes Methods for Assessing Differential Expression in Microarray
//! Experiments", for moderated variances; the fit by the mean of s is ours. Tested below, in
//! `tests/rendering/error_bars.rs` and by `make accuracy`.

use super::Film;
use super::batches::{BATCHES, BatchMeans};
use super::chi_square::{INVERSE_CHI_SQUARE, mean_root_of_chi_square};
use crate::image::Image;
use crate::math::plane::Plane;
use crate::math::rgb::Rgb;
use crate::math::stats::standardised_student_quantile;
use crate::planted::planted;

/// Radius in pixels of the square of neighbours that the variance is moderated by.
const NEAR: usize = 3;
/// Radius in pixels of the square of neighbours that the kurtosis is estimated from, which takes more of them.
const FAR: usize = 5;

/// The excess kurtosis of a pixel's mean, estimated from its neighbours, above which the pixel is flagged.
const MAX_KURTOSIS: f32 = 12.0;

/// The share of black neighbours above which a pixel is flagged, if the others are lit by rare samples.
const MAX_UNLIT: f32 = 0.2;

/// The share of the lit neighbours that are black in some of their batches, above which rare samples light them.
const MAX_PARTLY_LIT: f32 = 0.5;

/// The fraction of the kurtosis to which the degrees of freedom are matched.
const KURTOSIS_FRACTION: f32 = 0.2;

/// The least degrees of freedom: Student's t has a variance only above 2.
const MIN_FREEDOM: f32 = 2.2;

/// The standard error, degrees of freedom and flag of each pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorBars {
    /// The standard error of each channel.
    pub standard_errors: Image,
    /// Degrees of freedom of each pixel, row by row, above 2.
    pub freedom: Vec<f32>,
    /// Flags of unreliable pixels, row by row.
    pub flags: Vec<bool>,
}

impl ErrorBars {
    /// The half-width of a pixel's confidence interval of this probability, in standard errors.
    pub fn quantile(&self, index: usize, probability: f64) -> f64 {
        standardised_student_quantile(self.freedom[index].into(), probability)
    }

    /// The share of flagged pixels.
    pub fn flagged_share(&self) -> f64 {
        let flagged = self.flags.iter().filter(|&&flag| flag).count();
        flagged as f64 / self.flags.len() as f64
    }
}

impl Film {
    /// Computes the error bars of all pixels.
    pub fn error_bars(&self) -> ErrorBars {
        let pixels = Pixels::of(self);
        let shared = 2 * self.border_size as usize;
        let own = [
            &pixels.variances[0],
            &pixels.variances[1],
            &pixels.variances[2],
        ];
        let neighbours = Neighbours::of(&pixels, shared);
        let near = own.map(|plane| plane.mean_of_others(NEAR));
        let weights: Vec<Weights> = (0..self.pixel_count())
            .map(|index| neighbours.weights(index))
            .collect();
        let standard_errors = weights.iter().enumerate().map(|(index, weights)| {
            let n = pixels.samples[index].max(1) as f32;
            Rgb::from([0, 1, 2].map(|c| {
                let variance = weights.moderate(own[c].values[index], near[c].values[index]);
                (variance / n).sqrt() * pixels.unit
            }))
        });
        let [width, height] = [self.window.width, self.window.height];
        ErrorBars {
            standard_errors: Image::new(width, height, standard_errors.collect()),
            freedom: weights.iter().map(Weights::freedom).collect(),
            flags: (0..self.pixel_count())
                .map(|index| pixels.samples[index] < BATCHES || neighbours.are_doubtful(index))
                .collect(),
        }
    }
}

/// Statistics of each pixel's batches, in units of the image's mean.
struct Pixels {
    unit: f32,
    samples: Vec<u64>,
    /// The variance of a sample in each channel.
    variances: [Plane; 3],
    /// The variance of luminance and its square root.
    luminance: Plane,
    deviation: Plane,
    /// The fourth cumulant and the squared variance of luminance, each over the variance, so that pixels of all
    /// brightnesses count, noisier ones more.
    fourth: Plane,
    squared: Plane,
    /// 1 where all batches are black, else 0.
    unlit: Plane,
    /// 1 where some batches are black and others are not, else 0.
    partly_lit: Plane,
}

impl Pixels {
    fn of(film: &Film) -> Self {
        let [width, height] = [film.window.width, film.window.height].map(|side| side as usize);
        let mean = film.mean().iter().sum::<f64>() / 3.0;
        let unit = if mean > 0.0 { mean } else { 1.0 };
        let empty = Plane::filled(width, height, 0.0);
        let mut this = Self {
            unit: unit as f32,
            samples: Vec::with_capacity(width * height),
            variances: [empty.clone(), empty.clone(), empty.clone()],
            luminance: empty.clone(),
            deviation: empty.clone(),
            fourth: empty.clone(),
            squared: empty.clone(),
            unlit: empty.clone(),
            partly_lit: empty,
        };
        for index in 0..film.pixel_count() {
            this.add_pixel(index, &film.batch_means(index), unit * unit);
        }
        this
    }

    fn add_pixel(&mut self, index: usize, batches: &BatchMeans, square: f64) {
        self.samples.push(batches.samples());
        let variances = batches.variance().unwrap_or_default();
        for (plane, variance) in self.variances.iter_mut().zip(variances) {
            plane.values[index] = (variance / square) as f32;
        }
        let cumulants = batches.luminance_cumulants().unwrap_or_default();
        let variance = cumulants.variance / square;
        self.luminance.values[index] = variance as f32;
        self.deviation.values[index] = variance.sqrt() as f32;
        if variance > 0.0 {
            let scale = square * square * variance;
            self.fourth.values[index] = (cumulants.fourth / scale) as f32;
            self.squared.values[index] = (cumulants.squared_variance / scale) as f32;
        }
        let black = batches.are_black.iter().filter(|&&is_black| is_black);
        let black = black.count() as u64;
        self.unlit.values[index] = f32::from(u8::from(black == BATCHES));
        self.partly_lit.values[index] = f32::from(u8::from((1..BATCHES).contains(&black)));
    }
}

/// Means over the neighbours of each pixel.
struct Neighbours {
    variance: Plane,
    deviation: Plane,
    fourth: Plane,
    squared: Plane,
    unlit: Plane,
    partly_lit: Plane,
}

impl Neighbours {
    /// The means, where a pixel shares samples with those at most `shared` rows and columns away. The kurtosis and the flags
    /// are taken from others; the noise of variances that are moderated is much larger than what is shared.
    fn of(pixels: &Pixels, shared: usize) -> Self {
        let far = |plane: &Plane| {
            planted!(
                "flags-by-the-pixel-itself",
                plane.clone(),
                plane.mean_around(shared, FAR + shared)
            )
        };
        Self {
            variance: pixels.luminance.mean_of_others(NEAR),
            deviation: pixels.deviation.mean_of_others(NEAR),
            fourth: far(&pixels.fourth),
            squared: far(&pixels.squared),
            unlit: far(&pixels.unlit),
            partly_lit: far(&pixels.partly_lit),
        }
    }

    /// The excess kurtosis of a batch mean; 0 without variance.
    fn kurtosis(&self, index: usize) -> f32 {
        /// The largest kurtosis returned.
        const MAX_ESTIMATE: f32 = 1e4;
        let [fourth, squared] = [&self.fourth, &self.squared].map(|plane| plane.values[index]);
        match fourth {
            _ if fourth <= 0.0 => 0.0,
            // The unbiased estimate of the squared variance may fall below 0 by chance where only rare events
            // contribute.
            _ if squared <= fourth / MAX_ESTIMATE => MAX_ESTIMATE,
            _ => fourth / squared,
        }
    }

    fn are_doubtful(&self, index: usize) -> bool {
        let [unlit, partly_lit] = [&self.unlit, &self.partly_lit].map(|plane| plane.values[index]);
        let is_lit_rarely = unlit > MAX_UNLIT && partly_lit > MAX_PARTLY_LIT * (1.0 - unlit);
        self.kurtosis(index) / BATCHES as f32 > MAX_KURTOSIS || is_lit_rarely
    }

    fn weights(&self, index: usize) -> Weights {
        let kurtosis = self.kurtosis(index);
        let own = 2.0 / (2.0 / 3.0 + kurtosis / BATCHES as f32);
        let [variance, deviation] =
            [&self.variance, &self.deviation].map(|plane| plane.values[index]);
        let of_noise = mean_root_of_chi_square(own);
        let ratio = match variance {
            // Nothing is known of the noise of neighbours without any: the pixel's own variance counts.
            0.0 => 0.0,
            variance => deviation * deviation / (of_noise * of_noise * variance),
        };
        Weights {
            own,
            neighbours: INVERSE_CHI_SQUARE.freedom(ratio),
            kurtosis: kurtosis / BATCHES as f32,
        }
    }
}

/// The degrees of freedom of a pixel's own variance and of its neighbours'.
struct Weights {
    /// Degrees of freedom d of the pixel's own variance.
    own: f32,
    /// Degrees of freedom d0 of the distribution of the neighbours' variances, above 2.
    neighbours: f32,
    /// Excess kurtosis of the pixel's mean.
    kurtosis: f32,
}

impl Weights {
    /// The expected variance v, given the pixel's own estimate and the neighbours' mean.
    fn moderate(&self, own: f32, neighbours: f32) -> f32 {
        let prior = self.neighbours - 2.0;
        (prior * neighbours + self.own * own) / (prior + self.own)
    }

    /// The degrees of freedom of Student's t for the error of the pixel's mean.
    fn freedom(&self) -> f32 {
        let of_variance = self.own + self.neighbours;
        let of_mean = 4.0 + 6.0 / (KURTOSIS_FRACTION * self.kurtosis).max(f32::MIN_POSITIVE);
        let both = 1.0 / (1.0 / of_variance + 1.0 / of_mean);
        planted!(
            "moderation-forgets-its-freedom",
            f32::MAX,
            both.max(MIN_FREEDOM)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::{TestRandom, film};
    use crate::math::rgb::Rgb;

    const SIZE: (u32, u32) = (48, 48);

    /// The shares of unflagged pixels whose intervals of 50, 80, 95 and 99 % contain the expectation 1.
    fn coverage(samples: u64, sample: impl Fn(usize, &mut TestRandom) -> f64 + Copy) -> [f64; 4] {
        let mut held = [0; 4];
        let mut count = 0;
        for seed in 0..20 {
            let film = film(SIZE, samples, seed, sample);
            let (bars, picture) = (film.error_bars(), film.develop());
            for (index, pixel) in picture.pixels().iter().enumerate() {
                if bars.flags[index] {
                    continue;
                }
                count += 1;
                let [x, ..] = pixel.to_array();
                let [se, ..] = bars.standard_errors.pixels()[index].to_array();
                for (held, probability) in held.iter_mut().zip([0.5, 0.8, 0.95, 0.99]) {
                    let half_width = bars.quantile(index, probability) * f64::from(se);
                    *held += u32::from((f64::from(x) - 1.0).abs() <= half_width);
                }
            }
        }
        assert!(
            f64::from(count) > 0.9 * 20.0 * 2304.0,
            "{count} of 46080 are trusted"
        );
        held.map(|held| f64::from(held) / f64::from(count))
    }

    fn assert_coverage(name: &str, shares: [f64; 4], expected: [[f64; 2]; 4]) {
        println!("{name}: {shares:.4?}");
        for (share, [low, high]) in shares.into_iter().zip(expected) {
            assert!((low..=high).contains(&share), "{name}: {shares:?}");
        }
    }

    #[test]
    fn interval_coverage_is_nominal_for_equal_and_unequal_variances() {
        // 46,080 pixels: the shares are known to 0.25, 0.2, 0.1 and 0.05 %.
        let exact = [[0.49, 0.525], [0.785, 0.82], [0.94, 0.96], [0.984, 0.994]];
        assert_coverage("alike", coverage(16, |_, it| 1.0 + it.normal()), exact);
        // Variances from a scaled inverse chi-square distribution with five degrees of freedom, one for each pixel.
        let unlike = |pixel: usize, it: &mut TestRandom| {
            let mut own = TestRandom::new(1000 + pixel as u64);
            let chi_square: f64 = (0..5).map(|_| own.normal().powi(2)).sum();
            1.0 + it.normal() * (5.0 / chi_square).sqrt()
        };
        assert_coverage("unlike", coverage(16, unlike), exact);
    }

    #[test]
    fn rare_events_have_near_nominal_coverage_or_are_flagged() {
        // Three events a pixel: the mean has an excess kurtosis of 0.3 and a skewness of 0.6.
        let rare = |_: usize, it: &mut TestRandom| {
            let event = if it.uniform() < 3.0 / 64.0 {
                64.0 / 3.0
            } else {
                0.0
            };
            0.5 + 0.1 * it.normal() + 0.5 * event
        };
        let near = [[0.44, 0.60], [0.76, 0.86], [0.93, 0.97], [0.975, 0.995]];
        assert_coverage("three events", coverage(64, rare), near);
        // A fiftieth of an event per pixel: nearly all pixels have not sampled one.
        let film = film(SIZE, 64, 1, |_, it| {
            let event = if it.uniform() < 0.02 / 64.0 {
                3200.0
            } else {
                0.0
            };
            0.5 + 0.001 * it.normal() + 0.5 * event
        });
        let flagged = film.error_bars().flagged_share();
        assert!(flagged > 0.85, "{flagged}");
    }

    #[test]
    fn pixel_flag_depends_on_neighbours_not_on_own_samples() {
        let flags = |bright: Option<usize>| {
            let mut film = film(SIZE, 16, 5, |_, it| {
                1.0 + it.normal() + if it.uniform() < 0.02 { 30.0 } else { 0.0 }
            });
            if let Some(pixel) = bright {
                film.tiles_mut()[0].pixels[pixel].add(0, Rgb::grey(1e5));
            }
            film.error_bars().flags
        };
        let usual = flags(None);
        let mut changed = 0;
        for pixel in [1000, 1001, 1500, 2000] {
            let unusual = flags(Some(pixel));
            assert_eq!(unusual[pixel], usual[pixel], "{pixel} was asked");
            changed += (0..usual.len()).filter(|&i| unusual[i] != usual[i]).count();
        }
        assert!(changed > 10, "nobody was asked: {changed}");
    }

    #[test]
    fn sparsely_lit_pixels_are_flagged_but_black_background_is_not() {
        // One sample in fifty is lit.
        let rare = film(SIZE, 16, 2, |_, it| {
            if it.uniform() < 0.02 {
                it.uniform()
            } else {
                0.0
            }
        });
        assert!(rare.error_bars().flags.iter().all(|&flag| flag));
        // A black background is not a rare contribution, nor is a pattern of pixels that every sample lights.
        let half = film(SIZE, 16, 2, |pixel, it| {
            if pixel % 48 < 24 { it.uniform() } else { 0.0 }
        });
        let flags = half.error_bars().flags;
        assert!(flags.iter().all(|&flag| !flag));
        // Pixels without a sample in each batch are flagged.
        assert!(film(SIZE, 3, 2, |_, it| it.uniform()).error_bars().flags[0]);
    }
}
