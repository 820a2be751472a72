//! One tile's samples of one pass.
//!
//! Measure: samples; radiance.
//! Range: samples that are not finite are counted and located, and left out of the sums.
//! Source: none needed. Tested in `tests/rendering/determinism.rs`.

use super::camera_rays::{CameraRays, Pixel, blocks};
use super::dispatch::Dispatched;
use crate::effects::Effects;
use crate::film::Tile;
use crate::film::filter::Filter;
use crate::film::splats::{SplatSink, Splats};
use crate::integrator::observer::PathObserver;
use crate::integrator::waiting::AT_ONCE;
use crate::integrator::{Integrator, RayCounts};
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::sampler::Sampler;
use crate::scene::Scene;
use std::ops::Range;

/// A sample that was not a finite number: enough to replay it with the render's seed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct NonFiniteSample {
    /// Row of its pixel.
    pub y: u32,
    /// Column of its pixel.
    pub x: u32,
    /// Its index.
    pub sample: u64,
}

/// Samples that were not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Rejected {
    /// How many.
    pub count: u64,
    /// The first one in reading order.
    pub first: Option<NonFiniteSample>,
}

impl Rejected {
    /// Takes others in; in whatever order, the result is the same.
    pub fn merge(&mut self, other: Self) {
        self.count += other.count;
        self.first = self.first.into_iter().chain(other.first).min();
    }
}

/// What a tile's pass tells beside its sums.
#[derive(Debug, Default)]
pub struct Outcome {
    pub rays: RayCounts,
    pub rejected: Rejected,
}

/// Which samples of a tile's pixels are asked for.
#[derive(Debug, Clone)]
pub enum Asked {
    /// The same of every pixel.
    Same(Range<u64>),
    /// Of each pixel those from its count so far up to this.
    Each(Vec<u64>),
}

impl Asked {
    /// How many they are for all pixels of a tile together.
    pub fn sample_count(&self, tile: &Tile) -> u64 {
        match self {
            Self::Same(range) => (range.end - range.start) * tile.window.pixel_count(),
            Self::Each(ends) => ends.iter().sum::<u64>() - tile.sample_count(),
        }
    }
}

/// The samples to be taken in the pixels of a tile.
pub struct TileJob<'a, O> {
    pub scene: &'a Scene,
    pub filter: &'a Filter,
    pub tile: &'a mut Tile,
    /// Where light for other pixels goes.
    pub splats: Option<&'a Splats>,
    pub asked: Asked,
    pub observer: &'a mut O,
}

/// What one sample finds for other places of the film.
struct Elsewhere<'a> {
    filter: &'a Filter,
    splats: Option<&'a Splats>,
    found: Vec<(Vec2, Rgb)>,
}

impl SplatSink for Elsewhere<'_> {
    fn reaches(&self, film: Vec2) -> bool {
        self.splats
            .is_some_and(|splats| splats.reaches(self.filter, film))
    }

    fn splat(&mut self, film: Vec2, value: Rgb) {
        self.found.push((film, value));
    }
}

impl Elsewhere<'_> {
    fn is_finite(&self) -> bool {
        self.found.iter().all(|(_, value)| value.is_finite())
    }

    /// Brings what the sample with this index has found to the film.
    fn add(&self, sample: u64) {
        for &(film, value) in &self.found {
            if let Some(splats) = self.splats {
                splats.add(self.filter, sample, film, value);
            }
        }
    }
}

impl<O: PathObserver> Dispatched for TileJob<'_, O> {
    type Output = Outcome;

    fn run<E: Effects, S: Sampler, I: Integrator>(self, integrator: I, sampler: S) -> Outcome {
        let Self {
            scene,
            filter,
            tile,
            splats,
            asked,
            observer,
        } = self;
        let mut front = Front {
            scene,
            integrator,
            camera_rays: CameraRays::new(),
            samples: Vec::new(),
            elsewhere: Elsewhere {
                filter,
                splats,
                found: Vec::new(),
            },
            outcome: Outcome::default(),
        };
        for (pixel, position) in tile.window.pixels().enumerate() {
            let at = Pixel {
                scene,
                filter,
                position,
            };
            let range = match &asked {
                Asked::Same(range) => range.clone(),
                Asked::Each(ends) => tile.count(pixel)..ends[pixel],
            };
            for block in blocks(range) {
                let index = |index| Index {
                    pixel,
                    position,
                    index,
                };
                front.samples.extend(block.clone().map(index));
                front
                    .camera_rays
                    .add::<E, O>(&at, &sampler, block, observer);
                if front.samples.len() >= AT_ONCE {
                    front.advance::<E, O>(tile, observer);
                }
            }
        }
        front.advance::<E, O>(tile, observer);
        if let (Some(splats), Asked::Same(range)) = (splats, &asked) {
            for sample in range.clone() {
                splats.add_paths(sample, tile.window.pixel_count());
            }
        }
        match asked {
            Asked::Same(range) => tile.samples += range.end - range.start,
            Asked::Each(ends) => {
                tile.samples = ends.iter().copied().min().unwrap_or(tile.samples);
                tile.counts = Some(ends);
            }
        }
        front.outcome
    }
}

/// Which sample of which pixel.
struct Index {
    /// In the tile.
    pixel: usize,
    /// On the film.
    position: [u32; 2],
    index: u64,
}

/// Samples that are under way together.
struct Front<'a, I, S> {
    scene: &'a Scene,
    integrator: I,
    camera_rays: CameraRays<S>,
    /// As those of `camera_rays`.
    samples: Vec<Index>,
    elsewhere: Elsewhere<'a>,
    outcome: Outcome,
}

impl<I: Integrator, S: Sampler> Front<'_, I, S> {
    /// Brings all samples to the film.
    fn advance<E: Effects, O: PathObserver>(&mut self, tile: &mut Tile, observer: &mut O) {
        self.camera_rays.trace(self.scene);
        let mut places = 0..self.samples.len();
        while !places.is_empty() {
            let end = self.camera_rays.estimate::<E, I, O, _>(
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

    /// Brings one sample to the film.
    fn film<O: PathObserver>(&mut self, tile: &mut Tile, place: usize, observer: &mut O) {
        let value = self.camera_rays.value(place);
        let Index {
            pixel,
            position: [x, y],
            index: sample,
        } = self.samples[place];
        if value.is_finite() && self.elsewhere.is_finite() {
            self.elsewhere.add(sample);
            tile.pixels[pixel].add(sample, value);
        } else {
            let first = Some(NonFiniteSample { y, x, sample });
            self.outcome.rejected.merge(Rejected { count: 1, first });
        }
        self.elsewhere.found.clear();
        let rays = self.camera_rays.sample(place).1.rays;
        self.outcome.rays += rays;
        if let Some(of_pixels) = &mut tile.rays {
            of_pixels[pixel] += rays.total();
        }
        observer.filmed(value);
    }
}
