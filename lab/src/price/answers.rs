//! The time and the samples that `render --error` takes to some errors, by the records of a render's own error.
//!
//! The forecast is that of `--error` itself: it ends where the bound of the error is small enough.
//!
//! Measure: samples per pixel; seconds at the scene's own size; errors as roots of relMSE.
//! Range: at least one record; intervals have a confidence of 95 %, for the uncertainty of the error and of its power law.
//! Source: `src/render/convergence.rs`, `src/render/budget.rs`. Tested below and in `cli/tests/command/price.rs`.

use crate::study::answer::Answer;
use crate::study::bootstrap::Ranged;
use etendue::internals::render::CONFIDENCE;
use etendue::internals::render::budget::MIN_SPP_TO_TARGET;
use etendue::internals::render::convergence::{ErrorRecord, Forecast, PowerLaw};
use serde::Serialize;

/// The number of standard errors of an interval.
pub(super) const SIGMAS: f64 = 2.0;

/// Where an error is requested, forecasts aim a little below it.
const AIM: f64 = 0.99;

/// The least samples per pixel with which `--error` ends.
const MIN_SPP: f64 = MIN_SPP_TO_TARGET as f64;

/// A root of relMSE that rounding to single precision explains.
const ROUNDING: f64 = 2e-6;

/// The price of one error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PriceRow {
    /// The root of relMSE.
    pub error: f64,
    /// Samples per pixel; `None` where there is no time.
    pub spp: Option<f64>,
    /// The time.
    pub time: Answer,
}

/// The facts from which prices follow.
#[derive(Debug, Clone, Copy)]
pub struct PriceInput<'a> {
    /// All records of the error, from few samples to many.
    pub error_records: &'a [ErrorRecord],
    /// The samples per pixel that were rendered.
    pub spp: f64,
    /// The evenly distributed ones that they are equivalent to, as those of the records.
    pub equivalent_spp: f64,
    /// The number of pixels of the scene's own size.
    pub pixels: u64,
    /// Whether the error falls in steps, as with Sobol' points.
    pub in_steps: bool,
    /// Seconds before the first sample.
    pub start: f64,
    /// Seconds of a sample of each pixel.
    pub pace: f64,
    /// The relative standard error of the pace.
    pub pace_error: f64,
    /// The reason why nothing beyond the render is known.
    pub doubt: Option<&'a str>,
}

