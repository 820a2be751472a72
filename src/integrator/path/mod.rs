//! Path tracing: with next event estimation, multiple importance sampling and Russian roulette, or by any simpler
//! [`Technique`] of the course.
//!
//! The radiance along a ray is the sum over paths x_0 x_1 ... x_k from the eye to a light,
//!
//!   L = sum_k  beta_k [ w_bsdf Le(x_k) + w_light f(x_k) |cos| Le(y) V(x_k, y) / p_light(y) ],
//!   beta_k = prod_{j<k} f(x_j) |cos| / p_bsdf / q_j,
//!
//! where each way of reaching a light is weighted by the power heuristic of both densities (other techniques: by 0 or 1),
//! and q_j is the probability of surviving the roulette. Where a coin decides, with probability p, that the path ends with
//! what its surface emits, that is divided by p and all that comes later by 1 - p. Delta lobes cannot be found by light
//! sampling, nor can the constant environment, which is not a light that one samples: there w_bsdf = 1. Delta lights
//! cannot be found by scattering: there w_light = 1.
//!
//! The integrator is compiled for the effects `E`; with others it gives the same numbers.
//!
//! Measure: radiance; densities per steradian.
//! Range: any scene that calls for no effect beyond `E`; without a bounce limit a path ends by absorption, by leaving, or
//! by roulette.
//! Source: Kajiya 1986; Veach 1997, sections 8.3, 9.2 and 10.4.1. Tested in `battery/`,
//! `tests/scattering/furnace.rs`, `tests/rendering/effects.rs` and `tests/rendering/integrators.rs`.

mod direct_light;
mod state;

pub use state::PathState;

use super::indirect::{Indirect, Traced};
use super::observer::{PathObserver, RayKind};
use super::steps::{sample_direction, toss};
use super::technique::{Chosen, Technique, Weighted};
use super::waiting::{ShadowRays, Waiting};
use super::{CameraRay, Integrator, RayCounts, Roulette, Sample};
use crate::accel::Hit;
use crate::accel::packet::LANES;
use crate::effects::{Effects, Slot, Switch};
use crate::math::rgb::Rgb;
use crate::sampler::{Decision, Sampler};
use crate::scene::Scene;
use direct_light::{draw_light, sample_light};
use std::slice;

/// The path integrator's choices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PathIntegrator<C = Weighted, K = Traced> {
    /// How it finds light.
    pub technique: C,
    /// What it knows of indirect light.
    pub indirect: K,
    /// Scattering events at most; `None` does not limit them.
    pub max_bounces: Option<u32>,
    /// When paths end by chance.
    pub roulette: Roulette,
}

impl<C: Chosen, K: Indirect> Integrator for PathIntegrator<C, K> {
    const SIDE_BY_SIDE: bool = true;

    fn radiance<E: Effects, S: Sampler, O: PathObserver>(
        &self,
        scene: &Scene,
        sampler: &mut S,
        camera_ray: &CameraRay,
        found: Option<Hit>,
        rays: &mut RayCounts,
        observer: &mut O,
    ) -> Rgb {
        let path = PathState::<E>::new(camera_ray.ray, camera_ray.time);
        rays.camera += 1;
        let waiting = &mut Waiting::default();
        self.follow(scene, sampler, path, found, waiting, rays, observer)
    }

    fn radiances<E: Effects, S: Sampler, O: PathObserver>(
        &self,
        scene: &Scene,
        samples: &mut [Sample<S>],
        waiting: &mut Waiting,
        observer: &mut O,
    ) {
        let begin = |sample: &mut Sample<S>| {
            sample.rays.camera += 1;
            let CameraRay { ray, time } = sample.camera_ray;
            PathState::<E>::new(ray, time)
        };
        let mut paths: Vec<PathState<E>> = samples.iter_mut().map(begin).collect();
        self.follow_all(scene, samples, &mut paths, waiting, observer);
        for (sample, path) in samples.iter_mut().zip(paths) {
            sample.radiance = path.radiance;
        }
    }
}

