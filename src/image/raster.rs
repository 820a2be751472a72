//! The formats of the image crate: PNG and JPEG, and Radiance HDR.
//!
//! Measure: PNG and JPEG hold sRGB codes or linear values in 8 or 16 bits; HDR linear values with a shared exponent.
//! Range: an alpha channel is dropped; PNG is written clamped to [0, 1].
//! Source: the image crate. Tested in `image/mod.rs`.

use super::{ColourSpace, Image, LARGEST_SIDE, checked_size, srgb};
use crate::math::rgb::Rgb;
use ::image::codecs::hdr::HdrEncoder;
use ::image::codecs::png::{CompressionType, FilterType, PngEncoder};
use ::image::{ExtendedColorType, ImageEncoder, ImageReader, Limits};
use std::io::{self, Cursor, Write};

/// Memory that decoding one picture may take, in bytes: that of the largest texture one would use.
const LARGEST_ALLOCATION: u64 = 4 << 30;

/// Reads a picture, or says why not.
pub fn decode(bytes: &[u8], space: ColourSpace) -> Result<Image, String> {
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .expect("a slice in memory can be read");
    let Some(format) = reader.format() else {
        return Err("not a picture: expected PNG, JPEG, HDR, EXR or PFM".to_owned());
    };
    let mut limits = Limits::default();
    limits.max_image_width = Some(LARGEST_SIDE);
    limits.max_image_height = Some(LARGEST_SIDE);
    limits.max_alloc = Some(LARGEST_ALLOCATION);
    reader.limits(limits);
    let picture = reader
        .decode()
        .map_err(|error| format!("not a picture that can be read: {error}"))?;
    let linear = space == ColourSpace::Linear || format == ::image::ImageFormat::Hdr;
    let (width, height) = checked_size(picture.width() as usize, picture.height() as usize)?;
    let decode = |code: f32| if linear { code } else { srgb::decode(code) };
    let pixels = match picture.color() {
        // 256 codes need no more than a table.
        ::image::ColorType::L8
        | ::image::ColorType::La8
        | ::image::ColorType::Rgb8
        | ::image::ColorType::Rgba8 => {
            let table: Vec<f32> = (0..=255_u8)
                .map(|code| decode(f32::from(code) / 255.0))
                .collect();
            let to_linear = |code: u8| table[usize::from(code)];
            picture
                .into_rgb8()
                .pixels()
                .map(|p| Rgb::from(p.0.map(to_linear)))
                .collect()
        }
        _ => picture
            .into_rgb32f()
            .pixels()
            .map(|p| Rgb::from(p.0.map(decode)))
            .collect(),
    };
    Ok(Image::new(width, height, pixels))
}

/// Writes sRGB codes of 8 bits, of the picture times 2^exposure.
pub fn encode_png(image: &Image, exposure: f32, file: impl Write) -> io::Result<()> {
    let gain = exposure.exp2();
    // What is not a number shows as black.
    let code = |x: f32| (255.0 * srgb::encode((gain * x).clamp(0.0, 1.0))).round() as u8;
    let bytes: Vec<u8> = image
        .pixels
        .iter()
        .flat_map(|p| p.to_array().map(code))
        .collect();
    PngEncoder::new_with_quality(file, CompressionType::Default, FilterType::Adaptive)
        .write_image(&bytes, image.width, image.height, ExtendedColorType::Rgb8)
        .map_err(io::Error::other)
}

/// Writes Radiance's shared exponents.
pub fn encode_hdr(image: &Image, file: impl Write) -> io::Result<()> {
    let pixels: Vec<_> = image
        .pixels
        .iter()
        .map(|p| ::image::Rgb(p.to_array()))
        .collect();
    HdrEncoder::new(file)
        .encode(&pixels, image.width as usize, image.height as usize)
        .map_err(io::Error::other)
}
