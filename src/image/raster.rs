//! Reading PNG, BMP and Radiance HDR through the `image` crate.
//!
//! Measure: integer samples are codes of the colour space asked for, over their maximum; HDR's floats are linear.
//! Range: PNG of 8 and 16 bits, grey, palette and colour; BMP of 1 to 32 bits a pixel, with run lengths or without. Alpha is
//! read apart from colour; embedded profiles and HDR's EXPOSURE are not applied.
//! Source: the crate's decoders. Tested below and, with HDR, in `hdr.rs`.

use super::srgb::to_linear;
use super::{ColourSpace, Image, MAX_PIXELS, MAX_SIDE, checked_size};
use crate::error::{Error, Result};
use crate::math::rgb::Rgb;
use ::image::codecs::bmp::BmpDecoder;
use ::image::codecs::hdr::HdrDecoder;
use ::image::codecs::png::PngDecoder;
use ::image::{ImageDecoder, ImageError, Limits};
use std::io::Cursor;

/// Decodes an image from the bytes of a PNG file.
pub(super) fn decode_png(bytes: &[u8], space: ColourSpace) -> Result<Image> {
    let no_png = |cause| not_valid("PNG", cause);
    let decoder = PngDecoder::with_limits(Cursor::new(bytes), limits()).map_err(no_png)?;
    decode(decoder, bytes.len(), space, no_png)
}

/// Decodes the alpha channel of a PNG file, grey; `None` if it has none.
pub(super) fn decode_png_alpha(bytes: &[u8]) -> Result<Option<Image>> {
    let no_png = |cause| not_valid("PNG", cause);
    let decoder = PngDecoder::with_limits(Cursor::new(bytes), limits()).map_err(no_png)?;
    decode_alpha(decoder, bytes.len(), no_png)
}

/// Decodes an image from the bytes of a BMP file.
pub(super) fn decode_bmp(bytes: &[u8], space: ColourSpace) -> Result<Image> {
    let no_bmp = |cause| not_valid("BMP", cause);
    let decoder = BmpDecoder::new(Cursor::new(bytes)).map_err(no_bmp)?;
    decode(decoder, bytes.len(), space, no_bmp)
}

/// Decodes the alpha channel of a BMP file, grey; `None` if its header has no mask of alpha.
pub(super) fn decode_bmp_alpha(bytes: &[u8]) -> Result<Option<Image>> {
    let no_bmp = |cause| not_valid("BMP", cause);
    let decoder = BmpDecoder::new(Cursor::new(bytes)).map_err(no_bmp)?;
    decode_alpha(decoder, bytes.len(), no_bmp)
}

/// Decodes an image from the bytes of a Radiance HDR file.
pub(super) fn decode_hdr(bytes: &[u8]) -> Result<Image> {
    let no_hdr = |cause| not_valid("HDR", cause);
    // The strict decoder would refuse the signature #?RGBE, which many programs write.
    let decoder = HdrDecoder::new_nonstrict(Cursor::new(bytes)).map_err(no_hdr)?;
    decode(decoder, bytes.len(), ColourSpace::Linear, no_hdr)
}

fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE as u32);
    limits.max_image_height = Some(MAX_SIDE as u32);
    // Four channels of 16 bits.
    limits.max_alloc = Some(8 * MAX_PIXELS as u64);
    limits
}

/// An error about a file that the crate refuses.
pub(super) fn not_valid(format: &str, cause: ImageError) -> Error {
    Error::scene(format!("not a valid {format} file: {cause}")).because(cause)
}

/// Decodes the colours of a file of `file_size` bytes, whose size in pixels is checked before memory is allocated.
pub(super) fn decode(
    decoder: impl ImageDecoder,
    file_size: usize,
    space: ColourSpace,
    not_valid: impl Fn(ImageError) -> Error,
) -> Result<Image> {
    let samples = RasterSamples::read(decoder, file_size, not_valid)?;
    Ok(samples.image(space, colour))
}

