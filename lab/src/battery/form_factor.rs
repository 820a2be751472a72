//! The form factor from a flat shape to a light, estimated with the renderer's own light sampling.
//!
//! Measure: the fraction of the radiosity that leaves the first shape of a scene and reaches the second, the light.
//! Range: sixteen replicates, with the number of points given by the effort.
//! Source: F = 1/A integral over points and directions of cos V L / pi. Tested in `lab/tests/reports/battery.rs`.

use super::case::Trial;
use super::patch::ready;
use etendue::Result;
use etendue::internals::accel::{Hit, PrimitiveId};
use etendue::internals::effects::Slot;
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::geometry::surface::SurfacePoint;
use etendue::internals::light::types::{LightChoice, LightSampling};
use etendue::internals::math::ray::Ray;
use etendue::internals::math::vec::{DVec3, Vec2, Vec3};
use etendue::internals::sampler::hash::combine;
use etendue::internals::sampler::{Decision, Sampler, Sobol};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::SceneDescription;
use etendue::internals::scene::interaction::Interaction;
use std::f64::consts::PI;

/// Estimates the form factor, one number per replicate; `point` maps the unit square uniformly onto the first shape.
/// Each replicate uses at least `points` points.
pub fn form_factor(
    trial: &Trial<'_>,
    description: &SceneDescription,
    normal: DVec3,
    (point, points): (fn(f64, f64) -> DVec3, u64),
) -> Result<Vec<f64>> {
    let scene = ready(trial, description)?;
    let points = trial.samples(points);
    let replicate = |replicate: u64| {
        let mut sampler = Sobol::new(combine(trial.seed, replicate));
        let sample = |sample| {
            sampler.start([0, 0], sample);
            let [u, v] = sampler.draw(Decision::Camera);
            let p = scene.normalisation.point(point(f64::from(u), f64::from(v)));
            share(
                &scene,
                p,
                normal.as_vec3a(),
                sampler.draw(Decision::Light(0)),
            )
        };
        (0..points).map(sample).sum::<f64>() / points as f64
    };
    Ok((0..16).map(replicate).collect())
}

/// The contribution of one point of the first shape and one sampled point of the light.
fn share(scene: &Scene, p: Vec3, normal: Vec3, u: [f32; 4]) -> f64 {
    let id = PrimitiveId {
        shape: 0,
        primitive: 0,
    };
    let surface = SurfacePoint {
        p,
        error: Vec3::splat(f32::EPSILON),
        ng: normal,
        ns: normal,
    };
    let from_above = Ray::new(p + normal, -normal);
    let hit = Hit {
        id,
        t: 1.0,
        uv: [0.0; 2],
    };
    let uv = Slot::new(|| Vec2::ZERO);
    let at = Interaction::<Everything>::new(&from_above, &hit, &surface, false, uv);
    let [u, v, u_choice, v_choice] = u;
    let (rule, receiver) = (LightChoice::default(), at.receiver(false));
    let choice = scene
        .lights
        .choose::<Everything>(rule, &receiver, [u_choice, v_choice]);
    let (rules, u) = (LightSampling::default(), Vec2::new(u, v));
    let sample = choice.and_then(|c| scene.sample_light::<Everything>(c, rules, p, 0.0, u));
    let Some(sample) = sample else {
        return 0.0;
    };
    let shadow_ray = at.ray_to(&sample.end, sample.wi, false);
    if sample.radiance.is_black() || scene.visibility::<Everything>(&shadow_ray, 0.0) <= 0.0 {
        return 0.0;
    }
    let cos = f64::from(sample.wi.dot(normal)).max(0.0);
    let pdf = sample.pdf.map_or(f64::NAN, |pdf| f64::from(pdf.0));
    cos / (pdf * PI)
}
