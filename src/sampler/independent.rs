//! Independent uniform numbers: plain Monte Carlo.
//!
//! Every pixel has a PCG stream of its own. Each sample owns 2^10 numbers of it, reached by jumping ahead; paths of more
//! than 126 bounces continue in further streams. Samples begin an odd number of steps apart, because numbers a high power
//! of two apart in one stream are correlated.
//!
//! A number is reached by one jump from the first number of its sample. The jump is the same for all paths that draw for
//! the same decision, so that numbers are drawn in SIMD lanes.
//!
//! Measure: uniform in [0, 1 - 2^-24].
//! Range: sample indices below 2^47 do not repeat numbers.
//! Source: O'Neill 2014 (PCG-XSH-RR 64/32), Brown 1994 (jumping). Tested below against rand_pcg, and in
//! `tests/sampling/sampler.rs`.

use super::{Decision, LaneStates, Sampler, hash, store_each, to_unit};
use crate::math::lanes::{ActiveLanes, LANES, Lanes, vectorised};

/// log2 of the numbers that a sample owns in one stream.
const NUMBERS_PER_SAMPLE_BITS: u32 = 10;

/// The distance from one sample's first number to that of the next sample.
const SAMPLE_STRIDE: u64 = (1 << NUMBERS_PER_SAMPLE_BITS) + 1;

/// The multiplier of the congruential generator.
const MULTIPLIER: u64 = 6_364_136_223_846_793_005;

/// Several steps of the generator at once: `state * of_state + increment * of_increment`.
#[derive(Debug, Clone, Copy)]
struct Jump {
    of_state: u64,
    of_increment: u64,
}

impl Jump {
    /// No step.
    const NONE: Self = Self {
        of_state: 1,
        of_increment: 0,
    };

    /// One step.
    const ONE: Self = Self {
        of_state: MULTIPLIER,
        of_increment: 1,
    };

    /// The jump, followed by another one.
    const fn then(self, next: Self) -> Self {
        let of_increment = self.of_increment.wrapping_mul(next.of_state);
        Self {
            of_state: self.of_state.wrapping_mul(next.of_state),
            of_increment: of_increment.wrapping_add(next.of_increment),
        }
    }

    /// A jump of any number of steps, by repeated squaring.
    const fn of(mut steps: u64) -> Self {
        let (mut jump, mut power) = (Self::NONE, Self::ONE);
        while steps > 0 {
            if steps & 1 == 1 {
                jump = jump.then(power);
            }
            power = power.then(power);
            steps >>= 1;
        }
        jump
    }

    /// The jump from before the first number of a stream to the first number of a sample.
    fn to_sample(sample: u64) -> Self {
        Self::of(sample.wrapping_mul(SAMPLE_STRIDE).wrapping_add(1))
    }

    /// The state after the jump.
    #[inline(always)]
    fn from(self, stream: Stream) -> u64 {
        let increment = stream.increment.wrapping_mul(self.of_increment);
        stream
            .state
            .wrapping_mul(self.of_state)
            .wrapping_add(increment)
    }
}

/// The jumps to all numbers of a sample in one stream.
static JUMPS: [Jump; 1 << NUMBERS_PER_SAMPLE_BITS] = {
    let mut jumps = [Jump::NONE; 1 << NUMBERS_PER_SAMPLE_BITS];
    let mut steps = 1;
    while steps < jumps.len() {
        jumps[steps] = jumps[steps - 1].then(Jump::ONE);
        steps += 1;
    }
    jumps
};

/// A stream at one of its states.
#[derive(Debug, Clone, Copy)]
struct Stream {
    state: u64,
    /// Odd; it selects the stream.
    increment: u64,
}

impl Stream {
    /// The stream of a pixel, at the first number of a sample.
    #[inline(always)]
    fn new(pixel_seed: u64, stream: u64, to_sample: Jump) -> Self {
        let increment = (hash::combine(pixel_seed, stream) << 1) | 1;
        let first = Self {
            state: pixel_seed.wrapping_add(increment),
            increment,
        };
        Self {
            state: to_sample.from(first),
            increment,
        }
    }
}

/// The number of a state: its high bits, rotated by the highest ones.
#[inline(always)]
fn output(state: u64) -> u32 {
    let mixed = (((state >> 18) ^ state) >> 27) as u32;
    mixed.rotate_right((state >> 59) as u32)
}

/// The independent sampler.
#[derive(Debug, Clone)]
pub struct Independent {
    seed: u64,
    pixel_seed: u64,
    sample: u64,
    /// The first of the sample's streams.
    stream: Stream,
}

impl Independent {
    /// Creates a sampler for the given seed.
    pub fn new(seed: u64) -> Self {
        Self {
            seed,
            pixel_seed: 0,
            sample: 0,
            stream: Stream::new(0, 0, Jump::NONE),
        }
    }

    /// The stream of a number, and the jump to it.
    #[inline(always)]
    fn stream(&self, slot: u64) -> (Stream, Jump) {
        let stream = match slot >> NUMBERS_PER_SAMPLE_BITS {
            0 => self.stream,
            later => Stream::new(self.pixel_seed, later, Jump::to_sample(self.sample)),
        };
        (stream, jump(slot))
    }
}

