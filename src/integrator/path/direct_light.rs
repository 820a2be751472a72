//! Next event estimation: one light sample for each path, its contribution, and its shadow ray.
//!
//! Measure: radiance; densities per steradian.
//! Range: surfaces whose BSDF is not a delta; delta lobes of others reflect nothing that light sampling finds.
//! Source: Shirley, Wang and Zimmerman 1996 for light sampling; Veach 1997, section 9.2 for its weight. Tested in
//! `tests/rendering/integrators.rs`.

use super::super::indirect::Indirect;
use super::super::observer::{PathObserver, RayKind};
use super::super::technique::{LightRule, Technique, TechniqueSource};
use super::block::PathBlock;
use super::shading::{BsdfLanes, DirectLightLanes, LightPathLanes, StageScratch};
use super::{PathIntegrator, PathWavefront, first_two};
use crate::bsdf::BsdfValue;
use crate::effects::{EffectState, Effects, Slot, Switch};
use crate::light::lanes::ShadowRayEndKind;
use crate::light::types::LightSample;
use crate::math::lanes::ActiveLanes;
use crate::math::lanes::{LANES, load, store, vectorised};
use crate::math::measure::PdfSolidAngle;
use crate::math::rgb::Rgb;
use crate::math::vec::{LaneVec3, Vector};
use crate::planted::planted;
use crate::sampler::{Decision, LaneStates, Sampler};
use crate::sampling::mis::power_heuristic_with_third;
use crate::scene::interaction::Interaction;
use crate::scene::interaction::lanes::InteractionLanes;

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Samples a light at the surface of each path whose BSDF is not a delta. Returns these lanes.
    pub(super) fn sample_lights<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        wavefront: &mut PathWavefront<'_, S, O>,
        block: &mut PathBlock<E>,
        stage: &mut StageScratch<E>,
        states: &LaneStates,
    ) -> ActiveLanes<LANES> {
        let (scene, technique) = (wavefront.scene, self.technique.technique());
        let DirectLightLanes {
            receivers,
            context,
            samples,
            lights,
            shadow_ray_lanes,
            ..
        } = &mut stage.direct_light;
        *shadow_ray_lanes = ActiveLanes::NONE;
        if !technique.samples_lights() || scene.lights.is_empty() {
            return ActiveLanes::NONE;
        }
        let nee_lanes = block.active.without(&stage.bsdfs.delta);
        if !nee_lanes.any() {
            return nee_lanes;
        }
        let decision = Decision::Light(wavefront.bounce);
        let samplers = &mut *wavefront.samplers;
        let (sample_index, u) = (&block.sample_index, &mut context.u);
        let selection = &scene.lights;
        let are_several = selection.are_several::<E>();
        if are_several {
            S::draw_lanes(samplers, &nee_lanes, sample_index, states, decision, u);
        } else {
            let point = first_two(u);
            S::draw_lanes(samplers, &nee_lanes, sample_index, states, decision, point);
        }
        let rules = self.light_sampling();
        if are_several {
            stage.at.receivers(receivers);
        }
        selection.choose_lanes::<E>(rules.choice, &nee_lanes, receivers, context);
        block.set_chosen_lights(&nee_lanes, &context.light);
        context.time = block.packet.rays.time;
        let p = &stage.at.p;
        scene.sample_lights::<E>(&nee_lanes, context, rules, p, lights, samples);
        nee_lanes
    }

    /// Computes the contributions of the light samples of `nee_lanes`, and their shadow rays.
    ///
    /// `cached` marks lanes whose indirect light is cached: there no scattered ray can hit a light.
    pub(super) fn estimate_direct_light<E: Effects, S, O: PathObserver + ?Sized>(
        &self,
        wavefront: &mut PathWavefront<'_, S, O>,
        block: &mut PathBlock<E>,
        stage: &mut StageScratch<E>,
        nee_lanes: &ActiveLanes<LANES>,
        cached: &ActiveLanes<LANES>,
    ) {
        if !nee_lanes.any() {
            return;
        }
        let StageScratch {
            at,
            direct_light,
            light_paths,
            ..
        } = stage;
        let technique = self.technique;
        reflect::<E, C>(
            nee_lanes,
            cached,
            technique,
            at,
            block,
            light_paths,
            direct_light,
        );
        if E::DeltaLights::ON || E::EnvironmentMap::ON {
            set_shadow_rays_to_non_surfaces::<E>(at, direct_light);
        }
        if !wavefront.observer.is_observing() {
            return;
        }
        for lane in nee_lanes.each() {
            if !direct_light.shadow_ray_lanes.has(lane) {
                wavefront.observer.unlit();
                continue;
            }
            let (ray, time) = direct_light.shadow.get(lane);
            wavefront.observer.traced(RayKind::Shadow, &ray, time);
        }
    }
}

vectorised! {
    /// The values and densities of diffuse BSDFs for the light samples.
    pub(super) fn evaluate_diffuse<E: Effects>(
        at: &InteractionLanes<E>,
        bsdfs: &BsdfLanes<E>,
        direct_light: &mut DirectLightLanes,
    ) {
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = at.get(lane);
            let frame = at.frame;
            let wo = frame.to_local(at.wo);
            let wi = frame.to_local(load(&direct_light.samples.wi, lane));
            let BsdfValue { f, pdf } = bsdfs.diffuse_bsdf(lane).eval(wo, wi);
            store(&mut direct_light.f, lane, f);
            direct_light.pdf_bsdf[lane] = pdf.0;
        }
    }
}

