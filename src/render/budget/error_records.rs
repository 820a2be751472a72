//! The sample counts at which a render estimates its error, and the samples that it still takes to reach the requested one.
//!
//! Measure: samples per pixel, the mean where pixels differ; roots of relMSE.
//! Range: forecasts of at most `MAX_FORECAST` samples; without an error to reach, the estimates only show how the error falls.
//! Source: docs/accuracy.md, "The error that is printed"; `render/convergence.rs`. Tested below.

use super::PassPlanner;
use crate::film::ErrorEstimate;
use crate::film::batches::BATCHES;
use crate::render::adaptive::allocation::Allocation;
use crate::render::convergence::{
    ErrorRecord, Forecast, MIN_RECORD_SAMPLES, without_bound_if_rising,
};
use serde::{Deserialize, Serialize};

/// The samples per pixel of the first estimate where an error is requested: one sample in each batch.
pub(super) const FIRST_ESTIMATE_TO_TARGET: u64 = BATCHES;

/// The least samples per pixel with which a render to a requested error ends: those of the second estimate, since a single one
/// cannot show that the error falls as it should.
pub const MIN_SPP_TO_TARGET: u64 = 2 * FIRST_ESTIMATE_TO_TARGET;

/// The samples per pixel by which the second estimate is made that can determine a power law, unless the first one forecasts
/// that fewer samples are enough.
const PILOT: u64 = 64;

/// The largest ratio of the samples that are forecast to those of the pilot: beyond it, the power law would be extrapolated
/// too far.
const MAX_FORECAST_RATIO: u64 = 4;

/// The samples per pixel of the first estimate where no error is requested; the next estimate is after
/// [`ESTIMATE_RATIO`] times as many.
pub(super) const FIRST_ESTIMATE: u64 = 64;
/// The ratio of the samples of one such estimate to those of the estimate before.
pub(super) const ESTIMATE_RATIO: u64 = 4;

/// The largest relative standard error of the squared error from which the samples to come can be forecast.
const MAX_UNCERTAINTY: f64 = 0.12;

/// The divisor of the smallest step: the samples grow by at least 1/16 from one estimate to the next.
const SMALL_STEP: u64 = 16;

/// The divisor of the last step: the next estimate of the error is made after 4/5 of the samples that the forecast still
/// requires.
const LAST_STEP: u64 = 5;

/// The largest number of samples that is forecast.
const MAX_FORECAST: f64 = 1e18;

/// The factor, a little below 1, of the requested error at which forecasts aim, so that it is not narrowly missed.
const MARGIN: f64 = 0.99;

/// The forecast of when an error is reached.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Expected {
    /// The samples per pixel that it takes.
    pub spp: u64,
    /// The error so far.
    pub error: f64,
    /// Whether the samples so far are too few for a pilot of that many, or too uncertain.
    pub is_rough: bool,
}

/// The properties of an image that a forecast of its error needs.
#[derive(Debug, Clone, Copy)]
pub struct ForecastInput {
    /// The number of pixels.
    pub pixels: u64,
    /// Whether the error falls in steps, at powers of two of the samples, as with Sobol' points.
    pub in_steps: bool,
}

impl PassPlanner {
    /// The records of the error so far.
    pub fn error_records(&self) -> &[ErrorRecord] {
        &self.error_records
    }

    /// The forecast of when the requested error is reached, by the last record.
    pub fn expected(&self) -> Option<Expected> {
        self.expected
    }

    /// Whether an estimate of the error is due.
    pub fn is_estimate_due(&self) -> bool {
        self.spp >= self.next_estimate
    }

