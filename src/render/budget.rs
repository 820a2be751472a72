//! The number of samples of the next pass, such that a render ends when its budget is used up.
//!
//! Measure: samples per pixel, the mean where pixels differ; seconds.
//! Range: passes of 1 to `MAX_PASS` samples per pixel, multiples of a step. A time is met to within half a step: where
//! the samples of every pixel take long, that is the best that whole passes can do.
//! Source: none needed. Tested below and in `cli/tests/command/render.rs`.

use super::adaptive::allocation::Allocation;
use super::convergence::{Forecast, Look, stated};
use super::settings::{Budget, ErrorTarget};
use crate::film::ErrorEstimate;
use crate::film::batches::BATCHES;
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// The largest number of samples per pixel in one pass: between passes a render can report its error.
const MAX_PASS: u64 = 64;

/// The samples per pixel after which the error is estimated for the first time, and for the second time at the latest: the
/// pilot. The second estimate comes earlier where the first one forecasts that fewer samples are enough.
const PILOT: [u64; 2] = [16, 64];

/// A pilot has at least one in this many of the samples that it forecasts: a shorter one would extrapolate the power
/// law too far.
const SHARE_OF_PILOT: u64 = 4;

/// The samples per pixel of the first look at how the error falls, where no error is requested; the next look is after
/// [`BETWEEN_LOOKS`] times as many.
const FIRST_LOOK: u64 = 64;
/// The ratio of the samples of one such look to those of the look before.
const BETWEEN_LOOKS: u64 = 4;

/// The largest relative standard error of the squared error from which the samples to come can be forecast.
const MAX_UNCERTAINTY: f64 = 0.12;

/// The samples grow by at least one in this many from one look to the next.
const SMALL_STEP: u64 = 16;

/// The next estimate of the error is made when, of the missing samples by the forecast, all but one in this many are
/// taken.
const LAST_STEP: u64 = 5;

/// The largest number of samples that is forecast.
const FARTHEST: f64 = 1e18;

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

/// The part of a planner that a render keeps when it is interrupted, so that it ends after as many samples as if it had not
/// been.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PlannerState {
    /// The error to reach.
    target: Option<ErrorTarget>,
    next_look: u64,
    expected: Option<Expected>,
    is_reached: bool,
}

/// Plans the passes of a render.
#[derive(Debug, Clone)]
pub struct PassPlanner {
    budget: Budget,
    /// The number of which passes are multiples.
    step: u64,
    /// The samples per pixel when the clock was started.
    begun: u64,
    spp: u64,
    /// The seconds that a sample of every pixel took before the clock was started, if it is known.
    pace: Option<f64>,
    /// The samples per pixel at which the error is estimated next.
    next_look: u64,
    /// All looks. Their samples are the evenly distributed ones that those of the render are worth.
    looks: Vec<Look>,
    /// The properties of the image that a forecast needs.
    forecast_input: ForecastInput,
    expected: Option<Expected>,
    is_reached: bool,
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
    /// Creates the planner of a render that has not begun, whose passes are multiples of `step`.
    pub fn new(budget: Budget, step: u64, forecast_input: ForecastInput) -> Self {
        let next_look = match budget.error {
            Some(_) => PILOT[0],
            None => FIRST_LOOK,
        };
        Self {
            budget,
            step,
            begun: 0,
            spp: 0,
            pace: None,
            next_look,
            looks: Vec::new(),
            forecast_input,
            expected: None,
            is_reached: false,
        }
    }

    /// The planner of a render that has `spp` samples per pixel already, after these looks.
    pub fn resumed_from(self, spp: u64, looks: Vec<Look>) -> Self {
        let next_look = match self.budget.error {
            Some(_) => self.next_look,
            None => self.next_look.max(BETWEEN_LOOKS * spp),
        };
        Self {
            begun: spp,
            spp,
            next_look,
            looks,
            ..self
        }
    }

