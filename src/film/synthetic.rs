//! Films of random numbers with a known distribution, to test error estimates.
//!
//! Measure: radiance, the same in all channels.
//! Range: any size; one tile.
//! Source: none needed.

use super::{Film, Window};
use crate::math::rgb::Rgb;
use rand_core::Rng;
use rand_pcg::Pcg64;

/// A generator of random numbers.
pub struct TestRandom(Pcg64);

impl TestRandom {
    pub fn new(seed: u64) -> Self {
        Self(Pcg64::new(seed.into(), 11))
    }

    /// A uniform number in (0, 1).
    pub fn uniform(&mut self) -> f64 {
        ((self.0.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    /// An approximately normal number of mean 0 and variance 1, the sum of twelve uniform ones.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// Builds a film of `samples` samples per pixel, each a function of the pixel's index.
pub fn film(
    size: (u32, u32),
    samples: u64,
    seed: u64,
    sample: impl Fn(usize, &mut TestRandom) -> f64,
) -> Film {
    let mut film = Film::new(Window::whole(size), size.0.max(size.1));
    let mut numbers = TestRandom::new(seed);
    let tile = &mut film.tiles_mut()[0];
    tile.samples = samples;
    for (pixel, sums) in tile.pixels.iter_mut().enumerate() {
        for index in 0..samples {
            sums.add(index, Rgb::grey(sample(pixel, &mut numbers) as f32));
        }
    }
    film
}
