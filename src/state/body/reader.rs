//! A body that is read from its beginning to its end, in memory or in pieces of a file.
//!
//! Measure: bytes; sums as in `film/pixel.rs`.
//! Range: a body that is too short or has a number that no sum has is an error that names the byte.
//! Source: none needed. Tested in `tests.rs` beside this file and in `tests/fuzz_corpus.rs`.

use super::super::header::{AdaptivePilot, MAX_COUNTED, StateHeader, damaged};
use crate::error::{Error, Result};
use crate::film::batches::BATCHES;
use crate::film::pixel::{PixelSums, Sums};
use crate::film::splatted::WeightedSums;
use crate::film::{Tile, Window};
use crate::render::adaptive::allocation::Allocation;
use crate::render::settings::MAX_SPP;
use rayon::prelude::*;
use std::borrow::Cow;

/// The doubles of the sums of a pixel whose samples contribute to several: one for each bit.
pub const MAX_DOUBLES: usize = 32;

/// The bytes of a body that are read before sums are added, if there are so many.
const BUFFERED: usize = 1 << 25;

/// The sums of a part of a film: a tile, or a row of splats.
pub struct SumsOfPart<'a> {
    pub own: &'a mut [PixelSums],
    pub splatted: &'a mut [WeightedSums],
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
    pub least: usize,
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
    pub fn read<T>(
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
    pub fn add_sums(&mut self, mut parts: Vec<SumsOfPart<'_>>) -> Result<()> {
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
    pub fn check_ended(&mut self) -> Result<()> {
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
pub struct BodyReader<'a> {
    remaining: &'a [u8],
    /// The bytes of the body before the end of the part.
    end: u64,
}

impl BodyReader<'_> {
    pub fn take<const N: usize>(&mut self) -> Result<[u8; N]> {
        match self.remaining.split_first_chunk() {
            Some((bytes, rest)) => {
                self.remaining = rest;
                Ok(*bytes)
            }
            None => Err(self.damaged("more sums, but the file ends")),
        }
    }

    /// Adds the sample count of a tile.
    pub fn add_samples(&mut self, header: &StateHeader, sum: &mut u64) -> Result<()> {
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
    pub fn add_counts(&mut self, tile: &mut Tile) -> Result<()> {
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
    pub fn allocation(&mut self, window: Window, pilot: &AdaptivePilot) -> Result<Allocation> {
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

    fn damaged(&self, expected: &str) -> Error {
        let at = self.end - self.remaining.len() as u64;
        damaged(format!("at byte {at} of its body, expected {expected}"))
    }
}
