//! Reading and writing PFM: a short text header, then floats.
//!
//! Measure: linear; rows from the bottom to the top.
//! Range: `PF` (colour) and `Pf` (grey), either byte order; the magnitude of the scale is not applied, as in other
//! readers. Written little-endian.
//! Source: Debevec's description of PFM. Tested below.

use super::{Image, checked_size};
use crate::error::{Error, Result};
use crate::math::rgb::Rgb;
use std::io::{self, Write};

/// Decodes an image from the bytes of a PFM file.
pub(super) fn decode(bytes: &[u8]) -> Result<Image> {
    let header = PfmHeader::parse(bytes)
        .ok_or_else(|| Error::scene("not a valid PFM file: expected width, height and scale"))?;
    let (width, height) = checked_size(header.width, header.height, bytes.len())?;
    let (samples, _) = bytes[header.length..].as_chunks::<4>();
    let row_length = header.width * header.channels;
    let expected = row_length * header.height;
    if samples.len() < expected {
        return Err(Error::scene(format!(
            "not a valid PFM file: {} samples of {expected}",
            samples.len()
        )));
    }
    let value = |sample| match header.little_endian {
        true => f32::from_le_bytes(sample),
        false => f32::from_be_bytes(sample),
    };
    let pixels = samples[..expected]
        .chunks_exact(row_length)
        .rev()
        .flat_map(|row| row.chunks_exact(header.channels))
        .map(|pixel| match *pixel {
            [r, g, b] => Rgb::new(value(r), value(g), value(b)),
            _ => Rgb::grey(value(pixel[0])),
        })
        .collect();
    Ok(Image::new(width, height, pixels))
}

/// Writes `image` as a PFM file.
pub(super) fn encode(mut writer: impl Write, image: &Image) -> io::Result<()> {
    // A negative scale means little-endian.
    write!(writer, "PF\n{} {}\n-1.0\n", image.width(), image.height())?;
    for row in image.pixels().chunks_exact(image.width() as usize).rev() {
        for sample in row.iter().flat_map(|pixel| pixel.to_array()) {
            writer.write_all(&sample.to_le_bytes())?;
        }
    }
    Ok(())
}

struct PfmHeader {
    channels: usize,
    width: usize,
    height: usize,
    little_endian: bool,
    /// Length of the header in bytes; the samples follow.
    length: usize,
}

impl PfmHeader {
    /// Parses four words, each ended by one byte of white space or more, the last by exactly one.
    fn parse(bytes: &[u8]) -> Option<Self> {
        let mut length = 0;
        let mut word = || {
            length += bytes[length..]
                .iter()
                .position(|b| !b.is_ascii_whitespace())?;
            let start = length;
            length += bytes[start..].iter().position(u8::is_ascii_whitespace)?;
            let word = std::str::from_utf8(&bytes[start..length]).ok();
            length += 1;
            word
        };
        let channels = match word()? {
            "PF" => 3,
            "Pf" => 1,
            _ => return None,
        };
        let width = word()?.parse().ok()?;
        let height = word()?.parse().ok()?;
        let scale: f64 = word()?.parse().ok()?;
        // A line may end in two characters: then there is a byte more than pixels take.
        let size = |width: usize, height: usize| {
            usize::checked_mul(4 * channels, width.checked_mul(height)?)
        };
        let is_one_longer = bytes.len().checked_sub(length + 1) == size(width, height);
        if bytes[length - 1] == b'\r' && bytes.get(length) == Some(&b'\n') && is_one_longer {
            length += 1;
        }
        Some(Self {
            channels,
            width,
            height,
            little_endian: scale < 0.0,
            length,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::sample_image;
    use super::*;

    #[test]
    fn pfm_round_trip_is_lossless() {
        let mut bytes = Vec::new();
        encode(&mut bytes, &sample_image()).expect("encoded");
        assert_eq!(decode(&bytes).expect("an image"), sample_image());
    }

    #[test]
    fn pfm_lines_may_end_in_two_characters() {
        let mut bytes = Vec::new();
        encode(&mut bytes, &sample_image()).expect("encoded");
        let pixels = bytes.len() - 12 * sample_image().pixels().len();
        let head = String::from_utf8(bytes[..pixels].to_vec()).expect("ASCII");
        let other = [head.replace('\n', "\r\n").as_bytes(), &bytes[pixels..]].concat();
        assert_eq!(decode(&other).expect("an image"), sample_image());
    }

    #[test]
    fn grey_big_endian_pfm_is_read_bottom_to_top() {
        let mut bytes = b"Pf\n1 2\n1.0\n".to_vec();
        bytes.extend(1.0_f32.to_be_bytes());
        bytes.extend(2.0_f32.to_be_bytes());
        let image = decode(&bytes).expect("an image");
        assert_eq!(image.pixels(), [Rgb::grey(2.0), Rgb::grey(1.0)]);
    }

    #[test]
    fn malformed_or_truncated_pfm_is_rejected() {
        for text in [
            "PF\n",
            "PF\n1 1\n",
            "PF\n-1 1\n-1.0\n",
            "PF\n1 1\nx\n",
            "PF\n99999 99999\n-1.0\n",
            "PF\n1 1\n-1.0\n12345678",
        ] {
            assert!(decode(text.as_bytes()).is_err(), "{text}");
        }
    }
}