    /// The planner after an interruption: `state` is that of the planner before it, and `elapsed` the time that the samples
    /// so far took.
    pub fn restored(self, state: Option<PlannerState>, elapsed: Duration) -> Self {
        let pace = elapsed.as_secs_f64() / self.spp as f64;
        let kept = state.filter(|state| state.target == self.budget.error);
        Self {
            pace: (self.spp > 0).then_some(pace),
            next_look: kept.map_or(self.next_look, |state| state.next_look),
            expected: kept.and_then(|state| state.expected),
            is_reached: kept.is_some_and(|state| state.is_reached),
            ..self
        }
    }

    /// The part to be kept in case of an interruption.
    pub fn state(&self) -> PlannerState {
        PlannerState {
            target: self.budget.error,
            next_look: self.next_look,
            expected: self.expected,
            is_reached: self.is_reached,
        }
    }

    /// All looks at the error so far.
    pub fn looks(&self) -> &[Look] {
        &self.looks
    }

    /// The samples per pixel that are complete.
    pub fn spp(&self) -> u64 {
        self.spp
    }

    /// The forecast of when the requested error is reached, by the last look.
    pub fn expected(&self) -> Option<Expected> {
        self.expected
    }

    /// Whether the requested error is reached.
    pub fn is_reached(&self) -> bool {
        self.is_reached
    }

    /// Records a complete pass.
    pub fn pass_done(&mut self, samples: u64) {
        self.spp += samples;
    }

    /// Whether an estimate of the error is due.
    pub fn is_look_due(&self) -> bool {
        self.spp >= self.next_look
    }

    /// The error to reach.
    pub fn target(&self) -> Option<ErrorTarget> {
        self.budget.error
    }

    /// Records an estimate of the error that was due, and decides when to make the next: where the requested error is
    /// expected to be reached, and before that whenever the samples have doubled, since no power law holds for ever.
    ///
    /// Where samples are distributed by an allocation, the power law is that of what they are worth, distributed
    /// evenly.
    pub fn add_look(&mut self, error: Option<ErrorEstimate>, allocation: Option<&Allocation>) {
        let Some(error) = error else {
            // A black image: light may still be found.
            self.next_look = 2 * self.spp;
            return;
        };
        let worth = allocation.map_or(self.spp as f64, |allocation| allocation.worth(self.spp));
        let error = stated(error, worth, &self.looks);
        self.looks.push(Look::new(worth, &error));
        let Some(target) = self.budget.error else {
            self.next_look = BETWEEN_LOOKS * self.spp;
            return;
        };
        let is_pilot = self.looks.len() < 2 && self.spp < PILOT[1];
        if error.upper_bound <= target.rel_rmse && !is_pilot {
            self.is_reached = true;
            return;
        }
        if is_pilot {
            self.next_look = PILOT[1];
        }
        let in_steps = self.forecast_input.in_steps && allocation.is_none();
        let Some(forecast) = Forecast::new(
            &self.looks,
            self.forecast_input.pixels,
            target.confidence,
            in_steps,
        ) else {
            return;
        };
        let needed = forecast.samples_for(MARGIN * target.rel_rmse);
        let needed = allocation.map_or(needed, |it| it.level_of(needed));
        let needed = needed.ceil().min(FARTHEST) as u64;
        // Where the error is above the forecast by chance, a few more samples change little.
        let least = self.spp + (self.spp / SMALL_STEP).max(1);
        let needed = needed.max(least).next_multiple_of(self.step);
        if is_pilot {
            self.next_look = needed.clamp(3 * self.spp / 2, PILOT[1].max(2 * self.spp));
        } else {
            self.expected = Some(Expected {
                spp: needed,
                error: error.rel_rmse,
                is_rough: needed > SHARE_OF_PILOT * self.spp || error.uncertainty > MAX_UNCERTAINTY,
            });
            // A forecast is better from closer by: the last step is a small one, so that it does not lead far beyond.
            let close = needed - (needed - self.spp) / LAST_STEP;
            let close = close.next_multiple_of(self.step);
            let leaves_a_step = needed >= close + (close / SMALL_STEP).max(1);
            let next = if leaves_a_step { close } else { needed };
            self.next_look = next.min(2 * self.spp);
        }
    }

