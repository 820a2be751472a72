//! The rays and the rejected samples of a part of a render: a tile's pass, a Markov chain, or all of them together.
//!
//! Measure: counts.
//! Range: any; the sum does not depend on the order of the parts.
//! Source: none needed. Tested in `tests/rendering/determinism.rs` and `tests/rendering/state.rs`.

use crate::integrator::RayCounts;
use serde::{Deserialize, Serialize};

/// A sample that was not a finite number: enough to replay it with the render's seed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct NonFiniteSample {
    /// The row of its pixel.
    pub y: u32,
    /// The column of its pixel.
    pub x: u32,
    /// The index of the sample.
    pub sample: u64,
}

/// The samples that were not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Rejected {
    /// The number of them.
    pub count: u64,
    /// The first one in reading order.
    pub first: Option<NonFiniteSample>,
}

impl Rejected {
    /// Merges other rejected samples, of which at most 2^64 - 1 are counted; the result does not depend on the order.
    pub fn merge(&mut self, other: Self) {
        self.count = self.count.saturating_add(other.count);
        self.first = self.first.into_iter().chain(other.first).min();
    }
}

/// The counts of a part of a render.
#[derive(Debug, Clone, Copy, Default)]
pub struct Tally {
    pub rays: RayCounts,
    pub rejected: Rejected,
}

impl Tally {
    /// Adds the counts of another part.
    pub fn merge(&mut self, other: Self) {
        self.rays += other.rays;
        self.rejected.merge(other.rejected);
    }

    /// The counts of two parts together.
    pub fn merged(mut self, other: Self) -> Self {
        self.merge(other);
        self
    }
}
