//! Sobol' points with Owen scrambling: the same mean as independent numbers, with less variance where the integrand is
//! smooth.
//!
//! Every decision uses the first four Sobol' dimensions, with the order of the points and their digits scrambled by
//! seeds of its own (padding). So the number of dimensions is unlimited: any bounce is sampled as well as the first.
//!
//! Measure: uniform in [0, 1 - 2^-24].
//! Range: any sample index; every 2^32 samples the scrambles change and a new sequence begins.
//! Source: Burley 2020, "Practical Hash-based Owen Scrambling" (JCGT 9-4); the hash by Vegdahl 2021, "Building a Better
//! LK Hash"; direction numbers of Joe and Kuo 2008. Elementary intervals and uniformity in `tests/sampling/sampler.rs`.

use super::{Batch, Batches, Decision, LaneStates, Sampler, hash, store_each, to_unit};
use crate::math::lanes::{ActiveLanes, LANES, Lanes, MAX_SCALAR_LANES, vectorised};
use crate::planted::planted;

/// The Sobol' sampler.
#[derive(Debug, Clone)]
pub struct Sobol {
    seed: u64,
    batches: Batches,
    /// Seed of the pixel and of the block of 2^32 samples.
    sequence_seed: u64,
    /// The sample index within its block, bits reversed.
    reversed_index: u32,
}

impl Sobol {
    /// Creates a sampler for the given seed.
    pub fn new(seed: u64) -> Self {
        Self {
            seed,
            batches: Batches::ONE,
            sequence_seed: 0,
            reversed_index: 0,
        }
    }

    /// Computes the numbers of a decision, without changing the state of the sampler.
    #[inline]
    fn numbers<const N: usize>(&self, decision: Decision) -> [f32; N] {
        const { assert!(N <= DIMENSIONS) };
        let seeds = Seeds::<N>::of(self.sequence_seed, decision.slot());
        let points = sobol_reversed::<N>(scramble_reversed(self.reversed_index, seeds.order));
        std::array::from_fn(|d| number(points[d], seeds.of_dimension[d]))
    }

    /// Returns the sampler with a separate sequence for each batch.
    pub fn in_batches(self, batches: Batches) -> Self {
        Self { batches, ..self }
    }
}

impl Sampler for Sobol {
    #[inline]
    fn start(&mut self, pixel: [u32; 2], sample: u64) {
        let (batch, sample) = self.batches.split(sample);
        self.sequence_seed = sequence_seed(self.seed, pixel, batch, sample);
        self.reversed_index = (sample as u32).reverse_bits();
    }

    fn start_lanes(&self, pixels: &[Lanes<u32>; 2], sample: u64) -> [Self; LANES] {
        let (batch, sample) = self.batches.split(sample);
        let mut sequence_seeds = [0; LANES];
        seed_lanes(self.seed, pixels, batch, sample, &mut sequence_seeds);
        sequence_seeds.map(|sequence_seed| Self {
            sequence_seed,
            reversed_index: (sample as u32).reverse_bits(),
            ..*self
        })
    }

    #[inline]
    fn draw<const N: usize>(&mut self, decision: Decision) -> [f32; N] {
        self.numbers(decision)
    }

