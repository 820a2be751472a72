//! The body of a state file: the sums of all pixels, which are added to those of a film, layers, and the allocation of an
//! adaptive render.
//!
//! Most of the doubles of a sum are 0: samples of similar brightness have no rounding error, and black pixels have no
//! sum. A bit for each double, 24 or 32 a pixel, tells which are not.
//!
//! Measure: bytes; sums as in `film/pixel.rs`.
//! Range: a body that is too short, too long or has a number that no sum has is an error that names the byte.
//! Source: none needed. Tested in `tests/rendering/state.rs` and `tests/fuzz_corpus.rs`.

use super::header::{AdaptivePilot, MAX_COUNTED, StateHeader, damaged};
use crate::error::Result;
use crate::film::batches::BATCHES;
use crate::film::pixel::{PixelSums, Sums};
use crate::film::splatted::{Splatted, WeightedSums};
use crate::film::{Film, Tile, Window};
use crate::image::Layer;
use crate::render::adaptive::allocation::Allocation;
use crate::render::settings::MAX_SPP;
use rayon::prelude::*;
use std::borrow::Cow;
use std::io::{self, Write};

/// The doubles of the sums of a pixel whose samples contribute to several: one for each bit.
const MAX_DOUBLES: usize = 32;

/// The bytes of a body that are read before sums are added, if there are so many.
const BUFFERED: usize = 1 << 25;

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

/// The sums of a part of a film: a tile, or a row of splats.
struct SumsOfPart<'a> {
    own: &'a mut [PixelSums],
    splatted: &'a mut [WeightedSums],
}

impl SumsOfPart<'_> {
    fn count(&self) -> usize {
        self.own.len() + self.splatted.len()
    }

    /// The most bytes that these sums take in a file.
    fn most_bytes(&self) -> usize {
        self.count().saturating_mul(4 + 8 * MAX_DOUBLES)
    }

    fn add(&mut self, mut reader: BodyReader<'_>) -> Result<()> {
        self.own.iter_mut().try_for_each(|it| reader.add_sums(it))?;
        let mut splatted = self.splatted.iter_mut();
        splatted.try_for_each(|it| reader.add_sums(it))
    }
}

/// Returns the next piece of a body; `None` after the last one.
pub type NextPiece<'a> = dyn FnMut() -> Result<Option<Vec<u8>>> + 'a;

/// A body that is read from its beginning to its end.
pub struct Body<'a> {
    /// A part of the body: all of it, if it is in memory.
    buffer: Cow<'a, [u8]>,
    /// The bytes of the buffer that have been used.
    used: usize,
    /// The bytes of the body before the end of the buffer.
    end: u64,
    /// The bytes of the whole body.
    length: u64,
    /// The bytes that are read at once, if there are so many.
    least: usize,
    /// The source of the pieces that follow, if any do.
    pieces: Option<&'a mut NextPiece<'a>>,
}

impl<'a> Body<'a> {
    /// The body with these bytes.
    pub fn of(bytes: &'a [u8]) -> Self {
        Self {
            buffer: Cow::Borrowed(bytes),
            used: 0,
            end: bytes.len() as u64,
            length: bytes.len() as u64,
            least: BUFFERED,
            pieces: None,
        }
    }

    /// The body of this length whose pieces follow.
    pub fn in_pieces(pieces: &'a mut NextPiece<'a>, length: u64) -> Self {
        Self {
            buffer: Cow::Owned(vec![]),
            used: 0,
            end: 0,
            length,
            least: BUFFERED,
            pieces: Some(pieces),
        }
    }

    /// A reader of the next bytes, of which there are at least so many unless the body ends.
    fn next(&mut self, least: usize) -> Result<BodyReader<'_>> {
        if let Some(next_piece) = &mut self.pieces
            && self.buffer.len() - self.used < least
        {
            let buffer = self.buffer.to_mut();
            buffer.drain(..self.used);
            self.used = 0;
            // Many parts at once, which threads share.
            while buffer.len() < least.max(self.least) && self.end < self.length {
                let Some(piece) = next_piece()? else {
                    break;
                };
                self.end += piece.len() as u64;
                buffer.extend(piece);
            }
        }
        Ok(BodyReader {
            remaining: &self.buffer[self.used..],
            end: self.end,
        })
    }

    /// Reads with a reader of at least so many bytes, unless the body ends.
    fn read<T>(
        &mut self,
        least: usize,
        read: impl FnOnce(&mut BodyReader<'_>) -> Result<T>,
    ) -> Result<T> {
        let mut reader = self.next(least)?;
        let before = reader.remaining.len();
        let value = read(&mut reader)?;
        let used = before - reader.remaining.len();
        self.used += used;
        Ok(value)
    }

    /// Adds the sums of these parts, which follow each other.
    fn add_sums(&mut self, mut parts: Vec<SumsOfPart<'_>>) -> Result<()> {
        let mut left = &mut parts[..];
        while let Some(first) = left.first() {
            let (least, length) = (first.most_bytes(), self.length);
            let parts = std::mem::take(&mut left);
            left = self.read(least, move |reader| {
                let is_last = reader.end == length;
                // The masks tell where the sums of each part begin, so that threads add them side by side.
                let mut starts = vec![];
                for part in &*parts {
                    let is_whole = is_last || part.most_bytes() <= reader.remaining.len();
                    if !starts.is_empty() && !is_whole {
                        break;
                    }
                    starts.push(*reader);
                    reader.skip(part.count())?;
                }
                let (now, later) = parts.split_at_mut(starts.len());
                let pairs = starts.into_par_iter().zip(now);
                pairs.try_for_each(|(reader, part)| part.add(reader))?;
                Ok(later)
            })?;
        }
        Ok(())
    }

    /// Checks that nothing follows.
    fn check_ended(&mut self) -> Result<()> {
        let left = self.length - self.end + (self.buffer.len() - self.used) as u64;
        match left {
            0 => Ok(()),
            left => Err(self
                .next(0)?
                .damaged(&format!("the end of its sums, but {left} bytes follow"))),
        }
    }
}

