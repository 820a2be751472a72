//! The samples of a pixel, with their camera rays and the hits on them.
//!
//! Camera rays of one pixel are coherent: those of a block of samples are traced as one coherent packet. Which of two
//! primitives at the same distance a ray hits may depend on such a packet. So that a sample stays a pure function of
//! seed, pixel and index, a block is always traced whole, whichever of its samples are requested. Blocks double in size
//! up to sixteen samples, as passes do, so that a pass rarely requests a part of one.
//!
//! Measure: pixels; sample indices.
//! Range: any indices; those of one call lie in one block, see [`blocks`].
//! Source: docs/architecture.md, "The way of a sample". Tested in `tests/rendering/determinism.rs`.

use crate::accel::lanes::{ExcludedLanes, RayHitLanes};
use crate::effects::{Effects, Switch};
use crate::film::filter::{Filter, FilterSample};
use crate::film::splats::SplatList;
use crate::integrator::observer::{PathObserver, RayKind};
use crate::integrator::path::{PathMemory, WAVEFRONT_SIZE};
use crate::integrator::{CameraRay, Integrator, Sample};
use crate::math::lanes::{ActiveLanes, LANES, Lanes};
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::planted::planted;
use crate::sampler::{AnySampler, Decision, Sampler};
use crate::scene::Scene;
use std::ops::Range;

/// The largest number of samples in a block: as many as a packet has lanes.
pub const LARGEST_BLOCK: u64 = LANES as u64;

/// The block of a sample: 0, 1, 2..4, 4..8, 8..16, 16..32, 32..48 and so on.
fn block_of(index: u64) -> Range<u64> {
    let size = match index {
        0 => 1,
        _ => (1 << index.ilog2()).min(LARGEST_BLOCK),
    };
    let first = index / size * size;
    first..first + size
}

/// Splits a range of sample indices where blocks begin.
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

/// A pixel whose camera rays are sampled.
#[derive(Clone, Copy)]
pub struct Pixel<'a> {
    pub scene: &'a Scene,
    pub filter: &'a Filter,
    pub position: [u32; 2],
}

/// The random numbers of the camera rays of a block of samples.
#[derive(Debug, Clone, Copy, Default)]
struct CameraNumbers {
    /// Two numbers for the film, two for the lens.
    camera: [Lanes<f32>; 4],
    time: Lanes<f32>,
}

impl CameraNumbers {
    /// Draws the numbers of each of at most [`LANES`] samplers.
    #[inline]
    fn draw<E: Effects>(samplers: &mut [AnySampler]) -> Self {
        let mut numbers = Self::default();
        let active = ActiveLanes::first(samplers.len());
        let places = std::array::from_fn(|place| place as u32);
        if E::Lens::ON {
            let camera = &mut numbers.camera;
            AnySampler::draw_lanes(samplers, &active, &places, Decision::Camera, camera);
        } else {
            let mut film = [[0.0; LANES]; 2];
            AnySampler::draw_lanes(samplers, &active, &places, Decision::Camera, &mut film);
            numbers.camera[..2].copy_from_slice(&film);
        }
        if E::Motion::ON {
            let time = std::array::from_mut(&mut numbers.time);
            AnySampler::draw_lanes(samplers, &active, &places, Decision::Time, time);
        }
        numbers
    }

    /// The numbers of a lane for the film.
    #[inline]
    fn film(&self, lane: usize) -> Vec2 {
        Vec2::new(self.camera[0][lane], self.camera[1][lane])
    }

    /// The numbers of a lane for the lens.
    #[inline]
    fn lens(&self, lane: usize) -> Vec2 {
        Vec2::new(self.camera[2][lane], self.camera[3][lane])
    }
}

impl Pixel<'_> {
    /// The camera ray of a lane, through the offset that the filter has sampled.
    #[inline]
    fn ray<E: Effects>(
        &self,
        numbers: &CameraNumbers,
        lane: usize,
        filtered: FilterSample,
    ) -> CameraRay {
        let middle = planted!("half-a-pixel", 0.0, 0.5);
        let [x, y] = self.position.map(|i| i as f32 + middle);
        let film = Vec2::new(x, y) + filtered.offset;
        let time = numbers.time[lane];
        let ray = self.scene.camera.ray::<E>(film, numbers.lens(lane), time);
        CameraRay { ray, time }
    }
}

/// Samples, with their camera rays and the hits on them. Their places are in the order in which they were added.
#[derive(Debug)]
pub struct CameraRays<E: Effects> {
    samplers: Vec<AnySampler>,
    samples: Vec<Sample>,
    /// The filter weight of each sample in its pixel.
    weights: Vec<f32>,
    /// The blocks whose camera rays have not been traced yet.
    blocks: Vec<Block>,
    /// The rays of these blocks, and memory for later ones.
    packets: Vec<RayHitLanes<LANES>>,
    memory: PathMemory<E>,
}

/// The samples of a block.
#[derive(Debug)]
struct Block {
    /// The lanes of all samples of the block.
    active: ActiveLanes<LANES>,
    /// The place of the first requested sample.
    place: usize,
    /// The lanes of the requested samples.
    lanes: Range<usize>,
}