    /// The samples per pixel of the next pass, `elapsed` after the start; `None` when the budget is used up. The pass
    /// should not last beyond the next checkpoint, which is due in `checkpoint`.
    pub fn next_pass(&self, elapsed: Duration, checkpoint: Option<Duration>) -> Option<u64> {
        if self.is_reached {
            return None;
        }
        // Passes grow with the samples so far, so that their overhead stays a fixed small share.
        let mut pass = self.spp.clamp(self.step, MAX_PASS);
        if let Some(spp) = self.budget.spp {
            pass = pass.min(spp.next_multiple_of(self.step).saturating_sub(self.spp));
        }
        if self.budget.error.is_some() {
            pass = pass.min(self.next_look.saturating_sub(self.spp).max(self.step));
        }
        let new = self.spp - self.begun;
        let now = (new > 0).then(|| elapsed.as_secs_f64() / new as f64);
        if let (Some(time), Some(per_sample)) = (self.budget.time, now) {
            let left = time.as_secs_f64() - elapsed.as_secs_f64();
            // Steps, rounded: ending half a step late is as good as half a step early.
            let affordable = (left / (per_sample * self.step as f64)).round().max(0.0) as u64;
            // The time of a step is known better after half of the remaining time.
            let careful = if affordable > 2 {
                affordable.div_ceil(2)
            } else {
                affordable
            };
            pass = pass.min(careful.saturating_mul(self.step));
            pass -= pass % self.step;
        }
        if let (Some(left), Some(per_sample)) = (checkpoint, now.or(self.pace)) {
            let until = (left.as_secs_f64() / per_sample) as u64;
            pass = pass.min((until - until % self.step).max(self.step));
        }
        // Samples that end with a round of batches can be merged with others that do.
        let end = self.spp + pass;
        let whole = end - end % BATCHES;
        let is_last = self.budget.spp.is_some_and(|spp| end >= spp);
        if whole > self.spp && !is_last {
            pass = whole - self.spp;
        }
        (pass > 0).then_some(pass)
    }

    /// The samples per pixel since the clock was started.
    pub fn new_spp(&self) -> f64 {
        (self.spp - self.begun) as f64
    }

