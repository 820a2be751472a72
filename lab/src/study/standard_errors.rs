//! The standard errors of an image's pixels, from its layers.
//!
//! Measure: the unit of the pixels.
//! Range: numbers of at least 0; others are errors. An image without the layers has none.
//! Source: the layers of `render --layers`. Tested in `study/bias_test.rs`.

use super::difference::UncertainNumber;
use etendue::internals::image::LayeredImage;
use etendue::{Error, Result};

/// An image and its standard errors.
pub struct Bars<'a> {
    image: &'a LayeredImage,
    /// Standard errors of R, G and B.
    pub errors: Option<[&'a [f32]; 3]>,
    flags: Option<&'a [f32]>,
}

impl<'a> Bars<'a> {
    /// The standard errors of an image, if it has layers of them.
    ///
    /// # Errors
    /// If one is negative or not finite.
    pub fn of(image: &'a LayeredImage) -> Result<Self> {
        let errors = match image.layer("se.R") {
            Some(_) => Some(image.required_layers(["se.R", "se.G", "se.B"])?),
            None => None,
        };
        let is_wrong = |error: &f32| !(error.is_finite() && *error >= 0.0);
        for errors in errors.into_iter().flatten() {
            if let Some(place) = errors.iter().position(is_wrong) {
                let width = image.image.width() as usize;
                let error = Error::scene(format!(
                    "the standard error of pixel ({}, {}) is {}: expected a number of at least 0",
                    place % width,
                    place / width,
                    errors[place]
                ));
                return Err(match &image.file {
                    Some(file) => error.in_file(file),
                    None => error,
                });
            }
        }
        Ok(Self {
            image,
            errors,
            flags: image.layer("flag.Y"),
        })
    }

    /// Whether the image flags a pixel.
    pub fn is_flagged(&self, index: usize) -> bool {
        self.flags.is_some_and(|flags| flags[index] != 0.0)
    }

    /// The value of a channel of a pixel, with its standard error.
    pub fn estimate(&self, index: usize, channel: usize) -> UncertainNumber {
        let value = self.image.image.pixels()[index].to_array()[channel];
        let standard_error = self.errors.map_or(0.0, |errors| errors[channel][index]);
        UncertainNumber {
            value: value.into(),
            standard_error: standard_error.into(),
        }
    }
}
