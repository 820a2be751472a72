//! The forecast of the samples and the time that an error takes.
//!
//! Measure: samples per pixel, seconds, roots of relMSE.
//! Range: a render to an error, after its pilot.
//! Source: `src/render/budget.rs`. Tested in `cli/tests/command/render.rs`.

use super::budget::PassPlanner;
use std::time::Duration;

/// The pilot's forecast for an error to be reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// Samples per pixel of the pilot.
    pub pilot: u64,
    /// The error after the pilot.
    pub error: f64,
    /// The samples per pixel in all.
    pub spp: u64,
    /// The time in all.
    pub time: Duration,
    /// Whether the pilot was so short that another forecast will replace this one.
    pub is_rough: bool,
}

impl Predicted {
    /// The forecast by the last record of the error, `elapsed` after the start.
    pub(super) fn by(planner: &PassPlanner, elapsed: Duration) -> Option<Self> {
        let expected = planner.expected()?;
        let still = expected.spp.saturating_sub(planner.spp()) as f64;
        Some(Self {
            pilot: planner.spp(),
            error: expected.error,
            spp: expected.spp,
            time: times(elapsed, 1.0 + still / planner.new_spp()),
            is_rough: expected.is_rough,
        })
    }
}

/// A multiple of a duration, or the longest one if that is too long: an error may take longer than any duration.
fn times(duration: Duration, factor: f64) -> Duration {
    Duration::try_from_secs_f64(duration.as_secs_f64() * factor).unwrap_or(Duration::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forecast_of_an_unreachable_error_is_the_longest_duration() {
        let second = Duration::from_secs(1);
        assert_eq!(times(second, 1.5), Duration::from_millis(1500));
        for factor in [1e20, f64::INFINITY, f64::NAN] {
            assert_eq!(times(second, factor), Duration::MAX, "{factor}");
        }
    }
}
