//! The error of an estimator by the number of its calls.
//!
//! Measure: root mean square errors, in the unit of the estimate; slopes on logarithmic axes.
//! Range: at least two runs for each number of calls.
//! Source: a least-squares line; its standard error from those of the squared errors. Tested below.

use super::topic::Lesson;
use super::uniform::Uniform;
use crate::plot::{Mark, Series};
use etendue::internals::math::stats::Moments;

/// Squared errors by number of calls.
#[derive(Debug, Clone)]
pub struct ErrorCurve {
    /// The number of calls, and the squared errors of independent runs.
    steps: Vec<(f64, Moments)>,
}

impl ErrorCurve {
    /// Runs `estimate` `runs` times with each number of calls; it may use fewer and returns how many.
    pub fn measure(
        lesson: &Lesson<'_>,
        experiment: &str,
        runs: usize,
        calls: &[usize],
        exact: f64,
        estimate: impl Fn(&mut Uniform, usize) -> Option<(f64, usize)> + Sync,
    ) -> Self {
        let step = |&wanted: &usize| {
            let experiment = format!("{experiment} {wanted}");
            let all = lesson.repeat(&experiment, runs, |uniform| estimate(uniform, wanted));
            let used = all.first().copied().flatten()?.1 as f64;
            let values = all
                .into_iter()
                .flatten()
                .map(|(value, _)| (value - exact).powi(2));
            Some((used, Moments::of(values)))
        };
        let mut steps: Vec<(f64, Moments)> = calls.iter().filter_map(step).collect();
        // Several requested numbers may give the same grid.
        steps.dedup_by_key(|(used, _)| *used);
        Self { steps }
    }

    /// The slope of the error on logarithmic axes, with its standard error.
    pub fn slope(&self) -> [f64; 2] {
        let count = self.steps.len() as f64;
        let mean_x = self.steps.iter().map(|(calls, _)| calls.ln()).sum::<f64>() / count;
        let mut sums = [0.0; 3];
        for (calls, squares) in &self.steps {
            let x = calls.ln() - mean_x;
            let spread = squares.standard_error().unwrap_or(f64::NAN) / squares.mean();
            sums[0] += x * squares.mean().ln();
            sums[1] += x * x;
            sums[2] += (x * spread).powi(2);
        }
        // The error is the root of the squared error, hence the factor of a half.
        [0.5 * sums[0] / sums[1], 0.5 * sums[2].sqrt() / sums[1]]
    }

    /// The errors as a series, with a ribbon of two standard errors.
    pub fn series(&self, name: impl Into<String>, mark: Mark, hue: usize) -> Series {
        let points = self
            .steps
            .iter()
            .map(|(calls, squares)| [*calls, squares.mean().sqrt()]);
        let ribbon = self.steps.iter().map(|(calls, squares)| {
            let two = 2.0 * squares.standard_error().unwrap_or(0.0);
            // A lower end of zero cannot be shown on a logarithmic axis.
            let low = (squares.mean() - two).max(0.1 * squares.mean());
            [*calls, low.sqrt(), (squares.mean() + two).sqrt()]
        });
        Series::new(name, mark, hue, points.collect()).within(ribbon.collect())
    }
}

/// Powers of two from 2^`first` to 2^`last`, by `step` powers.
pub fn powers_of_two(first: u32, last: u32, step: usize) -> Vec<usize> {
    (first..=last)
        .step_by(step)
        .map(|power| 1 << power)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lesson::topic::{LessonSettings, NullLessonObserver};

    #[test]
    fn error_curve_slope_matches_the_known_power_law() {
        let lesson = Lesson::new("test", LessonSettings::default(), &NullLessonObserver);
        let curve = ErrorCurve::measure(
            &lesson,
            "law",
            400,
            &powers_of_two(2, 12, 2),
            1.0,
            |uniform, calls| Some((1.0 + (uniform.double() - 0.5) / calls as f64, calls)),
        );
        let [slope, error] = curve.slope();
        assert!(
            (slope + 1.0).abs() < 5.2 * error && error < 0.02,
            "{slope} {error}"
        );
    }
}
