//! The stage that scatters paths: BSDF samples, Russian roulette, and the extension rays of the paths that continue.
//!
//! Measure: densities per steradian.
//! Range: any surface interaction.
//! Source: Veach 1997, section 10.4.1, for roulette. Tested in `tests/rendering/integrators.rs`.

use super::super::Roulette;
use super::super::indirect::Indirect;
use super::super::observer::PathObserver;
use super::super::roulette::Survival;
use super::super::technique::TechniqueSource;
use super::block::PathBlock;
use super::direct_light::evaluate_diffuse;
use super::shading::{
    BsdfLanes, DirectLightLanes, PrincipledStage, ScatteringLanes, StageScratch, to_local,
};
use super::simple_techniques::sample_direction;
use super::{PathIntegrator, PathWavefront, first_two};
use crate::bsdf::principled::lanes::PrincipledLanes;
use crate::bsdf::{BoundBsdf, BsdfSample, BsdfSampleInput, BsdfValue, Lobe, has_lobes};
use crate::effects::{Effects, Slot, Switch};
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3, load, store, vectorised};
use crate::math::rgb::Rgb;
use crate::math::vec::{LaneVec3, Vec2};
use crate::planted::planted;
use crate::sampler::{Decision, LaneStates, Sampler};
use crate::sampling::warp::sample_hemisphere_cosine_lanes;
use crate::scene::interaction::Interaction;
use crate::scene::interaction::lanes::InteractionLanes;
use crate::scene::{Scene, ShapeTraits};

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Samples the BSDFs of a block with the random numbers of `decision`, and evaluates them for the light samples of
    /// the lanes `nee_lanes`.
    pub(super) fn sample_bsdfs<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        wavefront: &mut PathWavefront<'_, S, O>,
        block: &PathBlock<E>,
        stage: &mut StageScratch<E>,
        states: &LaneStates,
        nee_lanes: &ActiveLanes<LANES>,
        decision: Decision,
    ) {
        let (scene, technique) = (wavefront.scene, self.technique.technique());
        let StageScratch {
            at,
            bsdfs,
            direct_light,
            scattering,
            ..
        } = stage;
        let active = block.active;
        let samplers = &mut *wavefront.samplers;
        let numbers = &mut scattering.numbers;
        let sample_index = &block.sample_index;
        if has_lobes::<E>() {
            S::draw_lanes(samplers, &active, sample_index, states, decision, numbers);
        } else {
            let direction = first_two(numbers);
            S::draw_lanes(samplers, &active, sample_index, states, decision, direction);
        }
        scattering.lobes = [Lobe::Diffuse; LANES];
        let [u, v, _] = scattering.numbers;
        sample_hemisphere_cosine_lanes(&[u, v], &mut scattering.cosine_direction);
        if nee_lanes.any() {
            evaluate_diffuse::<E>(at, bsdfs, direct_light);
        }
        sample_diffuse::<E>(at, bsdfs, scattering);
        if let Some(stage) = bsdfs.principled.get_mut()
            && stage.active.any()
        {
            sample_principled(scene, at, stage, nee_lanes, direct_light, scattering);
        }
        for lane in bsdfs.scalar_lanes.each() {
            let at: Interaction<E> = at.get(lane);
            let bsdf = scene.bsdf(&at);
            let bound = bsdf.bind::<E>(at.frame.to_local(at.wo));
            if nee_lanes.has(lane) {
                let wi = at.frame.to_local(load(&direct_light.samples.wi, lane));
                let BsdfValue { f, pdf } = bound.eval::<E>(wi);
                store(&mut direct_light.f, lane, f);
                direct_light.pdf_bsdf[lane] = pdf.0;
            }
            let [u, v, lobe] = scattering.numbers.each_ref().map(|u| u[lane]);
            let input = BsdfSampleInput {
                lobe,
                u: Vec2::new(u, v),
                cosine_direction: load(&scattering.cosine_direction, lane),
            };
            let sample = sample_direction::<E>(&bound, technique, &input);
            scattering.set::<E>(lane, &bound, sample);
        }
    }

    /// Scatters the paths of a block, sets the extension rays of those that continue, and deactivates the lanes of the
    /// others. `decision` addresses the random number of Russian roulette.
    pub(super) fn scatter<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        wavefront: &mut PathWavefront<'_, S, O>,
        block: &mut PathBlock<E>,
        stage: &mut StageScratch<E>,
        states: &LaneStates,
        decision: Decision,
    ) {
        let scene = wavefront.scene;
        let (active, bounce) = (block.active, wavefront.bounce);
        let StageScratch { at, scattering, .. } = stage;
        if self.roulette != Roulette::None {
            let numbers = std::array::from_mut(&mut scattering.roulette);
            S::draw_lanes(
                wavefront.samplers,
                &active,
                &block.sample_index,
                states,
                decision,
                numbers,
            );
        }
        let survival = self.roulette.survival();
        extend::<E>(&active, survival, bounce, at, block, scattering);
        let round = scattering
            .scattered
            .and(|lane| at.traits[lane] & ShapeTraits::FLAT == 0);
        for lane in round.each() {
            let at: Interaction<E> = at.get(lane);
            let wi = at.frame.to_world(load(&scattering.wi, lane));
            let time = block.packet.rays.time[lane];
            let through = scattering.is_transmitted[lane] != 0;
            let (_, excluded) = scene.spawn(&at, time, wi, through);
            block.excluded.set(lane, Some(excluded));
        }
        if !wavefront.observer.is_observing() {
            return;
        }
        for lane in active.each() {
            if !scattering.scattered.has(lane) {
                wavefront.observer.absorbed();
                continue;
            }
            let dir = load(&block.packet.rays.dir, lane);
            let beta = load(&scattering.beta, lane);
            wavefront
                .observer
                .scattered(dir, scattering.lobes[lane], beta);
            if !block.active.has(lane) {
                wavefront.observer.terminated(scattering.survival[lane]);
            }
        }
    }
}

