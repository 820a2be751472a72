//! Path tracing with next event estimation, multiple importance sampling and Russian roulette, or by any simpler
//! [`Technique`](super::technique::Technique) of the course.
//!
//! The radiance along a ray is the sum over paths x_0 x_1 ... x_k from the camera to a light,
//!
//!   L = sum_k  beta_k [ w_bsdf Le(x_k) + w_light f(x_k) |cos| Le(y) V(x_k, y) / p_light(y) ],
//!   beta_k = prod_{j<k} f(x_j) |cos| / p_bsdf / q_j,
//!
//! where y is a sampled point on a light, the two strategies that find a light are weighted by the power heuristic of their
//! densities (a simpler [`Technique`](super::technique::Technique): by 0 or 1), and q_j is the survival probability of Russian
//! roulette. Where a technique ends the path with its surface's emission with probability p, the emission is divided by p and
//! all later contributions by 1 - p. Light sampling applies neither to delta lobes nor to the constant environment: there
//! w_bsdf = 1. Scattered rays cannot hit delta lights: there w_light = 1.
//!
//! The integrator is compiled for the effects `E`; kernels for other effects give the same numbers.
//!
//! Measure: radiance; densities per steradian.
//! Range: any scene that needs no effect beyond `E`; without a bounce limit a path ends by absorption, by leaving the
//! scene, or by roulette.
//! Source: Kajiya 1986; Veach 1997, sections 8.3, 9.2 and 10.4.1. Tested in `lab/src/battery/`,
//! `tests/scattering/furnace.rs`, `tests/rendering/effects.rs` and `tests/rendering/integrators.rs`.

pub mod block;
pub mod blocks;
mod direct_light;
mod emission;
mod find_surface;
mod light_path_weights;
mod light_walk;
mod reuse;
mod scattering;
mod shading;
mod simple_techniques;

use super::indirect::{Indirect, Uncached};
use super::light_paths::{LightPathSplats, LightPaths};
use super::observer::{PathObserver, RayKind};
use super::reuse::PathReuse;
use super::technique::{DirectionRule, TechniqueSource, Weighted};
use super::{CameraRay, Integrator, RayCounts, Roulette, SampleLanes};
use crate::accel::Hit;
use crate::effects::{Effects, Switch};
use crate::light::types::{EnvironmentSampling, LightChoice, LightSampling};
use crate::math::lanes::{ActiveLanes, LANES, Lanes, load};
use crate::math::rgb::Rgb;
use crate::planted::planted;
use crate::sampler::{Decision, LaneStates, Sampler};
use crate::scene::Scene;
use crate::scene::interaction::Interaction;
use block::PathBlock;
use blocks::PathBlocks;
use light_walk::LightPathStart;
use reuse::ReuseScratch;
use shading::StageScratch;
use std::slice;

/// The number of paths in a wavefront: enough for the cost of a partly filled last block to be negligible; few enough, at
/// some 200 bytes each, to stay in a processor's second-level cache.
pub const WAVEFRONT_SIZE: usize = 512;

/// The path integrator and its settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PathIntegrator<C = Weighted, K = Uncached> {
    /// The technique by which light is found.
    pub technique: C,
    /// The source of indirect light.
    pub indirect: K,
    /// The largest number of scattering events; `None` for no limit.
    pub max_bounces: Option<u32>,
    /// The rule of Russian roulette.
    pub roulette: Roulette,
    /// The selection of lights.
    pub light_choice: LightChoice,
    /// The density of directions to an environment map; compensated only where every light that light sampling finds is
    /// found by BSDF sampling, too.
    pub environment_sampling: EnvironmentSampling,
    /// The light paths that find the same light.
    pub light_paths: LightPaths,
    /// The number of pixels that share their paths.
    pub reuse: PathReuse,
}

/// The scratch of the path integrator: the states of a wavefront of paths, and of the stages of a bounce.
#[derive(Debug)]
pub struct PathScratch<E: Effects> {
    /// The paths.
    pub paths: PathBlocks<E>,
    stage: StageScratch<E>,
    reuse: ReuseScratch<E>,
    /// The first rays of light paths, by the indices of their samples.
    starts: Vec<Option<LightPathStart>>,
}

impl<E: Effects> Default for PathScratch<E> {
    fn default() -> Self {
        Self {
            paths: PathBlocks::default(),
            stage: StageScratch::default(),
            reuse: ReuseScratch::default(),
            starts: Vec::new(),
        }
    }
}

impl<C: TechniqueSource, K: Indirect> Integrator for PathIntegrator<C, K> {
    const IS_WAVEFRONT: bool = true;

    type Scratch<'a, E: Effects> = PathScratch<E>;

