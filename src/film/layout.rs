//! The layout of a film: the sums that it has, and of which pixels.
//!
//! Measure: pixels; bytes.
//! Range: any; counts that exceed 64 bits are the largest number.
//! Source: none needed. Tested in `tests/rendering/session.rs` and `tests/rendering/state_headers.rs`.

use super::pixel::PixelSums;
use super::splats::Splats;
use super::splatted::WeightedSums;
use super::window::Window;

/// The counts of samples and rays of a pixel, in bytes.
const BYTES_OF_COUNTS: usize = 2 * size_of::<u64>();

/// The sums of a film, without samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FilmLayout {
    /// The part of the image that the film covers.
    pub window: Window,
    /// The edge of a tile, in pixels.
    pub tile_size: u32,
    /// The number of pixels on either side of a sample's own that it contributes to.
    pub border_size: u32,
    /// Whether there are sums of the splats of light paths.
    pub has_splats: bool,
    /// Whether each pixel has a count of samples and of rays.
    pub has_counts: bool,
}

impl FilmLayout {
    /// The number of pixels that the tiles have sums of: with a border, each tile has those of its halo, too.
    pub fn sum_count(&self) -> u64 {
        // Each tile along an axis adds its halo, and the sources beyond the edge.
        let along = |length: u32| {
            let tiles = u64::from(length.div_ceil(self.tile_size.max(1)));
            match self.border_size {
                0 => u64::from(length),
                border_size => u64::from(length) + 2 * u64::from(border_size) * (tiles + 1),
            }
        };
        along(self.window.width).saturating_mul(along(self.window.height))
    }

    /// The memory of the film, in bytes.
    pub fn memory(&self) -> u64 {
        let of_sums = match self.border_size {
            0 => size_of::<PixelSums>(),
            _ => size_of::<WeightedSums>(),
        };
        let of_pixel = usize::from(self.has_splats) * Splats::BYTES_PER_PIXEL
            + usize::from(self.has_counts) * BYTES_OF_COUNTS;
        let sums = self.sum_count().saturating_mul(of_sums as u64);
        let others = self.window.pixel_count().saturating_mul(of_pixel as u64);
        sums.saturating_add(others)
    }
}
