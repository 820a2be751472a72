//! The enum of all samplers, so that kernels are compiled once for all of them.
//!
//! Random numbers are drawn for many paths at once, so that the kind of sampler is tested once for all of them.
//!
//! Measure: that of the sampler.
//! Range: that of the sampler. Samplers that are drawn from together are of one kind.
//! Source: none needed. Tested in `tests/sampling/sampler.rs`.

use super::{Decision, Independent, Sampler, Sobol, Stratified, sobol};
use std::ops::Range;

/// A sampler whose kind is known only at run time.
#[derive(Debug, Clone)]
pub enum AnySampler {
    /// Independent numbers.
    Independent(Independent),
    /// Jittered strata.
    Stratified(Stratified),
    /// Owen-scrambled Sobol' points.
    Sobol(Sobol),
}

impl AsRef<Sobol> for AnySampler {
    #[inline(always)]
    fn as_ref(&self) -> &Sobol {
        match self {
            Self::Sobol(sampler) => sampler,
            _ => unreachable!("samplers that are drawn from together are of one kind"),
        }
    }
}

impl Sampler for AnySampler {
    #[inline]
    fn start(&mut self, pixel: [u32; 2], sample: u64) {
        match self {
            Self::Independent(sampler) => sampler.start(pixel, sample),
            Self::Stratified(sampler) => sampler.start(pixel, sample),
            Self::Sobol(sampler) => sampler.start(pixel, sample),
        }
    }

    #[inline]
    fn draw<const N: usize>(&mut self, decision: Decision) -> [f32; N] {
        match self {
            Self::Independent(sampler) => sampler.draw(decision),
            Self::Stratified(sampler) => sampler.draw(decision),
            Self::Sobol(sampler) => sampler.draw(decision),
        }
    }

    fn start_each(&self, pixel: [u32; 2], samples: Range<u64>, started: &mut Vec<Self>) {
        match self {
            Self::Independent(sampler) => {
                let samplers = sampler.started(pixel, samples);
                started.extend(samplers.map(Self::Independent));
            }
            Self::Stratified(sampler) => {
                let samplers = sampler.started(pixel, samples);
                started.extend(samplers.map(Self::Stratified));
            }
            Self::Sobol(sampler) => {
                let samplers = sampler.started(pixel, samples);
                started.extend(samplers.map(Self::Sobol));
            }
        }
    }

    #[inline]
    fn draw_each<const N: usize>(
        samplers: &mut [Self],
        places: &[usize],
        decision: Decision,
        mut tell: impl FnMut([f32; N]),
    ) {
        match samplers.first() {
            Some(Self::Sobol(_)) => sobol::draw_each(samplers, places, decision, tell),
            Some(Self::Independent(_)) => {
                for &place in places {
                    if let Self::Independent(sampler) = &mut samplers[place] {
                        tell(sampler.draw(decision));
                    }
                }
            }
            Some(Self::Stratified(_)) => {
                for &place in places {
                    if let Self::Stratified(sampler) = &mut samplers[place] {
                        tell(sampler.draw(decision));
                    }
                }
            }
            None => {}
        }
    }
}