impl<E: Effects> CameraRays<E> {
    /// Creates an empty list of samples.
    pub fn new() -> Self {
        Self {
            samplers: Vec::with_capacity(WAVEFRONT_SIZE + LANES),
            samples: Vec::with_capacity(WAVEFRONT_SIZE + LANES),
            weights: Vec::with_capacity(WAVEFRONT_SIZE + LANES),
            blocks: Vec::new(),
            packets: Vec::new(),
            memory: PathMemory::default(),
        }
    }

    /// Removes all samples and keeps the memory.
    pub fn clear(&mut self) {
        self.samplers.clear();
        self.samples.clear();
        self.weights.clear();
    }

    /// Adds the samples of `range`, which lies in one block, and returns their places. Their camera rays are not traced
    /// yet.
    pub fn add<O: PathObserver + ?Sized>(
        &mut self,
        pixel: &Pixel<'_>,
        sampler: &AnySampler,
        range: Range<u64>,
        observer: &mut O,
    ) -> Range<usize> {
        let block = block_of(range.start);
        let lane = |index: u64| (index - block.start) as usize;
        let (count, place) = (lane(block.end), self.samples.len());
        let sample_range = lane(range.start)..lane(range.end);
        sampler.start_each(pixel.position, block, &mut self.samplers);
        let numbers = CameraNumbers::draw::<E>(&mut self.samplers[place..]);
        let film: [Vec2; LANES] = std::array::from_fn(|lane| numbers.film(lane));
        if self.packets.len() == self.blocks.len() {
            self.packets.push(RayHitLanes::default());
        }
        let rays = &mut self.packets[self.blocks.len()].rays;
        let mut lane = 0..count;
        pixel.filter.sample_each(&film[..count], |filtered| {
            let Some(lane) = lane.next() else {
                return;
            };
            let camera_ray = pixel.ray::<E>(&numbers, lane, filtered);
            rays.set(lane, &camera_ray.ray);
            rays.time[lane] = camera_ray.time;
            self.samples.push(Sample::new(camera_ray));
            self.weights
                .push(planted!("filter-weight-dropped", 1.0, filtered.weight));
        });
        keep(&mut self.samplers, place, &sample_range);
        keep(&mut self.samples, place, &sample_range);
        keep(&mut self.weights, place, &sample_range);
        for sample in &self.samples[place..] {
            let CameraRay { ray, time } = &sample.camera_ray;
            observer.traced(RayKind::Camera, ray, *time);
        }
        self.blocks.push(Block {
            active: ActiveLanes::first(count),
            place,
            lanes: sample_range,
        });
        place..self.samples.len()
    }

    /// Traces the camera rays of all samples that were added since the last call.
    pub fn trace(&mut self, scene: &Scene) {
        let accel = &scene.accel;
        for (block, packet) in self.blocks.drain(..).zip(&mut self.packets) {
            accel.intersect_lanes(&block.active, packet, &ExcludedLanes::NONE, true);
            let samples = &mut self.samples[block.place..];
            for (sample, lane) in samples.iter_mut().zip(block.lanes) {
                sample.found = packet.hit(lane);
            }
        }
    }

    /// The sampler and the sample at a place.
    pub fn sample(&mut self, place: usize) -> (&mut AnySampler, &mut Sample) {
        (&mut self.samplers[place], &mut self.samples[place])
    }

    /// The filter weight of a sample in its pixel.
    pub fn weight(&self, place: usize) -> f32 {
        self.weights[place]
    }

    /// The value of a sample, once it is estimated: radiance along the camera ray, times the filter weight.
    #[inline]
    pub fn value(&self, place: usize) -> Rgb {
        self.weights[place] * self.samples[place].radiance
    }

    /// Estimates samples whose camera rays are traced: all of `places`, if the integrator gains by estimating a
    /// wavefront and the observer does not need paths in sequence, otherwise the first one. Returns the place after
    /// them.
    #[inline]
    pub fn estimate<I: Integrator, O: PathObserver + ?Sized>(
        &mut self,
        places: Range<usize>,
        scene: &Scene,
        integrator: I,
        observer: &mut O,
        splats: &mut SplatList<'_>,
    ) -> usize {
        if I::SIDE_BY_SIDE && !observer.is_sequential() {
            let samplers = &mut self.samplers[places.clone()];
            let (samples, memory) = (&mut self.samples[places.clone()], &mut self.memory);
            integrator.radiances::<E, _, O>(scene, samplers, samples, memory, observer);
            return places.end;
        }
        let sampler = &mut self.samplers[places.start];
        let Sample {
            camera_ray,
            found,
            radiance,
            rays,
        } = &mut self.samples[places.start];
        *radiance = integrator.radiance_and_splats::<E, _, _>(
            scene, sampler, camera_ray, *found, rays, observer, splats,
        );
        places.start + 1
    }
}

/// Keeps of the items from `start` on only those of a range, counted from there.
fn keep<T>(items: &mut Vec<T>, start: usize, range: &Range<usize>) {
    items.truncate(start + range.end);
    items.drain(start..start + range.start);
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
