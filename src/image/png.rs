//! Writing PNG: a picture to look at.
//!
//! Measure: linear values times 2^exposure, through the sRGB transfer function, to the nearest of 256 codes.
//! Range: any pixels; what lies outside of [0, 1] after the exposure is clamped, and a NaN is black.
//! Source: `srgb.rs`; a PNG without a colour chunk is read as sRGB (W3C PNG, section 13.13). Tested below.

use super::Image;
use super::srgb::to_code;
use ::image::codecs::png::PngEncoder;
use ::image::{ExtendedColorType, ImageEncoder};
use std::io::{self, Write};

/// `image` as the bytes of a file, made brighter by `exposure` stops.
pub fn png_bytes(image: &Image, exposure: f32) -> Vec<u8> {
    let mut bytes = Vec::new();
    encode(&mut bytes, image, exposure).expect("memory takes every picture of whole pixels");
    bytes
}

/// Writes `image`, made brighter by `exposure` stops.
pub(super) fn encode(writer: impl Write, image: &Image, exposure: f32) -> io::Result<()> {
    let gain = f64::from(exposure).exp2();
    let codes: Vec<u8> = image
        .pixels()
        .iter()
        .flat_map(|pixel| pixel.to_array())
        .map(|channel| to_code(f64::from(channel) * gain))
        .collect();
    PngEncoder::new(writer)
        .write_image(
            &codes,
            image.width(),
            image.height(),
            ExtendedColorType::Rgb8,
        )
        .map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::super::srgb::from_linear;
    use super::super::tests::sample_image;
    use super::super::{ColourSpace, raster};
    use super::*;

    #[test]
    fn every_pixel_comes_back_within_half_a_code() {
        let image = sample_image();
        for exposure in [0.0, -5.5, 1.0] {
            let mut bytes = Vec::new();
            encode(&mut bytes, &image, exposure).expect("encoded");
            let read = raster::decode_png(&bytes, ColourSpace::Linear).expect("a picture");
            assert_eq!((read.width(), read.height()), (13, 7));
            for (wrote, read) in image.pixels().iter().zip(read.pixels()) {
                for (wrote, read) in wrote.to_array().into_iter().zip(read.to_array()) {
                    let shown = (f64::from(wrote) * f64::from(exposure).exp2()).clamp(0.0, 1.0);
                    let codes = 255.0 * (f64::from(read) - from_linear(shown)).abs();
                    assert!(codes <= 0.5 + 1e-4, "{wrote} came back {codes} codes away");
                }
            }
        }
    }
}
