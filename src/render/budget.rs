//! How many samples the next pass takes, so that a render ends when it should.
//!
//! Measure: samples per pixel, seconds.
//! Range: passes of 1 to `LARGEST_PASS` samples per pixel. A time is met to within half a sample per pixel: where one
//! sample of every pixel takes long, that is the best that whole passes can do.
//! Source: none needed. Tested below and in `tests/command.rs`.

use super::camera_rays::LARGEST_BLOCK;
use super::settings::Budget;
use std::time::Duration;

/// Samples per pixel in one pass at most: between passes a render can report its error.
const LARGEST_PASS: u64 = 64;

/// Decides on passes as time goes by.
#[derive(Debug, Clone)]
pub struct PassPlanner {
    budget: Budget,
    spp: u64,
}

impl PassPlanner {
    /// For a render that has not begun.
    pub fn new(budget: Budget) -> Self {
        Self { budget, spp: 0 }
    }

    /// Samples per pixel that are complete.
    pub fn spp(&self) -> u64 {
        self.spp
    }

    /// Takes note of a complete pass.
    pub fn pass_done(&mut self, samples: u64) {
        self.spp += samples;
    }

    /// The next pass's samples per pixel, `elapsed` after the start; `None` when the budget is used up.
    pub fn next_pass(&self, elapsed: Duration) -> Option<u64> {
        // Passes grow with what is already there, so that their overhead stays a fixed small share.
        let mut pass = self.spp.clamp(1, LARGEST_PASS);
        if let Some(spp) = self.budget.spp {
            pass = pass.min(spp.saturating_sub(self.spp));
        }
        if let Some(time) = self.budget.time
            && self.spp > 0
        {
            let per_sample = elapsed.as_secs_f64() / self.spp as f64;
            let left = time.as_secs_f64() - elapsed.as_secs_f64();
            // Rounded: ending half a sample late is as good as half a sample early.
            let affordable = (left / per_sample).round().max(0.0) as u64;
            // The time of a sample is known better after half of what is left.
            let careful = if affordable > 2 {
                affordable.div_ceil(2)
            } else {
                affordable
            };
            pass = pass.min(careful);
            // Half of a block costs as many camera rays as all of it.
            let end = self.spp + pass;
            let whole = end - end % LARGEST_BLOCK;
            if whole > self.spp {
                pass = whole - self.spp;
            }
        }
        (pass > 0).then_some(pass)
    }

    /// The share of the budget used up after `per_pixel` samples per pixel and `elapsed`.
    pub fn fraction(&self, per_pixel: f64, elapsed: Duration) -> f64 {
        let by_samples = self.budget.spp.map_or(0.0, |spp| per_pixel / spp as f64);
        let by_time = self
            .budget
            .time
            .map_or(0.0, |time| elapsed.as_secs_f64() / time.as_secs_f64());
        by_samples.max(by_time).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs a planner against a clock on which one sample per pixel takes `cost` seconds.
    fn run(budget: Budget, cost: f64) -> (u64, f64) {
        let mut planner = PassPlanner::new(budget);
        let mut now = 0.0;
        while let Some(samples) = planner.next_pass(Duration::from_secs_f64(now)) {
            planner.pass_done(samples);
            now += samples as f64 * cost;
        }
        (planner.spp(), now)
    }

    #[test]
    fn samples_are_met_exactly() {
        for spp in [1, 2, 3, 63, 64, 65, 1000] {
            assert_eq!(
                run(
                    Budget {
                        spp: Some(spp),
                        time: None
                    },
                    1.0
                )
                .0,
                spp
            );
        }
    }

    #[test]
    fn a_time_is_met_within_half_a_sample() {
        for cost in [0.001, 0.013, 0.3, 1.9] {
            let budget = Budget {
                spp: None,
                time: Some(Duration::from_secs(10)),
            };
            let (_, now) = run(budget, cost);
            assert!(
                (now - 10.0).abs() <= 0.5 * cost + 1e-9,
                "cost {cost}: {now}"
            );
        }
    }

    #[test]
    fn the_tighter_of_two_limits_holds() {
        let budget = Budget {
            spp: Some(5),
            time: Some(Duration::from_secs(100)),
        };
        assert_eq!(run(budget, 1.0).0, 5);
        let budget = Budget {
            spp: Some(500),
            time: Some(Duration::from_secs(10)),
        };
        assert_eq!(run(budget, 1.0).0, 10);
    }

    #[test]
    fn there_is_always_a_first_sample() {
        let budget = Budget {
            spp: None,
            time: Some(Duration::ZERO),
        };
        assert_eq!(PassPlanner::new(budget).next_pass(Duration::ZERO), Some(1));
    }
}
