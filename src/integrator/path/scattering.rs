//! The stage that scatters paths: BSDF samples, Russian roulette, and the extension rays of the paths that continue.
//!
//! Measure: densities per steradian.
//! Range: any surface interaction.
//! Source: Veach 1997, section 10.4.1, for roulette. Tested in `tests/rendering/integrators.rs`.

use super::super::Roulette;
use super::super::indirect::Indirect;
use super::super::observer::PathObserver;
use super::super::technique::TechniqueSource;
use super::block::PathBlock;
use super::course::sample_direction;
use super::direct_light::evaluate_diffuse;
use super::shading::{BsdfLanes, ScatteringLanes, StageMemory};
use super::{PathIntegrator, Walk, first_two};
use crate::bsdf::{BoundBsdf, BsdfSample, BsdfSampleInput, BsdfValue, has_lobes};
use crate::effects::{Effects, Slot, Switch};
use crate::math::lanes::{ActiveLanes, LANES, load, store, vectorised};
use crate::math::rgb::Rgb;
use crate::math::vec::{LaneVec3, Vec2};
use crate::planted::planted;
use crate::sampler::{Decision, Sampler};
use crate::sampling::warp::sample_hemisphere_cosine_lanes;
use crate::scene::interaction::Interaction;
use crate::scene::interaction::lanes::InteractionLanes;

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Samples the BSDFs of a block, and evaluates them for the light samples of the lanes `lit`.
    pub(super) fn sample_bsdfs<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        walk: &mut Walk<'_, S, O>,
        block: &PathBlock<E>,
        stage: &mut StageMemory<E>,
        lit: &ActiveLanes<LANES>,
    ) {
        let (scene, technique) = (walk.scene, self.technique.technique());
        let StageMemory {
            at,
            bsdfs,
            direct_light,
            scattering,
            ..
        } = stage;
        let (active, bounce) = (block.active, walk.bounce);
        let decision = Decision::Bsdf(bounce);
        let samplers = &mut *walk.samplers;
        let numbers = &mut scattering.numbers;
        if has_lobes::<E>() {
            S::draw_lanes(samplers, &active, &block.path, decision, numbers);
        } else {
            let direction = first_two(numbers);
            S::draw_lanes(samplers, &active, &block.path, decision, direction);
        }
        let [u, v, _] = scattering.numbers;
        sample_hemisphere_cosine_lanes(&[u, v], &mut scattering.by_cosine);
        if lit.any() {
            evaluate_diffuse::<E>(at, bsdfs, direct_light);
        }
        sample_diffuse::<E>(at, bsdfs, scattering);
        for lane in bsdfs.singly.each() {
            let at: Interaction<E> = at.get(lane);
            let bsdf = scene.surface(&at);
            let bound = bsdf.seen_from::<E>(at.frame.to_local(at.wo));
            if lit.has(lane) {
                let wi = at.frame.to_local(load(&direct_light.samples.wi, lane));
                let BsdfValue { f, pdf } = bound.eval::<E>(wi);
                store(&mut direct_light.f, lane, f);
                direct_light.pdf_bsdf[lane] = pdf.0;
            }
            let [u, v, lobe] = scattering.numbers.each_ref().map(|u| u[lane]);
            let input = BsdfSampleInput {
                lobe,
                u: Vec2::new(u, v),
                by_cosine: load(&scattering.by_cosine, lane),
            };
            let sample = sample_direction::<E>(&bound, technique, &input);
            scattering.set::<E>(lane, &bound, sample);
        }
    }

    /// Scatters the paths of a block, sets the extension rays of those that continue, and deactivates the lanes of the
    /// others.
    pub(super) fn scatter<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        walk: &mut Walk<'_, S, O>,
        block: &mut PathBlock<E>,
        stage: &mut StageMemory<E>,
    ) {
        let scene = walk.scene;
        let StageMemory { at, scattering, .. } = stage;
        let (active, bounce) = (block.active, walk.bounce);
        if self.roulette != Roulette::None {
            let decision = planted!(
                "roulette-takes-a-spent-number",
                Decision::Bsdf(bounce),
                Decision::Roulette(bounce)
            );
            let numbers = std::array::from_mut(&mut scattering.roulette);
            S::draw_lanes(walk.samplers, &active, &block.path, decision, numbers);
        }
        extend::<E>(&active, self.roulette, bounce, at, block, scattering);
        for lane in active.each() {
            let id = at.id(lane);
            if !scattering.scattered.has(lane) {
                walk.observer.absorbed();
                continue;
            }
            if !scene.is_flat(id.shape) {
                let at: Interaction<E> = at.get(lane);
                let wi = at.frame.to_world(load(&scattering.wi, lane));
                let time = block.packet.rays.time[lane];
                let through = scattering.goes_through[lane] != 0;
                let (_, excluded) = scene.spawn(&at, time, wi, through);
                block.excluded.set(lane, Some(excluded));
            }
            let dir = load(&block.packet.rays.dir, lane);
            let beta = load(&scattering.beta, lane);
            walk.observer.scattered(dir, scattering.lobes[lane], beta);
            if !block.active.has(lane) {
                walk.observer.terminated(scattering.survival[lane]);
            }
        }
    }
}