impl<C: Chosen, K: Indirect> PathIntegrator<C, K> {
    /// One estimate of the radiance along the ray of a path, given what is found on it.
    #[expect(
        clippy::too_many_arguments,
        reason = "a path, its surroundings, and all that it may tell of"
    )]
    pub fn follow<E: Effects, S: Sampler, O: PathObserver>(
        &self,
        scene: &Scene,
        sampler: &S,
        mut path: PathState<E>,
        found: Option<Hit>,
        waiting: &mut Waiting,
        rays: &mut RayCounts,
        observer: &mut O,
    ) -> Rgb {
        let (ray, time) = (path.ray, path.time.or(0.0));
        let mut sample = Sample::new(sampler.clone(), CameraRay { ray, time });
        sample.found = found;
        let (samples, paths) = (slice::from_mut(&mut sample), slice::from_mut(&mut path));
        self.follow_all(scene, samples, paths, waiting, observer);
        *rays += sample.rays;
        path.radiance
    }

    /// Follows the paths of some samples side by side, all of which have scattered as often, to their ends.
    fn follow_all<E: Effects, S: Sampler, O: PathObserver>(
        &self,
        scene: &Scene,
        samples: &mut [Sample<S>],
        paths: &mut [PathState<E>],
        waiting: &mut Waiting,
        observer: &mut O,
    ) {
        let Waiting {
            shadows,
            onward,
            going,
            chosen,
        } = waiting;
        chosen.clear();
        chosen.resize(paths.len(), None);
        going.clear();
        going.extend(0..paths.len());
        let mut hits = [None; LANES];
        // What comes from a surface has been scattered there.
        let is_scattered = |path: &PathState<E>| path.departure.is_some();
        let first = u32::from(paths.first().is_some_and(is_scattered));
        for bounce in first.. {
            onward.clear();
            going.retain(|&number| {
                let (path, sample) = (&mut paths[number], &mut samples[number]);
                let chosen = &mut chosen[number];
                let goes_on = self.step(
                    scene, number, path, sample, chosen, bounce, shadows, observer,
                );
                if goes_on {
                    onward.push(&path.ray, path.time.or(0.0), path.departure);
                }
                goes_on
            });
            shadows.trace::<E, O>(scene, observer, |number, light| {
                paths[number].radiance += light;
            });
            if onward.is_empty() {
                break;
            }
            for (rays, numbers) in onward.packets_mut().iter_mut().zip(going.chunks(LANES)) {
                scene.accel.intersect_packet(rays, false, &mut hits);
                for (&number, found) in numbers.iter().zip(&hits) {
                    samples[number].found = *found;
                }
            }
        }
    }

    /// What a path does where its ray has come to; whether it goes on. Rays to lights are left to be traced.
    #[expect(
        clippy::too_many_arguments,
        reason = "a path, its surroundings, and all that it may tell of"
    )]
    #[inline(always)]
    fn step<E: Effects, S: Sampler, O: PathObserver>(
        &self,
        scene: &Scene,
        number: usize,
        path: &mut PathState<E>,
        sample: &mut Sample<S>,
        chosen: &mut Option<u32>,
        bounce: u32,
        shadows: &mut ShadowRays,
        observer: &mut O,
    ) -> bool {
        let technique = self.technique.technique();
        let (sampler, found, rays) = (&mut sample.sampler, sample.found, &mut sample.rays);
        let time = path.time.or(0.0);
        let u_alpha = draw_alpha::<E, S>(sampler, bounce);
        let Some(at) = scene.meet::<E>(&path.ray, time, path.departure, u_alpha, found) else {
            observer.escaped(path.ray.dir);
            let contribution = path.beta * beyond(scene, path, technique, *chosen);
            path.radiance += contribution;
            observer.environment(contribution);
            return false;
        };
        observer.arrived(&at, path.beta);

        // Emission, in the light of how else it could have been found.
        let emitted = scene.emitted(&at);
        let coin = toss::<S>(technique, emitted, sampler, bounce);
        if let Some(emitted) = emitted {
            let weight = path.weight_of_scattering(
                technique,
                |from| scene.light_pdf(from, time, &at),
                || chosen.is_some() && scene.light_of(&at) == *chosen,
            );
            let contribution = path.beta * emitted * (weight * coin.taken);
            observer.emission(contribution, weight);
            path.radiance += contribution;
        }
        if coin.ends || self.max_bounces.is_some_and(|limit| bounce >= limit) {
            observer.absorbed();
            return false;
        }
        path.beta *= coin.left;

        if scene.is_dark(&at) {
            observer.absorbed();
            return false;
        }
        let bsdf = scene.surface(&at);
        let is_limited = self.max_bounces.is_some();
        let known = self.indirect.reflected(&at, &bsdf, bounce, is_limited);
        let lighting = match known {
            // No ray is scattered that could find a light.
            Some(_) => technique.by_lights_alone(),
            None => technique,
        };
        let wo = at.frame.to_local(at.wo);
        let seen = bsdf.seen_from::<E>(wo);
        if technique.samples_lights() && !bsdf.is_delta::<E>() && !scene.lights.is_empty() {
            let (u, u_choice) = draw_light::<E, S>(sampler, bounce);
            let choice = scene.lights.choose::<E>(u_choice);
            *chosen = choice.map(|(light, _)| light);
            if let Some(choice) = choice
                && let Some(light) = sample_light(scene, &at, time, &seen, lighting, choice, u)
            {
                rays.shadow += 1;
                observer.traced(RayKind::Shadow, &light.ray, time);
                shadows.push(
                    number,
                    path.beta * light.contribution,
                    light.weight,
                    &light.ray,
                    time,
                );
                if O::ONE_BY_ONE {
                    shadows.trace::<E, O>(scene, observer, |_, light| path.radiance += light);
                }
            } else {
                observer.unlit();
            }
        }

        if let Some(known) = known {
            let contribution = path.beta * known;
            observer.known(contribution);
            path.radiance += contribution;
            return false;
        }

        // Onward.
        let u = sampler.draw(Decision::Bsdf(bounce));
        let Some(sample) = sample_direction::<E>(&bsdf, &seen, technique, u) else {
            observer.absorbed();
            return false;
        };
        let wi = at.frame.to_world(sample.wi);
        // A shading normal can promise what the surface cannot keep: light leaking through it.
        let goes_through = E::Transmission::ON && sample.lobe.is_transmission();
        if !at.agrees(wi, goes_through) {
            observer.absorbed();
            return false;
        }
        path.beta *= sample.weight;
        observer.scattered(wi, sample.lobe, path.beta);

        let mut reflected = sample.weight;
        if goes_through {
            reflected *= path.refract(bsdf.ior(), wo.z > 0.0);
        }
        let left = path.eta_scale.or(1.0) * path.beta;
        let survival = self.roulette.survival(bounce, reflected, left);
        if survival < 1.0 && !path.survives(survival, bounce, sampler) {
            observer.terminated(survival);
            return false;
        }
        path.leave(scene, &at, wi, sample.pdf, goes_through);
        rays.closest += 1;
        let kind = RayKind::onward(bounce, path.scattered_from.is_none());
        observer.traced(kind, &path.ray, time);
        true
    }
}

/// The number that decides where a surface is only partly there.
#[inline(always)]
fn draw_alpha<E: Effects, S: Sampler>(sampler: &mut S, bounce: u32) -> f32 {
    if !E::Alpha::ON {
        return 0.0;
    }
    let [u] = sampler.draw(Decision::Alpha(bounce));
    u
}

/// Radiance from beyond the scene along the path's ray.
#[inline]
fn beyond<E: Effects>(
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
        && let Some(beyond) = scene.lights.beyond(path.ray.dir)
    {
        let is_chosen = || Some(beyond.light) == chosen;
        radiance +=
            beyond.radiance * path.weight_of_scattering(technique, |_| beyond.pdf, is_chosen);
    }
    radiance
}
