//! The film: the window of the image, in tiles that are rendered independently, and the image and batch means
//! computed from them.
//!
//! A sample contributes to the pixel that it is taken for, its source, or, if the film has a footprint, to every pixel that
//! its filter covers; then pixels just outside of the window have samples, too. Sums do not depend on the order of samples.
//! So the image does not depend on tiles, passes or threads.
//!
//! Measure: pixels, whose coordinates are modulo 2^32: the column left of the image is 2^32 - 1; radiance.
//! Range: a window of at least one pixel; sample counts may differ between tiles after an interruption, and between
//! pixels with adaptive sampling.
//! Source: the image error of docs/accuracy.md. Tested below and in `tests/rendering/determinism.rs`.

pub mod batches;
mod error;
pub mod error_bars;
mod estimate;
pub mod filter;
pub mod footprint;
pub mod pixel;
mod relative_variance;
pub mod splats;
pub mod splatted;
#[cfg(test)]
mod synthetic;
mod tile;
mod window;

use crate::image::Image;
use crate::math::rgb::Rgb;
use crate::math::stats::Moments;
use batches::{BATCHES, BatchMeans, Half};
pub use error::{Doubt, ErrorEstimate};
pub(crate) use error::{MODEL_ERROR, margin};
pub use estimate::PixelEstimate;
use filter::FilterSampling;
use pixel::PixelSums;
use splats::Splats;
use splatted::{Splatted, WeightedSums};
pub use tile::Tile;
pub use window::Window;

/// The film: tiles over a window, and splats.
#[derive(Debug, Clone)]
pub struct Film {
    window: Window,
    tile_size: u32,
    /// The number of pixels on either side of a sample's own that it contributes to.
    reach: u32,
    tiles: Vec<Tile>,
    /// The splats of light paths, if there are any.
    splats: Option<Splats>,
}

impl Film {
    /// Builds an empty film over `window`, in square tiles of `tile_size` pixels.
    pub fn new(window: Window, tile_size: u32) -> Self {
        let step = tile_size.max(1);
        let starts = |from: u32, length: u32| (from..from + length).step_by(step as usize);
        let mut tiles = Vec::new();
        for y in starts(window.y, window.height) {
            for x in starts(window.x, window.width) {
                let tile = Window {
                    x,
                    y,
                    width: step.min(window.x + window.width - x),
                    height: step.min(window.y + window.height - y),
                };
                tiles.push(Tile {
                    window: tile,
                    pixels: vec![PixelSums::default(); tile.pixel_count() as usize],
                    splatted: None,
                    samples: 0,
                    counts: None,
                    rays: None,
                });
            }
        }
        Self {
            window,
            tile_size: step,
            reach: 0,
            tiles,
            splats: None,
        }
    }

    /// Lets each sample contribute to the pixels at most `reach` rows and columns away from its own; with 0, to its own alone.
    pub fn with_reach(mut self, reach: u32) -> Self {
        self.reach = reach;
        if reach > 0 {
            for tile in &mut self.tiles {
                tile.pixels = vec![];
                let sources = splatted::sources(self.window, tile.window, reach);
                tile.splatted = Some(Splatted::new(sources, reach));
            }
        }
        self
    }

    /// The number of pixels that the tiles of a film have sums of: with a reach, each tile has those of its halo, too.
    pub fn sum_count(window: Window, tile_size: u32, reach: u32) -> u64 {
        // Each tile along an axis adds its halo, and the sources beyond the edge.
        let along = |length: u32| {
            let tiles = u64::from(length.div_ceil(tile_size.max(1)));
            match reach {
                0 => u64::from(length),
                _ => u64::from(length) + 2 * u64::from(reach) * (tiles + 1),
            }
        };
        along(window.width).saturating_mul(along(window.height))
    }

    /// The memory of the sums of the pixels of a film, in bytes, without the splats of light paths.
    pub fn memory(window: Window, tile_size: u32, reach: u32) -> u64 {
        let of_pixel = match reach {
            0 => size_of::<PixelSums>(),
            _ => size_of::<WeightedSums>(),
        };
        Self::sum_count(window, tile_size, reach).saturating_mul(of_pixel as u64)
    }

