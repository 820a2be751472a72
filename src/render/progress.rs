//! How a render tells of itself while it goes on, and can be ended.
//!
//! Measure: samples per pixel, seconds.
//! Range: observers are called from any thread of a render.
//! Source: none needed. Tested in `tests/rendering/resume.rs` and `cli/tests/command/render.rs`.

use super::budget::PassPlanner;
use crate::film::Film;
use std::time::Duration;

/// How far a render has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Samples taken, over all pixels.
    pub samples: u64,
    /// Samples per pixel that are complete, in the mean where pixels differ.
    pub spp: u64,
    /// Time since the rendering began.
    pub elapsed: Duration,
    /// The share of the budget that is used up, in [0, 1].
    pub fraction: f64,
    /// Estimated root of relMSE, once it can be told.
    pub rel_rmse: Option<f64>,
    /// What the pilot told of the error that is asked for, roughly at first.
    pub predicted: Option<Predicted>,
}

/// What the pilot told of an error that is to be reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// Samples per pixel of the pilot.
    pub pilot: u64,
    /// The error after the pilot: its bound, or the estimate where it has none.
    pub error: f64,
    /// Samples per pixel in all.
    pub spp: u64,
    /// Time in all.
    pub time: Duration,
    /// Whether the pilot was so short that another forecast will take the place of this one.
    pub is_rough: bool,
}

impl Predicted {
    /// What the last look at the error told, `elapsed` after the start.
    pub(super) fn by(planner: &PassPlanner, elapsed: Duration) -> Option<Self> {
        let expected = planner.expected()?;
        let still = expected.spp.saturating_sub(planner.spp()) as f64;
        Some(Self {
            pilot: planner.spp(),
            error: expected.error,
            spp: expected.spp,
            time: elapsed.mul_f64(1.0 + still / planner.new_spp()),
            is_rough: expected.is_rough,
        })
    }
}

/// Is told how a render goes on, from any of its threads, and can end it.
pub trait RenderObserver: Sync {
    /// Before the first sample, while an irradiance cache is filled: the share of that which is done, and its records.
    fn cache_prepass(&self, _share: f64, _records: usize) {}
    /// After every tile.
    fn progress(&self, _progress: &Progress) {}
    /// After every pass, with the picture so far; no thread renders meanwhile.
    fn pass(&self, _film: &Film) {}
    /// Whether the render should stop as soon as it can; the samples so far are kept.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// Nobody watches.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unwatched;

impl RenderObserver for Unwatched {}
