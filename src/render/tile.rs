//! One tile's samples of one pass.
//!
//! Measure: samples; radiance.
//! Range: samples that are not finite are counted and located, and left out of the sums.
//! Source: none needed. Tested in `tests/determinism.rs`.

use super::camera_rays::{CameraRays, Pixel, blocks};
use super::dispatch::Dispatched;
use crate::effects::Effects;
use crate::film::Tile;
use crate::film::filter::Filter;
use crate::integrator::observer::PathObserver;
use crate::integrator::{Integrator, RayCounts};
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

/// The samples of `range` to be taken in every pixel of a tile.
pub struct TileJob<'a, O> {
    pub scene: &'a Scene,
    pub filter: &'a Filter,
    pub tile: &'a mut Tile,
    pub range: Range<u64>,
    pub observer: &'a mut O,
}

impl<O: PathObserver> Dispatched for TileJob<'_, O> {
    type Output = Outcome;

    fn run<E: Effects, S: Sampler, I: Integrator>(self, integrator: I, sampler: S) -> Outcome {
        let Self {
            scene,
            filter,
            tile,
            range,
            observer,
        } = self;
        let mut outcome = Outcome::default();
        let mut camera_rays = CameraRays::new();
        let mut bars = tile.bars.as_mut();
        for (i, ([x, y], sums)) in tile.window.pixels().zip(&mut tile.pixels).enumerate() {
            let pixel = Pixel {
                scene,
                filter,
                position: [x, y],
            };
            for block in blocks(range.clone()) {
                for (sample, place) in camera_rays.trace::<E, O>(&pixel, &sampler, block, observer)
                {
                    let rays = &mut outcome.rays;
                    let value =
                        camera_rays.value::<E, I, O>(place, scene, integrator, rays, observer);
                    if value.is_finite() {
                        sums.add(value);
                        if let Some(bars) = &mut bars {
                            bars[i].add(sample, value);
                        }
                    } else {
                        let first = Some(NonFiniteSample { y, x, sample });
                        outcome.rejected.merge(Rejected { count: 1, first });
                    }
                    observer.filmed(value);
                }
            }
        }
        tile.samples += range.end - range.start;
        outcome
    }
}
