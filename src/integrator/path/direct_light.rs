//! Next event estimation at the surfaces of paths: light samples, and the shadow rays that test their visibility.
//!
//! Measure: radiance; normalised scene units.
//! Range: any light and surface.
//! Source: next event estimation, Veach 1997, section 8.2. Tested in `battery/` and `tests/rendering/integrators.rs`.

use super::super::indirect::Indirect;
use super::super::observer::{PathObserver, RayKind};
use super::super::technique::{LightRule, Technique, TechniqueSource};
use super::queues::PathQueues;
use super::shading_context::ShadingContext;
use super::{PathIntegrator, Paths};
use crate::bsdf::BoundBsdf;
use crate::effects::{Effects, Slot, Switch};
use crate::light::types::{LightSample, LightSampleContext};
use crate::math::lanes::LANES;
use crate::math::measure::Pmf;
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::planted::planted;
use crate::sampler::{Decision, Sampler};
use crate::scene::Scene;
use crate::scene::interaction::Interaction;

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Samples one light at the surface of each path, and queues the shadow rays.
    pub(super) fn sample_direct_light<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        paths: &mut Paths<'_, E, S, O>,
        interactions: &[Interaction<E>],
        shading: &[ShadingContext<'_>],
    ) {
        let (scene, technique) = (paths.scene, self.technique.technique());
        if !technique.samples_lights() || scene.lights.is_empty() {
            return;
        }
        let PathQueues {
            active,
            chosen,
            nee_paths,
            light_u,
            light_contexts,
            samples,
            shadow_rays,
            ..
        } = &mut *paths.queues;
        let all = active.iter().zip(interactions).zip(shading);
        let all_nee = all.filter(|(_, shading)| shading.samples_lights);

        nee_paths.clear();
        nee_paths.extend(all_nee.clone().map(|((path_index, _), _)| *path_index));
        light_u.clear();
        draw_light_u::<E, S>(paths.samplers, nee_paths, paths.bounce, light_u);

        let mut asking = all_nee.clone();
        let mut answered = all_nee;
        for numbers in light_u.chunks(LANES) {
            light_contexts.clear();
            for (&numbers, ((path_index, at), _)) in numbers.iter().zip(asking.by_ref()) {
                let time = paths.states[*path_index].time.or(0.0);
                let light_context = light_context(scene, at, time, numbers);
                chosen[*path_index] = Some(light_context.light);
                light_contexts.push(light_context);
            }
            scene.sample_lights::<E>(light_contexts, technique.points, samples);

            let light_samples = light_contexts.iter().zip(&*samples);
            for ((light_context, light), ((&path_index, at), shading)) in
                light_samples.zip(answered.by_ref())
            {
                let lighting = match shading.cached_indirect {
                    // The path ends here: no scattered ray can hit a light.
                    Some(_) => technique.by_lights_alone(),
                    None => technique,
                };
                let found = light.as_ref().and_then(|light| {
                    reflected(at, &shading.view, lighting, light_context.pmf, light)
                });
                let Some(found) = found else {
                    paths.observer.unlit();
                    continue;
                };
                let (path, time) = (&mut paths.states[path_index], light_context.time);
                paths.samples[path_index].rays.shadow += 1;
                paths.observer.traced(RayKind::Shadow, &found.ray, time);
                let contribution = path.beta * found.contribution;
                shadow_rays.push(path_index, contribution, found.weight, &found.ray, time);
                if paths.observer.is_sequential() {
                    shadow_rays
                        .trace::<E, O>(scene, paths.observer, |_, light| path.radiance += light);
                }
            }
        }
    }
}

/// Draws the random numbers that choose a point on a light and, where there are several lights, the light.
#[inline]
fn draw_light_u<E: Effects, S: Sampler>(
    samplers: &mut [S],
    places: &[usize],
    bounce: u32,
    numbers: &mut Vec<[f32; 4]>,
) {
    let decision = Decision::Light(bounce);
    if E::ManyLights::ON {
        S::draw_each(samplers, places, decision, |u| numbers.push(u));
    } else {
        S::draw_each(samplers, places, decision, |[u, v]| {
            numbers.push([u, v, 0.0, 0.0]);
        });
    }
}

/// Builds the input of light sampling at a surface, from numbers that choose a point on the light and the light.
#[inline]
fn light_context<E: Effects>(
    scene: &Scene,
    at: &Interaction<E>,
    time: f32,
    [u, v, choice @ ..]: [f32; 4],
) -> LightSampleContext {
    let choice = scene.lights.choose::<E>(choice);
    let (light, pmf) = choice.expect("there are lights, or nobody would look");
    LightSampleContext {
        light,
        pmf,
        p: at.p,
        time,
        u: Vec2::new(u, v),
    }
}

/// The result of light sampling at a surface, before its visibility is known.
struct DirectLight {
    /// The contribution f |cos| Le / p_light, times the MIS weight.
    contribution: Rgb,
    weight: f32,
    /// The shadow ray.
    ray: Ray,
}

/// Computes the reflected light from one point on one light, weighted against BSDF sampling.
#[inline]
fn reflected<E: Effects>(
    at: &Interaction<E>,
    shading: &BoundBsdf,
    technique: Technique,
    pmf: Pmf,
    light: &LightSample,
) -> Option<DirectLight> {
    if light.radiance.is_black() {
        return None;
    }
    let wi = at.frame.to_local(light.wi);
    // Reflection or transmission in the shading frame must be the same at the geometric surface.
    let goes_through = wi.z * shading.wo().z < 0.0;
    if !at.agrees(light.wi, goes_through) {
        return None;
    }
    let value = shading.eval::<E>(wi);
    if value.f.is_black() {
        return None;
    }
    let (weight, over_pdf) = match light.pdf {
        Some(pdf) if technique.lights == LightRule::PartitionedLights => (1.0, pmf.0 / pdf.0),
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
