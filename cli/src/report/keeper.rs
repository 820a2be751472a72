//! What long measurements have in common: progress with the time left, Ctrl-C, and what is done so far in a file.
//!
//! Measure: seconds.
//! Range: a file that cannot be written ends the work, as Ctrl-C does, and is the result.
//! Source: none needed. Tested in `cli/tests/command/bench.rs` and `cli/tests/command/study.rs`.

use crate::output::{Watcher, time_left};
use etendue::internals::image::atomic::write_text;
use etendue::internals::render::RenderObserver;
use etendue::{Error, Result};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Shows progress, passes Ctrl-C on, and writes what is measured while it goes on.
pub struct Keeper<'a> {
    watcher: &'a Watcher,
    start: Instant,
    /// Why writing failed.
    failure: Mutex<Option<Error>>,
}

impl<'a> Keeper<'a> {
    /// For work that begins now.
    pub fn new(watcher: &'a Watcher) -> Self {
        Self {
            watcher,
            start: Instant::now(),
            failure: Mutex::new(None),
        }
    }

    /// Shows what is being done, with this share of all behind it.
    pub fn show(&self, fraction: f64, what: &str) {
        self.watcher.show(fraction, || {
            let left = time_left(fraction, self.start.elapsed());
            left.map_or(what.to_owned(), |left| format!("{what}, {left} left"))
        });
    }

    /// Whether to stop.
    pub fn is_cancelled(&self) -> bool {
        self.failure().is_some() || self.watcher.is_cancelled()
    }

    /// Writes what is done so far.
    pub fn keep(&self, path: &Path, text: &str) {
        if let Err(error) = write_text(path, text) {
            self.failure().get_or_insert(error);
        }
    }

    /// Whether everything could be written.
    pub fn result(&self) -> Result<()> {
        self.failure().take().map_or(Ok(()), Err)
    }

    fn failure(&self) -> MutexGuard<'_, Option<Error>> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
