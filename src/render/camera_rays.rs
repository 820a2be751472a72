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

use crate::accel::Hit;
use crate::accel::batch::{HitBatch, PacketWidth, Packets, RayBatch};
use crate::effects::{Effects, Switch};
use crate::film::filter::Filter;
use crate::integrator::RayCounts;
use crate::integrator::observer::{PathObserver, RayKind};
use crate::integrator::path::{CameraRay, PathIntegrator};
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
    (first..last).map(move |block| {
        let start = block * BLOCK;
        start.max(range.start)..(start + BLOCK).min(range.end)
    })
}

/// A pixel that is looked through.
#[derive(Clone, Copy)]
pub struct Pixel<'a> {
    pub scene: &'a Scene,
    pub filter: &'a Filter,
    pub position: [u32; 2],
}

/// A sample, seen from the camera.
#[derive(Debug, Clone)]
pub struct CameraSample<S> {
    pub index: u64,
    /// Its random numbers.
    pub sampler: S,
    pub ray: CameraRay,
    /// What its radiance counts in the pixel.
    pub weight: f32,
    /// What its ray meets.
    pub found: Option<Hit>,
}

impl Pixel<'_> {
    fn sample<E: Effects, S: Sampler>(&self, sampler: &S, index: u64) -> CameraSample<S> {
        let mut sampler = sampler.clone();
        sampler.start(self.position, index);
        let [film_x, film_y, lens_x, lens_y] = sampler.draw(Decision::Camera);
        let filtered = self.filter.sample(Vec2::new(film_x, film_y));
        let time = if E::Motion::ON {
            let [time] = sampler.draw(Decision::Time);
            time
        } else {
            0.0
        };
        let [x, y] = self.position.map(|i| i as f32 + 0.5);
        let film = Vec2::new(x, y) + filtered.offset;
        let lens = Vec2::new(lens_x, lens_y);
        let ray = self.scene.camera.ray::<E>(film, lens, time);
        CameraSample {
            index,
            sampler,
            ray: CameraRay { ray, time },
            weight: filtered.weight,
            found: None,
        }
    }
}

/// Room for the samples of one block.
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

    /// Traces the camera rays of the samples of `range`, which lies in one block.
    pub fn trace<E: Effects, O: PathObserver>(
        &mut self,
        pixel: &Pixel<'_>,
        sampler: &S,
        range: Range<u64>,
        observer: &mut O,
    ) -> &mut [CameraSample<S>] {
        let (traced, packets) = if range.start < BLOCK {
            (range.clone(), Packets::default())
        } else {
            let first = range.start / BLOCK * BLOCK;
            let packets = Packets {
                width: PacketWidth::Sixteen,
                coherent: true,
            };
            (first..first + BLOCK, packets)
        };
        self.samples.clear();
        self.rays.clear();
        for index in traced.clone() {
            let sample = pixel.sample::<E, S>(sampler, index);
            if range.contains(&index) {
                observer.traced(RayKind::Camera, &sample.ray.ray, sample.ray.time);
            }
            self.rays.push(&sample.ray.ray, sample.ray.time);
            self.samples.push(sample);
        }
        let accel = &pixel.scene.accel;
        accel.intersect_batch(&self.rays, packets, &mut self.hits);
        for (index, sample) in self.samples.iter_mut().enumerate() {
            sample.found = self.hits.get(index);
        }
        let skipped = (range.start - traced.start) as usize;
        let asked = (range.end - range.start) as usize;
        &mut self.samples[skipped..skipped + asked]
    }
}

impl<S> CameraSample<S> {
    /// The sample's value: radiance along the camera ray, times the filter's weight.
    #[inline]
    pub fn value<E: Effects, O: PathObserver>(
        &mut self,
        scene: &Scene,
        integrator: PathIntegrator,
        rays: &mut RayCounts,
        observer: &mut O,
    ) -> Rgb
    where
        S: Sampler,
    {
        let (ray, found) = (&self.ray, self.found);
        let sampler = &mut self.sampler;
        let radiance = integrator.radiance::<E, _, _>(scene, sampler, ray, found, rays, observer);
        self.weight * radiance
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
