//! Tiles: the parts of a film that are rendered independently.
//!
//! Measure: samples per pixel, rays.
//! Range: sample counts may differ between the pixels of adaptive renders.
//! Source: none needed. Tested in `tests/rendering/determinism.rs` and `tests/rendering/adaptive_pixels.rs`.

use super::pixel::PixelSums;
use super::splatted::Splatted;
use super::window::Window;

/// A rectangular part of the film.
#[derive(Debug, Clone)]
pub struct Tile {
    /// The pixels that the tile covers.
    pub window: Window,
    /// The sample sums of the tile's pixels, row by row; empty if samples contribute to several pixels.
    pub pixels: Vec<PixelSums>,
    /// The sums of samples that contribute to several pixels.
    pub splatted: Option<Splatted>,
    /// The sample count of every pixel; where counts differ, the count that every pixel has at least.
    pub samples: u64,
    /// The sample count of each pixel, where they may differ.
    pub counts: Option<Vec<u64>>,
    /// The number of rays traced for each pixel, where sample counts may differ.
    pub rays: Option<Vec<u64>>,
}

impl Tile {
    /// The pixels whose samples are taken: the tile's, and with a footprint those beyond the image's edge that contribute.
    pub fn sources(&self) -> Window {
        self.splatted
            .as_ref()
            .map_or(self.window, Splatted::sources)
    }

    /// The sample count of the pixel at this index in the tile.
    pub fn count(&self, place: usize) -> u64 {
        match &self.counts {
            Some(counts) => counts[place],
            None => self.samples,
        }
    }

    /// The sample count of all pixels of the tile; the largest number if there are more.
    pub fn sample_count(&self) -> u64 {
        match &self.counts {
            Some(counts) => counts.iter().copied().fold(0, u64::saturating_add),
            None => self.samples.saturating_mul(self.window.pixel_count()),
        }
    }
}