/// The jump from the first number of a stream to that of a slot.
#[inline(always)]
fn jump(slot: u64) -> Jump {
    JUMPS[slot as usize % JUMPS.len()]
}

/// A started stream for each lane.
#[derive(Debug, Default)]
struct StreamLanes {
    pixel_seeds: Lanes<u64>,
    states: Lanes<u64>,
    increments: Lanes<u64>,
}

vectorised! {
    /// Starts the first stream of each pixel.
    fn start_lanes(
        seed: u64,
        pixels: &[Lanes<u32>; 2],
        to_sample: Jump,
        started: &mut StreamLanes,
    ) {
        let [x, y] = pixels;
        for (lane, pixel) in x.iter().zip(y).enumerate() {
            let pixel_seed = hash::pixel_seed(seed, [*pixel.0, *pixel.1]);
            let stream = Stream::new(pixel_seed, 0, to_sample);
            started.pixel_seeds[lane] = pixel_seed;
            started.states[lane] = stream.state;
            started.increments[lane] = stream.increment;
        }
    }
}

impl Sampler for Independent {
    #[inline]
    fn start(&mut self, pixel: [u32; 2], sample: u64) {
        self.pixel_seed = hash::pixel_seed(self.seed, pixel);
        self.sample = sample;
        self.stream = Stream::new(self.pixel_seed, 0, Jump::to_sample(sample));
    }

    fn start_lanes(&self, pixels: &[Lanes<u32>; 2], sample: u64) -> [Self; LANES] {
        let mut started = StreamLanes::default();
        start_lanes(self.seed, pixels, Jump::to_sample(sample), &mut started);
        std::array::from_fn(|lane| Self {
            seed: self.seed,
            pixel_seed: started.pixel_seeds[lane],
            sample,
            stream: Stream {
                state: started.states[lane],
                increment: started.increments[lane],
            },
        })
    }

    #[inline(always)]
    fn draw<const N: usize>(&mut self, decision: Decision) -> [f32; N] {
        let (stream, jump) = self.stream(decision.slot());
        numbers(stream, jump)
    }

    #[inline(always)]
    fn lane_state(&self) -> [u64; 2] {
        [self.stream.state, self.stream.increment]
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
        draw_from_lanes(samplers, active, places, states, decision, numbers);
    }
}

impl AsRef<Self> for Independent {
    #[inline(always)]
    fn as_ref(&self) -> &Self {
        self
    }
}

/// The numbers of a stream after a jump.
#[inline(always)]
fn numbers<const N: usize>(stream: Stream, jump: Jump) -> [f32; N] {
    let mut at = Stream {
        state: jump.from(stream),
        ..stream
    };
    std::array::from_fn(|_| {
        let number = to_unit(output(at.state));
        at.state = Jump::ONE.from(at);
        number
    })
}

/// [`Sampler::draw_lanes`] for samplers that are all independent samplers.
#[inline]
pub(super) fn draw_from_lanes<const N: usize, S: AsRef<Independent>>(
    samplers: &[S],
    active: &ActiveLanes<LANES>,
    places: &Lanes<u32>,
    states: &LaneStates,
    decision: Decision,
    numbers: &mut [Lanes<f32>; N],
) {
    let slot = decision.slot();
    if slot >> NUMBERS_PER_SAMPLE_BITS == 0 {
        let LaneStates([states, increments]) = states;
        return draw_lanes(states, increments, jump(slot), numbers);
    }
    // A later stream.
    for lane in active.each() {
        let (stream, jump) = samplers[places[lane] as usize].as_ref().stream(slot);
        store_each(numbers, lane, self::numbers(stream, jump));
    }
}

vectorised! {
    /// [`numbers`] for each lane.
    fn draw_lanes<const N: usize>(
        states: &Lanes<u64>,
        increments: &Lanes<u64>,
        jump: Jump,
        drawn: &mut [Lanes<f32>; N],
    ) {
        for lane in 0..LANES {
            let stream = Stream { state: states[lane], increment: increments[lane] };
            let numbers: [f32; N] = numbers(stream, jump);
            for i in 0..N {
                drawn[i][lane] = numbers[i];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::Rng;
    use rand_pcg::Pcg32;

    #[test]
    fn independent_sampler_matches_pcg32() {
        let (seed, pixel) = (9, [3, 5]);
        let pixel_seed = hash::pixel_seed(seed, pixel);
        let mut sampler = Independent::new(seed);
        for sample in [0, 1, 7, 1_000_003, 1 << 46] {
            sampler.start(pixel, sample);
            for bounce in [0, 1, 5, 126, 127, 1000] {
                let decision = Decision::Bsdf(bounce);
                let (stream, place) = (decision.slot() / 1024, decision.slot() % 1024);
                let mut pcg = Pcg32::new(pixel_seed, hash::combine(pixel_seed, stream));
                pcg.advance(sample.wrapping_mul(SAMPLE_STRIDE).wrapping_add(place));
                let expected: [f32; 3] = std::array::from_fn(|_| to_unit(pcg.next_u32()));
                assert_eq!(sampler.draw(decision), expected, "{sample} {bounce}");
            }
        }
    }
}
