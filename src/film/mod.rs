//! The film: the window of the image, in tiles that are rendered independently. `develop.rs` computes the image from them.
//!
//! A sample contributes to the pixel that it is taken for, its source, or, if the film has a footprint, to every pixel that
//! its filter covers; then pixels just outside of the window have samples, too. Sums do not depend on the order of samples.
//! So the image does not depend on tiles, passes or threads.
//!
//! Measure: pixels, whose coordinates are modulo 2^32: the column left of the image is 2^32 - 1; radiance.
//! Range: a window of at least one pixel; sample counts may differ between tiles after an interruption, and between
//! pixels with adaptive sampling.
//! Source: none needed. Tested below and in `tests/rendering/determinism.rs`.

pub mod batches;
mod chi_square;
mod develop;
mod doubt;
mod error;
pub mod error_bars;
mod estimate;
pub mod filter;
pub mod footprint;
mod layout;
pub mod pixel;
mod relative_variance;
pub mod splats;
pub mod splatted;
#[cfg(test)]
mod synthetic;
mod tile;
mod window;

use batches::BATCHES;
pub use doubt::Doubt;
pub(crate) use error::Allowances;
pub use error::ErrorEstimate;
pub use estimate::PixelEstimate;
use filter::FilterSampling;
pub use layout::FilmLayout;
use pixel::PixelSums;
use splats::Splats;
use splatted::Splatted;
pub use tile::Tile;
pub use window::Window;

/// The film: tiles over a window, and splats.
#[derive(Debug, Clone)]
pub struct Film {
    window: Window,
    tile_size: u32,
    /// The number of pixels on either side of a sample's own that it contributes to.
    border_size: u32,
    tiles: Vec<Tile>,
    /// The splats of light paths, if there are any.
    splats: Option<Splats>,
}

impl Film {
    /// Builds an empty film over `window`, in square tiles of `tile_size` pixels.
    pub fn new(window: Window, tile_size: u32) -> Self {
        let tiles = window.tiles(tile_size).map(|tile| Tile {
            window: tile,
            pixels: vec![PixelSums::default(); tile.pixel_count() as usize],
            splatted: None,
            samples: 0,
            counts: None,
            rays: None,
        });
        Self {
            window,
            tile_size: tile_size.max(1),
            border_size: 0,
            tiles: tiles.collect(),
            splats: None,
        }
    }

    /// Builds an empty film of a layout.
    #[doc(hidden)]
    pub fn of_layout(layout: &FilmLayout) -> Self {
        let mut film = Self::new(layout.window, layout.tile_size).with_border(layout.border_size);
        if layout.has_splats {
            film = film.with_splats();
        }
        if layout.has_counts {
            film = film.with_counts();
        }
        film
    }

    /// Lets each sample contribute to the pixels at most `border_size` rows and columns away from its own; with 0, to its own
    /// alone.
    #[doc(hidden)]
    pub fn with_border(mut self, border_size: u32) -> Self {
        self.border_size = border_size;
        if border_size > 0 {
            for tile in &mut self.tiles {
                tile.pixels = vec![];
                let sources = splatted::sources(self.window, tile.window, border_size);
                tile.splatted = Some(Splatted::new(sources, border_size));
            }
        }
        self
    }

    /// Adds a buffer for the splats of light paths.
    #[doc(hidden)]
    pub fn with_splats(mut self) -> Self {
        self.splats = Some(Splats::new(self.window));
        self
    }

    /// Adds counts of samples and rays for each pixel.
    #[doc(hidden)]
    pub fn with_counts(mut self) -> Self {
        for tile in &mut self.tiles {
            tile.counts = Some(vec![0; tile.pixels.len()]);
            tile.rays = Some(vec![0; tile.pixels.len()]);
        }
        self
    }

    /// The part of the image that the film covers.
    pub fn window(&self) -> Window {
        self.window
    }

    /// The edge of a tile, in pixels.
    pub fn tile_size(&self) -> u32 {
        self.tile_size
    }

    /// The number of pixels on either side of a sample's own that it contributes to.
    pub fn border_size(&self) -> u32 {
        self.border_size
    }

    /// The estimator of the filter by the samples of the film.
    #[doc(hidden)]
    pub fn filter_sampling(&self) -> FilterSampling {
        match self.border_size {
            0 => FilterSampling::Importance,
            _ => FilterSampling::Splatting,
        }
    }

    /// The tiles.
    #[doc(hidden)]
    pub fn tiles(&self) -> &[Tile] {
        &self.tiles
    }

