//! Reading JPEG.
//!
//! Measure: codes of the colour space asked for, over 255.
//! Range: baseline and progressive files of 8 bits, grey or colour; the EXIF orientation and embedded profiles are
//! not applied. A truncated file is an error, not an image that is grey from there on.
//! Source: the `zune-jpeg` crate, in strict mode: through the `image` crate it would ignore missing data. Tested
//! below.

use super::raster::{code_values, gather};
use super::{ColourSpace, Image, MAX_SIDE, checked_size};
use crate::error::{Error, Result};
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

const START_OF_SCAN: [u8; 2] = [0xFF, 0xDA];
const END_OF_IMAGE: [u8; 2] = [0xFF, 0xD9];

/// Decodes an image from the bytes of a JPEG file.
pub(super) fn decode(bytes: &[u8], space: ColourSpace) -> Result<Image> {
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .set_max_width(MAX_SIDE)
        .set_max_height(MAX_SIDE);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(not_valid)?;
    let info = decoder.info().expect("the headers are decoded");
    let (width, height) = checked_size(info.width.into(), info.height.into(), bytes.len())?;
    let colours = match decoder.input_colorspace() {
        Some(ColorSpace::Luma) => ColorSpace::Luma,
        _ => ColorSpace::RGB,
    };
    decoder.set_options(options.jpeg_set_out_colorspace(colours));
    // Even the strict decoder makes up the very last block if the end is missing.
    if last(END_OF_IMAGE, bytes) < last(START_OF_SCAN, bytes) {
        return Err(Error::scene("not a valid JPEG file: it has no end"));
    }
    let samples = decoder.decode().map_err(not_valid)?;
    let values = code_values(u8::MAX.into(), space);
    let pixels = gather(&samples, colours.num_components(), |[code]: [u8; 1]| {
        values[usize::from(code)]
    });
    Ok(Image::new(width, height, pixels))
}

/// The last position of a marker; `None`, which is less than any position, if there is none.
fn last(marker: [u8; 2], bytes: &[u8]) -> Option<usize> {
    bytes.windows(2).rposition(|pair| pair == marker)
}

fn not_valid(cause: DecodeErrors) -> Error {
    Error::scene(format!("not a valid JPEG file: {cause}")).because(cause)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use ::image::codecs::jpeg::JpegEncoder;
    use ::image::{ExtendedColorType, ImageEncoder};

    /// An image of `width` by 8 pixels, all 128, in one channel or three.
    fn jpeg(width: u32, channels: ExtendedColorType) -> Vec<u8> {
        let mut bytes = Vec::new();
        let samples = vec![128; width as usize * 8 * usize::from(channels.channel_count())];
        JpegEncoder::new_with_quality(&mut bytes, 100)
            .write_image(&samples, width, 8, channels)
            .expect("encoded");
        bytes
    }

    /// A grey square of 8 x 8 pixels.
    pub(in crate::image) fn square() -> Vec<u8> {
        jpeg(8, ExtendedColorType::Rgb8)
    }

    /// The file with this size in its frame header.
    fn resized(bytes: &[u8], width: u16, height: u16) -> Vec<u8> {
        let mut bytes = bytes.to_vec();
        let frame = bytes.windows(2).position(|marker| marker == [0xFF, 0xC0]);
        let size = frame.expect("a baseline file has a frame header") + 5;
        bytes[size..size + 2].copy_from_slice(&height.to_be_bytes());
        bytes[size + 2..size + 4].copy_from_slice(&width.to_be_bytes());
        bytes
    }

    #[test]
    fn rgb_and_grey_jpegs_are_decoded() {
        for channels in [ExtendedColorType::Rgb8, ExtendedColorType::L8] {
            let image = decode(&jpeg(8, channels), ColourSpace::Linear).expect("an image");
            assert_eq!((image.width(), image.height()), (8, 8));
            let [r, g, b] = image.get(3, 4).to_array();
            assert!([r, g, b].iter().all(|c| (c - 128.0 / 255.0).abs() < 0.01));
        }
    }

    #[test]
    fn jpegs_with_missing_scan_data_are_rejected() {
        let whole = jpeg(512, ExtendedColorType::Rgb8);
        let scan = whole.windows(2).position(|marker| marker == [0xFF, 0xDA]);
        let scan = scan.expect("there is a scan") + 2;
        for end in scan..whole.len() - 2 {
            let cut = decode(&whole[..end], ColourSpace::Srgb);
            assert!(cut.is_err(), "{end} bytes of {}", whole.len());
        }
        for (width, height) in [(4096, 4096), (65535, 4096)] {
            let short = decode(&resized(&whole, width, height), ColourSpace::Srgb);
            assert!(short.is_err(), "{width} x {height} pixels");
        }
    }
}
