//! The film: the picture's window, cut into tiles that are filled independently, and what comes out of them.
//!
//! Each sample belongs to one pixel, and each pixel's samples are added in the order of their indices. So the picture
//! does not depend on tiles, passes or threads.
//!
//! Measure: pixels; radiance.
//! Range: a window of at least one pixel; tiles may have different sample counts after an interruption.
//! Source: the image error of docs/accuracy.md. Tested below and in `tests/determinism.rs`.

pub mod filter;
pub mod pixel;

use crate::image::Image;
use crate::math::rgb::Rgb;
use crate::math::stats::Moments;
use pixel::PixelSums;

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// Left column.
    pub x: u32,
    /// Top row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Window {
    /// How many pixels.
    pub fn pixel_count(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Its pixels, row by row.
    pub fn pixels(self) -> impl Iterator<Item = [u32; 2]> {
        let columns = self.x..self.x + self.width;
        (self.y..self.y + self.height).flat_map(move |y| columns.clone().map(move |x| [x, y]))
    }
}

/// A part of the film.
#[derive(Debug, Clone)]
pub struct Tile {
    /// Where it lies.
    pub window: Window,
    /// Sums of its pixels, row by row.
    pub pixels: Vec<PixelSums>,
    /// Samples in every pixel of it.
    pub samples: u64,
}

/// The film.
#[derive(Debug, Clone)]
pub struct Film {
    window: Window,
    tiles: Vec<Tile>,
}

/// How far the picture is likely to be from the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorEstimate {
    /// Estimated root of relMSE, the mean over pixels and channels of (x - r)^2 / (r^2 + eps).
    pub rel_rmse: f64,
    /// With this confidence ...
    pub confidence: f64,
    /// ... the root of relMSE is below this.
    pub upper_bound: f64,
    /// The share of pixels whose estimate cannot be trusted: nothing arrived in them, but something in their
    /// neighbourhood.
    pub uncalibrated_fraction: f64,
}

