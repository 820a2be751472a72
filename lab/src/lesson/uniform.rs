//! Uniform random numbers for experiments without rendering.
//!
//! Measure: none.
//! Range: [0, 1 - 2^-53] in double precision, [0, 1 - 2^-24] in single; a stream repeats after 2^128 numbers.
//! Source: O'Neill 2014 (PCG), in rand_pcg. Tested below.

use etendue::internals::math::vec::Vec2;
use etendue::internals::sampler::hash::combine;
use rand_core::Rng;
use rand_pcg::Pcg64;

/// A stream of uniform numbers.
#[derive(Debug, Clone)]
pub struct Uniform(Pcg64);

impl Uniform {
    /// The stream for a seed.
    pub fn new(seed: u64) -> Self {
        Self(Pcg64::new(u128::from(seed), u128::from(combine(seed, 1))))
    }

    /// The next number.
    #[inline]
    pub fn double(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The next number, in single precision.
    #[inline]
    pub fn single(&mut self) -> f32 {
        (self.0.next_u64() >> 40) as f32 / (1_u32 << 24) as f32
    }

    /// The next two numbers, in single precision.
    #[inline]
    pub fn pair(&mut self) -> Vec2 {
        Vec2::new(self.single(), self.single())
    }
}

/// A seed derived from `seed`, two names and an index.
pub fn seed_of(seed: u64, names: [&str; 2], index: u64) -> u64 {
    let letters = names.iter().flat_map(|name| name.bytes().chain([0]));
    let of_names = letters.fold(seed, |seed, letter| combine(seed, u64::from(letter)));
    combine(of_names, index)
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue::internals::math::stats::Moments;

    #[test]
    fn uniform_mean_and_variance_match_and_seeds_differ() {
        let mut uniform = Uniform::new(seed_of(0, ["a", "b"], 3));
        let numbers = Moments::of((0..1 << 20).map(|_| uniform.double()));
        // Four standard errors of a mean of variance 1/12, and of a variance of variance 1/180.
        assert!((numbers.mean() - 0.5).abs() < 4.0 * (1.0 / 12.0 / 1e6_f64).sqrt());
        let variance = numbers.variance().expect("many");
        assert!((variance - 1.0 / 12.0).abs() < 4.0 * (1.0 / 180.0 / 1e6_f64).sqrt());
        let seeds = [
            seed_of(0, ["a", "b"], 0),
            seed_of(1, ["a", "b"], 0),
            seed_of(0, ["ab", ""], 0),
            seed_of(0, ["a", "b"], 1),
        ];
        let distinct: std::collections::HashSet<u64> = seeds.into_iter().collect();
        assert_eq!(distinct.len(), seeds.len());
    }
}
