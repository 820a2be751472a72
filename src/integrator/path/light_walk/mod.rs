//! The walk of light paths: sixteen at a time from surface to surface, each of which is connected to the lens.
//!
//! The stages are those of camera paths. Throughputs are of power, and relative to the flux of the first ray; the ratio of
//! a block is that of scattering and the light path, for a light that can be hit (`light_paths/weights.rs`).
//!
//! Measure: radiance times the number of camera samples, by which the splat buffer divides.
//! Range: any scene; without a bounce limit a path ends by absorption, by leaving the scene, or by roulette.
//! Source: Veach 1997, section 10.3.4. Tested in `tests/rendering/light_paths.rs`.

mod connect;
mod power;
mod towards_camera;

use super::super::SampleLanes;
use super::super::indirect::Indirect;
use super::super::light_paths::LightPathSplats;
use super::super::light_paths::source::LightPathFirstRay;
use super::super::observer::NullPathObserver;
use super::super::technique::TechniqueSource;
use super::block::PathBlock;
use super::shading::StageScratch;
use super::{PathIntegrator, PathScratch, PathWavefront};
use crate::effects::{Effects, Switch};
use crate::light::types::Receiver;
use crate::math::lanes::{ActiveLanes, LANES, Lanes};
use crate::sampler::{Decision, LaneStates, Sampler};
use crate::scene::interaction::Interaction;
use crate::scene::{Scene, ShapeTraits};