    /// Adds a buffer for the splats of light paths.
    pub fn with_splats(mut self) -> Self {
        self.splats = Some(Splats::new(self.window));
        self
    }

    /// The memory of the counts of samples and rays of a pixel, in bytes.
    pub const BYTES_OF_COUNTS: usize = 2 * size_of::<u64>();

    /// Adds counts of samples and rays for each pixel.
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
    pub fn reach(&self) -> u32 {
        self.reach
    }

    /// The estimator of the filter by the samples of the film.
    pub fn filter_sampling(&self) -> FilterSampling {
        match self.reach {
            0 => FilterSampling::Importance,
            _ => FilterSampling::Splatting,
        }
    }

    /// The tiles.
    pub fn tiles(&self) -> &[Tile] {
        &self.tiles
    }

    /// The tiles, mutable.
    pub fn tiles_mut(&mut self) -> &mut [Tile] {
        &mut self.tiles
    }

    /// The tiles, mutable, and the buffer that light paths splat to at the same time.
    pub fn tiles_and_splats(&mut self) -> (&mut [Tile], Option<&Splats>) {
        (&mut self.tiles, self.splats.as_ref())
    }

    /// The tiles and the splats of light paths, both mutable.
    pub fn parts_mut(&mut self) -> (&mut [Tile], Option<&mut Splats>) {
        (&mut self.tiles, self.splats.as_mut())
    }

    /// The splats of light paths.
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
        let mut counts = vec![0; self.window.pixel_count() as usize];
        for (index, _, samples) in self.means() {
            counts[index] = samples;
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

    /// The image so far: the mean of each pixel.
    pub fn develop(&self) -> Image {
        let [width, height] = [self.window.width, self.window.height];
        let mut image = vec![Rgb::BLACK; self.window.pixel_count() as usize];
        for (index, mean, _) in self.means() {
            image[index] = Rgb::from(mean.map(|x| x as f32));
        }
        Image::new(width, height, image)
    }

    /// The image of the even batches. If all batches of a pixel have the same sample count, the image of the odd
    /// batches, which is independent, follows from this one and the whole image.
    pub fn develop_half(&self) -> Image {
        let [width, height] = [self.window.width, self.window.height];
        let pixels = (0..self.pixel_count()).map(|index| {
            let mean = self.batch_means(index).half_mean(Half::Even);
            Rgb::from(mean.map(|x| x as f32))
        });
        Image::new(width, height, pixels.collect())
    }

    /// The batch means of a pixel of the window: of its samples plus the splats of light paths. Samples and splats
    /// are not independent, but batches are.
    pub fn batch_means(&self, index: usize) -> BatchMeans {
        let (tile, place) = self.locate(index);
        let mut batches = match tile.pixels.get(place) {
            Some(sums) => sums.batch_means(tile.count(place)),
            None => self.splatted_means(index),
        };
        if let Some(splats) = &self.splats {
            let of_samples = batches.means.iter_mut().zip(&mut batches.are_black);
            for ((mean, is_black), splats) in of_samples.zip(splats.batch_means(index)) {
                *mean = sum(*mean, splats);
                *is_black &= splats == [0.0; 3];
            }
        }
        batches
    }

    /// The batch means of a pixel of a film whose samples contribute to several pixels.
    fn splatted_means(&self, index: usize) -> BatchMeans {
        let (home, _) = self.locate(index);
        let (width, step) = (self.window.width as usize, self.tile_size as usize);
        let reach = self.reach as usize;
        let across = width.div_ceil(step);
        let near = |at: usize, tiles: usize| {
            let last = (at + reach) / step;
            at.saturating_sub(reach) / step..(last + 1).min(tiles)
        };
        let (x, y) = (index % width, index / width);
        let pixel = [
            self.window.x.wrapping_add(x as u32),
            self.window.y.wrapping_add(y as u32),
        ];
        let columns = near(x, across);
        let rows = near(y, self.tiles.len() / across);
        let tiles = rows.flat_map(|row| columns.clone().map(move |column| (row, column)));
        let sums = tiles.filter_map(|(row, column)| {
            let tile = &self.tiles[row * across + column];
            let sums = tile.splatted.as_ref()?.sums_of(pixel)?;
            Some((sums, tile.samples))
        });
        splatted::batch_means(sums, home.samples)
    }

    /// Whether every pixel has a sample in each batch, which error estimates require.
    pub fn has_all_batches(&self) -> bool {
        self.tiles.iter().all(|tile| tile.samples >= BATCHES)
    }

    /// The mean of each channel over the whole image.
    pub fn mean(&self) -> [f64; 3] {
        let mut channels = [Moments::default(); 3];
        for (_, mean, _) in self.means() {
            for (moments, x) in channels.iter_mut().zip(mean) {
                moments.push(x);
            }
        }
        channels.map(|moments| moments.mean())
    }

    /// Splits values of the window's pixels, given row by row, by tile, in the order of the tiles' pixels.
    pub fn per_tile<T: Copy>(&self, of_pixels: &[T]) -> Vec<Vec<T>> {
        let of_tile = |tile: &Tile| {
            let pixels = tile.window.pixels();
            pixels.map(|pixel| of_pixels[self.index(pixel)]).collect()
        };
        self.tiles.iter().map(of_tile).collect()
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

    /// The index in the window, mean and sample count of each pixel.
    fn means(&self) -> impl Iterator<Item = (usize, [f64; 3], u64)> {
        self.tiles.iter().flat_map(move |tile| {
            let pixels = tile.window.pixels().enumerate();
            pixels.map(move |(place, pixel)| {
                let (index, samples) = (self.index(pixel), tile.count(place));
                let mut mean = match tile.pixels.get(place) {
                    Some(sums) => sums.mean(samples),
                    None => self.splatted_means(index).mean(),
                };
                if let Some(splats) = &self.splats {
                    mean = sum(mean, splats.mean(index));
                }
                (index, mean, samples)
            })
        })
    }
}

/// The sum of two colours, channel by channel.
fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| a[c] + b[c])
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

