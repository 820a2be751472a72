//! The first stage of a bounce: surface interactions, emission with its MIS weight, and the ends of paths.
//!
//! Measure: radiance.
//! Range: any block of paths whose rays have been traced.
//! Source: Veach 1997, section 9.2. Tested in `tests/rendering/integrators.rs`.

use super::super::indirect::Indirect;
use super::super::observer::{PathObserver, PathVertex};
use super::super::technique::{EmissionRule, Technique, TechniqueSource};
use super::block::PathBlock;
use super::shading::StageScratch;
use super::simple_techniques::sample_termination;
use super::{PathIntegrator, PathWavefront};
use crate::effects::{Effects, Switch};
use crate::light::types::Receiver;
use crate::math::lanes::{ActiveLanes, LANES, load, store};
use crate::math::measure::PdfSolidAngle;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec3;
use crate::sampler::{Decision, Sampler};
use crate::sampling::mis::power_heuristic_with_third;
use crate::scene::interaction::Interaction;
use crate::scene::interaction::lanes::InteractionLanes;
use crate::scene::{Scene, ShapeTraits};

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Computes the surface interactions of a block, adds emission to the radiance of its paths, and deactivates the lanes
    /// of paths that end here.
    pub(super) fn add_emission<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        wavefront: &mut PathWavefront<'_, S, O>,
        block: &mut PathBlock<E>,
        stage: &mut StageScratch<E>,
    ) {
        let (scene, bounce, technique) = (
            wavefront.scene,
            wavefront.bounce,
            self.technique.technique(),
        );
        let (samplers, samples) = (&mut *wavefront.samplers, &*wavefront.samples);
        let sample_index = &block.sample_index;
        let alpha = |lane: usize| {
            let sample = sample_index[lane] as usize;
            let [u] = samplers[sample].draw(Decision::Alpha(bounce));
            let end = match bounce {
                0 => samples[sample / LANES].t_max(sample % LANES),
                _ => f32::INFINITY,
            };
            (u, end)
        };
        let StageScratch { surfaces, at, .. } = stage;
        let hit_lanes = scene.surface_interactions::<E>(
            &block.active,
            &block.packet,
            &block.excluded,
            alpha,
            surfaces,
            at,
        );
        if wavefront.observer.is_observing() {
            for lane in block.active.each() {
                if hit_lanes.has(lane) {
                    let beta = load(&block.beta, lane);
                    wavefront.observer.arrived(&at.vertex(lane), beta);
                } else {
                    wavefront
                        .observer
                        .escaped(load(&block.packet.rays.dir, lane));
                }
            }
        }
        for lane in block.active.without(&hit_lanes).each() {
            let dir: Vec3 = load(&block.packet.rays.dir, lane);
            let mut contribution = Rgb::BLACK;
            if E::Environment::ON {
                contribution =
                    load::<Rgb>(&block.beta, lane) * self.environment(scene, block, lane, dir);
                block.add(lane, contribution);
            }
            wavefront.observer.environment(contribution);
        }
        block.active = hit_lanes;
        let ends_at_random = technique.emission != EmissionRule::Always;
        let emission_lanes = if ends_at_random {
            hit_lanes
        } else {
            at.emitting_or_absorbing_lanes(&hit_lanes)
        };
        for lane in emission_lanes.each() {
            if self.add_surface_emission::<E, S, O>(wavefront, block, at, lane, technique) {
                wavefront.observer.absorbed();
                block.active.set(lane, false);
            }
        }
        if self.max_bounces.is_some_and(|limit| bounce >= limit) {
            for _ in block.active.each() {
                wavefront.observer.absorbed();
            }
            block.active = ActiveLanes::NONE;
        }
    }

    /// Adds the emission at the surface of one path, weighted against light sampling. Returns whether the path ends: by the
    /// rule of its technique, or on the back of a one-sided surface.
    #[inline(always)]
    fn add_surface_emission<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        wavefront: &mut PathWavefront<'_, S, O>,
        block: &mut PathBlock<E>,
        at: &InteractionLanes<E>,
        lane: usize,
        technique: Technique,
    ) -> bool {
        let scene = wavefront.scene;
        let (at, beta): (Interaction<E>, Rgb) = (at.get(lane), load(&block.beta, lane));
        let emitted = scene.emitted(&at);
        let sampler = &mut wavefront.samplers[block.sample_index[lane] as usize];
        let termination = sample_termination::<S>(technique, emitted, sampler, wavefront.bounce);
        if let Some(emitted) = emitted {
            let time = block.packet.rays.time[lane];
            let chosen_light = block.chosen_light(lane);
            let choice = self.light_choice;
            let weight = mis_weight_of_bsdf(
                block,
                lane,
                technique,
                |from| scene.light_pdf(choice, &from, time, &at),
                || chosen_light.is_some() && scene.light_of(&at) == chosen_light,
            );
            let weight = if E::LightPaths::ON {
                power_heuristic_with_third(
                    weight,
                    self.light_path_ratio_at_emitter(scene, block, lane, &at),
                )
            } else {
                weight
            };
            let contribution = beta * emitted * (weight * termination.emission_factor);
            wavefront.observer.emission(contribution, weight);
            block.add(lane, contribution);
        }
        store(
            &mut block.beta,
            lane,
            beta * termination.continuation_factor,
        );
        termination.ends || scene.is_absorbing_side(&at)
    }

    /// The radiance of the environment along the ray of a path, with its MIS weight.
    #[inline]
    fn environment<E: Effects>(
        &self,
        scene: &Scene,
        block: &PathBlock<E>,
        lane: usize,
        dir: Vec3,
    ) -> Rgb {
        let mut radiance = scene.environment;
        let (technique, rules) = (self.technique.technique(), self.light_sampling());
        if E::EnvironmentMap::ON
            && let Some(environment) = scene.lights.environment(dir, rules.environment)
        {
            let light = environment.light;
            let p_light = |from: Receiver| {
                let pmf = scene.lights.pmf::<E>(light, rules.choice, &from);
                pmf * environment.pdf
            };
            let is_chosen = || Some(light) == block.chosen_light(lane);
            let mut weight = mis_weight_of_bsdf(block, lane, technique, p_light, is_chosen);
            if E::LightPaths::ON {
                let ratio = self.light_path_ratio_at_environment(scene, block, lane, dir, light);
                weight = power_heuristic_with_third(weight, ratio);
            }
            radiance += environment.radiance * weight;
        }
        radiance
    }
}

