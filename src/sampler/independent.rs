//! Independent uniform numbers: plain Monte Carlo.
//!
//! Every pixel has a PCG stream of its own. Each sample owns 2^10 numbers of it, reached by jumping ahead; paths of more
//! than 126 bounces continue in further streams. Samples begin an odd number of steps apart, because numbers a high power
//! of two apart in one stream are correlated.
//!
//! Measure: uniform in [0, 1 - 2^-24].
//! Range: sample indices below 2^47 do not repeat numbers.
//! Source: O'Neill 2014 (PCG), Brown 1994 (jumping), both in rand_pcg. Tested in `tests/sampling/sampler.rs`.

use super::{Decision, Sampler, hash, to_unit};
use rand_core::Rng;
use rand_pcg::Pcg32;

/// log2 of the numbers that a sample owns in one stream.
const NUMBERS_PER_SAMPLE_BITS: u32 = 10;

/// The distance from one sample's first number to that of the next sample.
const SAMPLE_STRIDE: u64 = (1 << NUMBERS_PER_SAMPLE_BITS) + 1;

/// The independent sampler.
#[derive(Debug, Clone)]
pub struct Independent {
    seed: u64,
    pixel_seed: u64,
    sample: u64,
    generator: Pcg32,
    /// The slot of the number that `generator` returns next.
    next_slot: u64,
}

impl Independent {
    /// Creates a sampler for the given seed.
    pub fn new(seed: u64) -> Self {
        Self {
            seed,
            pixel_seed: 0,
            sample: 0,
            generator: Pcg32::new(0, 0),
            next_slot: 0,
        }
    }

    /// Advances or jumps, so that `slot` is the next number.
    #[inline]
    fn seek(&mut self, slot: u64) {
        let same_stream = (slot ^ self.next_slot) >> NUMBERS_PER_SAMPLE_BITS == 0;
        if slot < self.next_slot || !same_stream {
            self.jump(slot);
        }
        while self.next_slot < slot {
            self.generator.next_u32();
            self.next_slot += 1;
        }
    }

    fn jump(&mut self, slot: u64) {
        let stream = slot >> NUMBERS_PER_SAMPLE_BITS;
        let first = (stream << NUMBERS_PER_SAMPLE_BITS).max(slot & !0xff);
        let stream_seed = hash::combine(self.pixel_seed, stream);
        self.generator = Pcg32::new(self.pixel_seed, stream_seed);
        self.generator.advance(
            self.sample
                .wrapping_mul(SAMPLE_STRIDE)
                .wrapping_add(first - (stream << NUMBERS_PER_SAMPLE_BITS)),
        );
        self.next_slot = first;
    }
}

impl Sampler for Independent {
    #[inline]
    fn start(&mut self, pixel: [u32; 2], sample: u64) {
        self.pixel_seed = hash::pixel_seed(self.seed, pixel);
        self.sample = sample;
        self.jump(0);
    }

    // Inlined into the stages of a bounce: of all samplers, this one is the quickest.
    #[inline(always)]
    fn draw<const N: usize>(&mut self, decision: Decision) -> [f32; N] {
        self.seek(decision.slot());
        self.next_slot += N as u64;
        std::array::from_fn(|_| to_unit(self.generator.next_u32()))
    }
}