/// The reflected light of a light sample, before its visibility is known.
struct DirectLightEstimate {
    /// Whether there is any.
    is_lit: bool,
    /// The contribution f |cos| Le / p_light, times the MIS weight.
    contribution: Rgb<LaneVec3>,
    weight: f32,
    /// Whether the light goes through the surface.
    is_transmitted: bool,
}

/// Computes the contribution of a light sample, weighted against BSDF sampling and, by the ratio `light_path_over_nee` of their
/// densities, against light paths. The density of the sample includes the probability `pmf` of selecting the light, and
/// is infinite for a delta light. Free of branches.
#[inline(always)]
fn reflected<E: Effects>(
    at: &Interaction<E, LaneVec3>,
    technique: Technique,
    pmf: f32,
    (wi, radiance, pdf): (LaneVec3, Rgb<LaneVec3>, f32),
    value: BsdfValue<LaneVec3>,
    light_path_over_nee: EffectState<E::LightPaths, f32>,
) -> DirectLightEstimate {
    let local = at.frame.to_local(wi);
    // Reflection or transmission in the shading frame must be the same at the geometric surface.
    let is_transmitted = is_transmitted(at, wi);
    let is_delta = pdf == f32::INFINITY;
    let (weight, over_pdf) = if technique.lights == LightRule::PartitionedLights {
        (1.0, pmf / pdf)
    } else {
        (
            technique.mis_weight_of_light(PdfSolidAngle(pdf), value.pdf),
            1.0 / pdf,
        )
    };
    let (weight, over_pdf) = if is_delta {
        (1.0, 1.0)
    } else {
        (weight, over_pdf)
    };
    let weight = if E::LightPaths::ON {
        power_heuristic_with_third(weight, light_path_over_nee.or(0.0))
    } else {
        weight
    };
    let cos = planted!("light-without-cosine", 1.0, local.z.abs());
    DirectLightEstimate {
        is_lit: !radiance.is_black()
            & at.is_consistent_side(wi, is_transmitted)
            & !value.f.is_black(),
        contribution: value.f * radiance * (cos * weight * over_pdf),
        weight,
        is_transmitted,
    }
}

/// Whether light along `wi` goes through the surface.
#[inline(always)]
fn is_transmitted<E: Effects, V: Vector>(at: &Interaction<E, V>, wi: V) -> bool {
    at.frame.to_local(wi).z() * at.frame.to_local(at.wo).z() < 0.0
}

vectorised! {
    /// The contributions of the light samples, weighted against BSDF sampling, and their shadow rays to points on surfaces.
    fn reflect<E: Effects, C: TechniqueSource>(
        nee_lanes: &ActiveLanes<LANES>,
        cached: &ActiveLanes<LANES>,
        technique: C,
        at: &InteractionLanes<E>,
        block: &mut PathBlock<E>,
        light_paths: &EffectState<E::LightPaths, LightPathLanes>,
        direct_light: &mut DirectLightLanes,
    ) {
        for lane in 0..LANES {
            let samples = &direct_light.samples;
            let technique = if cached.has(lane) {
                technique.technique().with_light_sampling_only()
            } else {
                technique.technique()
            };
            let at: Interaction<E, LaneVec3> = at.get(lane);
            let value = BsdfValue {
                f: load(&direct_light.f, lane),
                pdf: PdfSolidAngle(direct_light.pdf_bsdf[lane]),
            };
            let wi = load(&samples.wi, lane);
            let light = (wi, load(&samples.radiance, lane), samples.pdf[lane]);
            let pmf = direct_light.context.pmf[lane];
            let light_path_over_nee = Slot::new(|| light_paths.get().map_or(0.0, |it| it.light_path_over_nee[lane]));
            let estimate = reflected::<E>(&at, technique, pmf, light, value, light_path_over_nee);
            let ray = at.ray_to_surface(&samples.surface(lane), wi, estimate.is_transmitted);
            let is_in_mask = planted!("ended-paths-sample-lights", true, nee_lanes.has(lane));
            let has_sample = (samples.end[lane] != ShadowRayEndKind::None as u32) & (pmf > 0.0);
            let is_lit = estimate.is_lit & is_in_mask & has_sample;
            let beta: Rgb<LaneVec3> = load(&block.beta, lane);
            store(&mut direct_light.contribution, lane, beta * estimate.contribution);
            direct_light.weight[lane] = estimate.weight;
            direct_light.shadow.set(lane, &ray);
            let time = block.packet.rays.time[lane];
            direct_light.shadow.time[lane] = planted!("shadows-as-the-shutter-opens", 0.0, time);
            direct_light.shadow_ray_lanes.set(lane, is_lit);
            block.count_rays(lane, false, is_lit);
        }
    }
}

/// Sets the shadow rays to lights that are not surfaces.
fn set_shadow_rays_to_non_surfaces<E: Effects>(
    at: &InteractionLanes<E>,
    direct_light: &mut DirectLightLanes,
) {
    for lane in direct_light.shadow_ray_lanes.each() {
        if direct_light.samples.end[lane] == ShadowRayEndKind::Surface as u32 {
            continue;
        }
        if let Some(LightSample { wi, end, .. }) = direct_light.samples.get(lane) {
            let at: Interaction<E> = at.get(lane);
            let ray = at.ray_to(&end, wi, is_transmitted(&at, wi));
            direct_light.shadow.set(lane, &ray);
        }
    }
}