    /// Records an estimate of the error that was due, and decides when to make the next: where the requested error is
    /// expected to be reached, and before that whenever the samples have doubled, since no power law holds for ever.
    ///
    /// Where samples are distributed by an allocation, the power law is that of the evenly distributed
    /// samples that they are equivalent to.
    pub fn record_error(&mut self, error: Option<ErrorEstimate>, allocation: Option<&Allocation>) {
        let Some(error) = error else {
            // A black image: light may still be found.
            self.next_estimate = 2 * self.spp;
            return;
        };
        let equivalent_spp = allocation.map_or(self.spp as f64, |allocation| {
            allocation.equivalent_spp(self.spp)
        });
        let error = without_bound_if_rising(error, equivalent_spp, &self.error_records);
        self.error_records
            .push(ErrorRecord::new(equivalent_spp, &error));
        let Some(target) = self.budget.error else {
            self.next_estimate = ESTIMATE_RATIO * self.spp;
            return;
        };
        let is_confirmed = self.error_records.len() >= 2 || self.spp >= PILOT;
        if error.upper_bound <= target.rel_rmse && is_confirmed {
            self.is_reached = true;
            return;
        }
        let in_steps = self.forecast_input.in_steps && allocation.is_none();
        let Some(forecast) = Forecast::new(
            &self.error_records,
            self.forecast_input.pixels,
            target.confidence,
            in_steps,
        ) else {
            return;
        };
        let needed = forecast.samples_for(MARGIN * target.rel_rmse);
        let needed = allocation.map_or(needed, |it| it.level_of(needed));
        let needed = needed.ceil().min(MAX_FORECAST) as u64;
        // Where the error is above the forecast by chance, a few more samples change little.
        let least = self.spp + (self.spp / SMALL_STEP).max(1);
        let needed = needed.max(least).next_multiple_of(self.step);
        if self.spp < MIN_RECORD_SAMPLES {
            self.next_estimate = needed.min(MIN_RECORD_SAMPLES);
        } else if self.spp == MIN_RECORD_SAMPLES {
            self.next_estimate = needed.min(PILOT);
        } else {
            self.expected = Some(Expected {
                spp: needed,
                error: error.rel_rmse,
                is_rough: needed > MAX_FORECAST_RATIO * self.spp
                    || error.uncertainty > MAX_UNCERTAINTY,
            });
            // A forecast is better from closer by: the last step is a small one, so that it does not lead far beyond.
            let close = needed - (needed - self.spp) / LAST_STEP;
            let close = close.next_multiple_of(self.step);
            let leaves_a_step = needed >= close + (close / SMALL_STEP).max(1);
            let next = if leaves_a_step { close } else { needed };
            self.next_estimate = next.min(2 * self.spp);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Allowances;
    use crate::render::settings::{Budget, ErrorTarget};
    use std::time::Duration;

    /// An image whose error falls smoothly.
    const FORECAST_INPUT: ForecastInput = ForecastInput {
        pixels: 1 << 40,
        in_steps: false,
    };

    /// The bound over an error without uncertainty.
    fn least_bound() -> f64 {
        Allowances::default()
            .relative_bound(0.95, f64::INFINITY)
            .sqrt()
    }

    /// The samples, those at each estimate and the forecast for a target if the error is `scale` times this power of the
    /// samples.
    fn reach(target: f64, scale: f64, power: f64) -> (u64, Vec<u64>, Option<Expected>) {
        let error = ErrorTarget {
            rel_rmse: target,
            confidence: 0.95,
        };
        let budget = Budget {
            error: Some(error),
            ..Budget::default()
        };
        let mut planner = PassPlanner::new(budget, 4, FORECAST_INPUT);
        let (mut estimated_at, mut first) = (Vec::new(), None);
        while let Some(samples) = planner.next_pass(Duration::ZERO, None) {
            assert_eq!(samples % 4, 0);
            planner.pass_done(samples);
            if planner.is_estimate_due() {
                estimated_at.push(planner.spp());
                let rel_rmse = scale * (planner.spp() as f64).powf(-power);
                let estimate = ErrorEstimate {
                    rel_rmse,
                    // Enough for rounding not to count as a rise.
                    uncertainty: 1e-6,
                    bias: 0.0,
                    largest_sample: 0.0,
                    largest_pixel: 0.0,
                    confidence: 0.95,
                    upper_bound: least_bound() * rel_rmse,
                    doubt: None,
                };
                planner.record_error(Some(estimate), None);
                first = first
                    .filter(|it: &Expected| !it.is_rough)
                    .or(planner.expected());
            }
        }
        assert!(planner.is_reached());
        (planner.spp(), estimated_at, first)
    }

    #[test]
    fn error_target_is_met_closely_and_forecast_accurately() {
        for power in [0.5, 0.75, 1.0] {
            for target in [0.1, 0.05, 0.01, 0.003] {
                let (spp, estimated_at, forecast) = reach(target, 1.0, power);
                let needed = (least_bound() / target).powf(1.0 / power);
                assert!(spp as f64 >= needed, "{target} {power}: {spp}");
                assert!(
                    spp as f64 <= 1.05 * needed + 64.0,
                    "{target} {power}: {spp} of {needed}"
                );
                assert!(estimated_at.len() < 20, "{estimated_at:?}");
                if let Some(forecast) = forecast {
                    assert!(!forecast.is_rough, "{target} {power}");
                    // Within a percent, or the multiples of four that counts are.
                    let off = forecast.spp.abs_diff(spp);
                    assert!(off <= 4.max(spp / 100), "{target} {power}: {off} of {spp}");
                }
            }
        }
    }

    #[test]
    fn error_target_met_at_once_stops_at_the_second_estimate() {
        let (spp, estimated_at, forecast) = reach(0.5, 0.1, 0.5);
        assert_eq!((spp, estimated_at, forecast), (8, vec![4, 8], None));
    }
}