/// The MIS weight of light found by scattering, where light sampling has the density `p_light`.
#[inline]
fn mis_weight_of_bsdf<E: Effects>(
    block: &PathBlock<E>,
    lane: usize,
    technique: Technique,
    p_light: impl FnOnce(Receiver) -> PdfSolidAngle,
    is_chosen: impl FnOnce() -> bool,
) -> f32 {
    match block.prev_vertex(lane) {
        Some((from, p_bsdf)) => technique.mis_weight_of_bsdf(p_bsdf, || p_light(from), is_chosen),
        None => 1.0,
    }
}

impl<E: Effects> InteractionLanes<E> {
    /// The lanes among the given ones that are on a shape that emits, or on the back of a one-sided one.
    #[inline(always)]
    fn emitting_or_absorbing_lanes(&self, lanes: &ActiveLanes<LANES>) -> ActiveLanes<LANES> {
        lanes.and(|lane| {
            let traits = self.traits[lane];
            let emits = E::AreaLights::ON & (traits & ShapeTraits::EMISSIVE != 0);
            let is_one_sided = E::OneSided::ON & (traits & ShapeTraits::ONE_SIDED != 0);
            emits | (is_one_sided & self.is_behind(lane))
        })
    }

    /// The vertex of a lane, for observers.
    #[inline(always)]
    fn vertex(&self, lane: usize) -> PathVertex {
        (&self.get::<Vec3>(lane)).into()
    }
}