impl Film {
    /// An empty film over `window`, in square tiles of `tile_size` pixels.
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
                    samples: 0,
                });
            }
        }
        Self { window, tiles }
    }

    /// The part of the picture that it covers.
    pub fn window(&self) -> Window {
        self.window
    }

    /// The tiles.
    pub fn tiles(&self) -> &[Tile] {
        &self.tiles
    }

    /// The tiles, to be filled.
    pub fn tiles_mut(&mut self) -> &mut [Tile] {
        &mut self.tiles
    }

    /// Samples in all pixels together.
    pub fn sample_count(&self) -> u64 {
        self.tiles
            .iter()
            .map(|tile| tile.samples * tile.window.pixel_count())
            .sum()
    }

    /// The picture so far: the mean of each pixel.
    pub fn develop(&self) -> Image {
        let [width, height] = [self.window.width, self.window.height];
        let mut image = vec![Rgb::BLACK; self.window.pixel_count() as usize];
        for (index, _, mean, _) in self.means() {
            image[index] = Rgb::from(mean.map(|x| x as f32));
        }
        Image::new(width, height, image)
    }

    /// The mean of each channel over the whole picture.
    pub fn mean(&self) -> [f64; 3] {
        let mut channels = [Moments::default(); 3];
        for (_, _, mean, _) in self.means() {
            for (moments, x) in channels.iter_mut().zip(mean) {
                moments.push(x);
            }
        }
        channels.map(|moments| moments.mean())
    }

    /// The estimated error of the picture; `None` before every pixel has two samples, or for a black picture.
    ///
    /// It takes samples as independent. Those of a low-discrepancy sampler err less: for them it is an upper bound.
    pub fn error(&self) -> Option<ErrorEstimate> {
        if self.tiles.iter().any(|tile| tile.samples < 2) {
            return None;
        }
        let mean = self.mean().iter().sum::<f64>() / 3.0;
        let epsilon = 0.01 * mean * mean;
        if epsilon == 0.0 {
            return None;
        }
        let mut per_pixel = Moments::default();
        for (_, sums, mean, samples) in self.means() {
            let variance = sums.variance_of_mean(samples)?;
            let relative = |c: usize| variance[c] / (mean[c] * mean[c] + epsilon);
            per_pixel.push((relative(0) + relative(1) + relative(2)) / 3.0);
        }
        // The one-sided 95 % bound of a mean over many pixels.
        let margin = 1.645 * per_pixel.standard_error().unwrap_or(f64::INFINITY);
        Some(ErrorEstimate {
            rel_rmse: per_pixel.mean().sqrt(),
            confidence: 0.95,
            upper_bound: (per_pixel.mean() + margin).sqrt(),
            uncalibrated_fraction: self.uncalibrated_fraction(),
        })
    }

    /// Each pixel's index in the window, sums, mean and sample count.
    fn means(&self) -> impl Iterator<Item = (usize, &PixelSums, [f64; 3], u64)> {
        self.tiles.iter().flat_map(move |tile| {
            tile.window
                .pixels()
                .zip(&tile.pixels)
                .map(move |([x, y], sums)| {
                    let row = (y - self.window.y) as usize;
                    let index = row * self.window.width as usize + (x - self.window.x) as usize;
                    (index, sums, sums.mean(tile.samples), tile.samples)
                })
        })
    }

    /// The share of pixels without light among whose neighbours, up to four pixels away, there is some.
    fn uncalibrated_fraction(&self) -> f64 {
        const REACH: usize = 4;
        let (width, height) = (self.window.width as usize, self.window.height as usize);
        let mut lit = vec![false; width * height];
        for (index, _, mean, _) in self.means() {
            lit[index] = mean != [0.0; 3];
        }
        let mut near = lit.clone();
        spread(&mut near, width, 1, REACH);
        spread(&mut near, height, width, REACH);
        let doubtful = lit
            .iter()
            .zip(&near)
            .filter(|(lit, near)| !**lit && **near)
            .count();
        doubtful as f64 / lit.len() as f64
    }
}

/// Spreads `true` by `reach` along one axis: `length` entries, `stride` apart.
fn spread(mask: &mut [bool], length: usize, stride: usize, reach: usize) {
    let lines = mask.len() / length;
    for line in 0..lines {
        let start = if stride == 1 { line * length } else { line };
        let before: Vec<bool> = (0..length).map(|i| mask[start + i * stride]).collect();
        for i in 0..length {
            let around = i.saturating_sub(reach)..(i + reach + 1).min(length);
            mask[start + i * stride] = before[around].contains(&true);
        }
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
    fn tiles_cover_the_window_once() {
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
            tile.samples = 2;
            for ([x, y], sums) in tile.window.pixels().zip(&mut tile.pixels) {
                sums.add(Rgb::grey((x * y) as f32));
                sums.add(Rgb::grey((x + y) as f32));
            }
        }
        film
    }

    #[test]
    fn the_picture_and_its_error_do_not_depend_on_the_tiles() {
        assert_eq!(filled(1).develop(), filled(4).develop());
        let (a, b) = (
            filled(2).error().expect("two samples"),
            filled(64).error().expect("two"),
        );
        assert!((a.rel_rmse - b.rel_rmse).abs() < 1e-12);
        assert!(a.upper_bound > a.rel_rmse);
    }

    #[test]
    fn a_dark_pixel_beside_a_lit_one_is_not_trusted() {
        let mut film = Film::new(
            Window {
                x: 0,
                y: 0,
                width: 20,
                height: 1,
            },
            32,
        );
        for tile in film.tiles_mut() {
            tile.samples = 2;
            tile.pixels[0].add(Rgb::WHITE);
        }
        // The four pixels next to the lit one.
        assert_eq!(film.uncalibrated_fraction(), 0.2);
    }
}
