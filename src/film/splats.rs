//! Splats: contributions at arbitrary film positions, as light paths that reach the camera make them.
//!
//! A splat contributes to every pixel whose filter covers its position. Sums are exact, so they have the same bits for
//! any order of the threads.
//!
//! Measure: film positions in pixels from the upper left corner of the whole image; radiance, times the number of
//! samples by which the buffer divides.
//! Range: finite values; any position. 192 bytes a pixel.
//! Source: `pixel.rs` for the sums. Tested below and in `tests/rendering/bidirectional.rs`.

use super::Window;
use super::batches::BATCHES;
use super::filter::Filter;
use super::pixel::PixelSums;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::planted::planted;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard};

/// A bidirectional strategy: s vertices of the light subpath and t of the camera subpath, endpoints included.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Strategy {
    /// Vertices of the light subpath.
    pub s: usize,
    /// Vertices of the camera subpath.
    pub t: usize,
}

/// A contribution at a film position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Splat {
    /// The film position.
    pub film_position: Vec2,
    /// Radiance times the number of samples.
    pub value: Rgb,
}

/// The pixels of a row that a splat contributes to.
struct SplatInRow {
    y: u32,
    first_column: u32,
    /// The index of the splat.
    splat: usize,
    /// The range of the filter weights along the columns.
    weights: Range<usize>,
}

/// The splats of a sample at film positions other than that of its camera ray, and a test of where splats count.
pub struct SplatList<'a> {
    /// Whether a splat at a film position would count.
    pub reaches: &'a dyn Fn(Vec2) -> bool,
    /// The splats.
    pub splats: Vec<Splat>,
}

impl SplatList<'_> {
    /// An empty list, where no position counts.
    pub fn none() -> Self {
        Self {
            reaches: &|_| false,
            splats: Vec::new(),
        }
    }
}

/// The splat sums of all pixels.
#[derive(Debug)]
pub struct Splats {
    window: Window,
    /// The number of samples so far, of each batch.
    samples: [AtomicU64; BATCHES as usize],
    /// Pixels row by row, each with its batches.
    rows: Vec<Mutex<Vec<PixelSums>>>,
}

impl Clone for Splats {
    fn clone(&self) -> Self {
        let rows = (0..self.rows.len()).map(|row| Mutex::new(self.row(row).clone()));
        Self {
            window: self.window,
            samples: std::array::from_fn(|batch| AtomicU64::new(self.samples_of(batch))),
            rows: rows.collect(),
        }
    }
}

impl Splats {
    /// Memory of the splat sums of a pixel, in bytes.
    pub const BYTES_PER_PIXEL: usize = size_of::<PixelSums>();

    /// Builds an empty buffer for the pixels of this window.
    pub fn new(window: Window) -> Self {
        let row = vec![PixelSums::default(); window.width as usize];
        Self {
            window,
            samples: std::array::from_fn(|_| AtomicU64::new(0)),
            rows: (0..window.height)
                .map(|_| Mutex::new(row.clone()))
                .collect(),
        }
    }

    /// The memory of the buffer, in bytes.
    pub fn memory(&self) -> usize {
        self.window.pixel_count() as usize * Self::BYTES_PER_PIXEL
    }

    /// Whether the filter of any pixel covers this position.
    #[inline]
    pub fn reaches(&self, filter: &Filter, film: Vec2) -> bool {
        Self::covers(self.window, filter, film)
    }

    /// Whether the filter of any pixel of a window covers this position.
    #[inline]
    pub fn covers(window: Window, filter: &Filter, film: Vec2) -> bool {
        let rows = covering(filter, film.y, window.y, window.height);
        let columns = covering(filter, film.x, window.x, window.width);
        !rows.is_empty() && !columns.is_empty()
    }

    /// Adds a contribution of the sample with this index to one pixel of the image, which is in the window.
    pub fn add_to_pixel(&self, sample: u64, [x, y]: [u32; 2], value: Rgb) {
        let mut row = self.row((y - self.window.y) as usize);
        let pixel = &mut row[(x - self.window.x) as usize];
        pixel.add(sample, value);
    }

    /// Counts samples with this index, with or without splats.
    pub fn add_samples(&self, sample: u64, count: u64) {
        self.samples[(sample % BATCHES) as usize].fetch_add(count, Ordering::Relaxed);
    }

    /// The number of samples of all batches; the largest number if there are more.
    pub fn sample_count(&self) -> u64 {
        let samples = (0..self.samples.len()).map(|batch| self.samples_of(batch));
        samples.fold(0, u64::saturating_add)
    }