    /// The share of the budget used up after `per_pixel` samples per pixel and `elapsed`.
    pub fn fraction(&self, per_pixel: f64, elapsed: Duration) -> f64 {
        let share = |limit: Option<u64>| limit.map_or(0.0, |spp| per_pixel / spp as f64);
        let by_samples = share(self.budget.spp);
        let by_error = share(self.expected.map(|expected| expected.spp));
        let by_time = self
            .budget
            .time
            .map_or(0.0, |time| elapsed.as_secs_f64() / time.as_secs_f64());
        by_samples.max(by_error).max(by_time).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::MODEL_ERROR;

    /// An image whose error falls smoothly.
    const FORECAST_INPUT: ForecastInput = ForecastInput {
        pixels: 1 << 40,
        in_steps: false,
    };

    /// Runs a planner against a clock on which one sample per pixel takes `cost` seconds.
    fn run(budget: Budget, cost: f64) -> (u64, f64) {
        run_in_steps(1, budget, cost)
    }

    /// Runs a planner whose passes are multiples of `step`.
    fn run_in_steps(step: u64, budget: Budget, cost: f64) -> (u64, f64) {
        let mut planner = PassPlanner::new(budget, step, FORECAST_INPUT);
        let mut now = 0.0;
        while let Some(samples) = planner.next_pass(Duration::from_secs_f64(now), None) {
            planner.pass_done(samples);
            now += samples as f64 * cost;
        }
        (planner.spp(), now)
    }

    #[test]
    fn sample_budget_is_met_exactly() {
        for spp in [1, 2, 3, 63, 64, 65, 1000] {
            assert_eq!(
                run(
                    Budget {
                        spp: Some(spp),
                        ..Budget::default()
                    },
                    1.0
                )
                .0,
                spp
            );
        }
    }

    #[test]
    fn time_budget_is_met_within_half_a_step() {
        for (step, costs) in [(1, [0.001, 0.013, 0.3, 1.9]), (4, [0.001, 0.3, 0.9, 1.4])] {
            for cost in costs {
                let budget = Budget {
                    time: Some(Duration::from_secs(10)),
                    ..Budget::default()
                };
                let (_, now) = run_in_steps(step, budget, cost);
                assert!(
                    (now - 10.0).abs() <= 0.5 * step as f64 * cost + 1e-9,
                    "step {step}, cost {cost}: {now}"
                );
            }
        }
    }

    #[test]
    fn tighter_of_sample_and_time_budget_applies() {
        let budget = Budget {
            spp: Some(5),
            time: Some(Duration::from_secs(100)),
            ..Budget::default()
        };
        assert_eq!(run(budget, 1.0).0, 5);
        let budget = Budget {
            spp: Some(500),
            time: Some(Duration::from_secs(10)),
            ..Budget::default()
        };
        assert_eq!(run(budget, 1.0).0, 10);
    }

    #[test]
    fn passes_end_with_a_round_of_batches_but_at_the_end() {
        let mut planner = PassPlanner::new(Budget::samples(107), 1, FORECAST_INPUT);
        let mut now = 0.0;
        let checkpoint = Some(Duration::from_secs_f64(7.5));
        while let Some(samples) = planner.next_pass(Duration::from_secs_f64(now), checkpoint) {
            planner.pass_done(samples);
            now += samples as f64;
            let spp = planner.spp();
            assert!(spp < 4 || spp.is_multiple_of(4) || spp == 107, "{spp}");
        }
        assert_eq!(planner.spp(), 107);
    }

    #[test]
    fn zero_time_budget_still_takes_one_sample() {
        let budget = Budget {
            time: Some(Duration::ZERO),
            ..Budget::default()
        };
        assert_eq!(
            PassPlanner::new(budget, 1, FORECAST_INPUT).next_pass(Duration::ZERO, None),
            Some(1)
        );
    }

    #[test]
    fn resumed_render_has_the_full_time_budget() {
        let budget = Budget {
            time: Some(Duration::from_secs(10)),
            ..Budget::default()
        };
        let mut planner =
            PassPlanner::new(budget, 1, FORECAST_INPUT).resumed_from(1000, Vec::new());
        let mut now = 0.0;
        while let Some(samples) = planner.next_pass(Duration::from_secs_f64(now), None) {
            planner.pass_done(samples);
            now += samples as f64 * 0.01;
        }
        assert!((now - 10.0).abs() <= 0.005 + 1e-9, "{now}");
        assert_eq!(planner.new_spp(), 1000.0);
    }

    /// The samples, looks and forecast for a target if the error is `scale` times this power of the samples.
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
        let (mut looks, mut first) = (Vec::new(), None);
        while let Some(samples) = planner.next_pass(Duration::ZERO, None) {
            assert_eq!(samples % 4, 0);
            planner.pass_done(samples);
            if planner.is_look_due() {
                looks.push(planner.spp());
                let rel_rmse = scale * (planner.spp() as f64).powf(-power);
                let estimate = ErrorEstimate {
                    rel_rmse,
                    // Enough for rounding not to count as a rise.
                    uncertainty: 1e-6,
                    bias: 0.0,
                    largest_sample: 0.0,
                    confidence: 0.95,
                    upper_bound: (1.0 + MODEL_ERROR).sqrt() * rel_rmse,
                    doubt: None,
                };
                planner.add_look(Some(estimate), None);
                first = first
                    .filter(|it: &Expected| !it.is_rough)
                    .or(planner.expected());
            }
        }
        assert!(planner.is_reached());
        (planner.spp(), looks, first)
    }

    #[test]
    fn error_target_is_met_closely_and_forecast_accurately() {
        for power in [0.5, 0.75, 1.0] {
            for target in [0.1, 0.05, 0.01, 0.003] {
                let (spp, looks, forecast) = reach(target, 1.0, power);
                let needed = ((1.0 + MODEL_ERROR).sqrt() / target).powf(1.0 / power);
                assert!(spp as f64 >= needed, "{target} {power}: {spp}");
                assert!(
                    spp as f64 <= 1.05 * needed + 64.0,
                    "{target} {power}: {spp} of {needed}"
                );
                assert!(looks.len() < 20, "{looks:?}");
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
    fn error_target_met_at_once_stops_at_the_second_look() {
        let (spp, looks, forecast) = reach(0.5, 0.1, 0.5);
        assert_eq!((spp, looks, forecast), (24, vec![16, 24], None));
    }
}