    /// The tiles, mutable.
    #[doc(hidden)]
    pub fn tiles_mut(&mut self) -> &mut [Tile] {
        &mut self.tiles
    }

    /// The tiles, mutable, and the buffer that light paths splat to at the same time.
    #[doc(hidden)]
    pub fn tiles_and_splats(&mut self) -> (&mut [Tile], Option<&Splats>) {
        (&mut self.tiles, self.splats.as_ref())
    }

    /// The tiles and the splats of light paths, both mutable.
    #[doc(hidden)]
    pub fn parts_mut(&mut self) -> (&mut [Tile], Option<&mut Splats>) {
        (&mut self.tiles, self.splats.as_mut())
    }

    /// The splats of light paths.
    #[doc(hidden)]
    pub fn splats(&self) -> Option<&Splats> {
        self.splats.as_ref()
    }

    /// Whether the film counts samples and rays for each pixel.
    pub fn has_counts(&self) -> bool {
        self.tiles.iter().any(|tile| tile.counts.is_some())
    }

    /// The sample count of all pixels; the largest number if there are more.
    pub fn sample_count(&self) -> u64 {
        let of_tiles = self.tiles.iter().map(Tile::sample_count);
        of_tiles.fold(0, u64::saturating_add)
    }

    /// The sample count of each pixel, row by row.
    pub fn sample_counts(&self) -> Vec<u64> {
        let mut counts = vec![0; self.pixel_count()];
        for tile in &self.tiles {
            for (place, pixel) in tile.window.pixels().enumerate() {
                counts[self.index(pixel)] = tile.count(place);
            }
        }
        counts
    }

    /// The number of rays traced for each pixel, row by row; 0 without [`with_counts`](Self::with_counts).
    pub fn ray_counts(&self) -> Vec<u64> {
        let mut rays = vec![0; self.window.pixel_count() as usize];
        for tile in &self.tiles {
            let of_tile = tile.rays.iter().flatten();
            for (pixel, &count) in tile.window.pixels().zip(of_tile) {
                rays[self.index(pixel)] = count;
            }
        }
        rays
    }

    /// Whether every pixel has a sample in each batch, which error estimates require.
    pub fn has_all_batches(&self) -> bool {
        self.tiles.iter().all(|tile| tile.samples >= BATCHES)
    }

    /// The values of the window's pixels, given row by row, in the order of the tiles and their pixels.
    #[doc(hidden)]
    pub fn in_tile_order<T: Copy>(&self, of_pixels: &[T]) -> Vec<T> {
        let pixels = self.tiles.iter().flat_map(|tile| tile.window.pixels());
        pixels.map(|pixel| of_pixels[self.index(pixel)]).collect()
    }

    /// Splits values in the order of [`in_tile_order`](Self::in_tile_order) by tile.
    #[doc(hidden)]
    pub fn per_tile<'v, T>(&self, mut in_order: &'v [T]) -> impl Iterator<Item = &'v [T]> {
        self.tiles.iter().map(move |tile| {
            let (of_tile, others) = in_order.split_at(tile.window.pixel_count() as usize);
            in_order = others;
            of_tile
        })
    }

    /// The number of pixels of the window.
    fn pixel_count(&self) -> usize {
        self.window.pixel_count() as usize
    }

    /// The tile of a pixel of the window, and the pixel's index in it.
    fn locate(&self, index: usize) -> (&Tile, usize) {
        let (width, step) = (self.window.width as usize, self.tile_size as usize);
        let (x, y) = (index % width, index / width);
        let tile = &self.tiles[y / step * width.div_ceil(step) + x / step];
        (tile, y % step * tile.window.width as usize + x % step)
    }

    /// The index in the window of a pixel of the image.
    fn index(&self, [x, y]: [u32; 2]) -> usize {
        (y - self.window.y) as usize * self.window.width as usize + (x - self.window.x) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: Window = Window {
        x: 3,
        y: 5,
        width: 10,
        height: 7,
    };

    #[test]
    fn tiles_partition_the_window() {
        for tile_size in [1, 3, 4, 100] {
            let film = Film::new(WINDOW, tile_size);
            let mut pixels: Vec<_> = film
                .tiles()
                .iter()
                .flat_map(|t| t.window.pixels())
                .collect();
            pixels.sort_by_key(|&[x, y]| (y, x));
            assert_eq!(pixels, WINDOW.pixels().collect::<Vec<_>>());
        }
    }
}
