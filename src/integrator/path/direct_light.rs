//! Light that is looked for at the surfaces of paths, and the rays that tell whether it is visible.
//!
//! Measure: radiance; normalised scene units.
//! Range: any light and surface.
//! Source: next event estimation, Veach 1997, section 8.2. Tested in `battery/` and `tests/rendering/integrators.rs`.

use super::super::indirect::Indirect;
use super::super::observer::{PathObserver, RayKind};
use super::super::technique::{Chosen, LightRule, Technique};
use super::super::waiting::Waiting;
use super::seen::Seen;
use super::{PathIntegrator, Paths};
use crate::bsdf::View;
use crate::effects::{Effects, Slot, Switch};
use crate::light::types::{LightQuestion, LightSample};
use crate::math::lanes::LANES;
use crate::math::measure::Pmf;
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::planted::planted;
use crate::sampler::{Decision, Sampler};
use crate::scene::Scene;
use crate::scene::interaction::Interaction;

impl<C: Chosen, K: Indirect> PathIntegrator<C, K> {
    /// Looks for one light where each path is, and leaves the rays to them to be traced.
    pub(super) fn look_for_lights<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        paths: &mut Paths<'_, E, S, O>,
        arrivals: &[Interaction<E>],
        seen: &[Seen<'_>],
    ) {
        let (scene, technique) = (paths.scene, self.technique.technique());
        if !technique.samples_lights() || scene.lights.is_empty() {
            return;
        }
        let Waiting {
            going,
            chosen,
            looking,
            light_numbers,
            questions,
            samples,
            shadows,
            ..
        } = &mut *paths.waiting;
        let all = going.iter().zip(arrivals).zip(seen);
        let all_that_look = all.filter(|(_, seen)| seen.looks);

        looking.clear();
        looking.extend(all_that_look.clone().map(|((number, _), _)| *number));
        light_numbers.clear();
        draw_lights::<E, S>(paths.samplers, looking, paths.bounce, light_numbers);

        let mut asking = all_that_look.clone();
        let mut answered = all_that_look;
        for numbers in light_numbers.chunks(LANES) {
            questions.clear();
            for (&numbers, ((number, at), _)) in numbers.iter().zip(asking.by_ref()) {
                let time = paths.states[*number].time.or(0.0);
                let question = question(scene, at, time, numbers);
                chosen[*number] = Some(question.light);
                questions.push(question);
            }
            scene.sample_lights::<E>(questions, technique.points, samples);

            let answers = questions.iter().zip(&*samples);
            for ((question, light), ((&number, at), seen)) in answers.zip(answered.by_ref()) {
                let lighting = match seen.known {
                    // No ray is scattered that could find a light.
                    Some(_) => technique.by_lights_alone(),
                    None => technique,
                };
                let found = light
                    .as_ref()
                    .and_then(|light| reflected(at, &seen.view, lighting, question.pmf, light));
                let Some(found) = found else {
                    paths.observer.unlit();
                    continue;
                };
                let (path, time) = (&mut paths.states[number], question.time);
                paths.samples[number].rays.shadow += 1;
                paths.observer.traced(RayKind::Shadow, &found.ray, time);
                let contribution = path.beta * found.contribution;
                shadows.push(number, contribution, found.weight, &found.ray, time);
                if paths.observer.is_sequential() {
                    shadows.trace::<E, O>(scene, paths.observer, |_, light| path.radiance += light);
                }
            }
        }
    }
}

/// Draws the numbers that choose a point on a light and, where there are several, the light.
#[inline]
fn draw_lights<E: Effects, S: Sampler>(
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

/// What is asked at a surface, by numbers that choose a point on a light and the light.
#[inline]
fn question<E: Effects>(
    scene: &Scene,
    at: &Interaction<E>,
    time: f32,
    [u, v, choice @ ..]: [f32; 4],
) -> LightQuestion {
    let choice = scene.lights.choose::<E>(choice);
    let (light, pmf) = choice.expect("there are lights, or nobody would look");
    LightQuestion {
        light,
        pmf,
        p: at.p,
        time,
        u: Vec2::new(u, v),
    }
}

/// What light sampling found at a surface, if nothing is in the way.
struct DirectLight {
    /// f |cos| Le / p_light, times the weight.
    contribution: Rgb,
    weight: f32,
    /// To the light.
    ray: Ray,
}

/// What a surface reflects of one point on one light, weighted against the chance that the BSDF finds it.
#[inline]
fn reflected<E: Effects>(
    at: &Interaction<E>,
    seen: &View,
    technique: Technique,
    pmf: Pmf,
    light: &LightSample,
) -> Option<DirectLight> {
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
        Some(pdf) if technique.lights == LightRule::OneAndRest => (1.0, pmf.0 / pdf.0),
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
