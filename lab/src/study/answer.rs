//! The time that a variant takes to an error: measured where it was reached, else by the law of its error, `never` below
//! its bias, or the reason why it is not known.
//!
//! Measure: seconds at the scene's own size, from the first sample on; errors as roots of relMSE.
//! Range: any error above 0. Intervals have a confidence of 95 %; the upper end includes the samples that `--error` takes
//! to be sure of the error.
//! Source: docs/accuracy.md, "The study". Tested below and in `lab/tests/reports/study.rs`.

use super::bias::Bias;
use super::bootstrap::Ranged;
use super::fit::{Curve, TimeLaw};
use super::gram::Estimate;
use super::law::{Law, NoLaw};
use etendue::internals::render::CONFIDENCE;
use etendue::internals::render::convergence::{ErrorRecord, Forecast};
use serde::Serialize;

/// A root of relMSE that rounding to single precision explains.
const ROUNDING: f64 = 2e-6;

/// The largest factor by which certainty may raise the number of samples; beyond it `--error` does not end in most cases.
const MAX_CERTAINTY: f64 = 2.0;

/// The time to an error.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// Reached between two levels.
    Measured(Ranged),
    /// Reached by the shortest renders, which take this long.
    AtOnce(f64),
    /// Beyond what was measured, by the law.
    Law(Ranged),
    /// The bias alone is larger; this is its root.
    Never(f64),
    /// The time of the samples from which on there is no noise.
    Exact(f64),
    /// Not known, for this reason.
    Unknown(String),
}

impl Answer {
    /// The likely seconds, where there are any.
    pub fn seconds(&self) -> Option<f64> {
        match self {
            Self::Measured(range) | Self::Law(range) => Some(range.value),
            Self::AtOnce(seconds) | Self::Exact(seconds) => Some(*seconds),
            Self::Never(_) | Self::Unknown(_) => None,
        }
    }

    /// The answer for times that are `factor` as long.
    pub fn scaled(&self, factor: &Ranged) -> Self {
        let range = |range: &Ranged| Ranged {
            value: factor.value * range.value,
            low: factor.low * range.low,
            high: factor.high * range.high,
        };
        match self {
            Self::Measured(it) => Self::Measured(range(it)),
            Self::Law(it) => Self::Law(range(it)),
            Self::AtOnce(seconds) => Self::AtOnce(factor.value * seconds),
            Self::Exact(seconds) => Self::Exact(factor.value * seconds),
            other => other.clone(),
        }
    }
}

/// The facts about a variant from which its answers follow.
pub(super) struct AnswerInput<'a> {
    pub curve: &'a Curve,
    pub law: Result<Law, NoLaw>,
    pub bias: &'a Bias,
    /// Whether the settings bias it, found or not.
    pub is_biased: bool,
    /// The variance of one sample.
    pub variance: Estimate,
    /// Seconds by samples at the scene's own size.
    pub time: TimeLaw,
    /// The half width of the interval of the logarithm of the pace.
    pub pace_margin: f64,
    /// The error as a render estimates it, and the number of pixels at the scene's own size.
    pub error_record: Option<ErrorRecord>,
    pub pixels: u64,
    /// The factor of the error at the scene's own size, relative to that of the curve.
    pub error_factor: f64,
}

