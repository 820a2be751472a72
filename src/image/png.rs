//! Writing PNG: an 8-bit sRGB image for display.
//!
//! Measure: linear values times 2^exposure, through the sRGB transfer function, to the nearest of 256 codes.
//! Range: any pixels; values outside of [0, 1] after the exposure are clamped, and a NaN is black.
//! Source: `srgb.rs`; a PNG without a colour chunk is read as sRGB (W3C PNG, section 13.13). Tested below.

use super::raster::code_values;
use super::srgb::to_code;
use super::{ColourSpace, Image};
use crate::math::functions::exp2;
use ::png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter};
use std::io::{self, Write};

/// Encodes `image` as the bytes of a file, brightened by `exposure` stops.
pub fn png_bytes(image: &Image, exposure: f32) -> Vec<u8> {
    png_bytes_with_texts(image, exposure, &[])
}

/// Encodes `image` as [`png_bytes`] does, with text chunks: pairs of a keyword and its text.
///
/// # Panics
///
/// If a keyword does not have 1 to 79 letters in Latin-1.
pub fn png_bytes_with_texts(image: &Image, exposure: f32, texts: &[(&str, String)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    encode(&mut bytes, image, exposure, texts)
        .expect("memory takes every image of whole pixels, and keywords are short");
    bytes
}

/// Writes `image`, brightened by `exposure` stops, with text chunks.
pub(super) fn encode(
    writer: impl Write,
    image: &Image,
    exposure: f32,
    texts: &[(&str, String)],
) -> io::Result<()> {
    let size = (image.width(), image.height());
    encode_codes(writer, size, &codes(image, exposure), texts)
}

/// Writes 8-bit codes of red, green and blue as a PNG file of this width and height.
///
/// # Errors
/// If the writer fails.
pub fn write_codes(writer: impl Write, size: (u32, u32), codes: &[u8]) -> io::Result<()> {
    encode_codes(writer, size, codes, &[])
}

fn encode_codes(
    writer: impl Write,
    (width, height): (u32, u32),
    codes: &[u8],
    texts: &[(&str, String)],
) -> io::Result<()> {
    let mut encoder = Encoder::new(writer, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Adaptive);
    let failed = |error| match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    };
    for (keyword, text) in texts {
        let added = encoder.add_itxt_chunk((*keyword).to_owned(), text.clone());
        added.map_err(failed)?;
    }
    let mut writer = encoder.write_header().map_err(failed)?;
    let written = writer.write_image_data(codes);
    written.and_then(|()| writer.finish()).map_err(failed)
}

/// The 8-bit sRGB codes of each pixel's channels, brightened by `exposure` stops.
pub fn codes(image: &Image, exposure: f32) -> Vec<u8> {
    let gain = exp2(f64::from(exposure));
    let channels = image.pixels().iter().flat_map(|pixel| pixel.to_array());
    channels
        .map(|channel| to_code(f64::from(channel) * gain))
        .collect()
}

/// The 8-bit codes of a colour space for each pixel's channels, if they decode to exactly these pixels.
pub fn exact_codes(image: &Image, space: ColourSpace) -> Option<Vec<u8>> {
    let values = code_values(u8::MAX.into(), space);
    let channels = image.pixels().iter().flat_map(|pixel| pixel.to_array());
    channels
        .map(|channel| {
            let code = match space {
                ColourSpace::Srgb => to_code(f64::from(channel)),
                ColourSpace::Linear => (255.0 * channel).round() as u8,
            };
            (values[usize::from(code)].to_bits() == channel.to_bits()).then_some(code)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::srgb::from_linear;
    use super::super::tests::sample_image;
    use super::super::{ColourSpace, raster};
    use super::*;

    #[test]
    fn png_round_trip_error_is_at_most_half_a_code() {
        let image = sample_image();
        for exposure in [0.0, -5.5, 1.0] {
            let mut bytes = Vec::new();
            encode(&mut bytes, &image, exposure, &[]).expect("encoded");
            let read = raster::decode_png(&bytes, ColourSpace::Linear).expect("an image");
            assert_eq!((read.width(), read.height()), (13, 7));
            for (wrote, read) in image.pixels().iter().zip(read.pixels()) {
                for (wrote, read) in wrote.to_array().into_iter().zip(read.to_array()) {
                    let shown = (f64::from(wrote) * exp2(f64::from(exposure))).clamp(0.0, 1.0);
                    let codes = 255.0 * (f64::from(read) - from_linear(shown)).abs();
                    assert!(codes <= 0.5 + 1e-4, "{wrote} came back {codes} codes away");
                }
            }
        }
    }

    #[test]
    fn png_text_metadata_is_stored_without_changing_the_image() {
        let texts = [("Comment", "\u{65e5}.exr, scale \u{b1} 0.25".to_owned())];
        let bytes = png_bytes_with_texts(&sample_image(), 0.0, &texts);
        let reader = ::png::Decoder::new(io::Cursor::new(&bytes)).read_info();
        let info = reader.expect("an image").info().clone();
        let [found] = info.utf8_text.as_slice() else {
            panic!("{} texts", info.utf8_text.len());
        };
        let text = found.get_text().expect("it is UTF-8");
        assert_eq!((&*found.keyword, &text), (texts[0].0, &texts[0].1));
        assert_eq!(
            raster::decode_png(&bytes, ColourSpace::Srgb).expect("an image"),
            raster::decode_png(&png_bytes(&sample_image(), 0.0), ColourSpace::Srgb)
                .expect("an image")
        );
    }
}
