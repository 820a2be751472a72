//! The input of a denoiser, from the layers of an image file.
//!
//! Measure: linear radiance.
//! Range: all layers that `etendue render --layers` writes; finite numbers, but for distances where nothing is seen; standard
//! errors of at least 0. Anything else is an error that names the layer and the pixel.
//! Source: docs/accuracy.md. Tested in `tests/rendering/denoise.rs`.

use super::guides::FirstHitLayers;
use crate::error::{Error, Result};
use crate::image::LayeredImage;
use crate::math::plane::Plane;

/// A noisy image, with its halves, its variance and its first hits.
#[derive(Debug, Clone)]
pub struct NoisyImage {
    /// The pixels of the image.
    pub(super) picture: [Plane; 3],
    /// The images of either half of the samples, independent of each other; their mean is the whole image.
    pub(super) halves: [[Plane; 3]; 2],
    /// The variance of the whole image.
    pub(super) variance: [Plane; 3],
    pub(super) first: FirstHitLayers,
}

/// The name of a layer that only filtered images have.
pub const FILTERED_LAYER: &str = "noisy.R";

impl NoisyImage {
    /// Builds the input from an image and its layers.
    ///
    /// # Errors
    /// If a layer is missing or has an invalid number, or if the image is filtered already.
    pub fn new(picture: &LayeredImage) -> Result<Self> {
        let in_file = |error: Error| match &picture.file {
            Some(file) => error.in_file(file),
            None => error,
        };
        if picture.layer(FILTERED_LAYER).is_some() {
            return Err(in_file(Error::scene(
                "is filtered already: expected an image that `etendue render --layers` wrote without --denoise",
            )));
        }
        let size = [picture.image.width(), picture.image.height()].map(|side| side as usize);
        let plane = |name: &str, is_valid: fn(f32) -> bool| {
            let [samples] = picture.required_layers([name])?;
            match samples.iter().position(|&x| !is_valid(x)) {
                None => Ok(Plane::new(size[0], size[1], samples.to_vec())),
                Some(at) => Err(in_file(Error::scene(format!(
                    "layer `{name}` is {} in pixel ({}, {}): expected {}",
                    samples[at],
                    at % size[0],
                    at / size[0],
                    if is_valid(-1.0) {
                        "a finite number"
                    } else {
                        "a number of at least 0"
                    }
                )))),
            }
        };
        let number = |name: &str| plane(name, f32::is_finite);
        let error = |name: &str| plane(name, |x| x.is_finite() && x >= 0.0);
        let numbers = |names: [&str; 3]| -> Result<[Plane; 3]> {
            let [a, b, c] = names.map(number);
            Ok([a?, b?, c?])
        };
        let errors = |names: [&str; 3]| -> Result<[Plane; 3]> {
            let [a, b, c] = names.map(error);
            Ok([a?, b?, c?])
        };
        let channel = |c: usize| {
            let samples = picture.image.pixels().iter().map(|it| it.to_array()[c]);
            Plane::new(size[0], size[1], samples.collect())
        };
        let whole = [0, 1, 2].map(channel);
        let half = numbers(["half.R", "half.G", "half.B"])?;
        let other =
            [0, 1, 2].map(|c| whole[c].like(|i| 2.0 * whole[c].values[i] - half[c].values[i]));
        let errors_of_mean = errors(["se.R", "se.G", "se.B"])?;
        Ok(Self {
            variance: errors_of_mean.map(|it| it.like(|i| it.values[i] * it.values[i])),
            picture: whole,
            halves: [half, other],
            first: FirstHitLayers {
                albedo: numbers(["albedo.R", "albedo.G", "albedo.B"])?,
                normal: numbers(["normal.X", "normal.Y", "normal.Z"])?,
                distance: plane("depth.Z", |x| x >= 0.0)?,
                errors: errors(["se.albedo", "se.normal", "se.depth"])?,
            },
        })
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        [self.picture[0].width, self.picture[0].height]
    }
}