impl AnswerInput<'_> {
    /// The time until the root of relMSE is `error`.
    pub fn answer(&self, error: f64) -> Answer {
        let rel_mse = (error / self.error_factor).powi(2);
        if let Some(spp) = self.exact_from() {
            return Answer::Exact(self.time.at(spp));
        }
        if let Some(samples) = self.curve.between(self.law.as_ref().ok(), rel_mse) {
            return match samples.value {
                0.0 => Answer::AtOnce(self.time.at(self.curve.spp[0])),
                _ => Answer::Measured(self.seconds(&samples, error)),
            };
        }
        if self.bias.is_square_found {
            return self.beyond_with_bias(error);
        }
        if self.is_biased && error < self.bias.at_most {
            return Answer::Unknown(format!(
                "its settings bias it, by {:.2} % at most, which this study was too short to measure",
                100.0 * self.bias.at_most
            ));
        }
        match &self.law {
            Ok(law) => Answer::Law(self.seconds(&self.curve.beyond(law, rel_mse), error)),
            Err(reason) => Answer::Unknown(reason.why().to_owned()),
        }
    }

    /// The answer for a variant whose error is B^2 + V / N.
    fn beyond_with_bias(&self, error: f64) -> Answer {
        let squared = self.bias.squared;
        let bias = squared.value.max(0.0);
        let margin = squared.margin(0.95);
        let left = error * error - bias;
        if bias - margin > error * error {
            return Answer::Never(bias.sqrt());
        }
        if left <= margin {
            return Answer::Unknown(format!(
                "its bias is about as large: {:.2} %",
                100.0 * bias.sqrt()
            ));
        }
        let spread = self.variance.margin(0.95);
        let samples = |variance: f64, left: f64| variance.max(0.0) / left;
        let range = Ranged {
            value: samples(self.variance.value, left),
            low: samples(self.variance.value - spread, left + margin),
            high: samples(self.variance.value + spread, left - margin),
        };
        Answer::Law(self.seconds(&range, error))
    }

    /// The samples per pixel from which on no level has any noise or bias: a few, where the weights of a filter are noisy.
    fn exact_from(&self) -> Option<f64> {
        let exact = |mean: &f64| mean.abs() < ROUNDING * ROUNDING;
        let levels = self.curve.spp.iter().zip(&self.curve.means);
        let (spp, _) = levels.rev().take_while(|(_, mean)| exact(mean)).last()?;
        Some(*spp)
    }

    /// Converts samples to seconds, with the uncertainty of the pace.
    fn seconds(&self, samples: &Ranged, error: f64) -> Ranged {
        let [value, low, high] = [
            samples.value,
            samples.low,
            self.certainty(error) * samples.high,
        ]
        .map(|samples| self.time.at(samples));
        let widened = |end: f64| (end / value).ln().hypot(self.pace_margin);
        Ranged {
            value,
            low: value * (-widened(low)).exp(),
            high: value * widened(high).exp(),
        }
    }

    /// The factor by which `--error` takes more samples than the error itself, to be sure of it.
    fn certainty(&self, error: f64) -> f64 {
        let Some(error_record) = self.error_record else {
            return 1.0;
        };
        // The uncertainty of the squared error is known at the record only; that of fewer samples is about as large.
        let error = (error / self.error_factor).min(error_record.rel_rmse);
        let forecast = Forecast::new(&[error_record], self.pixels, CONFIDENCE, false);
        let independent = error_record.samples * (error_record.rel_rmse / error).powi(2);
        let factor = forecast.map_or(1.0, |it| it.samples_for(error) / independent);
        factor.clamp(1.0, MAX_CERTAINTY)
    }
}

#[cfg(test)]
mod tests {
    use super::super::fit::ErrorLevel;
    use super::*;

    fn estimate(value: f64, standard_error: f64) -> Estimate {
        Estimate {
            value,
            standard_error,
            freedom: 10.0,
        }
    }

    fn bias(squared: f64, is_found: bool) -> Bias {
        Bias {
            squared: estimate(squared, 0.01 * squared),
            p: if is_found { 1e-9 } else { 0.5 },
            is_found,
            is_square_found: is_found,
            at_most: 0.004,
            light: [0.0, 0.01],
        }
    }

    /// Answers for an error of bias^2 + 0.1 / N at 1 to 64 samples, of which one takes a second.
    fn answers(squared_bias: f64, is_biased: bool) -> [Answer; 3] {
        let level = |power: i32| {
            let spp = f64::from(power).exp2();
            let error = squared_bias + 0.1 / spp;
            ErrorLevel {
                spp,
                errors: vec![0.98 * error, error, 1.02 * error],
            }
        };
        let curve = Curve::new(&(0..7).map(level).collect::<Vec<_>>(), 3);
        let facts = AnswerInput {
            law: curve.law(),
            curve: &curve,
            bias: &bias(squared_bias, squared_bias > 0.0),
            is_biased,
            variance: estimate(0.1, 0.001),
            time: TimeLaw {
                start: 0.0,
                sample: 1.0,
            },
            pace_margin: 0.02,
            error_record: None,
            pixels: 1 << 20,
            error_factor: 1.0,
        };
        [0.1, 0.03, 0.003].map(|error| facts.answer(error))
    }