/// The first ray of a light path, and the light sampling densities for its MIS weights.
#[derive(Debug, Clone, Copy)]
pub struct LightPathStart {
    first_ray: LightPathFirstRay,
    /// The density of light sampling at the first surface.
    nee: f32,
    /// The density of light sampling over that of scattering, beyond the first surface.
    nee_over_scattering: f32,
}

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Traces a light path for each active lane of the samples, at its time; the counts of their rays are stored in the
    /// samples. There is a sampler for each lane, in order.
    pub(super) fn walk_from_lights<E: Effects, S: Sampler>(
        &self,
        scene: &Scene,
        samplers: &mut [S],
        samples: &mut [SampleLanes],
        scratch: &mut PathScratch<E>,
        splats: &mut LightPathSplats<'_>,
    ) {
        let PathScratch {
            paths,
            stage,
            starts,
            ..
        } = scratch;
        starts.clear();
        for (samplers, samples) in samplers.chunks_mut(LANES).zip(&mut *samples) {
            starts.extend(self.emit::<E, S>(scene, samplers, samples));
        }
        paths.begin(samples);
        let mut wavefront = PathWavefront {
            scene,
            samples,
            samplers,
            observer: &mut NullPathObserver,
            bounce: 0,
        };
        let max_bounces = self.max_bounces.unwrap_or(u32::MAX);
        while !paths.is_empty() && wavefront.bounce < max_bounces {
            for block in paths.blocks_mut() {
                wavefront.trace_extension_rays(block);
                self.advance_from_lights(&mut wavefront, block, stage, starts, splats);
            }
            paths.compact();
            wavefront.bounce += 1;
        }
    }

    /// Samples the first rays of light paths, and deactivates the lanes that have none. Returns the start of each lane.
    fn emit<E: Effects, S: Sampler>(
        &self,
        scene: &Scene,
        samplers: &mut [S],
        samples: &mut SampleLanes,
    ) -> Lanes<Option<LightPathStart>> {
        let mut starts = [None; LANES];
        let (active, lane_indices) = (samples.active, std::array::from_fn(|lane| lane as u32));
        if !active.any() {
            return starts;
        }
        let states = LaneStates::gather(samplers, &active, &lane_indices);
        let (mut source, mut direction) = ([[0.0; LANES]; 4], [[0.0; LANES]; 3]);
        let decision = Decision::Source;
        S::draw_lanes(
            samplers,
            &active,
            &lane_indices,
            &states,
            decision,
            &mut source,
        );
        let decision = Decision::SourceDirection;
        S::draw_lanes(
            samplers,
            &active,
            &lane_indices,
            &states,
            decision,
            &mut direction,
        );
        for lane in active.each() {
            let time = samples.packet.rays.time[lane];
            let numbers = (source.map(|u| u[lane]), direction.map(|u| u[lane]));
            let first_ray = LightPathFirstRay::sample::<E>(scene, numbers, time);
            samples.active.set(lane, first_ray.is_some());
            if let Some(first_ray) = first_ray {
                samples.packet.rays.set(lane, &first_ray.sample.ray());
                starts[lane] = Some(LightPathStart {
                    first_ray,
                    nee: 0.0,
                    nee_over_scattering: 0.0,
                });
            }
        }
        starts
    }

    /// Takes the light paths of a block, whose rays have been traced, to their next vertices: connects these to the lens, and
    /// sets the extension rays of the paths that continue.
    fn advance_from_lights<E: Effects, S: Sampler>(
        &self,
        wavefront: &mut PathWavefront<'_, S, NullPathObserver>,
        block: &mut PathBlock<E>,
        stage: &mut StageScratch<E>,
        starts: &mut [Option<LightPathStart>],
        splats: &mut LightPathSplats<'_>,
    ) {
        let (scene, bounce) = (wavefront.scene, wavefront.bounce);
        let arrived = block.active;
        if bounce == 0 {
            for lane in arrived.each() {
                block.count_rays(lane, true, false);
            }
        }
        compute_interactions(wavefront, block, stage);
        if block.active.any() {
            self.look_up_bsdfs(scene, block, stage);
            if bounce == 0 {
                self.begin_from_lights(scene, block, stage, starts);
            }
            self.connect(wavefront, block, stage, starts, splats);
            if self.max_bounces == Some(bounce + 1) {
                block.active = ActiveLanes::NONE;
            } else {
                let states =
                    LaneStates::gather(wavefront.samplers, &block.active, &block.sample_index);
                let decision = Decision::LightPathBsdf(bounce);
                let nee_lanes = &ActiveLanes::NONE;
                self.sample_bsdfs(wavefront, block, stage, &states, nee_lanes, decision);
                self.convert_to_power(scene, block, stage, bounce, starts);
                let decision = Decision::LightPathRoulette(bounce);
                self.scatter(wavefront, block, stage, &states, decision);
                self.multiply_by_vertex_ratios(block, stage);
            }
        }
        for lane in arrived.without(&block.active).each() {
            block.finish_path(lane, wavefront.samples);
        }
    }

    /// Sets the ratios of the paths of a block at the first surface, and the densities of light sampling there.
    fn begin_from_lights<E: Effects>(
        &self,
        scene: &Scene,
        block: &mut PathBlock<E>,
        stage: &StageScratch<E>,
        starts: &mut [Option<LightPathStart>],
    ) {
        for lane in block.active.each() {
            let Some(start) = &mut starts[block.sample_index[lane] as usize] else {
                continue;
            };
            let at: Interaction<E> = stage.at.get(lane);
            block.set_light_path_ratio(lane, 1.0 / start.first_ray.density(scene, at.p));
            if !stage.bsdfs.delta.has(lane) {
                let transmits = stage.at.traits[lane] & ShapeTraits::TRANSMISSIVE != 0;
                let receiver = at.receiver(transmits);
                start.nee = self.density_of_nee(scene, start, Some(&receiver), block, lane);
            }
        }
    }

    /// The density of light sampling at a receiver for the source of a light path; without a receiver, that at the
    /// first surface as seen from the light.
    fn density_of_nee<E: Effects>(
        &self,
        scene: &Scene,
        start: &LightPathStart,
        receiver: Option<&Receiver>,
        block: &PathBlock<E>,
        lane: usize,
    ) -> f32 {
        let Some(receiver) = receiver else {
            return start.nee;
        };
        let LightPathFirstRay { light, sample, .. } = &start.first_ray;
        let (rules, time) = (self.light_sampling(), block.packet.rays.time[lane]);
        let lights = &scene.lights;
        lights.pdf_nee::<E>(*light, sample, rules, receiver, time)
    }
}

/// Computes the surface interactions of a block of light paths, and deactivates the lanes that have none, or that absorb all
/// light.
fn compute_interactions<E: Effects, S: Sampler>(
    wavefront: &mut PathWavefront<'_, S, NullPathObserver>,
    block: &mut PathBlock<E>,
    stage: &mut StageScratch<E>,
) {
    let (samplers, bounce) = (&mut *wavefront.samplers, wavefront.bounce);
    let sample_index = &block.sample_index;
    let alpha = |lane: usize| {
        let sampler = &mut samplers[sample_index[lane] as usize];
        let [u] = sampler.draw(Decision::LightPathAlpha(bounce));
        (u, f32::INFINITY)
    };
    let StageScratch { surfaces, at, .. } = stage;
    let hit_lanes = wavefront.scene.surface_interactions::<E>(
        &block.active,
        &block.packet,
        &block.excluded,
        alpha,
        surfaces,
        at,
    );
    block.active = hit_lanes.and(|lane| {
        let traits = at.traits[lane];
        let is_opaque = traits & ShapeTraits::TRANSMISSIVE == 0;
        let is_one_sided = E::OneSided::ON & (traits & ShapeTraits::ONE_SIDED != 0);
        !(is_one_sided & is_opaque & at.is_behind(lane))
    });
}