    /// The number of samples of each batch.
    pub fn samples(&self) -> [u64; BATCHES as usize] {
        std::array::from_fn(|batch| self.samples_of(batch))
    }

    fn samples_of(&self, batch: usize) -> u64 {
        self.samples[batch].load(Ordering::Relaxed)
    }

    /// Adds splats, each of the sample with this index. May be called by several threads at once. Each row is locked once
    /// for all of its splats, and its pixels are visited in order, so that many splats at a time take less time each.
    pub fn add(&self, filter: &Filter, splats: &[(u64, Splat)]) {
        let shift = planted!("splats-half-a-pixel-off", 0.5, 0.0);
        let offset = |film: f32, pixel: u32| f64::from(film + shift) - (f64::from(pixel) + 0.5);
        // Weights along the columns are the same in every row.
        let mut weights = Vec::with_capacity(splats.len());
        let mut in_rows = Vec::with_capacity(splats.len());
        for (splat, (_, of_splat)) in splats.iter().enumerate() {
            let film = of_splat.film_position;
            let columns = covering(filter, film.x + shift, self.window.x, self.window.width);
            let rows = covering(filter, film.y + shift, self.window.y, self.window.height);
            let first_weight = weights.len();
            let first_column = columns.start;
            weights.extend(columns.map(|x| filter.evaluate_axis(offset(film.x, x))));
            let weights = first_weight..weights.len();
            in_rows.extend(rows.map(|y| SplatInRow {
                y,
                first_column,
                splat,
                weights: weights.clone(),
            }));
        }
        in_rows.sort_unstable_by_key(|it| (it.y, it.first_column));
        for in_row in in_rows.chunk_by(|a, b| a.y == b.y) {
            let mut row = self.row((in_row[0].y - self.window.y) as usize);
            for it in in_row {
                let (sample, splat) = splats[it.splat];
                let of_row = filter.evaluate_axis(offset(splat.film_position.y, it.y));
                let pixels = &mut row[(it.first_column - self.window.x) as usize..];
                for (pixel, weight) in pixels.iter_mut().zip(&weights[it.weights.clone()]) {
                    pixel.add(sample, splat.value * (of_row * weight) as f32);
                }
            }
        }
    }

    /// The mean of a pixel of the window over all samples.
    pub fn mean(&self, pixel: usize) -> [f64; 3] {
        let splats = self.pixel(pixel);
        let samples = self.sample_count().max(1) as f64;
        let values = splats.values();
        std::array::from_fn(|c| values.iter().map(|batch| batch[c]).sum::<f64>() / samples)
    }

    /// The means of a pixel over the samples of each batch.
    pub fn batch_means(&self, pixel: usize) -> [[f64; 3]; BATCHES as usize] {
        let values = self.pixel(pixel).values();
        std::array::from_fn(|batch| {
            let samples = self.samples_of(batch).max(1) as f64;
            values[batch].map(|sum| sum / samples)
        })
    }

    /// The splat sums, row by row, mutable.
    pub fn rows_mut(&mut self) -> impl Iterator<Item = &mut [PixelSums]> {
        let rows = self.rows.iter_mut().map(Mutex::get_mut);
        rows.map(|row| &mut **row.expect("no thread panics while it holds this"))
    }

    /// The splat sums of a pixel of the window.
    pub fn pixel(&self, pixel: usize) -> PixelSums {
        let width = self.window.width as usize;
        self.row(pixel / width)[pixel % width]
    }

    fn row(&self, row: usize) -> MutexGuard<'_, Vec<PixelSums>> {
        self.rows[row]
            .lock()
            .expect("no thread panics while it holds this")
    }
}

