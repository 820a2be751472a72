//! The progress of a render, reported while it runs, and its cancellation.
//!
//! Measure: samples per pixel, seconds.
//! Range: observers are called from any thread of a render.
//! Source: none needed. Tested in `tests/rendering/resume.rs` and `cli/tests/command/render.rs`.

use super::predicted::Predicted;
use super::rendered::Rendered;
use crate::film::Film;
use std::time::Duration;

/// The progress of a render.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// The samples taken, over all pixels.
    pub samples: u64,
    /// Complete samples per pixel, the mean where pixels differ.
    pub spp: u64,
    /// Time since the rendering began.
    pub elapsed: Duration,
    /// The share of the budget that is used up, in [0, 1].
    pub fraction: f64,
    /// The estimated root of relMSE, once there is one.
    pub rel_rmse: Option<f64>,
    /// The pilot's forecast for the requested error, rough at first.
    pub predicted: Option<Predicted>,
}

/// Observes the progress of a render, from any of its threads, and can cancel it.
pub trait RenderObserver: Sync {
    /// Called before the first sample, while an irradiance cache is filled, with the share that is done and the number
    /// of records.
    fn cache_prepass(&self, _share: f64, _records: usize) {}
    /// Called after every tile.
    fn progress(&self, _progress: &Progress) {}
    /// Called after every pass, with the image so far; no thread renders meanwhile.
    fn pass(&self, _film: &Film) {}
    /// The time between two checkpoints; `None` for a render without.
    fn checkpoint_interval(&self) -> Option<Duration> {
        None
    }
    /// Called after a pass when a checkpoint is due, with the state of the render; no thread renders meanwhile.
    fn checkpoint(&self, _rendered: &Rendered) {}
    /// Whether the error so far is shown to anybody. If not, the render estimates it only where it depends on it: an estimate
    /// takes as long as some samples.
    fn shows_error(&self) -> bool {
        true
    }
    /// Whether the render should stop as soon as it can; the samples so far are kept.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// An observer that ignores everything.
#[derive(Debug, Clone, Copy, Default)]
pub struct NullRenderObserver;

impl RenderObserver for NullRenderObserver {
    fn shows_error(&self) -> bool {
        false
    }
}
