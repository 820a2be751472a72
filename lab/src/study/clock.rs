//! Two clocks: the time that passed, and the time that processors worked for this process.
//!
//! Measure: seconds.
//! Range: Unix tells the processors' time; elsewhere it is not a number, and no run is found to be disturbed.
//! Source: clock_gettime(2), through the rustix crate. Tested below.

use serde::Serialize;
use std::time::Instant;

/// What something took.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Seconds {
    /// That passed.
    pub wall: f64,
    /// That all processors together worked for it.
    pub cpu: f64,
}

/// Measures from when it is made.
#[derive(Debug, Clone, Copy)]
pub struct Stopwatch {
    wall: Instant,
    cpu: f64,
}

impl Stopwatch {
    /// Begins.
    pub fn start() -> Self {
        let cpu = cpu_seconds();
        Self {
            wall: Instant::now(),
            cpu,
        }
    }

    /// Since it began.
    pub fn read(&self) -> Seconds {
        let wall = self.wall.elapsed().as_secs_f64();
        Seconds {
            wall,
            cpu: cpu_seconds() - self.cpu,
        }
    }
}

/// What all processors have worked for this process.
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
    fn a_thread_that_sleeps_costs_no_work_and_one_that_works_does() {
        let watch = Stopwatch::start();
        std::thread::sleep(Duration::from_millis(30));
        let slept = watch.read().wall;
        assert!(slept >= 0.03, "{slept}");
        // The clock of all threads of this test program goes on at least as fast as this one works.
        let watch = Stopwatch::start();
        let mut number = 1.0_f64;
        while watch.read().cpu < 0.01 {
            number = std::hint::black_box(number.sin() + 1.0);
        }
        assert!(watch.read().wall > 0.0 && number > 0.0);
    }
}
