//! Adaptive sampling: the distribution of samples over the pixels.
//!
//! Measure: samples per pixel. The *level* of a render is the mean over the pixels, or, for greedy sampling, the count
//! of a pixel that has not stopped. A part of a two-phase render is a range of levels.
//! Range: counts are whole rounds of batches.
//! Source: docs/accuracy.md, "Adaptive sampling". Tested in `tests/rendering/adaptive.rs`.

pub mod allocation;
mod greedy;

use super::settings::{ADAPTIVE_PILOT, Adaptive, MIN_PILOT_DIVISOR, PILOT_DIVISOR, RenderSettings};
use crate::film::Film;
use allocation::Allocation;
use std::ops::Range;
use std::sync::Arc;

/// Whether a pilot of `level` samples per pixel, which has used up the share `used` of the budget, is long enough.
fn is_over(level: u64, used: f64) -> bool {
    let uses = |divisor: u64| used * divisor as f64 >= 1.0;
    uses(MIN_PILOT_DIVISOR) || (level >= ADAPTIVE_PILOT && uses(PILOT_DIVISOR))
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
    /// Even distribution in a part of a pilot, whose allocation follows from all parts together.
    Pilot,
    /// Even distribution during the pilot, then the pilot's allocation.
    ByPilot(Option<Arc<Allocation>>),
    /// Samples for those pixels whose own relative error is above this.
    Greedy(f64),
}

impl SampleAllocator {
    /// The allocator of the settings, for a part of a pilot or for a render with this allocation so far.
    pub fn new(
        settings: &RenderSettings,
        is_pilot: bool,
        allocation: Option<Arc<Allocation>>,
    ) -> Self {
        let budget = settings.budget;
        match (settings.adaptive, budget.error) {
            (Adaptive::Greedy, Some(target)) => Self::Greedy(target.rel_rmse),
            (Adaptive::TwoPhase, _) if is_pilot => Self::Pilot,
            (Adaptive::TwoPhase, _) => Self::ByPilot(allocation),
            _ => Self::Evenly,
        }
    }

    /// Records a complete pass, up to which the share `used` of the budget is used up, and computes the allocation if
    /// the pilot is over.
    pub fn pass_done(&mut self, film: &Film, level: u64, used: f64) {
        if let Self::ByPilot(allocation @ None) = self
            && is_over(level, used)
        {
            *allocation = Some(Arc::new(Allocation::by_pilot(film, level)));
        }
    }

    /// Whether the pilot is being rendered, after which samples are allocated.
    pub fn is_in_pilot(&self) -> bool {
        matches!(self, Self::ByPilot(None))
    }

    /// The pilot's allocation, once the pilot is over.
    pub fn allocation(&self) -> Option<&Arc<Allocation>> {
        match self {
            Self::ByPilot(allocation) => allocation.as_ref(),
            _ => None,
        }
    }

    /// The count of each pixel of a render at this level; nothing where all pixels have the same count, or none that
    /// is known from the level.
    pub fn counts(&self, pixels: u64, level: u64) -> Vec<u64> {
        match self {
            Self::Evenly => vec![],
            Self::ByPilot(Some(allocation)) => allocation.counts(level),
            Self::ByPilot(None) | Self::Pilot | Self::Greedy(_) => vec![level; pixels as usize],
        }
    }

    /// The samples that bring a part of a render from one level to the next. `firsts` are the counts of the render at
    /// the first level of the part. Pixels that have more already, from an interrupted pass, keep it.
    pub fn allocate(&self, film: &Film, firsts: &[u64], levels: Range<u64>) -> SampleAllocation {
        match self {
            Self::Evenly => SampleAllocation::Evenly,
            Self::Pilot | Self::ByPilot(_) => {
                let mut counts = self.counts(film.window().pixel_count(), levels.end);
                let now = film.sample_counts();
                for ((count, first), now) in counts.iter_mut().zip(firsts).zip(now) {
                    *count = count.saturating_sub(*first).max(now);
                }
                SampleAllocation::UpTo(counts)
            }
            Self::Greedy(target) => greedy::allocate(film, *target, levels.end - levels.start),
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
        assert_eq!(Budget::default().pilot(), ADAPTIVE_PILOT);
        // The share that is used up is forecast from the error, and is zero for a black image.
        assert!(!is_over(512, 0.0));
        assert!(is_over(16, 0.25), "there is no more time");
    }
}
