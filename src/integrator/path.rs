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

use super::indirect::{Indirect, Traced};
use super::observer::{PathObserver, RayKind};
use super::steps::{sample_direction, toss};
use super::technique::{Chosen, LightRule, Technique, Weighted};
use super::{CameraRay, Integrator, RayCounts, Roulette};
use crate::accel::{Departure, Hit};
use crate::bsdf::View;
use crate::effects::{Effects, Slot, State, Switch};
use crate::math::measure::{PdfSolidAngle, Pmf};
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3};
use crate::planted::planted;
use crate::sampler::{Decision, Sampler};
use crate::scene::Scene;
use crate::scene::interaction::Interaction;

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

/// A path under construction, with what the effects `E` need of it.
#[derive(Debug, Clone, Copy)]
pub struct PathState<E: Effects> {
    /// The ray onward.
    pub ray: Ray,
    /// What the ray leaves.
    pub departure: Option<Departure>,
    /// When, from 0 to 1 while the shutter is open.
    pub time: State<E::Motion, f32>,
    /// What radiance along the ray counts.
    pub beta: Rgb,
    /// What has been found.
    pub radiance: Rgb,
    /// Radiance is thinned by eta^2 inside glass and restored on the way out: no reason to end a path.
    pub eta_scale: State<E::Transmission, f32>,
    /// Where the path scattered last, and with which density; `None` from the camera and from delta lobes.
    pub scattered_from: Option<(Vec3, PdfSolidAngle)>,
}

impl<E: Effects> PathState<E> {
    /// A path that begins with a camera ray.
    #[inline]
    pub fn new(ray: Ray, time: f32) -> Self {
        Self {
            ray,
            departure: None,
            time: Slot::new(|| time),
            beta: Rgb::WHITE,
            radiance: Rgb::BLACK,
            eta_scale: Slot::new(|| 1.0),
            scattered_from: None,
        }
    }

    /// Multiplies the throughput that roulette goes by, on the way through a surface of index `eta`, inside over outside,
    /// and tells the factor.
    #[inline]
    fn refract(&mut self, eta: f32, enters: bool) -> f32 {
        let eta = if enters { eta } else { 1.0 / eta };
        self.eta_scale.update(|scale| scale * eta * eta);
        eta * eta
    }

    /// Whether it goes on, with probability `survival`: then its throughput makes up for those that end here.
    #[inline]
    fn survives<S: Sampler>(&mut self, survival: f32, bounce: u32, sampler: &mut S) -> bool {
        let decision = planted!(
            "roulette-takes-a-spent-number",
            Decision::Bsdf(bounce),
            Decision::Roulette(bounce)
        );
        let [u] = sampler.draw(decision);
        if u >= survival {
            return false;
        }
        let lifted = planted!("roulette-on-radiance", &mut self.radiance, &mut self.beta);
        *lifted *= planted!("roulette-without-division", 1.0, 1.0 / survival);
        true
    }

    /// Adds what light sampling found, as far as nothing is in the way.
    #[inline(always)]
    fn add_light<O: PathObserver>(
        &mut self,
        scene: &Scene,
        light: &DirectLight,
        rays: &mut RayCounts,
        observer: &mut O,
    ) {
        let time = self.time.or(0.0);
        rays.shadow += 1;
        observer.traced(RayKind::Shadow, &light.ray, time);
        let then = planted!("shadows-as-the-shutter-opens", 0.0, time);
        let visible = scene.visibility::<E>(&light.ray, then);
        observer.light(self.beta * light.contribution, light.weight, visible);
        if visible > 0.0 {
            self.radiance += self.beta * light.contribution * visible;
        }
    }

    /// Sends it on from a surface along `wi`, which was found with density `pdf`.
    #[inline(always)]
    fn leave(
        &mut self,
        scene: &Scene,
        at: &Interaction<E>,
        wi: Vec3,
        pdf: Option<PdfSolidAngle>,
        goes_through: bool,
    ) {
        let forgotten = planted!(
            "mirror-weighted-as-what-it-shows",
            self.scattered_from,
            None
        );
        self.scattered_from = pdf.map(|p_bsdf| (at.p, p_bsdf)).or(forgotten);
        let (ray, departure) = scene.spawn(at, self.time.or(0.0), wi, goes_through);
        (self.ray, self.departure) = (ray, Some(departure));
    }

    /// The weight of light found by scattering, where light sampling finds it with density `p_light`.
    #[inline]
    fn weight_of_scattering(
        &self,
        technique: Technique,
        p_light: impl FnOnce(Vec3) -> PdfSolidAngle,
        is_chosen: impl FnOnce() -> bool,
    ) -> f32 {
        match self.scattered_from {
            Some((from, p_bsdf)) => {
                technique.weight_of_scattering(p_bsdf, || p_light(from), is_chosen)
            }
            None => 1.0,
        }
    }
}

impl<C: Chosen, K: Indirect> Integrator for PathIntegrator<C, K> {
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
        self.follow(scene, sampler, path, found, rays, observer)
    }
}

