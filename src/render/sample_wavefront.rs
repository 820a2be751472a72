//! The samples of a wavefront, with their camera rays and the hits on them.
//!
//! The camera rays of a block of 4 x 4 pixels at one sample index are traced as one coherent packet. Which of two
//! primitives at the same distance a ray hits may depend on such a packet. So that a sample stays a pure function of
//! seed, pixel and index, a block is always traced whole, whichever of its pixels are requested.
//!
//! Measure: pixels; sample indices.
//! Range: any blocks and indices.
//! Source: docs/architecture.md, "The life of a sample". Tested in `tests/rendering/determinism.rs`.

use super::estimator::Estimator;
use super::light_wavefront::{LightWavefront, SampleOrigin};
use super::pixel_block::PixelBlock;
use crate::accel::lanes::{ExcludedLanes, NO_ID};
use crate::effects::{Effects, Switch};
use crate::film::Window;
use crate::film::filter::{Filter, FilterSampling};
use crate::film::splats::SplatList;
use crate::integrator::light_paths::LightPathShare;
use crate::integrator::observer::{PathObserver, RayKind};
use crate::integrator::path::WAVEFRONT_SIZE;
use crate::integrator::{Integrator, RayCounts, SampleLanes};
use crate::math::lanes::{ActiveLanes, LANES, Lanes};
use crate::math::rgb::Rgb;
use crate::planted::planted;
use crate::sampler::{AnySampler, Decision, LaneStates, Sampler};
use crate::scene::Scene;

/// The largest number of packets in a wavefront, which limits its memory where few lanes of each packet are requested.
const MAX_PACKETS: usize = 4 * WAVEFRONT_SIZE / LANES;

/// The bit of a column that no image has, for the random numbers of the second light path of a sample.
const SECOND_PATH: u32 = 1 << 31;

/// The source of camera rays.
#[derive(Clone, Copy)]
pub struct CameraRaySource<'a> {
    pub scene: &'a Scene,
    pub filter: &'a Filter,
    pub filter_sampling: FilterSampling,
    pub sampler: &'a AnySampler,
}

/// The samples of a packet.
#[derive(Debug, Clone, Copy)]
pub struct PacketIndex {
    /// Their pixels.
    pub block: PixelBlock,
    /// Their index in each pixel.
    pub sample: u64,
}

/// The samples of a wavefront, packet by packet.
#[derive(Debug, Default)]
pub struct SampleWavefront {
    indices: Vec<PacketIndex>,
    /// The samples; their active lanes are those to be estimated. Elements beyond those of `indices` are allocated for
    /// later packets.
    samples: Vec<SampleLanes>,
    /// The requested samples of each packet.
    requested: Vec<ActiveLanes<LANES>>,
    /// The samplers of all lanes of all packets.
    samplers: Vec<AnySampler>,
    /// The positions of the samples in their pixels, if they are uniformly distributed there.
    positions: Vec<[Lanes<f32>; 2]>,
    /// The filter weights of the samples in their pixels.
    weights: Vec<Lanes<f32>>,
    /// The number of requested samples.
    count: usize,
}

impl SampleWavefront {
    /// Removes all samples and keeps the memory.
    pub fn clear(&mut self) {
        self.indices.clear();
        self.requested.clear();
        self.samplers.clear();
        self.positions.clear();
        self.weights.clear();
        self.count = 0;
    }

    /// Whether there are enough samples for a wavefront.
    pub fn is_full(&self) -> bool {
        self.count >= WAVEFRONT_SIZE || self.indices.len() >= MAX_PACKETS
    }

