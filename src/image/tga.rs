//! Reading TGA, a format without a signature: a file is one if its header can be that of one.
//!
//! Measure: codes of the colour space asked for, over 255.
//! Range: colours of 15, 16, 24 and 32 bits, grey, and palettes, by run lengths or plain, from any corner. Alpha counts only
//! where the header states its bits: programs that have none leave anything there. Memory is that of the pixels, checked
//! before it is allocated, and of a palette of at most 256 KiB.
//! Source: Truevision, "TGA File Format Specification" 2.0; the decoder of the `image` crate. Tested below.

use super::raster::{self, not_valid};
use super::{ColourSpace, Image};
use crate::error::{Error, Result};
use ::image::ImageError;
use ::image::codecs::tga::TgaDecoder;
use std::io::Cursor;

/// The length of the header in bytes.
const HEADER: usize = 18;

/// Whether a file can be TGA: its header has a kind of image, the bits of a pixel that this kind has, and pixels.
pub(super) fn is_one(bytes: &[u8]) -> bool {
    let Some(header) = bytes.first_chunk::<HEADER>() else {
        return false;
    };
    let [_, palettes, kind, ..] = *header;
    let has_depth = match (kind, header[16]) {
        (1 | 9, depth) => palettes == 1 && matches!(depth, 8 | 16),
        (2 | 10, depth) => matches!(depth, 15 | 16 | 24 | 32),
        (3 | 11, depth) => matches!(depth, 8 | 16),
        _ => false,
    };
    let has_pixels = header[12..14] != [0, 0] && header[14..16] != [0, 0];
    palettes <= 1 && has_depth && has_pixels
}

/// Decodes an image from the bytes of a TGA file.
pub(super) fn decode(bytes: &[u8], space: ColourSpace) -> Result<Image> {
    raster::decode(decoder(bytes)?, bytes.len(), space, no_tga)
}

/// Decodes the alpha channel of a TGA file, grey; `None` if its header states none.
pub(super) fn decode_alpha(bytes: &[u8]) -> Result<Option<Image>> {
    let states_alpha = bytes.get(HEADER - 1).is_some_and(|byte| byte & 0x0F != 0);
    if !states_alpha {
        return Ok(None);
    }
    raster::decode_alpha(decoder(bytes)?, bytes.len(), no_tga)
}

fn decoder(bytes: &[u8]) -> Result<TgaDecoder<Cursor<&[u8]>>> {
    TgaDecoder::new(Cursor::new(bytes)).map_err(no_tga)
}

