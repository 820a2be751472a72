//! The common parts of long measurements: progress with the time left, Ctrl-C, and a file with the results so far.
//!
//! Measure: seconds.
//! Range: a file that cannot be written ends the measurement as Ctrl-C does; the error is returned at the end.
//! Source: none needed. Tested in `cli/tests/command/bench.rs` and `cli/tests/command/study.rs`.

use crate::output::{ConsoleObserver, time_left};
use etendue::internals::image::atomic::write_text;
use etendue::internals::render::RenderObserver;
use etendue::{Error, Result};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Shows progress, forwards Ctrl-C, and writes results during the measurement.
pub struct MeasurementObserver<'a> {
    console: &'a ConsoleObserver,
    start: Instant,
    /// The first error of writing.
    failure: Mutex<Option<Error>>,
}

impl<'a> MeasurementObserver<'a> {
    /// Creates an observer for a measurement that starts now.
    pub fn new(console: &'a ConsoleObserver) -> Self {
        Self {
            console,
            start: Instant::now(),
            failure: Mutex::new(None),
        }
    }

    /// Shows the current step and the completed fraction of the whole.
    pub fn show(&self, fraction: f64, what: &str) {
        self.console.show(fraction, || {
            let left = time_left(fraction, self.start.elapsed());
            left.map_or(what.to_owned(), |left| format!("{what}, {left} left"))
        });
    }

    /// Whether the measurement is to stop.
    pub fn is_cancelled(&self) -> bool {
        self.failure().is_some() || self.console.is_cancelled()
    }

    /// Writes the results so far.
    pub fn write(&self, path: &Path, text: &str) {
        if let Err(error) = write_text(path, text) {
            self.failure().get_or_insert(error);
        }
    }

    /// Returns the first error of writing, if there was one.
    pub fn result(&self) -> Result<()> {
        self.failure().take().map_or(Ok(()), Err)
    }

    fn failure(&self) -> MutexGuard<'_, Option<Error>> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
