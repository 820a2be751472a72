//! The clock of a price.
//!
//! Measure: seconds.
//! Range: negative seconds are left after the end of the budget.
//! Source: none needed. Tested in `cli/tests/command/price.rs`.

use crate::study::settings::StudyObserver;
use etendue::internals::render::{Progress, RenderObserver};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// The share of the budget that is kept for the output.
const RESERVE: f64 = 0.02;

/// The clock, which passes on cancellation.
pub(super) struct PriceClock<'a> {
    pub observer: &'a dyn StudyObserver,
    pub start: Instant,
    pub budget: f64,
}

impl PriceClock<'_> {
    /// Seconds since the start.
    pub fn elapsed(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Seconds left to measure in.
    pub fn remaining(&self) -> f64 {
        (1.0 - RESERVE) * self.budget - self.elapsed()
    }

    /// Begins a step and reports its name.
    pub fn begin(&self, what: &str) {
        let fraction = (self.elapsed() / self.budget).min(0.99);
        self.observer.progress(fraction, what);
    }
}

impl RenderObserver for PriceClock<'_> {
    fn progress(&self, _progress: &Progress) {
        self.begin("measuring the price");
    }

    fn is_cancelled(&self) -> bool {
        self.observer.is_cancelled()
    }
}

/// The clock of one render, which measures the time before its first sample.
pub(super) struct RenderClock<'a> {
    clock: &'a PriceClock<'a>,
    start: Instant,
    /// Seconds after which the irradiance cache was last worked on.
    before: Mutex<f64>,
}

impl<'a> RenderClock<'a> {
    /// The clock of a render that starts now.
    pub fn new(clock: &'a PriceClock<'a>) -> Self {
        Self {
            clock,
            start: Instant::now(),
            before: Mutex::new(0.0),
        }
    }

    /// Seconds before the first sample.
    pub fn before(&self) -> f64 {
        *self.before.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl RenderObserver for RenderClock<'_> {
    fn cache_prepass(&self, _share: f64, _records: usize) {
        let mut before = self.before.lock().unwrap_or_else(PoisonError::into_inner);
        *before = self.start.elapsed().as_secs_f64();
    }

    fn progress(&self, progress: &Progress) {
        self.clock.progress(progress);
    }

    fn is_cancelled(&self) -> bool {
        self.clock.is_cancelled()
    }
}