fn no_tga(cause: ImageError) -> Error {
    not_valid("TGA", cause)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::math::rgb::Rgb;

    /// A header: kind, bits of a pixel, width and height, and the last byte.
    fn header(kind: u8, depth: u8, [width, height]: [u16; 2], last: u8) -> Vec<u8> {
        let palettes = u8::from(matches!(kind, 1 | 9));
        // A palette has two colours of 24 bits.
        let mut bytes = vec![0, palettes, kind, 0, 0, 2 * palettes, 0, 24 * palettes];
        bytes.extend([0; 4]);
        bytes.extend(width.to_le_bytes());
        bytes.extend(height.to_le_bytes());
        bytes.extend([depth, last]);
        bytes
    }

    fn file(kind: u8, depth: u8, size: [u16; 2], last: u8, data: &[u8]) -> Vec<u8> {
        let mut bytes = header(kind, depth, size, last);
        bytes.extend(data);
        bytes
    }

    /// Four colours, two a row, the lower row first: red and green above blue and a mixed one.
    pub(in crate::image) fn colours() -> Vec<u8> {
        let data = [255, 0, 0, 153, 102, 51, 0, 0, 255, 0, 255, 0];
        file(2, 24, [2, 2], 0, &data)
    }

    const RED: Rgb = Rgb::new(1.0, 0.0, 0.0);
    const BLUE: Rgb = Rgb::new(0.0, 0.0, 1.0);

    #[test]
    fn plain_packed_grey_and_palette_tga_are_read_from_any_corner() {
        let green = Rgb::new(0.0, 1.0, 0.0);
        let mixed = Rgb::new(0.2, 0.4, 0.6);
        let palette = [255, 0, 0, 0, 0, 255];
        let from_top = 0x20;
        let cases = [
            (colours(), vec![RED, green, BLUE, mixed]),
            (
                file(10, 24, [2, 2], from_top, &[0x82, 0, 0, 255, 0, 255, 0, 0]),
                vec![RED, RED, RED, BLUE],
            ),
            (
                file(3, 8, [2, 1], from_top, &[51, 255]),
                vec![Rgb::grey(0.2), Rgb::WHITE],
            ),
            (
                file(1, 8, [2, 1], from_top, &[&palette[..], &[1, 0]].concat()),
                vec![RED, BLUE],
            ),
            (
                file(9, 8, [2, 2], from_top, &[&palette[..], &[0x83, 1]].concat()),
                vec![RED; 4],
            ),
            // Five bits a channel, and one that is not alpha.
            (
                file(2, 16, [2, 1], from_top, &[0x00, 0x7C, 0x1F, 0x80]),
                vec![RED, BLUE],
            ),
            // From the right.
            (
                file(2, 24, [2, 1], from_top | 0x10, &[255, 0, 0, 0, 0, 255]),
                vec![RED, BLUE],
            ),
        ];
        for (bytes, expected) in cases {
            assert!(is_one(&bytes), "{bytes:?}");
            let image = decode(&bytes, ColourSpace::Linear).expect("an image");
            assert_eq!(image.pixels(), expected, "{bytes:?}");
        }
    }

    #[test]
    fn tga_alpha_counts_only_where_the_header_states_it() {
        let data = [0, 0, 255, 51, 255, 0, 0, 255];
        let stated = file(2, 32, [2, 1], 0x28, &data);
        let alpha = decode_alpha(&stated).expect("an image");
        let expected = [Rgb::grey(0.2), Rgb::WHITE];
        assert_eq!(alpha.expect("it has one").pixels(), expected);
        let silent = file(2, 32, [2, 1], 0x20, &data);
        assert!(decode_alpha(&silent).expect("an image").is_none());
        for bytes in [stated, silent] {
            let image = decode(&bytes, ColourSpace::Linear).expect("an image");
            assert_eq!(image.pixels(), [RED, BLUE]);
        }
    }

    #[test]
    fn truncated_or_vast_tga_is_rejected() {
        let packed = file(10, 24, [2, 2], 0, &[0x82, 0, 0, 255, 0, 255, 0, 0]);
        for whole in [colours(), packed] {
            for length in 0..whole.len() {
                let cut = Image::decode(&whole[..length], ColourSpace::Srgb);
                assert!(cut.is_err(), "{length} bytes of {}", whole.len());
            }
        }
        let vast = header(10, 24, [65535, 4096], 0);
        let error = decode(&vast, ColourSpace::Srgb).expect_err("3 GB of pixels");
        assert!(error.to_string().contains("does not fit"), "{error}");
        let outside = file(1, 8, [1, 1], 0, &[255, 0, 0, 0, 0, 255, 2]);
        assert!(decode(&outside, ColourSpace::Srgb).is_err());
    }

    #[test]
    fn text_and_headers_of_other_formats_are_not_tga() {
        // An icon begins with a zero and its type, too.
        let icon = [
            &[0, 0, 1, 0, 1, 0, 16, 16, 0, 0, 1, 0, 32, 0, 8, 4, 24, 0][..],
            &[0; 9],
        ];
        assert!(!is_one(&icon.concat()));
        assert!(!is_one(b"a text of more than eighteen bytes"));
        assert!(!is_one(&header(2, 24, [0, 4], 0)));
        assert!(!is_one(&header(2, 8, [4, 4], 0)));
        assert!(!is_one(&colours()[..17]));
    }
}
