//! Portable float map: the plainest file of floats.
//!
//! Measure: linear values.
//! Range: `PF` (colour) and `Pf` (grey), either byte order; written little-endian.
//! Source: Debevec, "PFM Portable FloatMap Image Format": rows from the bottom up, a negative scale means little-endian.
//! Tested in `image/mod.rs`.

use super::{Image, checked_size};
use crate::math::rgb::Rgb;
use std::io::{self, Write};

/// Writes the picture.
pub fn encode(image: &Image, mut file: impl Write) -> io::Result<()> {
    write!(file, "PF\n{} {}\n-1.0\n", image.width, image.height)?;
    for row in image.pixels.chunks(image.width as usize).rev() {
        for value in row.iter().flat_map(|pixel| pixel.to_array()) {
            file.write_all(&value.to_le_bytes())?;
        }
    }
    Ok(())
}

/// Reads a picture, or says why not.
pub fn decode(bytes: &[u8]) -> Result<Image, String> {
    let mut rest = bytes;
    let mut word = || {
        let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let length = rest[start..].iter().position(|b| b.is_ascii_whitespace())?;
        let word = std::str::from_utf8(&rest[start..start + length]).ok()?;
        // One white space ends the header; values follow at once.
        rest = &rest[start + length + 1..];
        Some(word)
    };
    let header = (|| {
        Some((
            word()?,
            word()?.parse().ok()?,
            word()?.parse().ok()?,
            word()?,
        ))
    })();
    let Some((kind, width, height, scale)) = header else {
        return Err("not a PFM picture: its header is not three lines of words".to_owned());
    };
    let (width, height) = checked_size(width, height)?;
    let channels = match kind {
        "PF" => 3,
        "Pf" => 1,
        _ => return Err("not a PFM picture: expected PF or Pf".to_owned()),
    };
    let little_endian = scale.starts_with('-');
    let count = width as usize * height as usize * channels;
    if rest.len() != 4 * count {
        return Err(format!(
            "a PFM picture of {} bytes; {width} x {height} pixels take {}",
            rest.len(),
            4 * count
        ));
    }
    let values: Vec<f32> = rest
        .as_chunks()
        .0
        .iter()
        .map(|&b| {
            if little_endian {
                f32::from_le_bytes(b)
            } else {
                f32::from_be_bytes(b)
            }
        })
        .collect();
    let rows = values.chunks(width as usize * channels).rev();
    let pixel = |p: &[f32]| {
        if channels == 3 {
            Rgb::new(p[0], p[1], p[2])
        } else {
            Rgb::grey(p[0])
        }
    };
    let pixels = rows
        .flat_map(|row| row.chunks(channels).map(pixel))
        .collect();
    Ok(Image::new(width, height, pixels))
}