    #[inline(always)]
    fn lane_state(&self) -> [u64; 2] {
        [self.sequence_seed, self.reversed_index.into()]
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

impl AsRef<Self> for Sobol {
    #[inline(always)]
    fn as_ref(&self) -> &Self {
        self
    }
}

/// The seed of a sequence in a batch of a pixel, given the index of a sample in the batch.
#[inline(always)]
fn sequence_seed(seed: u64, pixel: [u32; 2], batch: Batch, sample: u64) -> u64 {
    hash::combine(batch.seed(hash::pixel_seed(seed, pixel)), sample >> 32)
}

vectorised! {
    /// [`sequence_seed`] for each lane.
    fn seed_lanes(
        seed: u64,
        pixels: &[Lanes<u32>; 2],
        batch: Batch,
        sample: u64,
        seeds: &mut Lanes<u64>,
    ) {
        let [x, y] = pixels;
        for (to, pixel) in seeds.iter_mut().zip(x.iter().zip(y)) {
            *to = sequence_seed(seed, [*pixel.0, *pixel.1], batch, sample);
        }
    }
}

/// [`Sampler::draw_lanes`] for samplers that are all Sobol' samplers.
#[inline]
pub(super) fn draw_from_lanes<const N: usize, S: AsRef<Sobol>>(
    samplers: &[S],
    active: &ActiveLanes<LANES>,
    places: &Lanes<u32>,
    states: &LaneStates,
    decision: Decision,
    numbers: &mut [Lanes<f32>; N],
) {
    const { assert!(N <= DIMENSIONS) };
    if active.count() <= MAX_SCALAR_LANES {
        for lane in active.each() {
            let sampler = samplers[places[lane] as usize].as_ref();
            store_each(numbers, lane, sampler.numbers(decision));
        }
        return;
    }
    let LaneStates([seeds, indices]) = states;
    draw_lanes(seeds, indices, decision.slot(), numbers);
}

vectorised! {
    /// [`Sampler::draw`] for each lane.
    fn draw_lanes<const N: usize>(
        sequence_seeds: &Lanes<u64>,
        reversed_indices: &Lanes<u64>,
        slot: u64,
        numbers: &mut [Lanes<f32>; N],
    ) {
        let (mut indices, mut seeds) = ([0; LANES], [[0; LANES]; N]);
        for (lane, &seed) in sequence_seeds.iter().enumerate() {
            let found = Seeds::<N>::of(seed, slot);
            indices[lane] = scramble_reversed(reversed_indices[lane] as u32, found.order);
            for (seeds, seed) in seeds.iter_mut().zip(found.of_dimension) {
                seeds[lane] = seed;
            }
        }
        let mut points = [[0; LANES]; N];
        for (lane, &index) in indices.iter().enumerate() {
            for (points, point) in points.iter_mut().zip(sobol_reversed::<N>(index)) {
                points[lane] = point;
            }
        }
        for ((numbers, points), seeds) in numbers.iter_mut().zip(&points).zip(&seeds) {
            for (lane, to) in numbers.iter_mut().enumerate() {
                *to = number(points[lane], seeds[lane]);
            }
        }
    }
}

/// The seeds of a decision of a sample.
struct Seeds<const N: usize> {
    /// The seed of the order of the points, whose scrambling decorrelates the decision from all others.
    order: u32,
    of_dimension: [u32; N],
}

impl<const N: usize> Seeds<N> {
    /// Derives the seeds, two from each word of the decision's own sequence.
    #[inline(always)]
    fn of(sequence_seed: u64, slot: u64) -> Self {
        let first = hash::split(sequence_seed, slot);
        let half = |index: u64| {
            let word = match index / 2 {
                0 => first,
                step => hash::split(first, step),
            };
            (word >> (32 * (index % 2))) as u32
        };
        Self {
            order: planted!("sobol-order-shared", sequence_seed as u32, half(0)),
            of_dimension: std::array::from_fn(|d| half(1 + d as u64)),
        }
    }
}

/// Scrambles a coordinate with its bits reversed and converts it to a random number.
#[inline(always)]
fn number(reversed: u32, seed: u32) -> f32 {
    to_unit(scramble_reversed(reversed, seed).reverse_bits())
}

/// The number of Sobol' dimensions.
const DIMENSIONS: usize = 4;

/// Owen scrambling of a number whose bits are reversed: every bit is flipped depending on the bits below it, which are
/// the more significant digits.
#[inline(always)]
fn scramble_reversed(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// The first Sobol' dimensions at a bit-reversed index, as bit-reversed fractions.
#[inline(always)]
fn sobol_reversed<const N: usize>(reversed_index: u32) -> [u32; N] {
    let index = reversed_index.reverse_bits();
    let mut x = [0; DIMENSIONS];
    x[0] = index;
    if N > 1 {
        x[1] = pascal(index);
    }
    if N > COMPUTED {
        [x[2], x[3]] = look_up(reversed_index);
    }
    std::array::from_fn(|d| x[d])
}

/// The second dimension, as a bit-reversed fraction: its digit j is the sum modulo 2 of the index's digits i times
/// binomial(i, j), which by Lucas is odd where i has all the bits that j has.
#[inline(always)]
fn pascal(index: u32) -> u32 {
    let mut x = index;
    x ^= (x >> 1) & 0x5555_5555;
    x ^= (x >> 2) & 0x3333_3333;
    x ^= (x >> 4) & 0x0f0f_0f0f;
    x ^= (x >> 8) & 0x00ff_00ff;
    x ^ (x >> 16)
}

/// The number of dimensions that are computed. The others are looked up in tables, which take space in the L1 cache.
const COMPUTED: usize = 2;

/// The third and the fourth dimension at a bit-reversed index, as bit-reversed fractions.
#[inline(always)]
fn look_up(reversed_index: u32) -> [u32; DIMENSIONS - COMPUTED] {
    let bytes = reversed_index.to_be_bytes();
    let mut x = [0; DIMENSIONS - COMPUTED];
    for (table, byte) in TABLES.iter().zip(bytes) {
        for (x, row) in x.iter_mut().zip(&table[usize::from(byte)]) {
            *x ^= row;
        }
    }
    x
}

/// `TABLES[b][v]`: the contribution of byte `v` at bits 8b.. of the index, its bits reversed, to each dimension that is
/// looked up.
static TABLES: DirectionTables = byte_tables();

type DirectionTables = [[[u32; DIMENSIONS - COMPUTED]; 256]; 4];

/// A primitive polynomial over GF(2) by its degree and inner coefficients, with its initial direction numbers.
struct Polynomial {
    degree: usize,
    coefficients: u32,
    initial: [u32; 3],
}

/// Joe and Kuo's dimensions 2 to 4; dimension 1 is van der Corput's.
const POLYNOMIALS: [Polynomial; DIMENSIONS - 1] = [
    Polynomial {
        degree: 1,
        coefficients: 0,
        initial: [1, 0, 0],
    },
    Polynomial {
        degree: 2,
        coefficients: 1,
        initial: [1, 3, 0],
    },
    Polynomial {
        degree: 3,
        coefficients: 1,
        initial: [1, 3, 1],
    },
];

/// v_i of each dimension, as fractions of 2^32 (Joe and Kuo 2008, eq. 2).
const fn direction_numbers() -> [[u32; DIMENSIONS]; 32] {
    let mut v = [[0; DIMENSIONS]; 32];
    let mut i = 0;
    while i < 32 {
        v[i][0] = 1 << (31 - i);
        let mut d = 1;
        while d < DIMENSIONS {
            let p = &POLYNOMIALS[d - 1];
            let s = p.degree;
            v[i][d] = if i < s {
                p.initial[i] << (31 - i)
            } else {
                let mut value = v[i - s][d] ^ (v[i - s][d] >> s);
                let mut k = 1;
                while k < s {
                    if (p.coefficients >> (s - 1 - k)) & 1 == 1 {
                        value ^= v[i - k][d];
                    }
                    k += 1;
                }
                value
            };
            d += 1;
        }
        i += 1;
    }
    v
}

const fn byte_tables() -> DirectionTables {
    let v = direction_numbers();
    let mut tables: DirectionTables = [[[0; DIMENSIONS - COMPUTED]; 256]; 4];
    let mut byte = 0;
    while byte < 4 {
        let mut value = 0;
        while value < 256 {
            let mut bit = 0;
            while bit < 8 {
                // The bits within a byte are reversed, as the index is.
                if (value >> (7 - bit)) & 1 == 1 {
                    let mut d = COMPUTED;
                    while d < DIMENSIONS {
                        tables[byte][value][d - COMPUTED] ^= v[8 * byte + bit][d].reverse_bits();
                        d += 1;
                    }
                }
                bit += 1;
            }
            value += 1;
        }
        byte += 1;
    }
    tables
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The points as fractions, unscrambled.
    fn point(index: u32) -> [u32; DIMENSIONS] {
        sobol_reversed::<DIMENSIONS>(index.reverse_bits()).map(u32::reverse_bits)
    }

    #[test]
    fn first_sobol_points_match_published_values() {
        let published = [
            [0.0, 0.0, 0.0, 0.0],
            [0.5, 0.5, 0.5, 0.5],
            [0.75, 0.25, 0.25, 0.25],
            [0.25, 0.75, 0.75, 0.75],
            [0.375, 0.375, 0.625, 0.875],
            [0.875, 0.875, 0.125, 0.375],
            [0.625, 0.125, 0.875, 0.625],
            [0.125, 0.625, 0.375, 0.125],
        ];
        for (i, expected) in (0_u32..).zip(published) {
            // Joe and Kuo list them in Gray-code order.
            let got = point(i ^ (i >> 1)).map(|x| f64::from(x) / 2.0_f64.powi(32));
            assert_eq!(got, expected, "point {i}");
        }
    }

    #[test]
    fn sobol_points_match_the_direction_numbers() {
        let v = direction_numbers();
        for i in 0..100_000 {
            let index = hash::mix(i) as u32;
            let mut expected = [0; DIMENSIONS];
            for (bit, v) in v.iter().enumerate() {
                if (index >> bit) & 1 == 1 {
                    for d in 0..DIMENSIONS {
                        expected[d] ^= v[d];
                    }
                }
            }
            assert_eq!(point(index), expected, "index {index:#x}");
        }
    }

    #[test]
    fn first_two_dimensions_fill_elementary_intervals() {
        // Dimensions 1 and 2 form a (0, 2)-sequence: every 16 points put one into each box of 2^-a by 2^(a-4).
        for block in 0..8_u32 {
            for a in 0..=4 {
                let mut seen = [false; 16];
                for i in 0..16 {
                    let p = point(block * 16 + i);
                    let x = if a == 0 { 0 } else { p[0] >> (32 - a) };
                    let y = if a == 4 { 0 } else { p[1] >> (28 + a) };
                    let cell = ((x << (4 - a)) | y) as usize;
                    assert!(!seen[cell], "block {block} shape {a}");
                    seen[cell] = true;
                }
            }
        }
    }
}
