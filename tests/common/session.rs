//! Sessions, folders for their files, and interruptions.
//!
//! Measure: samples per pixel.
//! Range: valid scenes; the folder is deleted when its value is dropped.
//! Source: none needed.

use super::scene_folder::load_text;
use etendue::internals::accel::AccelOptions;
use etendue::internals::render::{Progress, RenderObserver};
use etendue::internals::scene::description::SceneDescription;
use etendue::internals::session::{Session, tracing};
use std::sync::atomic::{AtomicU64, Ordering};
use tempfile::TempDir;

/// A session of a scene, given as text.
pub fn session(text: &str, threads: usize) -> Session {
    session_of(load_text(text), threads)
}

/// A session of a scene.
pub fn session_of(description: SceneDescription, threads: usize) -> Session {
    let options = AccelOptions {
        threads,
        ..tracing()
    };
    Session::new(description, options).expect("a valid scene")
}

/// An empty folder.
pub fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

/// Cancels a render after a number of tiles.
pub struct CancelAfter {
    tiles: AtomicU64,
}

impl CancelAfter {
    /// Lets a render complete this many tiles.
    pub fn tiles(count: u64) -> Self {
        Self {
            tiles: AtomicU64::new(count),
        }
    }
}

impl RenderObserver for CancelAfter {
    fn progress(&self, _: &Progress) {
        let fewer = |left: u64| left.checked_sub(1);
        let _ = self
            .tiles
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, fewer);
    }

    fn is_cancelled(&self) -> bool {
        self.tiles.load(Ordering::Relaxed) == 0
    }
}