    /// Adds a packet: the requested samples of a block's pixels. Its camera rays are not traced yet.
    pub fn add<E: Effects, O: PathObserver + ?Sized>(
        &mut self,
        source: &CameraRaySource<'_>,
        index: PacketIndex,
        requested: ActiveLanes<LANES>,
        observer: &mut O,
    ) {
        let packet = self.indices.len();
        if packet == self.samples.len() {
            self.samples.push(SampleLanes::default());
        }
        let pixels = index.block.pixels();
        self.samplers
            .extend(source.sampler.start_lanes(&pixels, index.sample));
        let numbers = CameraNumbers::draw::<E>(&mut self.samplers[packet * LANES..]);
        let ([x, y], weights) = match source.filter_sampling {
            FilterSampling::Importance => source.filter.sample_lanes(&numbers.film),
            FilterSampling::Splatting => {
                let offsets = numbers.film.map(|axis| axis.map(|position| position - 0.5));
                (offsets, [1.0; LANES])
            }
        };
        let middle = planted!("half-a-pixel", 0.0, 0.5);
        let on_film = |axis: usize, offsets: Lanes<f32>| {
            // Pixels above and to the left of the image have negative coordinates.
            let pixel = |lane: usize| pixels[axis][lane] as i32 as f32;
            std::array::from_fn(|lane| pixel(lane) + middle + offsets[lane])
        };
        let samples = &mut self.samples[packet];
        samples.active = requested;
        self.requested.push(requested);
        let rays = &mut samples.packet.rays;
        source.scene.camera.ray_lanes::<E>(
            &[on_film(0, x), on_film(1, y)],
            &numbers.lens,
            &numbers.time,
            &mut rays.origin,
            &mut rays.dir,
        );
        rays.t_min = [0.0; LANES];
        rays.t_max = [f32::INFINITY; LANES];
        rays.time = numbers.time;
        for lane in requested.each() {
            let (ray, time) = rays.get(lane);
            observer.traced(RayKind::Camera, &ray, time);
        }
        self.positions.push(numbers.film);
        self.weights
            .push(planted!("filter-weight-dropped", [1.0; LANES], weights));
        self.count += requested.count();
        self.indices.push(index);
    }

    /// Traces the camera rays of all packets.
    pub fn trace(&mut self, scene: &Scene) {
        let all = ActiveLanes::first(LANES);
        for samples in &mut self.samples[..self.indices.len()] {
            let packet = &mut samples.packet;
            packet.hits.geometry = [NO_ID; LANES];
            scene
                .accel
                .intersect_lanes(&all, packet, &ExcludedLanes::NONE, true);
        }
    }

    /// The indices of all packets, in the order in which they were added.
    pub fn indices(&self) -> &[PacketIndex] {
        &self.indices
    }

    /// The samples of a packet.
    pub fn samples(&self, packet: usize) -> &SampleLanes {
        &self.samples[packet]
    }

    /// The requested samples of a packet.
    pub fn requested(&self, packet: usize) -> ActiveLanes<LANES> {
        self.requested[packet]
    }

    /// The sampler of a sample.
    pub fn sampler(&mut self, packet: usize, lane: usize) -> &mut AnySampler {
        &mut self.samplers[packet * LANES + lane]
    }

    /// The positions of a packet's samples in their pixels, if they are uniformly distributed there.
    pub fn positions(&self, packet: usize) -> &[Lanes<f32>; 2] {
        &self.positions[packet]
    }

    /// The filter weight of a sample in its pixel.
    #[inline]
    pub fn weight(&self, packet: usize, lane: usize) -> f32 {
        self.weights[packet][lane]
    }

    /// Estimates all samples, whose camera rays are traced.
    pub fn estimate<E: Effects, I: Integrator, O: PathObserver + ?Sized>(
        &mut self,
        estimator: &mut Estimator<'_, E, I>,
        observer: &mut O,
    ) {
        let Estimator {
            scene,
            integrator,
            scratch,
        } = estimator;
        let samples = &mut self.samples[..self.indices.len()];
        if E::Reuse::ON && integrator.reuse().is_on() {
            for samples in &mut *samples {
                samples.active = ActiveLanes::first(LANES);
            }
        }
        integrator.radiances::<E, _, _>(scene, &mut self.samplers, samples, scratch, observer);
    }

