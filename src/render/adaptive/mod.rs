//! Adaptive sampling: which pixels get how many samples.
//!
//! Measure: samples per pixel. The *level* of a render is the mean over the pixels, or, for greedy sampling, what a pixel
//! has that has not stopped.
//! Range: counts are whole rounds of batches.
//! Source: docs/accuracy.md, "Adaptive sampling". Tested in `tests/rendering/adaptive.rs`.

pub mod allocation;
mod greedy;

use super::settings::{Budget, RenderSettings};
use crate::film::Film;
use crate::film::bars::BATCHES;
use allocation::Allocation;
use std::time::Duration;

/// How samples are given out to the pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Adaptive {
    /// The same number to each.
    #[default]
    Off,
    /// By the errors that a pilot shows, without bias.
    TwoPhase,
    /// To each until it seems good enough by its own samples. Biased.
    Greedy,
}

impl Adaptive {
    /// Every way.
    pub const ALL: &'static [Self] = &[Self::TwoPhase, Self::Greedy, Self::Off];

    /// The name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::TwoPhase => "two-phase",
            Self::Greedy => "greedy",
        }
    }

    /// What biases the picture, in words.
    pub fn bias(self) -> Option<String> {
        (self == Self::Greedy).then(|| {
            "greedy adaptive sampling: a pixel stops when its own samples are alike, also by chance"
                .to_owned()
        })
    }
}

/// Samples per pixel of a pilot that nothing makes shorter.
pub const LONGEST_PILOT: u64 = 64;

/// A pilot takes this share of the budget at most.
const PILOT_SHARE: u64 = 4;

/// Samples per pixel of the pilot: known before the first of them.
pub fn pilot(budget: Budget) -> u64 {
    let affordable = budget.spp.map_or(LONGEST_PILOT, |spp| spp / PILOT_SHARE);
    let whole = affordable - affordable % BATCHES;
    whole.clamp(BATCHES, LONGEST_PILOT)
}

/// What the next pass gives out.
#[derive(Debug, Clone, PartialEq)]
pub enum Deal {
    /// The same to every pixel.
    Evenly,
    /// What every pixel is to have after it, row by row.
    UpTo(Vec<u64>),
    /// Nothing: no pixel wants more.
    Nothing,
}

/// Gives samples out, pass by pass.
#[derive(Debug)]
pub enum Dealer {
    /// Evenly.
    Evenly,
    /// Evenly during the pilot, then as it tells.
    ByPilot {
        /// Samples per pixel of the pilot.
        pilot: u64,
        /// The time that there is for all.
        time: Option<Duration>,
        /// What the pilot tells, once it is over.
        allocation: Option<Allocation>,
    },
    /// To those pixels whose own relative error is above this.
    Greedy(f64),
}

impl Dealer {
    /// As the settings say.
    pub fn new(settings: &RenderSettings) -> Self {
        let budget = settings.budget;
        match (settings.adaptive, budget.error) {
            (Adaptive::Greedy, Some(target)) => Self::Greedy(target.rel_rmse),
            (Adaptive::TwoPhase, _) => Self::ByPilot {
                pilot: pilot(budget),
                time: budget.time,
                allocation: None,
            },
            _ => Self::Evenly,
        }
    }

    /// Takes note of a complete pass: whether the pilot is over, and what it tells.
    pub fn pass_done(&mut self, film: &Film, level: u64, elapsed: Duration) {
        if let Self::ByPilot {
            pilot,
            time,
            allocation: allocation @ None,
        } = self
        {
            let is_short = time.is_some_and(|time| elapsed > time / PILOT_SHARE as u32);
            if level >= *pilot || is_short {
                *allocation = Some(Allocation::by_pilot(film, level));
            }
        }
    }

    /// What the pilot tells, once it is over.
    pub fn allocation(&self) -> Option<&Allocation> {
        match self {
            Self::ByPilot { allocation, .. } => allocation.as_ref(),
            _ => None,
        }
    }

    /// What brings the render from one level to the next.
    pub fn deal(&self, film: &Film, level: u64, next: u64) -> Deal {
        match self {
            Self::Evenly => Deal::Evenly,
            Self::ByPilot { allocation, .. } => Deal::UpTo(match allocation {
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

    #[test]
    fn a_pilot_is_a_quarter_of_the_samples_at_most_but_one_round_of_batches() {
        for (spp, expected) in [
            (1, 16),
            (16, 16),
            (127, 16),
            (128, 32),
            (256, 64),
            (9999, 64),
        ] {
            assert_eq!(pilot(Budget::samples(spp)), expected, "{spp}");
        }
        assert_eq!(pilot(Budget::default()), LONGEST_PILOT);
    }
}
