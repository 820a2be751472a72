//! Two clocks: wall-clock time, and the processor time of this process.
//!
//! Measure: seconds.
//! Range: processor time is available on Unix; elsewhere it is NaN, and no run is detected as disturbed.
//! Source: clock_gettime(2), through the rustix crate. Tested below.

use serde::{Deserialize, Serialize};
use std::time::Instant;

/// The duration of some work.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Seconds {
    /// Wall-clock time.
    pub wall: f64,
    /// Processor time, summed over all processors; NaN, `null` in files, where the system does not tell it.
    #[serde(deserialize_with = "nan_for_null")]
    pub cpu: f64,
}

/// Reads a number, or NaN in place of none: JSON has no NaN.
fn nan_for_null<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    let number = Option::<f64>::deserialize(deserializer)?;
    Ok(number.unwrap_or(f64::NAN))
}

/// A stopwatch that runs from its creation.
#[derive(Debug, Clone, Copy)]
pub struct Stopwatch {
    wall: Instant,
    cpu: f64,
}

impl Stopwatch {
    /// Starts a stopwatch.
    pub fn start() -> Self {
        let cpu = cpu_seconds();
        Self {
            wall: Instant::now(),
            cpu,
        }
    }

    /// The time since the start.
    pub fn read(&self) -> Seconds {
        let wall = self.wall.elapsed().as_secs_f64();
        Seconds {
            wall,
            cpu: cpu_seconds() - self.cpu,
        }
    }
}

/// Processor time of this process, over all processors.
#[cfg(unix)]
fn cpu_seconds() -> f64 {
    use rustix::time::{ClockId, clock_gettime};
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

#[cfg(not(unix))]
fn cpu_seconds() -> f64 {
    f64::NAN
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn wall_clock_counts_sleep_and_cpu_clock_counts_work() {
        let stopwatch = Stopwatch::start();
        std::thread::sleep(Duration::from_millis(30));
        let slept = stopwatch.read().wall;
        assert!(slept >= 0.03, "{slept}");
        // The processor clock covers all threads of this test program, and advances at least as fast as this one works.
        let stopwatch = Stopwatch::start();
        let mut number = 1.0_f64;
        while stopwatch.read().cpu < 0.01 {
            number = std::hint::black_box(number.sin() + 1.0);
        }
        assert!(stopwatch.read().wall > 0.0 && number > 0.0);
    }
}