impl PriceInput<'_> {
    /// The price of an error.
    pub fn row(&self, error: f64) -> PriceRow {
        let unknown = |why: &str| PriceRow {
            error,
            spp: None,
            time: Answer::Unknown(why.to_owned()),
        };
        let time = |spp: f64| self.start + self.pace * spp;
        if self
            .error_records
            .iter()
            .all(|record| record.rel_rmse < ROUNDING)
        {
            return PriceRow {
                error,
                spp: Some(MIN_SPP),
                time: Answer::Exact(time(MIN_SPP)),
            };
        }
        let Some((index, equivalent_spp)) = self.ends(AIM * error) else {
            return unknown("too few samples were rendered to estimate the error");
        };
        if equivalent_spp > self.equivalent_spp
            && let Some(doubt) = self.doubt
        {
            return unknown(doubt);
        }
        let samples = equivalent_spp * self.spp / self.equivalent_spp;
        let range = self.interval(index, error, samples.max(MIN_SPP));
        let [value, low, high] = [range.value, range.low, range.high].map(time);
        let range = Ranged { value, low, high };
        let time = match samples {
            _ if samples <= MIN_SPP => Answer::AtOnce(time(MIN_SPP)),
            _ if equivalent_spp <= self.equivalent_spp => Answer::Measured(range),
            _ => Answer::Law(range),
        };
        PriceRow {
            error,
            spp: Some(samples.max(MIN_SPP).ceil()),
            time,
        }
    }

    /// The samples, distributed evenly, with which `--error` ends, and the record that forecasts them: the first that
    /// does so before the next.
    fn ends(&self, error: f64) -> Option<(usize, f64)> {
        let forecast = |index: usize| {
            let error_records = &self.error_records[..=index];
            let forecast = Forecast::new(error_records, self.pixels, CONFIDENCE, self.in_steps)?;
            Some((index, forecast.samples_for(error)))
        };
        let all = (0..self.error_records.len()).filter_map(forecast);
        let is_before_next = |&(index, samples): &(usize, f64)| {
            let next = self.error_records.get(index + 1);
            next.is_none_or(|next| samples <= next.samples)
        };
        all.into_iter().find(is_before_next)
    }

    /// The interval of the samples, by the record that forecasts them.
    fn interval(&self, index: usize, error: f64, value: f64) -> Ranged {
        let error_record = &self.error_records[index];
        let law = PowerLaw::of(&self.error_records[..=index]);
        let factor = (error_record.rel_rmse / error).max(1.0);
        let [fast, likely, slow] = law.samples_for(factor);
        let margin = (SIGMAS * error_record.uncertainty)
            .hypot(SIGMAS * self.pace_error)
            .min(2.0);
        Ranged {
            value,
            low: value * fast / likely * (-margin).exp(),
            high: value * slow / likely * margin.exp(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Records of an error of 1 / sqrt(N) at 4, 16, 64, 128 ... 1024 samples.
    fn error_records() -> Vec<ErrorRecord> {
        let samples = [4.0, 16.0, 64.0, 128.0, 256.0, 512.0, 1024.0];
        let error_record = |samples: f64| ErrorRecord {
            samples,
            rel_rmse: 1.0 / samples.sqrt(),
            uncertainty: 0.02,
            bias: 0.0,
            largest_sample: 0.0,
            largest_pixel: 0.0,
        };
        samples.map(error_record).to_vec()
    }

    fn facts<'a>(error_records: &'a [ErrorRecord], doubt: Option<&'a str>) -> PriceInput<'a> {
        PriceInput {
            error_records,
            spp: 1024.0,
            equivalent_spp: 1024.0,
            pixels: 1 << 20,
            in_steps: false,
            start: 0.0,
            pace: 0.5,
            pace_error: 0.0,
            doubt,
        }
    }

    #[test]
    fn time_is_measured_within_rendered_spp_and_extrapolated_beyond() {
        let error_records = error_records();
        let facts = facts(&error_records, None);
        let [ten, one] = [0.1, 0.01].map(|error| facts.row(error));
        let Answer::Measured(range) = ten.time else {
            panic!("100 samples and a few to be sure: {ten:?}");
        };
        assert!(
            (52.0..64.0).contains(&range.value) && range.low < 54.0,
            "{range:?}"
        );
        let Answer::Law(range) = one.time else {
            panic!("10 000 samples: {one:?}");
        };
        assert!((5150.0..5900.0).contains(&range.value), "{range:?}");
        assert!((one.spp.expect("known") * 0.5 / range.value - 1.0).abs() < 1e-3);
    }

    #[test]
    fn large_error_is_reached_by_the_shortest_render() {
        let error_records = error_records();
        let row = facts(&error_records, None).row(0.4);
        assert_eq!((row.spp, row.time), (Some(8.0), Answer::AtOnce(4.0)));
    }

    #[test]
    fn doubt_makes_extrapolated_times_unknown() {
        let error_records = error_records();
        let facts = facts(&error_records, Some("rare"));
        assert!(matches!(facts.row(0.1).time, Answer::Measured(_)));
        assert_eq!(facts.row(0.01).time, Answer::Unknown("rare".to_owned()));
    }

    #[test]
    fn zero_error_gives_an_exact_answer() {
        let mut error_records = error_records();
        error_records
            .iter_mut()
            .for_each(|record| record.rel_rmse = 0.0);
        // `--error` takes that many to see that there is no noise.
        let row = facts(&error_records, None).row(0.001);
        assert_eq!((row.spp, row.time), (Some(8.0), Answer::Exact(4.0)));
    }

    #[test]
    fn time_before_the_first_sample_is_added_once() {
        let error_records = error_records();
        let of_start = |start: f64| {
            let facts = PriceInput {
                start,
                ..facts(&error_records, None)
            };
            [0.1, 0.01].map(|error| facts.row(error).time.seconds().expect("known"))
        };
        let [none, some] = [0.0, 7.0].map(of_start);
        for index in 0..2 {
            assert!((some[index] - none[index] - 7.0).abs() < 1e-9);
        }
    }

    #[test]
    fn adaptive_samples_are_converted_by_their_worth() {
        let error_records = error_records();
        let even = facts(&error_records, None);
        // The records count equivalent samples, of which the render took half as many.
        let adaptive = PriceInput { spp: 512.0, ..even };
        for error in [0.1, 0.01] {
            let [even, adaptive] = [even.row(error), adaptive.row(error)];
            let ratio = even.spp.expect("known") / adaptive.spp.expect("known");
            assert!((ratio - 2.0).abs() < 0.05, "{ratio}");
            let is_same =
                |a: &Answer, b: &Answer| std::mem::discriminant(a) == std::mem::discriminant(b);
            assert!(is_same(&even.time, &adaptive.time));
        }
    }
}