    #[test]
    fn answer_is_measured_within_levels_and_extrapolated_beyond() {
        let [ten, three, third] = answers(0.0, false);
        let Answer::Measured(range) = ten else {
            panic!("reached after 10 samples: {ten:?}");
        };
        assert!((range.value - 10.0).abs() < 0.1 && range.holds(10.0));
        for (answer, seconds) in [(three, 111.1), (third, 11_111.0)] {
            let Answer::Law(range) = answer else {
                panic!("by the law: {answer:?}");
            };
            assert!((range.value / seconds - 1.0).abs() < 0.02 && range.holds(seconds));
            // The uncertainty of the pace alone is 2 %.
            assert!(range.low < 0.98 * range.value && range.high > 1.02 * range.value);
        }
    }

    #[test]
    fn error_below_the_bias_is_never_reached_or_unknown() {
        let [ten, three, third] = answers(8e-4, true);
        assert!(matches!(ten, Answer::Measured(_)), "{ten:?}");
        // 9e-4 - 8e-4 are left for the variance.
        let Answer::Law(range) = three else {
            panic!("just above the bias: {three:?}");
        };
        assert!(
            (range.value - 1000.0).abs() < 1.0 && range.high > 1100.0,
            "{range:?}"
        );
        assert_eq!(third, Answer::Never(8e-4_f64.sqrt()));
        // A bias that is known of but was not found.
        let [_, three, third] = answers(0.0, true);
        assert!(matches!(three, Answer::Law(_)), "{three:?}");
        assert!(matches!(third, Answer::Unknown(_)), "{third:?}");
    }

    #[test]
    fn image_is_exact_from_the_first_noise_free_level() {
        let level = |spp: f64, noise: f64| ErrorLevel {
            spp,
            errors: vec![noise, -1e-14, 0.0],
        };
        let curve = Curve::new(&[level(1.0, 1e-3), level(2.0, 1e-14), level(4.0, 0.0)], 3);
        let facts = AnswerInput {
            law: curve.law(),
            curve: &curve,
            bias: &bias(0.0, false),
            is_biased: false,
            variance: estimate(0.0, 0.0),
            time: TimeLaw {
                start: 0.5,
                sample: 1.0,
            },
            pace_margin: 0.0,
            error_record: None,
            pixels: 1,
            error_factor: 1.0,
        };
        assert_eq!(facts.answer(1e-3), Answer::Exact(2.5));
    }

    #[test]
    fn error_uncertainty_widens_the_upper_time_bound() {
        let level = |spp: f64| ErrorLevel {
            spp,
            errors: vec![0.1 / spp, 0.101 / spp],
        };
        let curve = Curve::new(&[level(1.0), level(2.0), level(4.0)], 3);
        let no_bias = bias(0.0, false);
        let facts = |error_record| AnswerInput {
            law: curve.law(),
            curve: &curve,
            bias: &no_bias,
            is_biased: false,
            variance: estimate(0.1, 0.0),
            time: TimeLaw {
                start: 0.0,
                sample: 1.0,
            },
            pace_margin: 0.0,
            error_record,
            pixels: 100_000,
            error_factor: 1.0,
        };
        let error_record = ErrorRecord {
            samples: 4.0,
            rel_rmse: 0.16,
            uncertainty: 0.05,
            bias: 0.0,
            largest_sample: 0.0,
            largest_pixel: 0.0,
        };
        let [sure, unsure] =
            [Some(error_record), None].map(|error_record| match facts(error_record).answer(0.01) {
                Answer::Law(range) => range,
                other => panic!("{other:?}"),
            });
        assert_eq!(sure.value, unsure.value);
        // At least the 3 % of the smoothing's bias, and what is left of the uncertainty.
        let more = sure.high / unsure.high;
        assert!((1.03..1.1).contains(&more), "{more}");
        // An error that was reached takes certainty, too: all of the uncertainty of the record.
        let [sure, unsure] =
            [Some(error_record), None].map(|error_record| match facts(error_record).answer(0.2) {
                Answer::Measured(range) => range,
                other => panic!("{other:?}"),
            });
        let more = sure.high / unsure.high;
        assert!((1.05..1.3).contains(&more), "{more}");
    }
}
