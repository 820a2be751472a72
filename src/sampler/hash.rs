//! Integer hashes that turn (seed, pixel, decision) into uncorrelated seeds.
//!
//! Measure: bits.
//! Range: all inputs; each function is a bijection of its first argument.
//! Source: Stafford's "Mix13" as the finaliser of SplitMix64 (Steele, Lea and Flood 2014). Tested through
//! `tests/sampling/sampler.rs`.

/// Mixes the bits of a 64-bit value.
#[inline(always)]
pub fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// Derives a seed from the seed `state` and `value`.
#[inline(always)]
pub fn combine(state: u64, value: u64) -> u64 {
    mix(state.wrapping_add(0x9e37_79b9_7f4a_7c15) ^ mix(value.wrapping_add(0x632b_e59b_d9b4_e019)))
}

/// The number at index `step` of the SplitMix64 sequence of a well mixed state. Quicker than [`combine`], which accepts
/// any state.
#[inline(always)]
pub fn split(state: u64, step: u64) -> u64 {
    mix(state.wrapping_add(step.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
}

/// The seed of a pixel.
#[inline(always)]
pub fn pixel_seed(seed: u64, pixel: [u32; 2]) -> u64 {
    combine(seed, u64::from(pixel[0]) | u64::from(pixel[1]) << 32)
}