/// The pixels, of `count` from `first` on, whose centre is above `at` minus the filter's radius, and not above `at`
/// plus it.
#[inline]
fn covering(filter: &Filter, at: f32, first: u32, count: u32) -> Range<u32> {
    let (at, radius) = (f64::from(at) - 0.5, filter.radius());
    let (low, high) = (f64::from(first), f64::from(first) + f64::from(count));
    let from = ((at - radius).floor() + 1.0).clamp(low, high);
    let to = ((at + radius).floor() + 1.0).clamp(low, high);
    from as u32..to.max(from) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::filter::{FilterDescription, FilterKind};
    use std::slice;

    const WINDOW: Window = Window {
        x: 2,
        y: 1,
        width: 5,
        height: 4,
    };

    fn filter(kind: FilterKind) -> Filter {
        let radius = kind.default_radius();
        Filter::new(&FilterDescription { kind, radius })
    }

    fn splat(sample: u64, film_position: Vec2, value: Rgb) -> (u64, Splat) {
        let splat = Splat {
            film_position,
            value,
        };
        (sample, splat)
    }

    /// Splats over the window and around it, with values that differ by a factor of 10^9.
    fn splats() -> Vec<(u64, Splat)> {
        let number = |i: u32, k: f32| (i as f32 * k).fract();
        let of_index = |i: u32| {
            let at = Vec2::new(9.0 * number(i, 0.618_034), 7.0 * number(i, 0.414_214));
            let value = 10.0_f32.powf(9.0 * number(i, 0.732_051) - 6.0);
            splat(i.into(), at, Rgb::new(value, 1.0 / 3.0, 0.1 * value))
        };
        (0..2000).map(of_index).collect()
    }

    #[test]
    fn splat_sums_are_bit_identical_in_reverse_order() {
        let filter = filter(FilterKind::Gaussian);
        let [one, other] = [0, 1].map(|_| Splats::new(WINDOW));
        let splats = splats();
        for sample in 0..2000 {
            one.add_samples(sample, 1);
            other.add_samples(sample, 1);
        }
        one.add(&filter, &splats);
        for splat in splats.iter().rev() {
            other.add(&filter, slice::from_ref(splat));
        }
        for pixel in 0..20 {
            assert_eq!(one.mean(pixel), other.mean(pixel));
            assert_eq!(one.batch_means(pixel), other.batch_means(pixel));
        }
    }

    #[test]
    fn box_filter_splats_to_the_containing_pixel() {
        let filter = filter(FilterKind::Box);
        let all = Splats::new(WINDOW);
        all.add_samples(0, 10);
        let mut expected = [0.0; 20];
        for of_sample in splats() {
            let Splat {
                film_position: at,
                value,
            } = of_sample.1;
            let (x, y) = (at.x.floor() - 2.0, at.y.floor() - 1.0);
            let is_inside = (0.0..5.0).contains(&x) && (0.0..4.0).contains(&y);
            assert_eq!(all.reaches(&filter, at), is_inside, "{at}");
            all.add(&filter, &[of_sample]);
            if is_inside {
                expected[y as usize * 5 + x as usize] += f64::from(value.to_array()[0]);
            }
        }
        for (pixel, expected) in expected.into_iter().enumerate() {
            let mean = all.mean(pixel)[0];
            assert!((mean / (expected / 10.0) - 1.0).abs() < 1e-12, "{pixel}");
        }
        // A border belongs to one of its two pixels.
        let borders = Splats::new(WINDOW);
        borders.add(&filter, &[splat(0, Vec2::new(4.0, 2.5), Rgb::WHITE)]);
        let lit = (0..20).filter(|&pixel| borders.mean(pixel)[0] > 0.0);
        assert_eq!(lit.collect::<Vec<_>>(), [7]);
    }

    /// Uniform light, splatted on a fine grid, gives the same mean in each pixel for every filter.
    #[test]
    fn uniform_splats_have_unit_mean_for_every_filter() {
        for &(name, kind) in FilterKind::ALL {
            let filter = filter(kind);
            let splats = Splats::new(WINDOW);
            const FINE: u32 = 32;
            splats.add_samples(3, u64::from(FINE * FINE));
            for i in 0..12 * FINE {
                for j in 0..10 * FINE {
                    let at = |i: u32| (i as f32 + 0.5) / FINE as f32 - 2.0;
                    let place = Vec2::new(at(i), at(j));
                    splats.add(&filter, &[splat(u64::from(i + j), place, Rgb::WHITE)]);
                }
            }
            for pixel in 0..20 {
                let mean = splats.mean(pixel)[1];
                // The midpoint rule on steps of 1/32 of a pixel.
                assert!((mean - 1.0).abs() < 2e-3, "{name}: {mean}");
            }
        }
    }

    #[test]
    fn splats_are_assigned_to_batches_by_sample_index() {
        let filter = filter(FilterKind::Box);
        let splats = Splats::new(WINDOW);
        for sample in 0..64 {
            let value = Rgb::grey((sample % BATCHES) as f32);
            splats.add(&filter, &[splat(sample, Vec2::new(2.5, 1.5), value)]);
            splats.add_samples(sample, 1);
        }
        let means = splats.batch_means(0);
        assert!((0..BATCHES as usize).all(|batch| means[batch] == [batch as f64; 3]));
        assert_eq!(splats.mean(0), [1.5; 3]);
    }
}
