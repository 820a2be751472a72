//! Reasons why an image's samples give no upper bound of its error.
//!
//! Where a few pixels dominate the differences between the halves of the batches, so that the relative standard error of
//! the squared error exceeds [`MAX_RELATIVE_STANDARD_ERROR`], or where a single sample, if it is there by chance, could
//! account for more than [`MAX_SAMPLE_RATIO`] times the whole squared error, the samples cannot distinguish a scene with
//! rare bright paths from one without. Then there is no upper bound, and a lower bound is reported.
//!
//! Measure: roots of relMSE, without unit.
//! Range: see `error.rs`.
//! Source: docs/accuracy.md, "The error that is printed". Tested in `error.rs`.

use super::relative_variance::RelativeVariances;

/// The relative standard error of the squared error above which the error counts as unknown.
const MAX_RELATIVE_STANDARD_ERROR: f64 = 0.4;

/// The number of standard errors from the squared error to its lower bound: 95 %, one-sided.
const LOWER_BOUND_SIGMAS: f64 = 1.645;

/// The largest share of pixels that counts as few.
const MAX_PIXELS: f64 = 0.05;

/// The largest ratio of a single sample's term to the whole squared error for which there is a bound.
const MAX_SAMPLE_RATIO: f64 = 2.0;

/// A reason why an image's samples give no upper bound of its error, with a lower bound of the root of relMSE.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Doubt {
    /// A few pixels hold half of the squared error, which the samples do not resolve. The lower bound leaves out the pixels with the
    /// largest errors, as many as make the bound largest.
    FewPixels {
        /// The lower bound.
        at_least: f64,
        /// The share of these pixels in all pixels.
        pixels: f64,
        /// The share of these pixels in the squared error.
        share: f64,
    },
    /// A single sample may account for more than the whole estimated squared error.
    OneSample {
        /// The lower bound.
        at_least: f64,
        /// The term of that sample over the whole squared error.
        times: f64,
    },
    /// The error has not fallen as expected since an earlier estimate.
    Rising {
        /// The lower bound.
        at_least: f64,
        /// Samples per pixel at that estimate.
        samples: f64,
        /// The root of relMSE estimated then.
        rel_rmse: f64,
    },
}

impl Doubt {
    /// Returns the reason, if any, why the error is not known: a few pixels or a single sample with too much of it.
    /// `standard_error` is that of the squared error.
    pub(super) fn of(parts: &RelativeVariances, standard_error: f64) -> Option<Self> {
        let mse = parts.mean();
        let outshining = parts.largest_sample / mse;
        let is_unresolved = standard_error > MAX_RELATIVE_STANDARD_ERROR * mse;
        if !is_unresolved && outshining <= MAX_SAMPLE_RATIO {
            return None;
        }
        let mut pixels: Vec<usize> = (0..parts.count()).collect();
        // Largest first; ties in the order of the pixels.
        pixels.sort_by(|&a, &b| parts.part(b).total_cmp(&parts.part(a)).then(a.cmp(&b)));
        let blocks = parts.blocks();
        let mut differences = vec![0.0; blocks.count];
        let (mut rest, mut squares) = (0.0, 0.0);
        let (mut best, mut bright, mut share) = (0.0, parts.count(), 1.0);
        // From the smallest on: subtracting the largest term from the sum would leave only rounding error.
        for (place, &index) in pixels.iter().enumerate().rev() {
            rest += parts.part(index);
            // The sum of squares over blocks, one of which gets another pixel.
            let block = &mut differences[blocks.block_of(index)];
            let difference = parts.difference(index);
            squares += difference * (2.0 * *block + difference);
            *block += difference;
            let error = (0.75 * squares).max(0.0).sqrt();
            best = f64::max(best, rest - LOWER_BOUND_SIGMAS * error);
            if rest <= 0.5 * mse {
                (bright, share) = (place, 1.0 - rest / mse);
            }
        }
        let at_least = best.sqrt();
        let are_few = bright as f64 <= MAX_PIXELS * parts.count() as f64;
        if is_unresolved && are_few {
            Some(Self::FewPixels {
                at_least,
                pixels: bright as f64 / parts.count() as f64,
                share,
            })
        } else if outshining > MAX_SAMPLE_RATIO {
            Some(Self::OneSample {
                at_least,
                times: outshining,
            })
        } else {
            // A small image, or one lit in a small part only: the bound is wide, but it holds.
            None
        }
    }

    /// The lower bound of the root of relMSE.
    pub fn at_least(&self) -> f64 {
        match *self {
            Self::FewPixels { at_least, .. }
            | Self::OneSample { at_least, .. }
            | Self::Rising { at_least, .. } => at_least,
        }
    }
}
