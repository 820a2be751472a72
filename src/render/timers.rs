//! The times at which a render writes its next checkpoint, and at which it estimates the error to show it.
//!
//! Measure: time that passes.
//! Range: any interval.
//! Source: none needed. Tested through `run.rs`.

use std::time::{Duration, Instant};

/// The time between estimates of the error that are only shown.
const MIN_ESTIMATE_INTERVAL: Duration = Duration::from_secs(2);

/// The estimates that are only shown take at most one in this many parts of the time.
const MAX_ESTIMATE_SHARE: u32 = 100;

/// The times of checkpoints.
pub(super) struct Checkpoints {
    interval: Option<Duration>,
    last: Instant,
}

impl Checkpoints {
    pub(super) fn new(interval: Option<Duration>, start: Instant) -> Self {
        Self {
            interval,
            last: start,
        }
    }

    /// The time until the next checkpoint.
    pub(super) fn remaining(&self) -> Option<Duration> {
        let interval = self.interval?;
        Some(interval.saturating_sub(self.last.elapsed()))
    }

    pub(super) fn is_due(&self) -> bool {
        self.remaining() == Some(Duration::ZERO)
    }

    pub(super) fn made(&mut self) {
        self.last = Instant::now();
    }
}

/// The times of estimates of the error that are only shown: an estimate takes one thread's time.
pub(super) struct Estimates {
    last: Instant,
    pause: Duration,
}

impl Estimates {
    pub(super) fn new(start: Instant) -> Self {
        Self {
            last: start,
            pause: MIN_ESTIMATE_INTERVAL,
        }
    }

    pub(super) fn are_due(&self) -> bool {
        self.last.elapsed() > self.pause
    }

    pub(super) fn made(&mut self, begun: Instant) {
        self.last = Instant::now();
        self.pause = MIN_ESTIMATE_INTERVAL.max(MAX_ESTIMATE_SHARE * begun.elapsed());
    }
}