impl<C: Chosen, K: Indirect> PathIntegrator<C, K> {
    /// One estimate of the radiance along the ray of a path, given what is found on it.
    pub fn follow<E: Effects, S: Sampler, O: PathObserver>(
        &self,
        scene: &Scene,
        sampler: &mut S,
        mut path: PathState<E>,
        mut found: Option<Hit>,
        rays: &mut RayCounts,
        observer: &mut O,
    ) -> Rgb {
        let technique = self.technique.technique();
        // The light that the last surface looked for, where that matters.
        let mut chosen = None;
        // What comes from a surface has been scattered there.
        let first = u32::from(path.departure.is_some());
        for bounce in first.. {
            let time = path.time.or(0.0);
            let u_alpha = draw_alpha::<E, S>(sampler, bounce);
            let Some(at) = scene.meet::<E>(&path.ray, time, path.departure, u_alpha, found) else {
                observer.escaped(path.ray.dir);
                let contribution = path.beta * beyond(scene, &path, technique, chosen);
                path.radiance += contribution;
                observer.environment(contribution);
                break;
            };
            observer.arrived(&at, path.beta);

            // Emission, in the light of how else it could have been found.
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
            if coin.ends || self.max_bounces.is_some_and(|limit| bounce >= limit) {
                observer.absorbed();
                break;
            }
            path.beta *= coin.left;

            let Some(bsdf) = scene.bsdf(&at) else {
                observer.absorbed();
                break;
            };
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
                chosen = choice.map(|(light, _)| light);
                if let Some(choice) = choice
                    && let Some(light) = sample_light(scene, &at, time, &seen, lighting, choice, u)
                {
                    path.add_light(scene, &light, rays, observer);
                } else {
                    observer.unlit();
                }
            }

            if let Some(known) = known {
                let contribution = path.beta * known;
                observer.known(contribution);
                path.radiance += contribution;
                break;
            }

            // Onward.
            let u = sampler.draw(Decision::Bsdf(bounce));
            let Some(sample) = sample_direction::<E>(&bsdf, &seen, technique, u) else {
                observer.absorbed();
                break;
            };
            let wi = at.frame.to_world(sample.wi);
            // A shading normal can promise what the surface cannot keep: light leaking through it.
            let goes_through = E::Transmission::ON && sample.lobe.is_transmission();
            if !at.agrees(wi, goes_through) {
                observer.absorbed();
                break;
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
                break;
            }
            path.leave(scene, &at, wi, sample.pdf, goes_through);
            rays.closest += 1;
            let kind = RayKind::onward(bounce, path.scattered_from.is_none());
            observer.traced(kind, &path.ray, time);
            found = scene.accel.intersect(&path.ray, time, path.departure);
        }
        path.radiance
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

/// The numbers that choose a point on a light and, where there are several, the light.
#[inline]
fn draw_light<E: Effects, S: Sampler>(sampler: &mut S, bounce: u32) -> (Vec2, [f32; 2]) {
    if E::ManyLights::ON {
        let [u, v, u_choice, v_choice] = sampler.draw(Decision::Light(bounce));
        return (Vec2::new(u, v), [u_choice, v_choice]);
    }
    let u = sampler.draw(Decision::Light(bounce));
    (Vec2::from_array(u), [0.0; 2])
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

/// What light sampling found at a surface, if nothing is in the way.
struct DirectLight {
    /// f |cos| Le / p_light, times the weight.
    contribution: Rgb,
    weight: f32,
    /// To the light.
    ray: Ray,
}

/// One point on one light, weighted against the chance that the BSDF finds it.
#[inline]
fn sample_light<E: Effects>(
    scene: &Scene,
    at: &Interaction<E>,
    time: f32,
    seen: &View,
    technique: Technique,
    choice: (u32, Pmf),
    u: Vec2,
) -> Option<DirectLight> {
    let light = scene.sample_light::<E>(choice, technique.points, at.p, time, u)?;
    if light.radiance.is_black() {
        return None;
    }
    let wi = at.frame.to_local(light.wi);
    // Reflection in the shading frame has to be reflection at the true surface.
    let goes_through = wi.z * seen.wo().z < 0.0;
    if !at.agrees(light.wi, goes_through) {
        return None;
    }
    let value = seen.eval::<E>(wi);
    if value.f.is_black() {
        return None;
    }
    let (weight, over_pdf) = match light.pdf {
        Some(pdf) if technique.lights == LightRule::OneAndRest => (1.0, choice.1.0 / pdf.0),
        Some(pdf) => (technique.weight_of_light(pdf, value.pdf), 1.0 / pdf.0),
        None => (1.0, 1.0),
    };
    let cos = planted!("light-without-cosine", 1.0, wi.z.abs());
    Some(DirectLight {
        contribution: value.f * light.radiance * (cos * weight * over_pdf),
        weight,
        ray: at.ray_to(&light.end, light.wi, goes_through),
    })
}