/// Decodes the alpha channel of a file as [`decode`] does its colours; `None` if it has none.
pub(super) fn decode_alpha(
    decoder: impl ImageDecoder,
    file_size: usize,
    not_valid: impl Fn(ImageError) -> Error,
) -> Result<Option<Image>> {
    if !decoder.color_type().has_alpha() {
        return Ok(None);
    }
    let samples = RasterSamples::read(decoder, file_size, not_valid)?;
    let space = ColourSpace::Linear;
    Ok(Some(
        samples.image(space, |pixel| Rgb::grey(pixel[pixel.len() - 1])),
    ))
}

/// The samples of an image, as in the file.
struct RasterSamples {
    size: (u32, u32),
    channels: usize,
    sample_size: usize,
    bytes: Vec<u8>,
}

impl RasterSamples {
    fn read(
        decoder: impl ImageDecoder,
        file_size: usize,
        not_valid: impl Fn(ImageError) -> Error,
    ) -> Result<Self> {
        let (width, height) = decoder.dimensions();
        let (width, height) = checked_size(width as usize, height as usize, file_size)?;
        let colour_type = decoder.color_type();
        let channels = usize::from(colour_type.channel_count());
        let sample_size = usize::from(colour_type.bytes_per_pixel()) / channels;
        let mut bytes = vec![0; width as usize * height as usize * channels * sample_size];
        decoder.read_image(&mut bytes).map_err(not_valid)?;
        Ok(Self {
            size: (width, height),
            channels,
            sample_size,
            bytes,
        })
    }

    /// Builds an image; `pixel` makes a colour of the values of a pixel's channels.
    fn image(&self, space: ColourSpace, pixel: impl Fn(&[f32]) -> Rgb) -> Image {
        let (bytes, channels) = (&self.bytes, self.channels);
        let pixels = match self.sample_size {
            1 => {
                let values = code_values(u8::MAX.into(), space);
                gather_by(
                    bytes,
                    channels,
                    |[code]: [u8; 1]| values[usize::from(code)],
                    pixel,
                )
            }
            2 => {
                let values = code_values(u16::MAX.into(), space);
                let value = |code| values[usize::from(u16::from_ne_bytes(code))];
                gather_by(bytes, channels, value, pixel)
            }
            _ => gather_by(bytes, channels, f32::from_ne_bytes, pixel),
        };
        Image::new(self.size.0, self.size.1, pixels)
    }
}

/// The linear value of every code from 0 to `max`.
pub(super) fn code_values(max: u32, space: ColourSpace) -> Vec<f32> {
    (0..=max)
        .map(|code| {
            let value = f64::from(code) / f64::from(max);
            match space {
                ColourSpace::Srgb => to_linear(value) as f32,
                ColourSpace::Linear => value as f32,
            }
        })
        .collect()
}

/// Builds pixels from samples of `SIZE` bytes: grey with one or two channels, colour with three or four; an even
/// number of channels ends in alpha.
pub(super) fn gather<const SIZE: usize>(
    bytes: &[u8],
    channels: usize,
    value: impl Fn([u8; SIZE]) -> f32,
) -> Vec<Rgb> {
    gather_by(bytes, channels, value, colour)
}

/// Builds pixels as [`gather`] does; `pixel` makes a colour of the values of at most four channels.
fn gather_by<const SIZE: usize>(
    bytes: &[u8],
    channels: usize,
    value: impl Fn([u8; SIZE]) -> f32,
    pixel: impl Fn(&[f32]) -> Rgb,
) -> Vec<Rgb> {
    let (samples, _) = bytes.as_chunks::<SIZE>();
    let mut values = [0.0; 4];
    samples
        .chunks_exact(channels)
        .map(|samples| {
            for (to, sample) in values.iter_mut().zip(samples) {
                *to = value(*sample);
            }
            pixel(&values[..samples.len().min(4)])
        })
        .collect()
}

