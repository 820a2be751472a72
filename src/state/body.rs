//! The body of a state file: the sums of all pixels, which are added to those of a film, layers, and the allocation of an
//! adaptive render.
//!
//! Most of the doubles of a sum are 0: samples of similar brightness have no rounding error, and black pixels have no
//! sum. A bit for each double, 24 or 32 a pixel, tells which are not.
//!
//! Measure: bytes; sums as in `film/pixel.rs`.
//! Range: a body that is too short, too long or has a number that no sum has is an error that names the byte.
//! Source: none needed. Tested in `tests/rendering/state.rs` and `tests/fuzz_corpus.rs`.

mod reader;

use super::header::StateHeader;
use crate::error::Result;
use crate::film::Film;
use crate::film::pixel::Sums;
use crate::film::splatted::Splatted;
use crate::image::Layer;
use crate::render::adaptive::allocation::Allocation;
pub use reader::Body;
use reader::{MAX_DOUBLES, SumsOfPart};
use std::io::{self, Write};

/// Writes the body of a state.
pub fn write(
    film: &Film,
    layers: &[Layer],
    allocation: Option<&Allocation>,
    writer: &mut impl Write,
) -> io::Result<()> {
    let tiles = film.tiles();
    for tile in tiles {
        writer.write_all(&tile.samples.to_le_bytes())?;
    }
    for tile in tiles {
        if let (Some(counts), Some(rays)) = (&tile.counts, &tile.rays) {
            for (count, rays) in counts.iter().zip(rays) {
                writer.write_all(&count.to_le_bytes())?;
                writer.write_all(&rays.to_le_bytes())?;
            }
        }
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
    for number in allocation.into_iter().flat_map(Allocation::parts).flatten() {
        writer.write_all(&number.to_le_bytes())?;
    }
    Ok(())
}

/// Writes the sums of a pixel: which doubles are not 0, and these.
fn write_sums<const C: usize>(sums: &Sums<C>, writer: &mut impl Write) -> io::Result<()> {
    let mut bytes = [0; 4 + 8 * MAX_DOUBLES];
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

/// The parts of a body beside its sums.
pub struct BesideSums {
    /// The layers of the first hits.
    pub layers: Vec<Layer>,
    /// The allocation of samples to the pixels.
    pub allocation: Option<Allocation>,
}

/// Adds the samples of a body to a film of the header's form, and returns its other parts.
///
/// # Errors
/// A damaged body. The film has then some of the samples.
pub fn add_to(header: &StateHeader, mut body: Body<'_>, film: &mut Film) -> Result<BesideSums> {
    let pixels = header.window.pixel_count() as usize;
    let (tiles, splats) = film.parts_mut();
    body.read(8 * tiles.len(), |reader| {
        let mut tiles = tiles.iter_mut();
        tiles.try_for_each(|tile| reader.add_samples(header, &mut tile.samples))
    })?;
    for tile in &mut *tiles {
        let counts = tile.counts.as_ref().map_or(0, Vec::len);
        body.read(16 * counts, |reader| reader.add_counts(tile))?;
    }
    let of_tiles = tiles.iter_mut().map(|tile| SumsOfPart {
        own: &mut tile.pixels,
        splatted: tile
            .splatted
            .as_mut()
            .map(Splatted::sums_mut)
            .unwrap_or_default(),
    });
    body.add_sums(of_tiles.collect())?;
    if let (Some(splats), Some(samples)) = (splats, header.splat_samples) {
        for (batch, count) in (0..).zip(samples) {
            splats.add_samples(batch, count);
        }
        let of_rows = splats.rows_mut().map(|own| SumsOfPart {
            own,
            splatted: &mut [],
        });
        body.add_sums(of_rows.collect())?;
    }
    let mut layers = vec![];
    for name in &header.layers {
        let samples = body.read(4 * pixels, |reader| {
            let samples = (0..pixels).map(|_| Ok(f32::from_le_bytes(reader.take()?)));
            samples.collect::<Result<_>>()
        })?;
        layers.push(Layer {
            name: name.clone(),
            samples,
        });
    }
    let allocation = match &header.pilot {
        Some(pilot) if header.has_allocation => Some(body.read(16 * pixels, |reader| {
            reader.allocation(header.window, pilot)
        })?),
        _ => None,
    };
    body.check_ended()?;
    Ok(BesideSums { layers, allocation })
}

#[cfg(test)]
mod tests;