    fn filled(tile_size: u32) -> Film {
        let mut film = Film::new(WINDOW, tile_size);
        for tile in film.tiles_mut() {
            tile.samples = 8;
            for ([x, y], sums) in tile.window.pixels().zip(&mut tile.pixels) {
                for index in 0..8 {
                    sums.add(
                        index,
                        Rgb::grey((x * y + (x + y) * index as u32 % 7) as f32),
                    );
                }
            }
        }
        film
    }

    #[test]
    fn image_and_error_estimate_are_independent_of_tile_size() {
        assert_eq!(filled(1).develop(), filled(4).develop());
        let [a, b] = [2, 64].map(|size| filled(size).error(0.95).expect("eight samples"));
        assert_eq!(a, b);
        assert!(a.upper_bound > a.rel_rmse);
        for index in 0..WINDOW.pixel_count() as usize {
            assert_eq!(filled(3).batch_means(index), filled(100).batch_means(index));
        }
    }

    #[test]
    fn half_image_is_the_mean_of_even_samples_for_unequal_counts() {
        let mut film = Film::new(WINDOW, 4).with_counts();
        for tile in film.tiles_mut() {
            tile.samples = 16;
            let counts = tile.counts.as_mut().expect("it has counts");
            for (place, (count, sums)) in counts.iter_mut().zip(&mut tile.pixels).enumerate() {
                *count = 16 * (1 + place as u64 % 3);
                for sample in 0..*count {
                    sums.add(sample, Rgb::grey(if sample % 2 == 0 { 3.0 } else { 5.0 }));
                }
            }
        }
        let half = film.develop_half();
        assert!(half.pixels().iter().all(|&pixel| pixel == Rgb::grey(3.0)));
        let whole = film.develop();
        assert!(whole.pixels().iter().all(|&pixel| pixel == Rgb::grey(4.0)));
    }
}
