//! The samples of one tile in one pass.
//!
//! Measure: samples; radiance.
//! Range: samples that are not finite are counted and located, and left out of the sums.
//! Source: none needed. Tested in `tests/rendering/determinism.rs`.

use super::camera_rays::{CameraRays, Pixel, blocks};
use super::dispatch::Dispatched;
use crate::effects::Effects;
use crate::film::Tile;
use crate::film::filter::Filter;
use crate::film::splats::{SplatList, Splats};
use crate::integrator::observer::PathObserver;
use crate::integrator::path::WAVEFRONT_SIZE;
use crate::integrator::{Integrator, RayCounts};
use crate::sampler::AnySampler;
use crate::scene::Scene;
use std::ops::Range;

/// A sample that was not a finite number: enough to replay it with the render's seed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct NonFiniteSample {
    /// The row of its pixel.
    pub y: u32,
    /// The column of its pixel.
    pub x: u32,
    /// The index of the sample.
    pub sample: u64,
}

/// The samples that were not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Rejected {
    /// The number of them.
    pub count: u64,
    /// The first one in reading order.
    pub first: Option<NonFiniteSample>,
}

impl Rejected {
    /// Merges other rejected samples; the result does not depend on the order.
    pub fn merge(&mut self, other: Self) {
        self.count += other.count;
        self.first = self.first.into_iter().chain(other.first).min();
    }
}

/// The results of a tile's pass beside its sums.
#[derive(Debug, Default)]
pub struct Outcome {
    pub rays: RayCounts,
    pub rejected: Rejected,
}

/// The indices of the samples to be taken in a tile's pixels.
#[derive(Debug, Clone)]
pub enum SampleRange {
    /// The range of every pixel.
    Same(Range<u64>),
    /// The end of each pixel's range, which begins at its count so far.
    Each(Vec<u64>),
}

impl SampleRange {
    /// The number of samples for all pixels of a tile together.
    pub fn sample_count(&self, tile: &Tile) -> u64 {
        match self {
            Self::Same(range) => (range.end - range.start) * tile.window.pixel_count(),
            Self::Each(ends) => ends.iter().sum::<u64>() - tile.sample_count(),
        }
    }
}

/// The job of sampling the pixels of a tile.
pub struct TileJob<'a, O: ?Sized> {
    pub scene: &'a Scene,
    pub filter: &'a Filter,
    pub tile: &'a mut Tile,
    /// The splats of the film, for light in other pixels.
    pub splats: Option<&'a Splats>,
    pub sample_range: SampleRange,
    pub sampler: AnySampler,
    pub observer: &'a mut O,
}

impl<O: PathObserver + ?Sized> Dispatched for TileJob<'_, O> {
    type Output = Outcome;

    fn run<E: Effects, I: Integrator>(self, integrator: I) -> Outcome {
        let Self {
            scene,
            filter,
            tile,
            splats,
            sample_range,
            sampler,
            observer,
        } = self;
        let reaches = |film| splats.is_some_and(|splats| splats.reaches(filter, film));
        let mut wavefront = Wavefront {
            scene,
            filter,
            integrator,
            camera_rays: CameraRays::<E>::new(),
            samples: Vec::new(),
            splats,
            elsewhere: SplatList {
                reaches: &reaches,
                splats: Vec::new(),
            },
            outcome: Outcome::default(),
        };
        for (pixel, position) in tile.window.pixels().enumerate() {
            let at = Pixel {
                scene,
                filter,
                position,
            };
            let range = match &sample_range {
                SampleRange::Same(range) => range.clone(),
                SampleRange::Each(ends) => tile.count(pixel)..ends[pixel],
            };
            for block in blocks(range) {
                let index = |index| Index {
                    pixel,
                    position,
                    index,
                };
                wavefront.samples.extend(block.clone().map(index));
                wavefront.camera_rays.add(&at, &sampler, block, observer);
                if wavefront.samples.len() >= WAVEFRONT_SIZE {
                    wavefront.advance(tile, observer);
                }
            }
        }
        wavefront.advance(tile, observer);
        if let (Some(splats), SampleRange::Same(range)) = (splats, &sample_range) {
            for sample in range.clone() {
                splats.add_paths(sample, tile.window.pixel_count());
            }
        }
        match sample_range {
            SampleRange::Same(range) => tile.samples += range.end - range.start,
            SampleRange::Each(ends) => {
                tile.samples = ends.iter().copied().min().unwrap_or(tile.samples);
                tile.counts = Some(ends);
            }
        }
        wavefront.outcome
    }
}

/// The index of a sample, and its pixel.
struct Index {
    /// The pixel's index in the tile.
    pixel: usize,
    /// The pixel's position on the film.
    position: [u32; 2],
    index: u64,
}

/// A wavefront of samples.
struct Wavefront<'a, E: Effects, I> {
    scene: &'a Scene,
    filter: &'a Filter,
    integrator: I,
    camera_rays: CameraRays<E>,
    /// The indices of the samples, in the order of `camera_rays`.
    samples: Vec<Index>,
    /// The splats of the film, and those of the current sample.
    splats: Option<&'a Splats>,
    elsewhere: SplatList<'a>,
    outcome: Outcome,
}

impl<E: Effects, I: Integrator> Wavefront<'_, E, I> {
    /// Estimates all samples, and adds them to the film.
    fn advance<O: PathObserver + ?Sized>(&mut self, tile: &mut Tile, observer: &mut O) {
        self.camera_rays.trace(self.scene);
        let mut places = 0..self.samples.len();
        while !places.is_empty() {
            let end = self.camera_rays.estimate::<I, O>(
                places.clone(),
                self.scene,
                self.integrator,
                observer,
                &mut self.elsewhere,
            );
            for place in places.start..end {
                self.film(tile, place, observer);
            }
            places.start = end;
        }
        self.camera_rays.clear();
        self.samples.clear();
    }

    /// Adds one sample to the film.
    fn film<O: PathObserver + ?Sized>(&mut self, tile: &mut Tile, place: usize, observer: &mut O) {
        let value = self.camera_rays.value(place);
        let Index {
            pixel,
            position: [x, y],
            index: sample,
        } = self.samples[place];
        let elsewhere = &mut self.elsewhere.splats;
        if value.is_finite() && elsewhere.iter().all(|splat| splat.value.is_finite()) {
            if let Some(splats) = self.splats {
                for splat in &*elsewhere {
                    splats.add(self.filter, sample, splat.film, splat.value);
                }
            }
            tile.pixels[pixel].add(sample, value);
        } else {
            let first = Some(NonFiniteSample { y, x, sample });
            self.outcome.rejected.merge(Rejected { count: 1, first });
        }
        elsewhere.clear();
        let rays = self.camera_rays.sample(place).1.rays;
        self.outcome.rays += rays;
        if let Some(of_pixels) = &mut tile.rays {
            of_pixels[pixel] += rays.total();
        }
        observer.filmed(value);
    }
}
