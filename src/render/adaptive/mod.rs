//! Adaptive sampling: the distribution of samples over the pixels.
//!
//! Measure: samples per pixel. The *level* of a render is the mean over the pixels, or, for greedy sampling, the count
//! of a pixel that has not stopped.
//! Range: counts are whole rounds of batches.
//! Source: docs/accuracy.md, "Adaptive sampling". Tested in `tests/rendering/adaptive.rs`.

pub mod allocation;
mod greedy;

use super::settings::{Adaptive, LARGEST_SHARE_OF_PILOT, PILOT, RenderSettings, SHARE_OF_PILOT};
use crate::film::Film;
use allocation::Allocation;

/// Whether a pilot of `level` samples per pixel, which has used up the share `used` of the budget, is long enough.
fn is_over(level: u64, used: f64) -> bool {
    let uses = |share: u64| used * share as f64 >= 1.0;
    uses(LARGEST_SHARE_OF_PILOT) || (level >= PILOT && uses(SHARE_OF_PILOT))
}

/// The samples of the next pass.
#[derive(Debug, Clone, PartialEq)]
pub enum SampleAllocation {
    /// Equally many for every pixel.
    Evenly,
    /// The count that every pixel is to have after the pass, row by row.
    UpTo(Vec<u64>),
    /// No samples: no pixel needs more.
    Nothing,
}

/// Distributes samples over the pixels, pass by pass.
#[derive(Debug)]
pub enum SampleAllocator {
    /// Even distribution.
    Evenly,
    /// Even distribution during the pilot, then the pilot's allocation.
    ByPilot(Option<Allocation>),
    /// Samples for those pixels whose own relative error is above this.
    Greedy(f64),
}

impl SampleAllocator {
    /// The allocator of the settings.
    pub fn new(settings: &RenderSettings) -> Self {
        let budget = settings.budget;
        match (settings.adaptive, budget.error) {
            (Adaptive::Greedy, Some(target)) => Self::Greedy(target.rel_rmse),
            (Adaptive::TwoPhase, _) => Self::ByPilot(None),
            _ => Self::Evenly,
        }
    }

    /// Records a complete pass, up to which the share `used` of the budget is used up, and computes the allocation if
    /// the pilot is over.
    pub fn pass_done(&mut self, film: &Film, level: u64, used: f64) {
        if let Self::ByPilot(allocation @ None) = self
            && is_over(level, used)
        {
            *allocation = Some(Allocation::by_pilot(film, level));
        }
    }

    /// The pilot's allocation, once the pilot is over.
    pub fn allocation(&self) -> Option<&Allocation> {
        match self {
            Self::ByPilot(allocation) => allocation.as_ref(),
            _ => None,
        }
    }

    /// The samples that bring the render from one level to the next.
    pub fn deal(&self, film: &Film, level: u64, next: u64) -> SampleAllocation {
        match self {
            Self::Evenly => SampleAllocation::Evenly,
            Self::ByPilot(allocation) => SampleAllocation::UpTo(match allocation {
                Some(allocation) => allocation.counts(&film.sample_counts(), next),
                None => vec![next; film.window().pixel_count() as usize],
            }),
            Self::Greedy(target) => greedy::deal(film, *target, next - level),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::batches::BATCHES;
    use crate::render::settings::Budget;

    #[test]
    fn pilot_is_a_sixteenth_of_the_budget_within_limits() {
        for (spp, expected) in [
            (1, 4),
            (16, 4),
            (100, 28),
            (128, 32),
            (256, 64),
            (1024, 64),
            (2048, 128),
            (9999, 628),
        ] {
            assert_eq!(Budget::samples(spp).pilot(), expected, "{spp}");
            let over = |level: u64| is_over(level, level as f64 / spp as f64);
            assert!(over(expected), "{spp}");
            assert!(expected == BATCHES || !over(expected - BATCHES), "{spp}");
        }
        assert_eq!(Budget::default().pilot(), PILOT);
        // The share that is used up is forecast from the error, and is zero for a black image.
        assert!(!is_over(512, 0.0));
        assert!(is_over(16, 0.25), "there is no more time");
    }
}
