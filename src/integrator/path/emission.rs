//! The stage where rays arrive: surface interactions, emission with its MIS weight, and the ends of paths.
//!
//! Measure: radiance.
//! Range: any block of paths whose rays have been traced.
//! Source: Veach 1997, section 9.2. Tested in `tests/rendering/integrators.rs`.

use super::super::indirect::Indirect;
use super::super::observer::{PathObserver, PathVertex};
use super::super::technique::{EmissionRule, Technique, TechniqueSource};
use super::block::PathBlock;
use super::course::toss;
use super::shading::StageMemory;
use super::{PathIntegrator, Walk};
use crate::effects::{Effects, Switch};
use crate::math::lanes::{load, store};
use crate::math::measure::PdfSolidAngle;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec3;
use crate::sampler::{Decision, Sampler};
use crate::scene::Scene;
use crate::scene::interaction::Interaction;
use crate::scene::interaction::lanes::InteractionLanes;

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Computes the surface interactions of a block, adds emission to the radiance of its paths, and deactivates the lanes
    /// of paths that end here.
    pub(super) fn add_emission<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        walk: &mut Walk<'_, S, O>,
        block: &mut PathBlock<E>,
        stage: &mut StageMemory<E>,
    ) {
        let (scene, bounce, technique) = (walk.scene, walk.bounce, self.technique.technique());
        let (samplers, path) = (&mut *walk.samplers, &block.path);
        let u_alpha = |lane: usize| {
            let sampler = &mut samplers[path[lane] as usize];
            let [u] = sampler.draw(Decision::Alpha(bounce));
            u
        };
        let StageMemory { surfaces, at, .. } = stage;
        let found = scene.surface_interactions::<E>(
            &block.active,
            &block.packet,
            &block.excluded,
            u_alpha,
            surfaces,
            at,
        );
        let is_last = self.max_bounces.is_some_and(|limit| bounce >= limit);
        for lane in block.active.each() {
            let beta: Rgb = load(&block.beta, lane);
            if !found.has(lane) {
                let dir: Vec3 = load(&block.packet.rays.dir, lane);
                walk.observer.escaped(dir);
                if E::Environment::ON {
                    let contribution = beta * environment(scene, block, lane, dir, technique);
                    walk.observer.environment(contribution);
                    block.add(lane, contribution);
                } else {
                    walk.observer.environment(Rgb::BLACK);
                }
                block.active.set(lane, false);
                continue;
            }
            walk.observer.arrived(&at.vertex(lane), beta);
            if self.ends_at::<E, S, O>(walk, block, at, lane, technique) || is_last {
                walk.observer.absorbed();
                block.active.set(lane, false);
            }
        }
    }

    /// Adds the emission at the surface of one path, weighted against light sampling. Returns whether the path ends.
    #[inline(always)]
    fn ends_at<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        walk: &mut Walk<'_, S, O>,
        block: &mut PathBlock<E>,
        at: &InteractionLanes<E>,
        lane: usize,
        technique: Technique,
    ) -> bool {
        let scene = walk.scene;
        let has_coin = technique.emission != EmissionRule::Always;
        let is_emitter = E::AreaLights::ON && scene.is_emitter(at.shape[lane]);
        if !has_coin && !is_emitter && !E::OneSided::ON {
            return false;
        }
        let (at, beta): (Interaction<E>, Rgb) = (at.get(lane), load(&block.beta, lane));
        let emitted = scene.emitted(&at);
        let sampler = &mut walk.samplers[block.path[lane] as usize];
        let coin = toss::<S>(technique, emitted, sampler, walk.bounce);
        if let Some(emitted) = emitted {
            let time = block.packet.rays.time[lane];
            let chosen = block.chosen(lane);
            let weight = weight_of_scattering(
                block,
                lane,
                technique,
                |from| scene.light_pdf(from, time, &at),
                || chosen.is_some() && scene.light_of(&at) == chosen,
            );
            let contribution = beta * emitted * (weight * coin.taken);
            walk.observer.emission(contribution, weight);
            block.add(lane, contribution);
        }
        store(&mut block.beta, lane, beta * coin.left);
        coin.ends || scene.is_dark(&at)
    }
}

/// The MIS weight of light found by scattering, where light sampling has the density `p_light`.
#[inline]
fn weight_of_scattering<E: Effects>(
    block: &PathBlock<E>,
    lane: usize,
    technique: Technique,
    p_light: impl FnOnce(Vec3) -> PdfSolidAngle,
    is_chosen: impl FnOnce() -> bool,
) -> f32 {
    match block.scattered_from(lane) {
        Some((from, p_bsdf)) => technique.weight_of_scattering(p_bsdf, || p_light(from), is_chosen),
        None => 1.0,
    }
}

/// The radiance of the environment along the ray of a path, with its MIS weight.
#[inline]
fn environment<E: Effects>(
    scene: &Scene,
    block: &PathBlock<E>,
    lane: usize,
    dir: Vec3,
    technique: Technique,
) -> Rgb {
    let mut radiance = scene.environment;
    if E::EnvironmentMap::ON
        && let Some(environment) = scene.lights.environment(dir)
    {
        let is_chosen = || Some(environment.light) == block.chosen(lane);
        radiance += environment.radiance
            * weight_of_scattering(block, lane, technique, |_| environment.pdf, is_chosen);
    }
    radiance
}

impl<E: Effects> InteractionLanes<E> {
    /// The vertex of a lane, for observers.
    #[inline(always)]
    fn vertex(&self, lane: usize) -> PathVertex {
        (&self.get::<Vec3>(lane)).into()
    }
}
