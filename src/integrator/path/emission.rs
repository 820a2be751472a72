//! Emission at the vertices of paths, and whether the paths continue from there.
//!
//! Measure: radiance.
//! Range: any hit; a path whose ray hits nothing ends in the environment.
//! Source: the emission of the rendering equation, Kajiya 1986, weighted as in Veach 1997, section 9.2. Tested in
//! `battery/` and `tests/rendering/integrators.rs`.

use super::super::indirect::Indirect;
use super::super::observer::PathObserver;
use super::super::technique::{Technique, TechniqueSource};
use super::course::toss;
use super::{PathIntegrator, PathState, Paths};
use crate::effects::{Effects, Slot, Switch};
use crate::math::rgb::Rgb;
use crate::sampler::{Decision, Sampler};
use crate::scene::Scene;
use crate::scene::interaction::Interaction;

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Adds the emission at the vertices of the active paths to their radiance, and the vertices where the paths do not
    /// end to `interactions`: only these paths stay active.
    // Inlined, as one of the two loops that call it is performance-critical.
    #[inline(always)]
    pub(super) fn add_emission_and_compact<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        paths: &mut Paths<'_, E, S, O>,
        interactions: &mut Vec<Interaction<E>>,
    ) {
        for place in 0..paths.queues.active.len() {
            let path_index = paths.queues.active[place];
            if self.add_emission(paths, path_index, interactions) {
                paths.queues.active[interactions.len() - 1] = path_index;
            }
        }
        paths.queues.active.truncate(interactions.len());
    }

    /// Adds the emission at the vertex of one path, and returns whether the path continues.
    #[inline(always)]
    fn add_emission<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        paths: &mut Paths<'_, E, S, O>,
        path_index: usize,
        interactions: &mut Vec<Interaction<E>>,
    ) -> bool {
        let (scene, bounce, technique) = (paths.scene, paths.bounce, self.technique.technique());
        let (path, sampler) = (
            &mut paths.states[path_index],
            &mut paths.samplers[path_index],
        );
        let observer = &mut *paths.observer;
        let (chosen, time) = (paths.queues.chosen[path_index], path.time.or(0.0));
        let u_alpha = draw_alpha::<E, S>(sampler, bounce);
        let found = paths.samples[path_index].found;
        let Some(at) =
            scene.surface_interaction::<E>(&path.ray, time, path.excluded.or(None), u_alpha, found)
        else {
            observer.escaped(path.ray.dir);
            let contribution = path.beta * environment(scene, path, technique, chosen);
            path.radiance += contribution;
            observer.environment(contribution);
            return false;
        };
        observer.arrived(&(&at).into(), path.beta);

        // Emission, weighted against light sampling.
        let emitted = scene.emitted(&at);
        let coin = toss::<S>(technique, emitted, sampler, bounce);
        if let Some(emitted) = emitted {
            let weight = path.weight_of_scattering(
                technique,
                |from| scene.light_pdf(from, time, &at),
                || chosen.is_some() && scene.light_of(&at) == chosen,
            );
            let contribution = path.beta * emitted * (weight * coin.taken);
            observer.emission(contribution, weight);
            path.radiance += contribution;
        }
        let is_last = self.max_bounces.is_some_and(|limit| bounce >= limit);
        if coin.ends || is_last || scene.is_dark(&at) {
            observer.absorbed();
            return false;
        }
        path.beta *= coin.left;
        interactions.push(at);
        true
    }
}

/// Draws the number that decides whether a surface with alpha is hit.
#[inline(always)]
fn draw_alpha<E: Effects, S: Sampler>(sampler: &mut S, bounce: u32) -> f32 {
    if !E::Alpha::ON {
        return 0.0;
    }
    let [u] = sampler.draw(Decision::Alpha(bounce));
    u
}

/// The radiance of the environment along the path's ray, with its MIS weight.
#[inline]
fn environment<E: Effects>(
    scene: &Scene,
    path: &PathState<E>,
    technique: Technique,
    chosen: Option<u32>,
) -> Rgb {
    if !E::Environment::ON {
        return Rgb::BLACK;
    }
    let mut radiance = scene.environment;
    if E::EnvironmentMap::ON
        && let Some(environment) = scene.lights.environment(path.ray.dir)
    {
        let is_chosen = || Some(environment.light) == chosen;
        radiance += environment.radiance
            * path.weight_of_scattering(technique, |_| environment.pdf, is_chosen);
    }
    radiance
}