    fn radiance<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        scene: &Scene,
        sampler: &mut S,
        camera_ray: &CameraRay,
        hit: Option<Hit>,
        rays: &mut RayCounts,
        scratch: &mut PathScratch<E>,
        observer: &mut O,
    ) -> Rgb {
        let mut samples = SampleLanes::default();
        samples.add(0, camera_ray, hit);
        let (samplers, samples) = (slice::from_mut(sampler), slice::from_mut(&mut samples));
        self.radiances::<E, S, O>(scene, samplers, samples, scratch, observer);
        let estimate = samples[0].estimate(0);
        *rays += estimate.rays;
        estimate.radiance
    }

    fn radiances<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        scene: &Scene,
        samplers: &mut [S],
        samples: &mut [SampleLanes],
        scratch: &mut PathScratch<E>,
        observer: &mut O,
    ) {
        scratch.paths.begin(samples);
        if self.reuses::<E>() {
            scratch.reuse.begin(samples.len());
        }
        let wavefront = PathWavefront {
            scene,
            samples: &mut *samples,
            samplers,
            observer,
            bounce: 0,
        };
        self.trace_wavefront(wavefront, scratch);
        if self.reuses::<E>() {
            scratch.reuse.distribute(samples);
        }
    }

    fn reuse(&self) -> PathReuse {
        self.reuse
    }

    fn light_paths(&self) -> LightPaths {
        self.light_paths
    }

    fn trace_light_paths<E: Effects, S: Sampler>(
        &self,
        scene: &Scene,
        samplers: &mut [S],
        samples: &mut [SampleLanes],
        scratch: &mut PathScratch<E>,
        splats: &mut LightPathSplats<'_>,
    ) {
        self.walk_from_lights(scene, samplers, samples, scratch, splats);
    }
}

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Traces all paths of a wavefront until they end, given the closest hits on their first rays, and stores the radiance
    /// in their samples.
    ///
    /// All paths are taken to their next vertex, block by block; then the last paths replace those that have ended, so that
    /// all blocks but one are full, and the rays are traced.
    pub fn trace_wavefront<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        mut wavefront: PathWavefront<'_, S, O>,
        scratch: &mut PathScratch<E>,
    ) {
        let PathScratch {
            paths,
            stage,
            reuse,
            ..
        } = scratch;
        stage.direct_light.lights.clear();
        while !paths.is_empty() {
            for block in paths.blocks_mut() {
                self.advance_block(&mut wavefront, block, stage, reuse);
            }
            paths.compact();
            for block in paths.blocks_mut() {
                wavefront.trace_extension_rays(block);
            }
            wavefront.bounce += 1;
        }
    }

    /// Processes one bounce of a block: adds emission and direct light, and sets the extension rays of the paths that
    /// continue.
    fn advance_block<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        wavefront: &mut PathWavefront<'_, S, O>,
        block: &mut PathBlock<E>,
        stage: &mut StageScratch<E>,
        reuse: &mut ReuseScratch<E>,
    ) {
        let arrived = block.active;
        self.add_emission(wavefront, block, stage);
        if block.active.any() {
            self.look_up_bsdfs(wavefront.scene, block, stage);
            if self.reuses::<E>() {
                let StageScratch { at, bsdfs, .. } = &*stage;
                match wavefront.bounce {
                    0 => reuse.store_first_hits(block, at, bsdfs),
                    1 => reuse.share(wavefront.scene, self.reuse, block, at, bsdfs),
                    _ => {}
                }
            }
            let mut cached = CachedLanes::NONE;
            if K::CACHES {
                cached = self.cached_indirect(wavefront, block, stage);
            }
            let states = LaneStates::gather(wavefront.samplers, &block.active, &block.sample_index);
            let nee_lanes = self.sample_lights(wavefront, block, stage, &states);
            let decision = Decision::Bsdf(wavefront.bounce);
            self.sample_bsdfs(wavefront, block, stage, &states, &nee_lanes, decision);
            let shares_rough = E::Glossy::ON && self.reuses::<E>() && wavefront.bounce == 1;
            if shares_rough {
                let StageScratch {
                    at,
                    bsdfs,
                    direct_light,
                    scattering,
                    ..
                } = &mut *stage;
                reuse.scatter_at_rough(at, bsdfs, &nee_lanes, direct_light, scattering);
            }
            self.compute_light_path_ratios(wavefront, block, stage, &nee_lanes);
            self.estimate_direct_light(wavefront, block, stage, &nee_lanes, &cached.lanes);
            if wavefront.observer.is_sequential() {
                wavefront.trace_shadow_rays(block, stage);
            }
            for lane in cached.lanes.each() {
                wavefront
                    .observer
                    .cached_indirect(cached.contributions[lane]);
                block.active.set(lane, false);
            }
            let decision = planted!(
                "roulette-takes-a-spent-number",
                Decision::Bsdf(wavefront.bounce),
                Decision::Roulette(wavefront.bounce)
            );
            self.scatter(wavefront, block, stage, &states, decision);
            self.update_camera_path_ratios(wavefront.bounce, block, stage);
            if !wavefront.observer.is_sequential() {
                wavefront.trace_shadow_rays(block, stage);
            }
            if shares_rough {
                reuse.keep_light_at_rough(block);
            }
            for lane in cached.lanes.each() {
                block.add(lane, cached.contributions[lane]);
            }
        }
        for lane in arrived.without(&block.active).each() {
            block.finish_path(lane, wavefront.samples);
        }
    }

    /// Whether the kernel reuses paths and the settings ask for it.
    #[inline(always)]
    fn reuses<E: Effects>(&self) -> bool {
        E::Reuse::ON && self.reuse.is_on()
    }

    /// The rules of light sampling.
    #[inline(always)]
    fn light_sampling(&self) -> LightSampling {
        LightSampling {
            choice: self.light_choice,
            points: self.technique.technique().points,
            environment: self.environment_sampling,
        }
    }

    /// Looks up the BSDFs at the surfaces of a block.
    #[inline(always)]
    fn look_up_bsdfs<E: Effects>(
        &self,
        scene: &Scene,
        block: &PathBlock<E>,
        stage: &mut StageScratch<E>,
    ) {
        let by_bsdf = self.technique.technique().directions == DirectionRule::Bsdf;
        let StageScratch { at, bsdfs, .. } = stage;
        bsdfs.look_up(scene, &block.active, at, K::CACHES || !by_bsdf);
    }

    /// Looks up the cached indirect light at the surfaces of a block.
    fn cached_indirect<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        wavefront: &PathWavefront<'_, S, O>,
        block: &PathBlock<E>,
        stage: &StageScratch<E>,
    ) -> CachedLanes {
        let mut cached = CachedLanes::NONE;
        let is_limited = self.max_bounces.is_some();
        for lane in block.active.each() {
            let at: Interaction<E> = stage.at.get(lane);
            let bsdf = wavefront.scene.bsdf(&at);
            let reflected = self
                .indirect
                .reflected(&at, &bsdf, wavefront.bounce, is_limited);
            if let Some(reflected) = reflected {
                cached.lanes.set(lane, true);
                cached.contributions[lane] = load::<Rgb>(&block.beta, lane) * reflected;
            }
        }
        cached
    }
}

