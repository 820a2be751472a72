//! The body of a state file: the sums of all pixels, which are added to those of a film.
//!
//! Most of the doubles of a sum are 0: samples of similar brightness have no rounding error, and black pixels have no
//! sum. A bit for each double, 24 or 32 a pixel, tells which are not.
//!
//! Measure: bytes; sums as in `film/pixel.rs`.
//! Range: a body that is too short, too long or has a number that no sum has is an error that names the byte.
//! Source: none needed. Tested in `tests/rendering/state.rs` and `tests/fuzz_corpus.rs`.

use super::header::{Header, damaged};
use crate::error::Result;
use crate::film::Film;
use crate::film::pixel::Sums;
use crate::film::splatted::Splatted;
use crate::image::Layer;
use std::io::{self, Write};

/// The doubles of the sums of a pixel whose samples contribute to several: one for each bit.
const MOST_DOUBLES: usize = 32;

/// Writes the body of a state.
pub fn write(film: &Film, layers: &[Layer], writer: &mut impl Write) -> io::Result<()> {
    let tiles = film.tiles();
    for tile in tiles {
        writer.write_all(&tile.samples.to_le_bytes())?;
    }
    for tile in tiles {
        for sums in &tile.pixels {
            write_sums(sums, writer)?;
        }
        for sums in tile.splatted.iter().flat_map(Splatted::sums) {
            write_sums(sums, writer)?;
        }
    }
    if let Some(splats) = film.splats() {
        for pixel in 0..film.window().pixel_count() as usize {
            write_sums(&splats.pixel(pixel), writer)?;
        }
    }
    for layer in layers {
        for sample in &layer.samples {
            writer.write_all(&sample.to_le_bytes())?;
        }
    }
    Ok(())
}

/// Writes the sums of a pixel: which doubles are not 0, and these.
fn write_sums<const C: usize>(sums: &Sums<C>, writer: &mut impl Write) -> io::Result<()> {
    let mut bytes = [0; 4 + 8 * MOST_DOUBLES];
    let (mut mask, mut length) = (0_u32, 4);
    for (i, double) in sums.to_doubles().enumerate() {
        if double != 0.0 {
            mask |= 1 << i;
            bytes[length..length + 8].copy_from_slice(&double.to_le_bytes());
            length += 8;
        }
    }
    bytes[..4].copy_from_slice(&mask.to_le_bytes());
    writer.write_all(&bytes[..length])
}

/// Adds the samples of a body to a film of the header's form, and returns the layers.
///
/// # Errors
/// A damaged body. The film has then some of the samples.
pub fn add_to(header: &Header, body: &[u8], film: &mut Film) -> Result<Vec<Layer>> {
    let mut reader = Reader {
        left: body,
        length: body.len(),
    };
    let pixels = header.window.pixel_count() as usize;
    let (tiles, splats) = film.tiles_and_splats();
    for tile in &mut *tiles {
        let samples = u64::from_le_bytes(reader.take()?);
        let (least, is_even) = (header.samples(), !header.is_uneven);
        if samples < least || (is_even && samples > least) {
            return Err(reader.damaged("as many samples as the header says"));
        }
        let sum = tile.samples.checked_add(samples);
        tile.samples = sum.ok_or_else(|| reader.damaged("fewer than 2^64 samples"))?;
    }
    for tile in tiles {
        for sums in &mut tile.pixels {
            reader.add_sums(sums)?;
        }
        for sums in tile.splatted.iter_mut().flat_map(Splatted::sums_mut) {
            reader.add_sums(sums)?;
        }
    }
    if let (Some(splats), Some(paths)) = (splats, header.paths) {
        for (batch, count) in (0..).zip(paths) {
            splats.add_paths(batch, count);
        }
        for pixel in 0..pixels {
            splats.change_pixel(pixel, |sums| reader.add_sums(sums))?;
        }
    }
    let mut layers = vec![];
    for name in &header.layers {
        let samples = (0..pixels).map(|_| Ok(f32::from_le_bytes(reader.take()?)));
        layers.push(Layer {
            name: name.clone(),
            samples: samples.collect::<Result<_>>()?,
        });
    }
    match reader.left.len() {
        0 => Ok(layers),
        left => Err(reader.damaged(&format!("the end of its sums, but {left} bytes follow"))),
    }
}

/// The part of a body that has not been read.
struct Reader<'a> {
    left: &'a [u8],
    /// The length of the body.
    length: usize,
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N]> {
        match self.left.split_first_chunk() {
            Some((bytes, left)) => {
                self.left = left;
                Ok(*bytes)
            }
            None => Err(self.damaged("more sums, but the file ends")),
        }
    }

    /// Adds the sums of a pixel to other sums.
    fn add_sums<const C: usize>(&mut self, sums: &mut Sums<C>) -> Result<()> {
        let mut mask = u32::from_le_bytes(self.take()?);
        if u64::from(mask) >> Sums::<C>::DOUBLES != 0 {
            return Err(self.damaged("24 bits that tell which doubles are not 0"));
        }
        while mask != 0 {
            let double = f64::from_le_bytes(self.take()?);
            if !double.is_finite() {
                return Err(self.damaged("a finite sum"));
            }
            sums.add_double(mask.trailing_zeros() as usize, double);
            mask &= mask - 1;
        }
        Ok(())
    }

    fn damaged(&self, expected: &str) -> crate::error::Error {
        let at = self.length - self.left.len();
        damaged(format!("at byte {at} of its body, expected {expected}"))
    }
}