/// Samples the principled BSDFs and the conductors that are evaluated in lanes, and evaluates them for the light samples of
/// the lanes `nee_lanes`.
fn sample_principled<E: Effects>(
    scene: &Scene,
    at: &InteractionLanes<E>,
    stage: &mut PrincipledStage,
    nee_lanes: &ActiveLanes<LANES>,
    direct_light: &mut DirectLightLanes,
    scattering: &mut ScatteringLanes,
) {
    let PrincipledStage {
        active,
        bsdfs,
        wo,
        to_light,
        sampled,
        f,
        pdf,
        reverse_pdf_of_light_sample,
        reverse_pdf_of_bsdf_sample,
    } = stage;
    let eval = |bsdfs: &PrincipledLanes, w: &Lanes3, f: &mut _, pdf: &mut _, reverse: &mut _| {
        if E::LightPaths::ON {
            bsdfs.eval_both_ways(w, f, pdf, reverse);
        } else {
            bsdfs.eval(w, f, pdf);
        }
    };
    if nee_lanes.any() {
        to_local::<E>(at, &direct_light.samples.wi, to_light);
        eval(bsdfs, to_light, f, pdf, reverse_pdf_of_light_sample);
        for (to, of) in direct_light.f.iter_mut().zip(&*f) {
            replace(active, to, of);
        }
        replace(active, &mut direct_light.pdf_bsdf, pdf);
    }
    let (numbers, cosine_direction) = (&scattering.numbers, &scattering.cosine_direction);
    let sample_multiple = |lane: usize, u: Vec2| {
        let at: Interaction<E> = at.get(lane);
        let bsdf = scene.material(at.id).rough_bsdf::<E>(at.uv.or(Vec2::ZERO));
        let (bsdf, _) = bsdf.expect("it was looked up before");
        bsdf.sample_multiple(u)
    };
    bsdfs.sample(active, numbers, cosine_direction, sample_multiple, sampled);
    flip_to_side_of_wo(wo, &mut sampled.wi, scattering, active);
    eval(bsdfs, &sampled.wi, f, pdf, reverse_pdf_of_bsdf_sample);
    weigh(active, &sampled.wi, f, pdf, scattering);
    for lane in active.each() {
        scattering.lobes[lane] = if sampled.is_diffuse[lane] != 0 {
            Lobe::Diffuse
        } else {
            Lobe::GlossyReflection
        };
    }
}

/// Copies the values of the given lanes.
#[inline(always)]
pub(super) fn replace(lanes: &ActiveLanes<LANES>, to: &mut Lanes<f32>, of: &Lanes<f32>) {
    for (lane, (to, of)) in to.iter_mut().zip(of).enumerate() {
        *to = if lanes.has(lane) { *of } else { *to };
    }
}

vectorised! {
    /// Flips sampled directions to the side of `wo`, and marks the lanes whose direction was sampled above the surface.
    fn flip_to_side_of_wo(
        wo: &Lanes3,
        wi: &mut Lanes3,
        scattering: &mut ScatteringLanes,
        active: &ActiveLanes<LANES>,
    ) {
        for lane in 0..LANES {
            let (cos_o, cos_i) = (wo[2][lane], wi[2][lane]);
            let is_sampled = (cos_o != 0.0) & (cos_i > 0.0);
            wi[2][lane] = cos_i.copysign(cos_o);
            let (kept, is_active) = (scattering.sampled.0[lane], active.has(lane));
            let mask = if is_sampled { -1 } else { 0 };
            scattering.sampled.0[lane] = if is_active { mask } else { kept };
        }
    }
}

