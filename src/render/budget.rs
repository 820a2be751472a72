//! The number of samples of the next pass, such that a render ends when its budget is used up. `budget/error_records.rs`
//! decides when the error is estimated.
//!
//! Measure: samples per pixel, the mean where pixels differ; seconds.
//! Range: passes of 1 to `MAX_PASS` samples per pixel, multiples of a step. A time is met to within half a step: where
//! the samples of every pixel take long, that is the best that whole passes can do.
//! Source: none needed. Tested below and in `cli/tests/command/render.rs`.

mod error_records;

pub use error_records::{Expected, ForecastInput, MIN_SPP_TO_TARGET};

use super::convergence::ErrorRecord;
use super::settings::{Budget, ErrorTarget};
use crate::film::batches::BATCHES;
use error_records::{ESTIMATE_RATIO, FIRST_ESTIMATE, FIRST_ESTIMATE_TO_TARGET};
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// The largest number of samples per pixel in one pass: between passes a render can report its error.
const MAX_PASS: u64 = 64;

/// The part of a planner that a render keeps when it is interrupted, so that it ends after as many samples as if it had not
/// been.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PlannerState {
    /// The error to reach.
    target: Option<ErrorTarget>,
    #[serde(rename = "next_look")]
    next_estimate: u64,
    expected: Option<Expected>,
    is_reached: bool,
}

impl PlannerState {
    /// The error to reach, if there is one.
    pub fn target(&self) -> Option<ErrorTarget> {
        self.target
    }
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
    next_estimate: u64,
    /// The records of the error so far, at equivalent counts of evenly distributed samples.
    error_records: Vec<ErrorRecord>,
    /// The properties of the image that a forecast needs.
    forecast_input: ForecastInput,
    expected: Option<Expected>,
    is_reached: bool,
    /// Whether a render that its time ends finishes its round of batches.
    in_rounds: bool,
}

impl PassPlanner {
    /// Creates the planner of a render that has not begun, whose passes are multiples of `step`.
    pub fn new(budget: Budget, step: u64, forecast_input: ForecastInput) -> Self {
        let next_estimate = match budget.error {
            Some(_) => FIRST_ESTIMATE_TO_TARGET,
            None => FIRST_ESTIMATE,
        };
        Self {
            budget,
            step,
            begun: 0,
            spp: 0,
            pace: None,
            next_estimate,
            error_records: Vec::new(),
            forecast_input,
            expected: None,
            is_reached: false,
            in_rounds: false,
        }
    }

    /// The planner of a render whose samples are added to others of their own ranges, as those of shards: where its time
    /// ends it, it finishes its round of batches, since of two ranges that end within one no error bars can be estimated.
    pub fn in_rounds(self, in_rounds: bool) -> Self {
        Self { in_rounds, ..self }
    }

    /// The planner of a render that has `spp` samples per pixel already, and these records of its error.
    pub fn resumed_from(self, spp: u64, error_records: Vec<ErrorRecord>) -> Self {
        let next_estimate = match self.budget.error {
            Some(_) => self.next_estimate,
            None => self.next_estimate.max(ESTIMATE_RATIO * spp),
        };
        Self {
            begun: spp,
            spp,
            next_estimate,
            error_records,
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
            next_estimate: kept.map_or(self.next_estimate, |state| state.next_estimate),
            expected: kept.and_then(|state| state.expected),
            is_reached: kept.is_some_and(|state| state.is_reached),
            ..self
        }
    }

    /// The part to be kept in case of an interruption.
    pub fn state(&self) -> PlannerState {
        PlannerState {
            target: self.budget.error,
            next_estimate: self.next_estimate,
            expected: self.expected,
            is_reached: self.is_reached,
        }
    }

    /// The samples per pixel that are complete.
    pub fn spp(&self) -> u64 {
        self.spp
    }

    /// Whether the requested error is reached.
    pub fn is_reached(&self) -> bool {
        self.is_reached
    }

    /// Records a complete pass.
    pub fn pass_done(&mut self, samples: u64) {
        self.spp += samples;
    }

    /// The error to reach.
    pub fn target(&self) -> Option<ErrorTarget> {
        self.budget.error
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
            pass = pass.min(self.next_estimate.saturating_sub(self.spp).max(self.step));
        }
        let new = self.spp - self.begun;
        let now = (new > 0).then(|| elapsed.as_secs_f64() / new as f64);
        if let (Some(time), Some(per_sample)) = (self.budget.time, now) {
            let remaining = time.as_secs_f64() - elapsed.as_secs_f64();
            // Steps, rounded: ending half a step late is as good as half a step early.
            let affordable = (remaining / (per_sample * self.step as f64))
                .round()
                .max(0.0) as u64;
            // The time of a step is known better after half of the remaining time.
            let careful = if affordable > 2 {
                affordable.div_ceil(2)
            } else {
                affordable
            };
            pass = pass.min(careful.saturating_mul(self.step));
            pass -= pass % self.step;
        }
        if let (Some(remaining), Some(per_sample)) = (checkpoint, now.or(self.pace)) {
            let until = (remaining.as_secs_f64() / per_sample) as u64;
            pass = pass.min((until - until % self.step).max(self.step));
        }
        if pass == 0 && self.in_rounds {
            let remaining = self
                .budget
                .spp
                .map_or(u64::MAX, |spp| spp.saturating_sub(self.spp));
            pass = (self.spp.next_multiple_of(BATCHES) - self.spp).min(remaining);
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
}
