//! The conditions under which a case is measured.
//!
//! Measure: samples.
//! Range: any backend and seed.
//! Source: docs/hard-cases.md. Tested in `lab/tests/reports/battery.rs`.

use etendue::internals::accel::AccelOptions;
use etendue::internals::render::RenderObserver;
use serde::Serialize;

/// The amount of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// The fewest samples that the power limits allow.
    Quick,
    /// Eight times as many samples, and the long rows at full length.
    Full,
}

/// The conditions under which a case is measured.
pub struct Trial<'a> {
    /// Options of the acceleration structure.
    pub options: AccelOptions,
    /// Selects one of 2^64 sets of random numbers.
    pub seed: u64,
    /// The effort.
    pub effort: Effort,
    /// Whether to end as soon as possible; the measurement is then discarded.
    pub is_cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl Trial<'_> {
    /// The number of samples for a case that needs at least `quick` of them.
    pub fn samples(&self, quick: u64) -> u64 {
        self.either(quick, 8 * quick)
    }

    /// Selects one of two values by the effort.
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
