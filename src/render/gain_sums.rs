//! The variance that light paths save, by pixel: of caustics, and of all others.
//!
//! Measure: squares of the unit of splats.
//! Range: as in `film/splats.rs`.
//! Source: `integrator/light_paths/weights.rs`. Tested in `tests/rendering/light_paths.rs`.

use crate::film::Window;
use crate::film::splats::Splats;

/// The sums of the gains of splats.
#[derive(Debug)]
pub struct GainSums {
    /// Those of caustics.
    pub caustics: Splats,
    /// Those of all other light paths.
    pub others: Splats,
}

impl GainSums {
    /// Creates empty sums for the pixels of this window.
    pub fn new(window: Window) -> Self {
        let [caustics, others] = [0, 1].map(|_| Splats::new(window));
        Self { caustics, others }
    }
}