vectorised! {
    /// Stores the samples of the given lanes, with the weights f |cos| / pdf.
    fn weigh(
        lanes: &ActiveLanes<LANES>,
        wi: &Lanes3,
        f: &Lanes3,
        pdf: &Lanes<f32>,
        scattering: &mut ScatteringLanes,
    ) {
        for lane in 0..LANES {
            let is_active = lanes.has(lane);
            let pdf = pdf[lane];
            let value: Rgb<LaneVec3> = load(f, lane);
            let weight = value * (wi[2][lane].abs() / pdf);
            let wi: LaneVec3 = load(wi, lane);
            let kept: Rgb<LaneVec3> = load(&scattering.weight, lane);
            store(&mut scattering.weight, lane, if is_active { weight } else { kept });
            let kept: LaneVec3 = load(&scattering.wi, lane);
            store(&mut scattering.wi, lane, if is_active { wi } else { kept });
            let kept = scattering.pdf[lane];
            scattering.pdf[lane] = if is_active { pdf } else { kept };
            let kept = scattering.sampled.0[lane];
            let mask = if pdf > 0.0 { kept } else { 0 };
            scattering.sampled.0[lane] = if is_active { mask } else { kept };
        }
    }
}

impl ScatteringLanes {
    /// Sets the sample of a lane.
    #[inline(always)]
    fn set<E: Effects>(&mut self, lane: usize, bound: &BoundBsdf<'_>, sample: Option<BsdfSample>) {
        self.sampled.set(lane, sample.is_some());
        let Some(sample) = sample else {
            return;
        };
        store(&mut self.wi, lane, sample.wi);
        store(&mut self.weight, lane, sample.weight);
        self.pdf[lane] = sample.pdf.map_or(f32::INFINITY, |pdf| pdf.0);
        self.lobes[lane] = sample.lobe;
        let is_transmitted = E::Transmission::ON && sample.lobe.is_transmission();
        self.is_transmitted[lane] = u32::from(is_transmitted);
        if is_transmitted {
            let ior = bound.bsdf().ior();
            let eta = if bound.wo().z > 0.0 { ior } else { 1.0 / ior };
            self.eta2[lane] = eta * eta;
        }
    }
}

vectorised! {
    /// Samples the diffuse BSDFs.
    fn sample_diffuse<E: Effects>(
        at: &InteractionLanes<E>,
        bsdfs: &BsdfLanes<E>,
        scattering: &mut ScatteringLanes,
    ) {
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = at.get(lane);
            let wo = at.frame.to_local(at.wo);
            let cosine_direction = load(&scattering.cosine_direction, lane);
            let sample = bsdfs.diffuse_bsdf(lane).sample_cosine(wo, cosine_direction);
            scattering.sampled.set(lane, wo.z != 0.0);
            store(&mut scattering.wi, lane, sample.wi);
            store(&mut scattering.weight, lane, sample.weight);
            scattering.pdf[lane] = sample.pdf.map_or(0.0, |pdf| pdf.0);
            scattering.is_transmitted[lane] = 0;
            scattering.eta2[lane] = 1.0;
        }
    }
}

vectorised! {
    /// Applies the BSDF samples to the paths: throughputs, Russian roulette, and extension rays with the exclusion that
    /// holds for flat shapes.
    fn extend<E: Effects>(
        active: &ActiveLanes<LANES>,
        rule: Survival,
        bounce: u32,
        at: &InteractionLanes<E>,
        block: &mut PathBlock<E>,
        scattering: &mut ScatteringLanes,
    ) {
        let interactions = at;
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = interactions.get(lane);
            let wi = at.frame.to_world(load(&scattering.wi, lane));
            // A direction sampled about the shading normal may be on the wrong side of the geometric surface: light would
            // leak.
            let is_transmitted = E::Transmission::ON && scattering.is_transmitted[lane] != 0;
            let is_scattered = active.has(lane)
                & scattering.sampled.has(lane)
                & at.is_consistent_side(wi, is_transmitted);
            let weight: Rgb<LaneVec3> = load(&scattering.weight, lane);
            let mut beta: Rgb<LaneVec3> = load(&block.beta, lane);
            beta *= weight;
            scattering.scattered.set(lane, is_scattered);
            store(&mut scattering.beta, lane, beta);
            let (mut reflected, mut rr_beta) = (weight, beta);
            if let Some(eta_scale) = block.eta_scale.get_mut() {
                let eta2 = scattering.eta2[lane];
                reflected *= eta2;
                eta_scale[lane] *= eta2;
                rr_beta = eta_scale[lane] * beta;
            }
            let survival = rule.probability(bounce, reflected, rr_beta);
            let ends = (survival < 1.0) & (scattering.roulette[lane] >= survival);
            let correction = if survival < 1.0 { rule.correction(survival) } else { 1.0 };
            let factor = planted!("roulette-without-division", 1.0, correction);
            scattering.survival[lane] = survival;
            if planted!("roulette-on-radiance", true, false) {
                let radiance: Rgb<LaneVec3> = load(&block.radiance, lane);
                store(&mut block.radiance, lane, factor * radiance);
            } else {
                beta *= factor;
            }
            store(&mut block.beta, lane, beta);
            let pdf = scattering.pdf[lane];
            block.set_prev_normal(lane, interactions.receiver_normal(lane));
            block.spawn_extension_ray(lane, &at, wi, pdf, is_transmitted);
            let continues = is_scattered & !ends;
            block.active.set(lane, continues);
            block.count_rays(lane, continues, false);
        }
    }
}
