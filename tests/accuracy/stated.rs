//! The errors that renders state, and their bounds, against the errors that they have.
//!
//! Measure: roots of relMSE.
//! Range: at least three renders of a scene, alike but for their seeds.
//! Source: docs/accuracy.md, "The error that is printed".

use etendue::internals::film::ErrorEstimate;
use etendue::internals::image::Image;
use etendue::internals::math::stats::Moments;
use std::fmt;

/// The confidence of the bounds.
pub const CONFIDENCE: f64 = 0.95;

/// An image and the error that was stated of it.
pub struct Stated {
    pub image: Image,
    pub error: ErrorEstimate,
}

/// Statistics of the errors that renders of one scene state.
#[derive(Default)]
pub struct StatedErrors {
    /// The true errors of all renders.
    truths: Moments,
    /// The stated errors over the true ones, of the renders that state an upper bound.
    ratios: Moments,
    /// The number of these whose error is at most the bound.
    held: u64,
}

impl StatedErrors {
    /// Compares each image with the mean of the others, whose noise is subtracted.
    pub fn of(renders: &[Stated]) -> Self {
        let others = (renders.len() - 1) as f64;
        let images: Vec<Vec<f64>> = renders.iter().map(|it| values(&it.image)).collect();
        let sums = |power: i32| -> Vec<f64> {
            let sum = |index: usize| images.iter().map(|it| it[index].powi(power)).sum();
            (0..images[0].len()).map(sum).collect()
        };
        let (sums, squares) = (sums(1), sums(2));
        let count = sums.len() as f64;
        let means: Vec<f64> = sums.iter().map(|it| it / renders.len() as f64).collect();
        let epsilon = 0.01 * (means.iter().sum::<f64>() / count).powi(2);
        let mut this = Self::default();
        for (image, Stated { error, .. }) in images.iter().zip(renders) {
            let terms = image.iter().enumerate().map(|(index, x)| {
                let mean = (sums[index] - x) / others;
                let variance = (squares[index] - x * x - others * mean * mean) / (others - 1.0);
                ((x - mean).powi(2) - variance / others) / (means[index].powi(2) + epsilon)
            });
            let truth = (terms.sum::<f64>() / count).max(0.0).sqrt();
            this.truths.push(truth);
            if error.doubt.is_none() {
                this.ratios.push(error.rel_rmse / truth);
                this.held += u64::from(truth <= error.upper_bound);
            }
        }
        this
    }

    /// The row of these statistics if they are out of tolerance: fewer than 93 % of the bounds hold, or the errors are off by
    /// more than 10 % and two standard errors in the mean.
    pub fn out_of_tolerance(&self) -> Option<String> {
        let bounded = self.ratios.count();
        let off = (self.ratios.mean() - 1.0).abs();
        let errors = self.ratios.standard_error();
        let is_off = errors.is_some_and(|error| off > 0.1 + 2.0 * error);
        let fails = 100 * self.held < 93 * bounded;
        (fails || is_off).then(|| self.to_string())
    }
}

/// All channels of all pixels.
fn values(image: &Image) -> Vec<f64> {
    let pixels = image.pixels().iter();
    pixels.flat_map(|it| it.to_array()).map(f64::from).collect()
}

/// A row of a table.
impl fmt::Display for StatedErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (truth, ratio) = (100.0 * self.truths.mean(), self.ratios.mean());
        let (held, bounded) = (self.held, self.ratios.count());
        let doubtful = self.truths.count() - bounded;
        write!(
            f,
            " {truth:.3} % | {ratio:.2} | {held} of {bounded} | {doubtful} |"
        )
    }
}
