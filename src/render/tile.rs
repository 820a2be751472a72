//! One tile's samples of one pass.
//!
//! Measure: samples; radiance.
//! Range: samples that are not finite are counted and located, and left out of the sums.
//! Source: none needed. Tested in `tests/determinism.rs`.

use super::dispatch::Dispatched;
use crate::effects::{Effects, Switch};
use crate::film::Tile;
use crate::film::filter::Filter;
use crate::integrator::RayCounts;
use crate::integrator::observer::PathObserver;
use crate::integrator::path::PathIntegrator;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::sampler::{Decision, Sampler};
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
    pub integrator: PathIntegrator,
    pub tile: &'a mut Tile,
    pub range: Range<u64>,
    pub observer: &'a mut O,
}

impl<O: PathObserver> Dispatched for TileJob<'_, O> {
    type Output = Outcome;

    fn run<E: Effects, S: Sampler>(self, mut sampler: S) -> Outcome {
        let Self {
            scene,
            filter,
            integrator,
            tile,
            range,
            observer,
        } = self;
        let mut outcome = Outcome::default();
        for ([x, y], sums) in tile.window.pixels().zip(&mut tile.pixels) {
            for sample in range.clone() {
                sampler.start([x, y], sample);
                let camera_sample = CameraSample {
                    scene,
                    filter,
                    pixel: [x, y],
                };
                let radiance = camera_sample.radiance::<E, _, _>(
                    integrator,
                    &mut sampler,
                    &mut outcome.rays,
                    observer,
                );
                if radiance.is_finite() {
                    sums.add(radiance);
                } else {
                    let first = Some(NonFiniteSample { y, x, sample });
                    outcome.rejected.merge(Rejected { count: 1, first });
                }
                observer.filmed(radiance);
            }
        }
        tile.samples += range.end - range.start;
        outcome
    }
}

/// A sample on its way from the film into the scene.
pub struct CameraSample<'a> {
    pub scene: &'a Scene,
    pub filter: &'a Filter,
    pub pixel: [u32; 2],
}

impl CameraSample<'_> {
    /// The sample's value: radiance along the camera ray, times the filter's weight.
    #[inline]
    pub fn radiance<E: Effects, S: Sampler, O: PathObserver>(
        &self,
        integrator: PathIntegrator,
        sampler: &mut S,
        rays: &mut RayCounts,
        observer: &mut O,
    ) -> Rgb {
        let [film_x, film_y, lens_x, lens_y] = sampler.draw(Decision::Camera);
        let filtered = self.filter.sample(Vec2::new(film_x, film_y));
        let time = if E::Motion::ON {
            let [time] = sampler.draw(Decision::Time);
            time
        } else {
            0.0
        };
        let [x, y] = self.pixel.map(|i| i as f32 + 0.5);
        let film = Vec2::new(x, y) + filtered.offset;
        let lens = Vec2::new(lens_x, lens_y);
        let ray = self.scene.camera.ray::<E>(film, lens, time);
        let radiance =
            integrator.radiance::<E, _, _>(self.scene, sampler, ray, time, rays, observer);
        filtered.weight * radiance
    }
}
