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
        let mut elsewhere = Elsewhere {
            filter,
            splats,
            found: Vec::new(),
        };
        let mut outcome = Outcome::default();
        let mut camera_rays = CameraRays::new();
        let (mut bars, counts) = (tile.bars.as_mut(), tile.counts.as_ref());
        let mut rays_of_pixels = tile.rays.as_mut();
        for (i, ([x, y], sums)) in tile.window.pixels().zip(&mut tile.pixels).enumerate() {
            let pixel = Pixel {
                scene,
                filter,
                position: [x, y],
            };
            let range = match &asked {
                Asked::Same(range) => range.clone(),
                Asked::Each(ends) => counts.map_or(tile.samples, |counts| counts[i])..ends[i],
            };
            let before = outcome.rays.total();
            for block in blocks(range) {
                for (sample, place) in camera_rays.trace::<E, O>(&pixel, &sampler, block, observer)
                {
                    let rays = &mut outcome.rays;
                    let value = camera_rays.value::<E, I, O, _>(
                        place,
                        scene,
                        integrator,
                        rays,
                        observer,
                        &mut elsewhere,
                    );
                    if value.is_finite() && elsewhere.is_finite() {
                        elsewhere.add(sample);
                        sums.add(value);
                        if let Some(bars) = &mut bars {
                            bars[i].add(sample, value);
                        }
                    } else {
                        let first = Some(NonFiniteSample { y, x, sample });
                        outcome.rejected.merge(Rejected { count: 1, first });
                    }
                    elsewhere.found.clear();
                    observer.filmed(value);
                }
            }
            if let Some(rays) = &mut rays_of_pixels {
                rays[i] += outcome.rays.total() - before;
            }
        }
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
        outcome
    }
}
