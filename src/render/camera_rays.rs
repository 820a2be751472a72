//! The samples of a pixel on their way from the film into the scene, with what their camera rays meet.
//!
//! Camera rays of one pixel go much the same way: those of sixteen samples are traced as one packet. Which of two
//! primitives at the same distance a ray meets may depend on its packet. So that a sample stays a pure function of seed,
//! pixel and index, packets are always of the same samples, whichever of them are asked for; and the first sixteen, which
//! passes take in smaller portions, go one by one.
//!
//! Measure: pixels; sample indices.
//! Range: any indices; those of one call lie in one block, see [`blocks`].
//! Source: docs/architecture.md, "The way of a sample". Tested in `tests/determinism.rs`.

use crate::accel::batch::{HitBatch, PacketWidth, Packets, RayBatch};
use crate::effects::{Effects, Switch};
use crate::film::filter::Filter;
use crate::integrator::RayCounts;
use crate::integrator::observer::{PathObserver, RayKind};
use crate::integrator::path::{CameraRay, PathIntegrator};
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::sampler::{Decision, Sampler};
use crate::scene::Scene;
use std::ops::Range;

/// Samples of a pixel whose camera rays are traced together: their indices begin at a multiple of this.
const BLOCK: u64 = 16;

/// Cuts a range of sample indices where blocks begin.
pub fn blocks(range: Range<u64>) -> impl Iterator<Item = Range<u64>> {
    let first = range.start / BLOCK;
    let last = range.end.div_ceil(BLOCK);
    let cut = (first..last).map(move |block| {
        let start = block * BLOCK;
        start.max(range.start)..(start + BLOCK).min(range.end)
    });
    cut.filter(|block| !block.is_empty())
}

/// A pixel that is looked through.
#[derive(Clone, Copy)]
pub struct Pixel<'a> {
    pub scene: &'a Scene,
    pub filter: &'a Filter,
    pub position: [u32; 2],
}

/// A sample whose camera ray is known.
#[derive(Debug, Clone)]
struct CameraSample<S> {
    /// Its random numbers.
    sampler: S,
    /// What its radiance counts in the pixel.
    weight: f32,
}

impl Pixel<'_> {
    /// A sample, its ray and its time.
    #[inline]
    fn sample<E: Effects, S: Sampler>(
        &self,
        mut sampler: S,
        index: u64,
    ) -> (CameraSample<S>, Ray, f32) {
        sampler.start(self.position, index);
        let (film, lens) = if E::Lens::ON {
            let [film_x, film_y, lens_x, lens_y] = sampler.draw(Decision::Camera);
            (Vec2::new(film_x, film_y), Vec2::new(lens_x, lens_y))
        } else {
            let film = sampler.draw(Decision::Camera);
            (Vec2::from_array(film), Vec2::ZERO)
        };
        let time = if E::Motion::ON {
            let [time] = sampler.draw(Decision::Time);
            time
        } else {
            0.0
        };
        let filtered = self.filter.sample(film);
        let [x, y] = self.position.map(|i| i as f32 + 0.5);
        let film = Vec2::new(x, y) + filtered.offset;
        let ray = self.scene.camera.ray::<E>(film, lens, time);
        let weight = filtered.weight;
        (CameraSample { sampler, weight }, ray, time)
    }
}

/// The camera rays of a block, and what they meet.
#[derive(Debug)]
pub struct CameraRays<S> {
    samples: Vec<CameraSample<S>>,
    rays: RayBatch,
    hits: HitBatch,
}

impl<S: Sampler> CameraRays<S> {
    /// Room for a block.
    pub fn new() -> Self {
        Self {
            samples: Vec::with_capacity(BLOCK as usize),
            rays: RayBatch::default(),
            hits: HitBatch::default(),
        }
    }

    /// Traces the camera rays of the samples of `range`, which lies in one block. Tells their indices, and where their
    /// [`value`](Self::value)s are to be had.
    pub fn trace<E: Effects, O: PathObserver>(
        &mut self,
        pixel: &Pixel<'_>,
        sampler: &S,
        range: Range<u64>,
        observer: &mut O,
    ) -> impl Iterator<Item = (u64, usize)> + use<E, O, S> {
        let (first, end, packets) = if range.start < BLOCK {
            (range.start, range.end, Packets::default())
        } else {
            let first = range.start / BLOCK * BLOCK;
            let packets = Packets {
                width: PacketWidth::Sixteen,
                coherent: true,
            };
            (first, first + BLOCK, packets)
        };
        self.samples.clear();
        self.rays.clear();
        for index in first..end {
            let (sample, ray, time) = pixel.sample::<E, S>(sampler.clone(), index);
            if range.contains(&index) {
                observer.traced(RayKind::Camera, &ray, time);
            }
            self.rays.push(&ray, time);
            self.samples.push(sample);
        }
        let accel = &pixel.scene.accel;
        accel.intersect_batch(&self.rays, packets, &mut self.hits);
        range.map(move |index| (index, (index - first) as usize))
    }

    /// A sample's value: radiance along the camera ray, times the filter's weight.
    #[inline]
    pub fn value<E: Effects, O: PathObserver>(
        &mut self,
        place: usize,
        scene: &Scene,
        integrator: PathIntegrator,
        rays: &mut RayCounts,
        observer: &mut O,
    ) -> Rgb {
        let (ray, time) = self.rays.get(place);
        let camera_ray = CameraRay { ray, time };
        let found = self.hits.get(place);
        let CameraSample { sampler, weight } = &mut self.samples[place];
        let radiance =
            integrator.radiance::<E, _, _>(scene, sampler, &camera_ray, found, rays, observer);
        *weight * radiance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_cut_a_range_at_multiples_and_nowhere_else() {
        let cut = |range| blocks(range).collect::<Vec<_>>();
        assert_eq!(cut(3..3), []);
        assert_eq!(cut(3..5), [3..5]);
        assert_eq!(cut(0..16), [0..16]);
        assert_eq!(cut(15..34), [15..16, 16..32, 32..34]);
    }
}