/// The indirect light of the lanes where it is cached: their paths end.
struct CachedLanes {
    lanes: ActiveLanes<LANES>,
    contributions: Lanes<Rgb>,
}

impl CachedLanes {
    const NONE: Self = Self {
        lanes: ActiveLanes::NONE,
        contributions: [Rgb::BLACK; LANES],
    };
}

/// The context of a wavefront of paths, all at the same bounce.
pub struct PathWavefront<'a, S, O: ?Sized> {
    /// The scene.
    pub scene: &'a Scene,
    /// The samples of the paths.
    pub samples: &'a mut [SampleLanes],
    /// The samplers of all lanes of the samples, in order.
    pub samplers: &'a mut [S],
    /// The observer of the paths.
    pub observer: &'a mut O,
    /// The number of scattering events before.
    pub bounce: u32,
}

impl<S, O: PathObserver + ?Sized> PathWavefront<'_, S, O> {
    /// Traces the extension rays of a block. Observers see them in the order in which their hits are processed.
    fn trace_extension_rays<E: Effects>(&mut self, block: &mut PathBlock<E>) {
        let observed = if self.observer.is_observing() {
            block.active
        } else {
            ActiveLanes::NONE
        };
        for lane in observed.each() {
            let is_delta = block.prev_vertex(lane).is_none();
            let kind = RayKind::extension(self.bounce, is_delta);
            let (ray, time) = block.packet.ray(lane);
            self.observer.traced(kind, &ray, time);
        }
        let accel = &self.scene.accel;
        accel.intersect_lanes(&block.active, &mut block.packet, &block.excluded, false);
    }

    /// Traces the shadow rays of a block, and adds the contributions of those that are not occluded.
    fn trace_shadow_rays<E: Effects>(
        &mut self,
        block: &mut PathBlock<E>,
        stage: &mut StageScratch<E>,
    ) {
        let lights = &mut stage.direct_light;
        if !lights.shadow_ray_lanes.any() {
            return;
        }
        let visible =
            self.scene
                .visibilities::<E>(&lights.shadow_ray_lanes, &mut lights.shadow, false);
        block.add_visible(&lights.shadow_ray_lanes, &lights.contribution, &visible);
        if self.observer.is_observing() {
            for lane in lights.shadow_ray_lanes.each() {
                let contribution = load(&lights.contribution, lane);
                let weight = lights.weight[lane];
                self.observer.light(contribution, weight, visible[lane]);
            }
        }
    }
}

/// The first two of several random numbers per lane.
#[inline(always)]
fn first_two<const N: usize>(numbers: &mut [Lanes<f32>; N]) -> &mut [Lanes<f32>; 2] {
    numbers
        .first_chunk_mut()
        .expect("every array of them has at least two")
}
