//! The enum of all samplers, so that kernels are compiled once for all of them.
//!
//! Random numbers are drawn for many paths at once, so that the kind of sampler is tested once for all of them.
//!
//! Measure: that of the sampler.
//! Range: that of the sampler. Samplers that are drawn from together are of one kind.
//! Source: none needed. Tested in `tests/sampling/sampler.rs`.

use super::{
    Decision, Independent, LaneStates, Sampler, Sobol, Stratified, independent, sobol, store_each,
};
use crate::math::lanes::{ActiveLanes, LANES, Lanes};

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

impl AsRef<Independent> for AnySampler {
    #[inline(always)]
    fn as_ref(&self) -> &Independent {
        match self {
            Self::Independent(sampler) => sampler,
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

    fn start_lanes(&self, pixels: &[Lanes<u32>; 2], sample: u64) -> [Self; LANES] {
        match self {
            Self::Independent(sampler) => {
                sampler.start_lanes(pixels, sample).map(Self::Independent)
            }
            Self::Stratified(sampler) => sampler.start_lanes(pixels, sample).map(Self::Stratified),
            Self::Sobol(sampler) => sampler.start_lanes(pixels, sample).map(Self::Sobol),
        }
    }

    #[inline(always)]
    fn lane_state(&self) -> [u64; 2] {
        match self {
            Self::Independent(sampler) => sampler.lane_state(),
            Self::Stratified(sampler) => sampler.lane_state(),
            Self::Sobol(sampler) => sampler.lane_state(),
        }
    }

    #[inline]
    fn draw_lanes<const N: usize>(
        samplers: &mut [Self],
        active: &ActiveLanes<LANES>,
        places: &Lanes<u32>,
        states: &LaneStates,
        decision: Decision,
        numbers: &mut [Lanes<f32>; N],
    ) {
        match samplers.first() {
            Some(Self::Sobol(_)) => {
                sobol::draw_from_lanes(samplers, active, places, states, decision, numbers);
            }
            Some(Self::Independent(_)) => {
                independent::draw_from_lanes(samplers, active, places, states, decision, numbers);
            }
            _ => {
                for lane in active.each() {
                    let drawn: [f32; N] = samplers[places[lane] as usize].draw(decision);
                    store_each(numbers, lane, drawn);
                }
            }
        }
    }
}
