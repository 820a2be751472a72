//! PCG streams in lanes, with any number of a stream by a jump.

use etendue::internals::math::lanes::{LANES, Lanes};

/// A PCG stream for each lane (O'Neill 2014), with the state of the next decision.
#[derive(Clone)]
pub struct RandomLanes {
    pub state: Lanes<u64>,
    pub increment: Lanes<u64>,
}

/// The multiplier of PCG's congruential generator.
pub const MULTIPLIER: u64 = 6_364_136_223_846_793_005;
/// The numbers that a bounce, or the camera, owns in a stream.
pub const NUMBERS: u64 = 8;
/// The steps from one sample of a pixel to the next.
pub const SAMPLE_STRIDE: u64 = 1025;

/// The multiplier of the state and that of the increment which advance a generator by `steps` (Brown 1994).
pub const fn jump(mut steps: u64) -> (u64, u64) {
    let (mut of_state, mut of_increment) = (1_u64, 0_u64);
    let (mut power, mut sum) = (MULTIPLIER, 1_u64);
    while steps > 0 {
        if steps & 1 == 1 {
            of_state = of_state.wrapping_mul(power);
            of_increment = of_increment.wrapping_mul(power).wrapping_add(sum);
        }
        sum = power.wrapping_add(1).wrapping_mul(sum);
        power = power.wrapping_mul(power);
        steps >>= 1;
    }
    (of_state, of_increment)
}

#[inline(always)]
pub const fn advance(state: u64, increment: u64, (of_state, of_increment): (u64, u64)) -> u64 {
    state
        .wrapping_mul(of_state)
        .wrapping_add(increment.wrapping_mul(of_increment))
}

impl RandomLanes {
    /// Draws the numbers at these places of each lane's decision, and advances to the next decision.
    #[inline(always)]
    pub fn draw<const N: usize>(&mut self, places: [(u64, u64); N], numbers: &mut [Lanes<f32>; 4]) {
        for (numbers, place) in numbers.iter_mut().zip(places) {
            for lane in 0..LANES {
                let state = advance(self.state[lane], self.increment[lane], place);
                let mixed = (((state >> 18) ^ state) >> 27) as u32;
                let bits = mixed.rotate_right((state >> 59) as u32) >> 8;
                numbers[lane] = bits as i32 as f32 * (1.0 / 16_777_216.0);
            }
        }
        const NEXT: (u64, u64) = jump(NUMBERS);
        for lane in 0..LANES {
            self.state[lane] = advance(self.state[lane], self.increment[lane], NEXT);
        }
    }
}
