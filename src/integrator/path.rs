//! Path tracing with next event estimation, multiple importance sampling and Russian roulette.
//!
//! The radiance along a ray is the sum over paths x_0 x_1 ... x_k from the eye to a light,
//!
//!   L = sum_k  beta_k [ w_bsdf Le(x_k) + w_light f(x_k) |cos| Le(y) V(x_k, y) / p_light(y) ],
//!   beta_k = prod_{j<k} f(x_j) |cos| / p_bsdf / q_j,
//!
//! where each way of reaching a light is weighted by the power heuristic of both densities, and q_j is the probability
//! of surviving the roulette. Delta lobes cannot be found by light sampling, nor can the constant environment, which is
//! not a light that one samples: there w_bsdf = 1.
//!
//! Measure: radiance; densities per steradian.
//! Range: any scene; without a bounce limit a path ends by absorption, by leaving, or by roulette.
//! Source: Kajiya 1986; Veach 1997, sections 8.3, 9.2 and 10.4.1. Tested in `tests/closed_forms.rs` and
//! `tests/furnace.rs`.

use super::observer::PathObserver;
use super::{RayCounts, Roulette};
use crate::bsdf::Bsdf;
use crate::math::measure::PdfSolidAngle;
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::sampler::{Decision, Sampler};
use crate::sampling::mis::power_heuristic;
use crate::scene::Scene;
use crate::scene::interaction::Interaction;

/// The path integrator's choices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PathIntegrator {
    /// Scattering events at most; `None` does not limit them.
    pub max_bounces: Option<u32>,
    /// When paths end by chance.
    pub roulette: Roulette,
}

impl PathIntegrator {
    /// One estimate of the radiance that arrives along `ray`.
    pub fn radiance<S: Sampler, O: PathObserver>(
        &self,
        scene: &Scene,
        sampler: &mut S,
        mut ray: Ray,
        rays: &mut RayCounts,
        observer: &mut O,
    ) -> Rgb {
        let mut radiance = Rgb::BLACK;
        let mut beta = Rgb::WHITE;
        // Radiance is thinned by eta^2 inside glass and restored on the way out: no reason to end a path.
        let mut eta_scale = 1.0;
        // Where the path scattered last, and with which density; `None` from the camera and from delta lobes.
        let mut scattered_from: Option<(Interaction, PdfSolidAngle)> = None;
        let mut departure = None;
        rays.camera += 1;
        for bounce in 0.. {
            let Some(at) = scene.intersect(&ray, departure) else {
                radiance += beta * scene.environment;
                observer.escaped(ray.dir);
                break;
            };
            observer.arrived(&at, beta);

            // Emission, in the light of how else it could have been found.
            if let Some(emitted) = scene.emitted(&at) {
                let weight = match &scattered_from {
                    Some((from, p_bsdf)) => power_heuristic(*p_bsdf, scene.light_pdf(from.p, &at)),
                    None => 1.0,
                };
                observer.emission(beta * emitted * weight, weight);
                radiance += beta * emitted * weight;
            }
            if self.max_bounces.is_some_and(|limit| bounce >= limit) {
                break;
            }

            let bsdf = scene.bsdf(&at);
            if !bsdf.is_delta() && !scene.lights.is_empty() {
                let u = sampler.draw(Decision::Light(bounce));
                if let Some(light) = sample_light(scene, &at, &bsdf, u) {
                    rays.shadow += 1;
                    let visible = !scene.accel.occluded(&light.segment);
                    observer.light(beta * light.contribution, light.weight, visible);
                    if visible {
                        radiance += beta * light.contribution;
                    }
                }
            }

            // Onward by the BSDF.
            let wo = at.frame.to_local(at.wo);
            let [u_lobe, u, v] = sampler.draw(Decision::Bsdf(bounce));
            let Some(sample) = bsdf.sample(wo, u_lobe, Vec2::new(u, v)) else {
                break;
            };
            let wi = at.frame.to_world(sample.wi);
            // A shading normal can promise what the surface cannot keep: light leaking through it.
            if at.is_reflection(wi) == sample.lobe.is_transmission() {
                break;
            }
            beta *= sample.weight;
            observer.scattered(wi, sample.lobe, beta);

            if sample.lobe.is_transmission() {
                let eta = if wo.z > 0.0 {
                    bsdf.ior()
                } else {
                    1.0 / bsdf.ior()
                };
                eta_scale *= eta * eta;
            }
            let survival = self.roulette.survival(bounce, eta_scale * beta);
            if survival < 1.0 {
                let [u] = sampler.draw(Decision::Roulette(bounce));
                if u >= survival {
                    observer.terminated(survival);
                    break;
                }
                beta *= 1.0 / survival;
            }
            scattered_from = sample.pdf.map(|p_bsdf| (at, p_bsdf));
            let (next, left) = scene.spawn(&at, wi);
            (ray, departure) = (next, Some(left));
            rays.closest += 1;
        }
        radiance
    }
}

/// What light sampling found at a surface, if nothing is in the way.
struct DirectLight {
    /// f |cos| Le / p_light, times the weight.
    contribution: Rgb,
    weight: f32,
    segment: Ray,
}

/// One point on one light, weighted against the chance that the BSDF finds it.
#[inline]
fn sample_light(scene: &Scene, at: &Interaction, bsdf: &Bsdf, u: [f32; 4]) -> Option<DirectLight> {
    let light = scene.lights.sample(at.p, u)?;
    if light.radiance.is_black() {
        return None;
    }
    let wi = at.frame.to_local(light.wi);
    let wo = at.frame.to_local(at.wo);
    // Reflection in the shading frame has to be reflection at the true surface.
    if at.is_reflection(light.wi) != (wi.z * wo.z > 0.0) {
        return None;
    }
    let value = bsdf.eval(wo, wi);
    if value.f.is_black() {
        return None;
    }
    let weight = power_heuristic(light.pdf, value.pdf);
    Some(DirectLight {
        contribution: value.f * light.radiance * (wi.z.abs() * weight / light.pdf.0),
        weight,
        segment: at.segment_to(&light.point, light.wi),
    })
}
