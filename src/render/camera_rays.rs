//! The samples of a pixel on their way from the film into the scene, with what their camera rays meet.
//!
//! Camera rays of one pixel go much the same way: those of a block of samples are traced as one packet. Which of two
//! primitives at the same distance a ray meets may depend on its packet. So that a sample stays a pure function of seed,
//! pixel and index, a block is always traced whole, whichever of its samples are asked for. Blocks double in size up to
//! sixteen samples, as passes do, so that those seldom ask for a part of one.
//!
//! Measure: pixels; sample indices.
//! Range: any indices; those of one call lie in one block, see [`blocks`].
//! Source: docs/architecture.md, "The way of a sample". Tested in `tests/rendering/determinism.rs`.

use crate::accel::Hit;
use crate::accel::batch::{HitBatch, PacketWidth, Packets, RayBatch};
use crate::effects::{Effects, Switch};
use crate::film::filter::Filter;
use crate::film::splats::SplatSink;
use crate::integrator::observer::{PathObserver, RayKind};
use crate::integrator::{CameraRay, Integrator, RayCounts};
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::planted::planted;
use crate::sampler::{Decision, Sampler};
use crate::scene::Scene;
use std::ops::Range;

/// Samples in a block at most.
pub const LARGEST_BLOCK: u64 = 16;

/// The block of a sample: 0, 1, 2..4, 4..8, 8..16, 16..32, 32..48 and so on.
fn block_of(index: u64) -> Range<u64> {
    let size = match index {
        0 => 1,
        _ => (1 << index.ilog2()).min(LARGEST_BLOCK),
    };
    let first = index / size * size;
    first..first + size
}

/// Cuts a range of sample indices where blocks begin.
pub fn blocks(range: Range<u64>) -> impl Iterator<Item = Range<u64>> {
    let mut rest = range;
    std::iter::from_fn(move || {
        let start = rest.start;
        if rest.is_empty() {
            return None;
        }
        rest.start = block_of(start).end.min(rest.end);
        Some(start..rest.start)
    })
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
        let middle = planted!("half-a-pixel", 0.0, 0.5);
        let [x, y] = self.position.map(|i| i as f32 + middle);
        let film = Vec2::new(x, y) + filtered.offset;
        let ray = self.scene.camera.ray::<E>(film, lens, time);
        let weight = planted!("filter-weight-dropped", 1.0, filtered.weight);
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
            samples: Vec::with_capacity(LARGEST_BLOCK as usize),
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
        let block = block_of(range.start);
        let width = match block.end - block.start {
            0..4 => PacketWidth::One,
            4..16 => PacketWidth::Eight,
            _ => PacketWidth::Sixteen,
        };
        let packets = Packets {
            width,
            coherent: true,
        };
        let first = block.start;
        self.samples.clear();
        self.rays.clear();
        for index in block {
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

    /// A sample's camera ray, what it meets, and where its random numbers come from.
    pub fn get(&mut self, place: usize) -> (CameraRay, Option<Hit>, &mut S) {
        let (ray, time) = self.rays.get(place);
        let found = self.hits.get(place);
        let sampler = &mut self.samples[place].sampler;
        (CameraRay { ray, time }, found, sampler)
    }

    /// What a sample's radiance counts in its pixel.
    pub fn weight(&self, place: usize) -> f32 {
        self.samples[place].weight
    }

    /// A sample's value: radiance along the camera ray, times the filter's weight.
    #[inline]
    pub fn value<E: Effects, I: Integrator, O: PathObserver, P: SplatSink>(
        &mut self,
        place: usize,
        scene: &Scene,
        integrator: I,
        rays: &mut RayCounts,
        observer: &mut O,
        splats: &mut P,
    ) -> Rgb {
        let weight = self.samples[place].weight;
        let (camera_ray, found, sampler) = self.get(place);
        let radiance = integrator.radiance_and_splats::<E, _, _, _>(
            scene,
            sampler,
            &camera_ray,
            found,
            rays,
            observer,
            splats,
        );
        weight * radiance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_cut_where_blocks_begin_and_nowhere_else() {
        let cut = |range| blocks(range).collect::<Vec<_>>();
        assert_eq!(cut(3..3), []);
        assert_eq!(cut(0..3), [0..1, 1..2, 2..3]);
        assert_eq!(cut(0..16), [0..1, 1..2, 2..4, 4..8, 8..16]);
        assert_eq!(cut(15..37), [15..16, 16..32, 32..37]);
        for index in 0..100 {
            let block = block_of(index);
            assert!(block.contains(&index));
            assert!(block.clone().all(|other| block_of(other) == block));
        }
    }
}