impl ScatteringLanes {
    /// Sets the sample of a lane.
    #[inline(always)]
    fn set<E: Effects>(&mut self, lane: usize, view: &BoundBsdf<'_>, sample: Option<BsdfSample>) {
        self.sampled.set(lane, sample.is_some());
        let Some(sample) = sample else {
            return;
        };
        store(&mut self.wi, lane, sample.wi);
        store(&mut self.weight, lane, sample.weight);
        self.pdf[lane] = sample.pdf.map_or(f32::INFINITY, |pdf| pdf.0);
        self.lobes[lane] = sample.lobe;
        let goes_through = E::Transmission::ON && sample.lobe.is_transmission();
        self.goes_through[lane] = u32::from(goes_through);
        if goes_through {
            let ior = view.bsdf().ior();
            let eta = if view.wo().z > 0.0 { ior } else { 1.0 / ior };
            self.eta2[lane] = eta * eta;
        }
    }
}

vectorised! {
    /// Samples the diffuse BSDFs.
    fn sample_diffuse<E: Effects>(
        at: &InteractionLanes<E>,
        bsdfs: &BsdfLanes,
        scattering: &mut ScatteringLanes,
    ) {
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = at.get(lane);
            let wo = at.frame.to_local(at.wo);
            let by_cosine = load(&scattering.by_cosine, lane);
            let sample = bsdfs.diffuse(lane).sample_cosine(wo, by_cosine);
            scattering.sampled.set(lane, wo.z != 0.0);
            store(&mut scattering.wi, lane, sample.wi);
            store(&mut scattering.weight, lane, sample.weight);
            scattering.pdf[lane] = sample.pdf.map_or(0.0, |pdf| pdf.0);
            scattering.goes_through[lane] = 0;
            scattering.eta2[lane] = 1.0;
        }
    }
}

vectorised! {
    /// Applies the BSDF samples to the paths: throughputs, roulette and extension rays, from flat shapes.
    fn extend<E: Effects>(
        active: &ActiveLanes<LANES>,
        roulette: Roulette,
        bounce: u32,
        at: &InteractionLanes<E>,
        block: &mut PathBlock<E>,
        scattering: &mut ScatteringLanes,
    ) {
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = at.get(lane);
            let wi = at.frame.to_world(load(&scattering.wi, lane));
            // A direction sampled about the shading normal may be on the wrong side of the geometric surface: light would
            // leak.
            let goes_through = E::Transmission::ON && scattering.goes_through[lane] != 0;
            let is_scattered = active.has(lane)
                & scattering.sampled.has(lane)
                & at.agrees(wi, goes_through);
            let weight: Rgb<LaneVec3> = load(&scattering.weight, lane);
            let mut beta: Rgb<LaneVec3> = load(&block.beta, lane);
            beta *= weight;
            scattering.scattered.set(lane, is_scattered);
            store(&mut scattering.beta, lane, beta);
            let (mut reflected, mut left) = (weight, beta);
            if let Some(eta_scale) = block.eta_scale.get_mut() {
                let eta2 = scattering.eta2[lane];
                reflected *= eta2;
                eta_scale[lane] *= eta2;
                left = eta_scale[lane] * beta;
            }
            let survival = roulette.survival(bounce, reflected, left);
            let ends = (survival < 1.0) & (scattering.roulette[lane] >= survival);
            let correction = if survival < 1.0 { 1.0 / survival } else { 1.0 };
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
            block.leave(lane, &at, wi, pdf, goes_through);
            let continues = is_scattered & !ends;
            block.active.set(lane, continues);
            block.count_rays(lane, continues, false);
        }
    }
}
