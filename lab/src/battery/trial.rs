//! With what a case is measured.
//!
//! Measure: samples.
//! Range: any backend and seed.
//! Source: docs/hard-cases.md. Tested in `lab/tests/reports/battery.rs`.

use etendue::internals::accel::AccelOptions;
use etendue::internals::render::RenderObserver;
use serde::Serialize;

/// How much is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// As little as the power limits allow.
    Quick,
    /// Eight times as many samples, and the long rows at full length.
    Full,
}

/// With what a case is measured.
pub struct Trial<'a> {
    /// How rays are traced.
    pub options: AccelOptions,
    /// Picks one of 2^64 sets of random numbers.
    pub seed: u64,
    /// How much is measured.
    pub effort: Effort,
    /// Whether to end as soon as possible; what was measured until then is thrown away.
    pub is_cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl Trial<'_> {
    /// The samples that a case takes that needs at least `quick` of them.
    pub fn samples(&self, quick: u64) -> u64 {
        self.either(quick, 8 * quick)
    }

    /// One of two, by the effort.
    pub fn either<T>(&self, quick: T, full: T) -> T {
        match self.effort {
            Effort::Quick => quick,
            Effort::Full => full,
        }
    }
}

impl RenderObserver for Trial<'_> {
    fn is_cancelled(&self) -> bool {
        (self.is_cancelled)()
    }
}
