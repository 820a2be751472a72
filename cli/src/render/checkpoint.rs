//! Checkpoints of a render that goes on: written at intervals, never over those of another render or of more samples.
//!
//! Measure: none.
//! Range: any render that can be continued.
//! Source: none needed. Tested in `cli/tests/command/checkpoints.rs`.

use crate::args::RenderArguments;
use crate::output::ConsoleObserver;
use etendue::internals::film::Film;
use etendue::internals::image::atomic::ExistingFile;
use etendue::internals::render::{Progress, RenderObserver, Rendered};
use etendue::internals::session::states::save;
use etendue::internals::session::{Rendering, Session};
use etendue::internals::state::{StateHeader, read_header};
use etendue::{Error, Result};
use std::path::Path;
use std::time::Duration;

/// Writes a checkpoint, unless another process has written one of another render or of more samples there.
///
/// # Errors
/// Such a file, and errors of writing.
pub fn save_over(header: StateHeader, rendered: &Rendered, path: &Path) -> Result<()> {
    if path.symlink_metadata().is_err() {
        let saved = save(header.clone(), rendered, vec![], path, ExistingFile::Keep);
        // If there is a file now, another process was quicker.
        if saved.is_ok() || path.symlink_metadata().is_err() {
            return saved;
        }
    }
    if let Ok(old) = read_header(path) {
        let is_other = old.identity != header.identity || old.shard != header.shard;
        if old.samples() > 0 && (is_other || old.samples() > rendered.spp) {
            return Err(Error::usage(
                "was written by another process, and has another render or more samples: it is kept",
            )
            .in_file(path));
        }
    }
    save(header, rendered, vec![], path, ExistingFile::Replace)
}

/// Shows progress, forwards Ctrl-C, and writes checkpoints.
pub struct Checkpointer<'a> {
    console: &'a ConsoleObserver,
    /// The file, the time between two checkpoints and what they have in common.
    checkpoint: Option<(&'a Path, Duration, StateHeader)>,
}

impl<'a> Checkpointer<'a> {
    /// The observer of a render with these arguments.
    ///
    /// # Errors
    /// An error of Embree.
    pub fn new(
        console: &'a ConsoleObserver,
        arguments: &'a RenderArguments,
        session: &Session,
        rendering: &Rendering,
    ) -> Result<Self> {
        let state = &arguments.state;
        let checkpoint = match &state.checkpoint {
            Some(path) => Some((path.as_path(), state.every, rendering.header(session)?)),
            None => None,
        };
        Ok(Self {
            console,
            checkpoint,
        })
    }
}

impl RenderObserver for Checkpointer<'_> {
    fn cache_prepass(&self, share: f64, records: usize) {
        self.console.cache_prepass(share, records);
    }

    fn progress(&self, progress: &Progress) {
        self.console.progress(progress);
    }

    fn pass(&self, film: &Film) {
        self.console.pass(film);
    }

    fn is_cancelled(&self) -> bool {
        self.console.is_cancelled()
    }

    fn shows_error(&self) -> bool {
        self.console.shows_error()
    }

    fn checkpoint_interval(&self) -> Option<Duration> {
        let (_, every, _) = self.checkpoint.as_ref()?;
        Some(*every)
    }

    fn checkpoint(&self, rendered: &Rendered) {
        if let Some((path, _, header)) = &self.checkpoint
            && let Err(error) = save_over(header.clone(), rendered, path)
        {
            // The checkpoint before is still there, and the disk may have room again for the next one.
            self.console
                .warn(&format!("warning: no checkpoint: {error}"));
        }
    }
}