/// The part of a body that has been read from the file, but not used.
#[derive(Clone, Copy)]
struct BodyReader<'a> {
    remaining: &'a [u8],
    /// The bytes of the body before the end of the part.
    end: u64,
}

impl BodyReader<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N]> {
        match self.remaining.split_first_chunk() {
            Some((bytes, rest)) => {
                self.remaining = rest;
                Ok(*bytes)
            }
            None => Err(self.damaged("more sums, but the file ends")),
        }
    }

    /// Adds the sample count of a tile.
    fn add_samples(&mut self, header: &StateHeader, sum: &mut u64) -> Result<()> {
        let samples = u64::from_le_bytes(self.take()?);
        let (least, is_even) = (header.samples(), !header.is_uneven);
        // Where pixels have counts of their own, the tile's is the least of these.
        let is_wrong = samples < least || (is_even && samples > least);
        if samples > MAX_SPP || (is_wrong && !header.has_counts) {
            return Err(self.damaged("as many samples as the header says"));
        }
        *sum = self.sum(*sum, samples)?;
        Ok(())
    }

    /// Adds the counts of the pixels of a tile, if they have counts of their own.
    fn add_counts(&mut self, tile: &mut Tile) -> Result<()> {
        let (Some(counts), Some(rays)) = (&mut tile.counts, &mut tile.rays) else {
            return Ok(());
        };
        for (sum, rays) in counts.iter_mut().zip(rays) {
            let count = u64::from_le_bytes(self.take()?);
            if count > MAX_SPP || !count.is_multiple_of(BATCHES) {
                return Err(self.damaged("samples in whole rounds, at most 2^46"));
            }
            *sum = self.sum(*sum, count)?;
            let more = u64::from_le_bytes(self.take()?);
            if more > MAX_COUNTED {
                return Err(self.damaged("at most 2^61 rays"));
            }
            *rays = self.sum(*rays, more)?;
        }
        tile.samples = counts.iter().copied().min().unwrap_or(0);
        Ok(())
    }

    fn sum(&self, sum: u64, more: u64) -> Result<u64> {
        let sum = sum.checked_add(more);
        sum.ok_or_else(|| self.damaged("fewer than 2^64 samples and rays"))
    }

    /// Passes over the sums of this many pixels.
    fn skip(&mut self, count: usize) -> Result<()> {
        for _ in 0..count {
            let mask = u32::from_le_bytes(self.take()?);
            let rest = self.remaining.get(8 * mask.count_ones() as usize..);
            self.remaining = rest.ok_or_else(|| self.damaged("more sums, but the file ends"))?;
        }
        Ok(())
    }

    /// Adds the sums of a pixel to other sums.
    fn add_sums<const C: usize>(&mut self, sums: &mut Sums<C>) -> Result<()> {
        let mut mask = u32::from_le_bytes(self.take()?);
        if u64::from(mask) >> Sums::<C>::DOUBLES != 0 {
            return Err(self.damaged("24 bits that tell which doubles are not 0"));
        }
        // Most sums have no rounding errors, and no channel that is black.
        if mask == (1 << (Sums::<C>::DOUBLES / 2)) - 1 {
            for batch in 0..BATCHES {
                let mut terms = [0.0; C];
                for term in &mut terms {
                    *term = self.take_finite()?;
                }
                sums.add_terms(batch, terms);
            }
            return Ok(());
        }
        while mask != 0 {
            let double = self.take_finite()?;
            sums.add_double(mask.trailing_zeros() as usize, double);
            mask &= mask - 1;
        }
        Ok(())
    }

    /// The allocation by the pilot of the header.
    fn allocation(&mut self, window: Window, pilot: &AdaptivePilot) -> Result<Allocation> {
        let pixels = window.pixel_count() as usize;
        let (mut variances, mut shares) = (Vec::with_capacity(pixels), Vec::with_capacity(pixels));
        for _ in 0..pixels {
            variances.push(self.take_finite()?);
            shares.push(self.take_finite()?);
        }
        let width = window.width as usize;
        let allocation = Allocation::of_parts(pilot.samples, width, variances, shares);
        match AdaptivePilot::of(&allocation) == *pilot {
            true => Ok(allocation),
            false => Err(self.damaged("the allocation of its pilot")),
        }
    }

    fn take_finite(&mut self) -> Result<f64> {
        let double = f64::from_le_bytes(self.take()?);
        match double.is_finite() {
            true => Ok(double),
            false => Err(self.damaged("a finite sum")),
        }
    }

    fn damaged(&self, expected: &str) -> crate::error::Error {
        let at = self.end - self.remaining.len() as u64;
        damaged(format!("at byte {at} of its body, expected {expected}"))
    }
}

#[cfg(test)]
mod tests;
