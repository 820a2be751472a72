//! Rendering threads, kept from one render to the next.
//!
//! Measure: none.
//! Range: at least one thread; renders that share them at the same time take turns by tiles.
//! Source: none needed. Tested in `tests/rendering/resume.rs`.

use crate::error::{Error, Result};

/// A pool of rendering threads.
#[derive(Debug)]
pub struct Threads(rayon::ThreadPool);

impl Threads {
    /// Starts `count` threads.
    ///
    /// # Errors
    /// If the system refuses, or `count` is 0.
    pub fn new(count: usize) -> Result<Self> {
        if count == 0 {
            return Err(Error::usage("threads must be at least 1"));
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
        pool.map(Self)
            .map_err(|error| Error::render("cannot start the threads").because(error))
    }

    /// The number of threads.
    pub fn count(&self) -> usize {
        self.0.current_num_threads()
    }

    /// Runs `work` on the threads, and waits until it is done.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.0.install(work)
    }
}
