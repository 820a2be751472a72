//! Writing Radiance HDR: three mantissas of eight bits and one exponent a pixel.
//!
//! Measure: linear.
//! Range: rounded to the nearest step, 1/128 of the largest channel or less; negative channels become 0, and values
//! beyond the format's range are clamped.
//! Source: Ward 1991, "Real Pixels"; the `image` crate writes the file. Tested below.

use super::Image;
use crate::math::rgb::Rgb;
use ::image::codecs::hdr::HdrEncoder;
use std::io::{self, Write};

/// The largest value of the format: mantissa 255/256, exponent 127.
const MAX: f32 = 255.0 / 256.0 * (1u128 << 127) as f32;
/// The least value of the largest channel, by the smallest exponent; a pixel below it is black.
const MIN: f32 = f32::MIN_POSITIVE;

/// Writes `image` as a Radiance HDR file.
pub(super) fn encode(writer: impl Write, image: &Image) -> io::Result<()> {
    let pixels: Vec<_> = image
        .pixels()
        .iter()
        .map(|&pixel| ::image::Rgb(nearest(pixel).to_array()))
        .collect();
    HdrEncoder::new(writer)
        .encode(&pixels, image.width() as usize, image.height() as usize)
        .map_err(io::Error::other)
}

/// The colour of the format that is nearest to `pixel`. The encoder alone would round every channel down, a bias of
/// half a step.
fn nearest(pixel: Rgb) -> Rgb {
    // A NaN fails the comparison and becomes 0.
    let pixel = pixel.map(|channel| if channel > 0.0 { channel.min(MAX) } else { 0.0 });
    let largest = pixel.max_channel();
    if largest < MIN {
        return Rgb::BLACK;
    }
    // The power of two at or below the largest channel, over 128: its mantissa then has eight bits.
    let step = f32::from_bits(largest.to_bits() & f32::INFINITY.to_bits()) / 128.0;
    let step = match (largest / step).round() {
        // Rounded up to the next power of two.
        256.0.. => 2.0 * step,
        _ => step,
    };
    pixel.map(|channel| (channel / step).round() * step)
}

#[cfg(test)]
mod tests {
    use super::super::{raster, tests::sample_image};
    use super::*;

    fn round_trip(image: &Image) -> Image {
        let mut bytes = Vec::new();
        encode(&mut bytes, image).expect("encoded");
        raster::decode_hdr(&bytes).expect("an image")
    }

    #[test]
    fn hdr_round_trip_error_is_at_most_half_a_step() {
        let image = sample_image();
        let read = round_trip(&image);
        for (wrote, read) in image.pixels().iter().zip(read.pixels()) {
            for (a, b) in wrote.to_array().into_iter().zip(read.to_array()) {
                assert!((a - b).abs() <= wrote.max_channel() / 256.0 * 1.0001);
            }
        }
    }

    #[test]
    fn hdr_reencoding_is_lossless_at_every_exponent() {
        for exponent in -125..127 {
            let unit = 2.0_f32.powi(exponent);
            let pixels = [1.0, 0.999, 0.501, 1.0 / 3.0]
                .map(|x| Rgb::new(x, 0.3 * x, 0.004) * unit)
                .to_vec();
            let once = round_trip(&Image::new(4, 1, pixels));
            assert_eq!(round_trip(&once), once);
            assert!(once.get(0, 0).max_channel() == unit);
        }
    }

    #[test]
    fn out_of_range_hdr_values_are_clamped() {
        let odd = Rgb::new(f32::INFINITY, -1.0, f32::NAN);
        let read = round_trip(&Image::filled(2, 2, odd));
        assert_eq!(read.get(0, 0), Rgb::new(MAX, 0.0, 0.0));
        let faint = Rgb::grey(1e-42);
        assert_eq!(
            round_trip(&Image::filled(1, 1, faint)).get(0, 0),
            Rgb::BLACK
        );
    }
}
