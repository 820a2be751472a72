//! Light that is looked for at the surfaces of paths, and the rays that tell whether it is visible.
//!
//! Measure: radiance; normalised scene units.
//! Range: any light and surface; as many rays together as a packet has.
//! Source: next event estimation, Veach 1997, section 8.2. Tested in `battery/` and `tests/rendering/integrators.rs`.

use super::super::technique::{LightRule, Technique};
use crate::bsdf::View;
use crate::effects::{Effects, Switch};
use crate::math::measure::Pmf;
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::planted::planted;
use crate::sampler::{Decision, Sampler};
use crate::scene::Scene;
use crate::scene::interaction::Interaction;

/// The numbers that choose a point on a light and, where there are several, the light.
#[inline]
pub(super) fn draw_light<E: Effects, S: Sampler>(sampler: &mut S, bounce: u32) -> (Vec2, [f32; 2]) {
    if E::ManyLights::ON {
        let [u, v, u_choice, v_choice] = sampler.draw(Decision::Light(bounce));
        return (Vec2::new(u, v), [u_choice, v_choice]);
    }
    let u = sampler.draw(Decision::Light(bounce));
    (Vec2::from_array(u), [0.0; 2])
}

/// What light sampling found at a surface, if nothing is in the way.
pub(super) struct DirectLight {
    /// f |cos| Le / p_light, times the weight.
    pub(super) contribution: Rgb,
    pub(super) weight: f32,
    /// To the light.
    pub(super) ray: Ray,
}

/// One point on one light, weighted against the chance that the BSDF finds it.
#[inline]
pub(super) fn sample_light<E: Effects>(
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