    /// Estimates one sample, whose camera ray is traced.
    pub fn estimate_one<E: Effects, I: Integrator, O: PathObserver + ?Sized>(
        &mut self,
        packet: usize,
        lane: usize,
        estimator: &mut Estimator<'_, E, I>,
        observer: &mut O,
        splats: &mut SplatList<'_>,
    ) {
        let (camera_ray, hit) = self.samples[packet].camera_ray(lane);
        let sampler = &mut self.samplers[packet * LANES + lane];
        let mut rays = RayCounts::default();
        let radiance = estimator.integrator.radiance_and_splats::<E, _, _>(
            estimator.scene,
            sampler,
            &camera_ray,
            hit,
            &mut rays,
            &mut estimator.scratch,
            observer,
            splats,
        );
        let [closest, shadow] = [rays.closest, rays.shadow].map(|count| count as u32);
        self.samples[packet].set_estimate(lane, radiance, closest, shadow);
    }

    /// Adds the light paths of the estimated samples whose pixels are in a window.
    pub fn add_light_paths(
        &mut self,
        share: LightPathShare,
        window: Window,
        light_paths: &mut LightWavefront,
    ) {
        let paths_of_a_sample = if share == LightPathShare::Two { 2 } else { 1 };
        for number in 0..paths_of_a_sample {
            if number > 0 {
                self.start_second_paths();
            }
            let samplers = self.samplers.chunks_mut(LANES);
            let packets = self.indices.iter().zip(&self.samples).zip(samplers);
            for ((index, samples), samplers) in packets {
                let in_window = index.block.lanes_in(window);
                let lanes = samples.active.and(|lane| in_window.has(lane));
                for lane in share.lanes_with_path(samplers, &lanes).each() {
                    let origin = SampleOrigin {
                        pixel: index.block.pixel(lane),
                        sample: index.sample,
                    };
                    let time = samples.packet.rays.time[lane];
                    light_paths.add(origin, time, samplers[lane].clone());
                }
            }
        }
    }

    /// Starts the samplers of all samples for their second light paths.
    fn start_second_paths(&mut self) {
        let samplers = self.samplers.chunks_mut(LANES);
        for (index, samplers) in self.indices.iter().zip(samplers) {
            let [x, y] = index.block.pixels();
            let pixels = [x.map(|x| x | SECOND_PATH), y];
            samplers.clone_from_slice(&samplers[0].start_lanes(&pixels, index.sample));
        }
    }

    /// The value of a sample, once it is estimated: radiance along the camera ray, times the filter weight if its position is
    /// sampled from the filter.
    #[inline]
    pub fn value(&self, packet: usize, lane: usize) -> Rgb {
        self.weights[packet][lane] * self.samples[packet].estimate(lane).radiance
    }
}

/// The random numbers of the camera rays of a packet.
#[derive(Debug, Clone, Copy, Default)]
struct CameraNumbers {
    film: [Lanes<f32>; 2],
    lens: [Lanes<f32>; 2],
    time: Lanes<f32>,
}

impl CameraNumbers {
    /// Draws the numbers from a sampler for each lane.
    #[inline]
    fn draw<E: Effects>(samplers: &mut [AnySampler]) -> Self {
        let mut numbers = Self::default();
        let active = ActiveLanes::first(LANES);
        let places = std::array::from_fn(|place| place as u32);
        let states = &LaneStates::gather(samplers, &active, &places);
        if E::Lens::ON {
            let mut camera = [[0.0; LANES]; 4];
            AnySampler::draw_lanes(
                samplers,
                &active,
                &places,
                states,
                Decision::Camera,
                &mut camera,
            );
            let [x, y, u, v] = camera;
            (numbers.film, numbers.lens) = ([x, y], [u, v]);
        } else {
            let film = &mut numbers.film;
            AnySampler::draw_lanes(samplers, &active, &places, states, Decision::Camera, film);
        }
        if E::Motion::ON {
            let time = std::array::from_mut(&mut numbers.time);
            AnySampler::draw_lanes(samplers, &active, &places, states, Decision::Time, time);
        }
        numbers
    }
}
