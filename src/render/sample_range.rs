//! The samples to be taken in a tile.
//!
//! Measure: sample indices.
//! Range: any tile; sample counts per pixel that are equal or not.
//! Source: none needed. Tested in `tests/rendering/determinism.rs` and `tests/rendering/adaptive.rs`.

use crate::film::Tile;
use crate::film::batches::BATCHES;
use std::ops::Range;

/// The indices of the samples to be taken in a tile's pixels.
#[derive(Debug, Clone)]
pub enum SampleRange<'a> {
    /// The range of every pixel.
    Same(Range<u64>),
    /// The index of each pixel's first sample, and its target count in the film. The range begins after the samples
    /// that it has.
    Each {
        /// The index of the first sample.
        firsts: &'a [u64],
        /// The count to be reached.
        counts: &'a [u64],
    },
}

impl SampleRange<'_> {
    /// The samples to be taken of a pixel. With equally many for all, it may lie beside the tile, as the source of a filter's
    /// footprint.
    pub fn of_pixel(&self, tile: &Tile, pixel: [u32; 2]) -> Range<u64> {
        match self {
            Self::Same(range) => range.clone(),
            Self::Each { firsts, counts } => {
                let place = tile.window.index(pixel);
                let first = firsts[place];
                first + tile.count(place)..first + counts[place]
            }
        }
    }

    /// The number of samples of each batch for all pixels of a tile together.
    pub fn batch_counts(&self, tile: &Tile) -> [u64; BATCHES as usize] {
        let mut counts = [0; BATCHES as usize];
        for pixel in tile.window.pixels() {
            let Range { start, end } = self.of_pixel(tile, pixel);
            for (batch, count) in (0..).zip(&mut counts) {
                let before = |index: u64| (index + BATCHES - 1 - batch) / BATCHES;
                *count += before(end) - before(start);
            }
        }
        counts
    }

    /// The number of samples for all pixels of a tile together.
    pub fn sample_count(&self, tile: &Tile) -> u64 {
        match self {
            Self::Same(range) => (range.end - range.start) * tile.window.pixel_count(),
            Self::Each { counts, .. } => {
                let counts = counts.iter().copied();
                let sum = counts.fold(0, u64::saturating_add);
                sum.saturating_sub(tile.sample_count())
            }
        }
    }
}
