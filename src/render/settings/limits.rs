//! The limits of a render: samples, time and error; and the pilot of an adaptive render within them.
//!
//! Measure: samples per pixel, seconds, the root of relMSE.
//! Range: stated at each field; `validate.rs` checks it.
//! Source: none needed. Tested in `src/render/budget.rs` and `tests/rendering/adaptive.rs`.

use crate::film::batches::BATCHES;
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// The samples per pixel of an adaptive render's pilot, where that is not too large a share.
pub const ADAPTIVE_PILOT: u64 = 64;

/// The budget over the largest pilot: a pilot ends at the latest when a fourth of the budget is used up.
pub const MIN_PILOT_DIVISOR: u64 = 4;

/// The budget over the usual pilot of a long render: a pilot continues until a sixteenth of the budget is used up, because a
/// longer pilot estimates better, and no pixel gets fewer samples in the end.
pub const PILOT_DIVISOR: u64 = 16;

/// The limits of a render, which stops at the first that is reached.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Budget {
    /// The largest number of samples per pixel, at least 1: the mean over the pixels with two-phase sampling, the count
    /// of each with greedy sampling.
    pub spp: Option<u64>,
    /// The largest time, for the rendering alone. The last pass ends as near to it as passes allow.
    pub time: Option<Duration>,
    /// The error to reach.
    pub error: Option<ErrorTarget>,
}

impl Budget {
    /// A budget of `spp` samples per pixel.
    pub fn samples(spp: u64) -> Self {
        Self {
            spp: Some(spp),
            ..Self::default()
        }
    }

    /// A budget of this time.
    pub fn time(time: Duration) -> Self {
        Self {
            time: Some(time),
            ..Self::default()
        }
    }

    /// The samples per pixel, if nothing else limits the render.
    pub fn only_samples(self) -> Option<u64> {
        self.spp
            .filter(|_| self.time.is_none() && self.error.is_none())
    }

    /// The samples per pixel of an adaptive render's pilot, as far as they are known before the first of them.
    pub fn pilot(self) -> u64 {
        let may_end_before = self.error.is_some() || self.time.is_some();
        let samples = self.spp.map_or(ADAPTIVE_PILOT, |spp| {
            let long = if may_end_before {
                0
            } else {
                spp.div_ceil(PILOT_DIVISOR)
            };
            ADAPTIVE_PILOT
                .min(spp.div_ceil(MIN_PILOT_DIVISOR))
                .max(long)
        });
        samples.max(1).next_multiple_of(BATCHES)
    }
}

/// An error to reach.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorTarget {
    /// The root of relMSE, above 0 and below 1.
    pub rel_rmse: f64,
    /// The probability with which the error is below that, above 0 and below 1.
    pub confidence: f64,
}
