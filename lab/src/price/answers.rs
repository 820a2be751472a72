//! The time and the samples that `render --error` takes to some errors, by the looks of a render at its own error.
//!
//! The forecast is that of `--error` itself: it ends where the bound of the error is small enough.
//!
//! Measure: samples per pixel; seconds at the scene's own size; errors as roots of relMSE.
//! Range: at least one look; intervals have a confidence of 95 %, for the uncertainty of the error and of its power law.
//! Source: `src/render/convergence.rs`, `src/render/budget.rs`. Tested below and in `cli/tests/command/price.rs`.

use crate::study::answer::Answer;
use crate::study::bootstrap::Ranged;
use etendue::internals::render::CONFIDENCE;
use etendue::internals::render::convergence::{Forecast, Look, PowerLaw};
use serde::Serialize;

/// The number of standard errors of an interval.
pub(super) const SIGMAS: f64 = 2.0;

/// Where an error is requested, forecasts aim a little below it.
const AIM: f64 = 0.99;

/// The least samples per pixel with which `--error` ends.
const MIN_SPP: f64 = 24.0;

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
    /// All looks, from few samples to many.
    pub looks: &'a [Look],
    /// The samples per pixel that were rendered.
    pub spp: f64,
    /// The evenly distributed ones that they are worth, as those of the looks.
    pub worth: f64,
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
        if self.looks.iter().all(|look| look.rel_rmse < ROUNDING) {
            return PriceRow {
                error,
                spp: Some(MIN_SPP),
                time: Answer::Exact(time(MIN_SPP)),
            };
        }
        let Some((index, worth)) = self.ends(AIM * error) else {
            return unknown("too few samples were rendered to estimate the error");
        };
        if worth > self.worth
            && let Some(doubt) = self.doubt
        {
            return unknown(doubt);
        }
        let samples = worth * self.spp / self.worth;
        let range = self.interval(index, error, samples.max(MIN_SPP));
        let [value, low, high] = [range.value, range.low, range.high].map(time);
        let range = Ranged { value, low, high };
        let time = match samples {
            _ if samples <= MIN_SPP => Answer::AtOnce(time(MIN_SPP)),
            _ if worth <= self.worth => Answer::Measured(range),
            _ => Answer::Law(range),
        };
        PriceRow {
            error,
            spp: Some(samples.max(MIN_SPP).ceil()),
            time,
        }
    }

    /// The samples, distributed evenly, with which `--error` ends, and the look that forecasts them: the first that
    /// does so before the next.
    fn ends(&self, error: f64) -> Option<(usize, f64)> {
        let forecast = |index: usize| {
            let looks = &self.looks[..=index];
            let forecast = Forecast::new(looks, self.pixels, CONFIDENCE, self.in_steps)?;
            Some((index, forecast.samples_for(error)))
        };
        let all = (0..self.looks.len()).filter_map(forecast);
        let is_before_next = |&(index, samples): &(usize, f64)| {
            let next = self.looks.get(index + 1);
            next.is_none_or(|next| samples <= next.samples)
        };
        all.into_iter().find(is_before_next)
    }

    /// The interval of the samples, by the look that forecasts them.
    fn interval(&self, index: usize, error: f64, value: f64) -> Ranged {
        let look = &self.looks[index];
        let law = PowerLaw::of(&self.looks[..=index]);
        let factor = (look.rel_rmse / error).max(1.0);
        let [fast, likely, slow] = law.samples_for(factor);
        let margin = (SIGMAS * look.uncertainty)
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

    /// Looks at an error of 1 / sqrt(N) at 16, 64, 128 ... 1024 samples.
    fn looks() -> Vec<Look> {
        let samples = [16.0, 64.0, 128.0, 256.0, 512.0, 1024.0];
        let look = |samples: f64| Look {
            samples,
            rel_rmse: 1.0 / samples.sqrt(),
            uncertainty: 0.02,
            bias: 0.0,
            largest_sample: 0.0,
        };
        samples.map(look).to_vec()
    }

    fn facts<'a>(looks: &'a [Look], doubt: Option<&'a str>) -> PriceInput<'a> {
        PriceInput {
            looks,
            spp: 1024.0,
            worth: 1024.0,
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
        let looks = looks();
        let facts = facts(&looks, None);
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
        let looks = looks();
        let row = facts(&looks, None).row(0.4);
        assert_eq!((row.spp, row.time), (Some(24.0), Answer::AtOnce(12.0)));
    }

    #[test]
    fn doubt_makes_extrapolated_times_unknown() {
        let looks = looks();
        let facts = facts(&looks, Some("rare"));
        assert!(matches!(facts.row(0.1).time, Answer::Measured(_)));
        assert_eq!(facts.row(0.01).time, Answer::Unknown("rare".to_owned()));
    }

    #[test]
    fn zero_error_gives_an_exact_answer() {
        let mut looks = looks();
        looks.iter_mut().for_each(|look| look.rel_rmse = 0.0);
        // `--error` takes that many to see that there is no noise.
        let row = facts(&looks, None).row(0.001);
        assert_eq!((row.spp, row.time), (Some(24.0), Answer::Exact(12.0)));
    }

    #[test]
    fn time_before_the_first_sample_is_added_once() {
        let looks = looks();
        let of_start = |start: f64| {
            let facts = PriceInput {
                start,
                ..facts(&looks, None)
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
        let looks = looks();
        let even = facts(&looks, None);
        // The looks count samples that are worth as much, of which the render took half as many.
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