/// The colour of a pixel's channels, without alpha.
fn colour(channels: &[f32]) -> Rgb {
    match *channels {
        [r, g, b, ..] => Rgb::new(r, g, b),
        [grey, ..] => Rgb::grey(grey),
        [] => Rgb::BLACK,
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use ::image::codecs::bmp::BmpEncoder;
    use ::image::codecs::png::PngEncoder;
    use ::image::{ExtendedColorType, ImageEncoder};

    fn png(samples: &[u8], width: u32, colour_type: ExtendedColorType) -> Vec<u8> {
        let mut bytes = Vec::new();
        PngEncoder::new(&mut bytes)
            .write_image(samples, width, 1, colour_type)
            .expect("encoded");
        bytes
    }

    /// A BMP file of two pixels on top of two others, of these samples.
    fn bmp_of(samples: &[u8], colour_type: ExtendedColorType) -> Vec<u8> {
        let mut bytes = Vec::new();
        BmpEncoder::new(&mut bytes)
            .write_image(samples, 2, 2, colour_type)
            .expect("encoded");
        bytes
    }

    /// A BMP file of four colours.
    pub(in crate::image) fn bmp() -> Vec<u8> {
        let samples = [255, 0, 0, 0, 255, 0, 0, 0, 255, 51, 102, 153];
        bmp_of(&samples, ExtendedColorType::Rgb8)
    }

    #[test]
    fn bmp_colours_and_alpha_are_read() {
        let image = decode_bmp(&bmp(), ColourSpace::Linear).expect("an image");
        let expected = [
            Rgb::new(1.0, 0.0, 0.0),
            Rgb::new(0.0, 1.0, 0.0),
            Rgb::new(0.0, 0.0, 1.0),
            Rgb::new(0.2, 0.4, 0.6),
        ];
        assert_eq!(image.pixels(), expected);
        assert!(decode_bmp_alpha(&bmp()).expect("an image").is_none());
        let samples: Vec<u8> = (0..4).flat_map(|i| [255, 0, 0, 51 * i]).collect();
        let bytes = bmp_of(&samples, ExtendedColorType::Rgba8);
        let alpha = decode_bmp_alpha(&bytes).expect("an image");
        let expected = [0, 51, 102, 153].map(|code| Rgb::grey(code as f32 / 255.0));
        assert_eq!(alpha.expect("it has one").pixels(), expected);
    }

    #[test]
    fn bmp_of_impossible_size_is_rejected_before_it_is_allocated() {
        let mut bytes = bmp();
        for side in [18, 22] {
            bytes[side..side + 4].copy_from_slice(&65535_i32.to_le_bytes());
        }
        let error = decode_bmp(&bytes, ColourSpace::Srgb).expect_err("16 GB of pixels");
        assert!(error.to_string().contains("65535 x 65535"), "{error}");
    }

    #[test]
    fn eight_bit_srgb_is_linearised_only_when_requested() {
        let bytes = png(&[0, 128, 255, 10, 20, 30], 2, ExtendedColorType::Rgb8);
        let linear = decode_png(&bytes, ColourSpace::Linear).expect("an image");
        assert_eq!(linear.get(0, 0), Rgb::new(0.0, 128.0 / 255.0, 1.0));
        let srgb = decode_png(&bytes, ColourSpace::Srgb).expect("an image");
        let [r, g, b] = srgb.get(0, 0).to_array();
        assert_eq!((r, b), (0.0, 1.0));
        assert!((g - 0.215_860_5).abs() < 1e-6);
    }

    #[test]
    fn grey_is_replicated_to_rgb_and_alpha_is_dropped() {
        let grey = png(&[51, 0], 1, ExtendedColorType::La8);
        let grey = decode_png(&grey, ColourSpace::Linear).expect("an image");
        assert_eq!(grey.get(0, 0), Rgb::grey(0.2));
        let rgba = png(&[255, 51, 0, 0], 1, ExtendedColorType::Rgba8);
        let rgba = decode_png(&rgba, ColourSpace::Linear).expect("an image");
        assert_eq!(rgba.get(0, 0), Rgb::new(1.0, 0.2, 0.0));
    }

    #[test]
    fn sixteen_bit_samples_keep_full_precision() {
        let samples: Vec<u8> = [1_u16, 256, 65535]
            .into_iter()
            .flat_map(u16::to_ne_bytes)
            .collect();
        let bytes = png(&samples, 1, ExtendedColorType::Rgb16);
        let image = decode_png(&bytes, ColourSpace::Linear).expect("an image");
        let expected = Rgb::new(1.0 / 65535.0, 256.0 / 65535.0, 1.0);
        assert_eq!(image.get(0, 0), expected);
    }
}
