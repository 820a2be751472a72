//! Synthetic renders, for the tests of the statistics of renders: images with standard errors, and levels of a study.
//!
//! Measure: radiance; levels as in `report.rs`.
//! Range: images of 40 x 24 pixels; levels of four renders, none of them disturbed.
//! Source: none needed.

use super::clock::Seconds;
use super::report::{LevelReport, RunReport};
use etendue::internals::film::batches::BATCHES;
use etendue::internals::image::{Image, Layer, LayeredImage};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::stats::{Moments, normal_quantile};
use rand_core::Rng;
use rand_pcg::Pcg64;

const SIZE: (u32, u32) = (40, 24);

/// A synthetic render: batches about a gradient, noisier to the right, with `bias` in the tile at (16, 16).
pub fn rendered(seed: u64, bias: f64) -> LayeredImage {
    let mut rng = Pcg64::new(seed.into(), 5);
    let mut pixels = Vec::new();
    let mut errors: [Vec<f32>; 3] = Default::default();
    for index in 0..(SIZE.0 * SIZE.1) {
        let (x, y) = (index % SIZE.0, index / SIZE.0);
        let factor = match (16..24).contains(&x) && (16..24).contains(&y) {
            true => 1.0 + bias,
            false => 1.0,
        };
        let mut channel = |c: usize| {
            let mean = 0.2 + 0.01 * f64::from(x) + 0.1 * c as f64;
            let sigma = 0.0075 + 0.0015 * f64::from(x);
            let batches = Moments::of((0..BATCHES).map(|_| {
                let u = ((rng.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64;
                factor * mean + sigma * normal_quantile(u)
            }));
            let error = batches.standard_error().expect("there are several");
            errors[c].push(error as f32);
            batches.mean() as f32
        };
        pixels.push(Rgb::new(channel(0), channel(1), channel(2)));
    }
    let mut image = LayeredImage::from(Image::new(SIZE.0, SIZE.1, pixels));
    let named = ["se.R", "se.G", "se.B"].into_iter().zip(errors);
    image.layers = named
        .map(|(name, samples)| Layer {
            name: name.to_owned(),
            samples,
        })
        .collect();
    image
}

/// A render that is not made.
#[derive(Debug, Clone, Copy)]
pub struct SyntheticRender {
    /// Its relMSE.
    pub rel_mse: f64,
    /// Its product with each of the renders before it.
    pub product: f64,
    /// Its duration.
    pub seconds: f64,
    /// Its mean luminance.
    pub luminance: f64,
}

/// A level of four renders, each by its seed.
pub fn level(spp: u64, mut render: impl FnMut(u64) -> SyntheticRender) -> LevelReport {
    let mut level = LevelReport {
        spp,
        ..LevelReport::default()
    };
    for seed in 0..4_u64 {
        let SyntheticRender {
            rel_mse,
            product,
            seconds,
            luminance,
        } = render(seed);
        let products = vec![product; seed as usize];
        level.gram.push(products.clone(), &products, rel_mse);
        level.runs.push(RunReport {
            seed,
            order: 0,
            seconds: Seconds {
                wall: seconds,
                cpu: seconds,
            },
            repeated: false,
            rel_mse,
            trimmed: rel_mse,
            luminance,
            rejected: 0,
        });
    }
    level
}
