//! The image and the batch means of a film.
//!
//! The samples of a pixel are those that it is the source of, or, if samples contribute to several pixels, those of all
//! tiles nearby; splats of light paths are added.
//!
//! Measure: radiance.
//! Range: a pixel without samples is black.
//! Source: the image error of docs/accuracy.md. Tested below and in `tests/rendering/determinism.rs`.

use super::Film;
use super::batches::{BatchMeans, Half};
use super::splatted;
use crate::image::Image;
use crate::math::rgb::Rgb;
use crate::math::stats::Moments;

impl Film {
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
        let mut batches = self.sample_batch_means(index);
        if let Some(splats) = &self.splats {
            let of_samples = batches.means.iter_mut().zip(&mut batches.are_black);
            for ((mean, is_black), splats) in of_samples.zip(splats.batch_means(index)) {
                *mean = sum(*mean, splats);
                *is_black &= splats == [0.0; 3];
            }
        }
        batches
    }

    /// The batch means of a pixel of the window, of its samples alone, without the splats of light paths.
    pub(super) fn sample_batch_means(&self, index: usize) -> BatchMeans {
        let (tile, place) = self.locate(index);
        match tile.pixels.get(place) {
            Some(sums) => sums.batch_means(tile.count(place)),
            None => self.splatted_means(index),
        }
    }

    /// The batch means of a pixel of a film whose samples contribute to several pixels.
    fn splatted_means(&self, index: usize) -> BatchMeans {
        let (home, _) = self.locate(index);
        let (width, step) = (self.window.width as usize, self.tile_size as usize);
        let border_size = self.border_size as usize;
        let across = width.div_ceil(step);
        let near = |at: usize, tiles: usize| {
            let last = (at + border_size) / step;
            at.saturating_sub(border_size) / step..(last + 1).min(tiles)
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

    /// The index in the window, mean and sample count of each pixel.
    pub(super) fn means(&self) -> impl Iterator<Item = (usize, [f64; 3], u64)> {
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
    use crate::film::Window;

    const WINDOW: Window = Window {
        x: 3,
        y: 5,
        width: 10,
        height: 7,
    };

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
