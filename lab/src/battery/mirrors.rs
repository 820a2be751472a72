//! Many successive reflections: the remaining radiance and the direction.
//!
//! Measure: radiance; cosines.
//! Range: up to 100 reflections.
//! Source: products of reflectances; three mirrors at right angles reverse a direction. Tested in
//! `lab/tests/reports/battery.rs`.

use super::case::{Case, Effort, Trial};
use super::claim::Claim;
use super::patch::{PatchSettings, bounces, patch_scene, ready};
use crate::bench::random::Random;
use crate::scene_builder::{mirror, rectangle, sky, surface};
use etendue::Result;
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::integrator::Roulette;
use etendue::internals::math::ray::Ray;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DAffine3, DVec3, Vec2, Vec3};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::SceneDescription;

/// Every case.
pub fn cases(_: Effort) -> Vec<Case> {
    let kept = [1, 10, 100].map(|reflections: i32| {
        // 0.99 as in the catalogue, in double precision.
        let claim = Claim::without_noise(0.99_f64.powi(reflections), 1e-5);
        let name = format!("{reflections} reflections of 0.99 between facing mirrors");
        let patch = PatchSettings {
            spp: 16,
            max_bounces: None,
            roulette: Roulette::None,
        };
        Case::seen(14, name, claim, corridor(f64::from(reflections)), patch)
    });
    let short = Case::seen(
        14,
        "100 facing mirrors with a limit of 99 bounces",
        Claim::exactly(0.0),
        corridor(100.0),
        bounces(99, 16),
    );
    let turn = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    // Along the axes the tangent frames are exact; for the turned cube, vertices and normals are rounded.
    let cubes = [
        ("along the axes", DAffine3::IDENTITY, 4.0),
        ("turned", turn, 16.0),
    ];
    let cubes = cubes.map(|(name, place, ulps)| {
        let name = format!("coordinates that a corner cube {name} turns by more than {ulps} ulp");
        Case::new(14, name, Claim::exactly(0.0), move |trial| {
            let allowed = ulps * f32::EPSILON / 2.0;
            Ok(vec![turned_wrongly(trial, place, allowed)?])
        })
    });
    kept.into_iter().chain([short]).chain(cubes).collect()
}

/// Two mirrors that face each other at z = 0 and z = 1, from x = -1 to `end`, viewed along x at 45 degrees: the k-th
/// reflection is at x = k - 1/2.
fn corridor(end: f64) -> SceneDescription {
    let eye = DVec3::new(0.0, 0.0, 0.5);
    let mut scene = patch_scene(eye, DVec3::new(0.5, 0.0, 0.0), mirror(0.99));
    let wall = |z: f64| rectangle([-1.0, -1.0, z], [end + 1.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    scene.shapes = vec![surface(wall(0.0), 0.0), surface(wall(1.0), 0.0)];
    scene.lights = vec![sky(Rgb::WHITE)];
    scene
}

/// Traces a ray through its reflections: its final direction and the number of reflections; `None` if it does not leave
/// the mirrors.
fn follow(scene: &Scene, mut ray: Ray) -> Option<(Vec3, u32)> {
    let mut excluded = None;
    for bounces in 0..100 {
        let Some(at) = scene.intersect::<Everything>(&ray, 0.0, excluded, 0.5) else {
            return Some((ray.dir, bounces));
        };
        let bsdf = scene.bsdf_of_side(&at)?;
        let wo = at.frame.to_local(at.wo);
        let sample = bsdf.sample::<Everything>(wo, 0.5, Vec2::splat(0.5))?;
        let wi = at.frame.to_world(sample.wi);
        let (next, leaves) = scene.spawn(&at, 0.0, wi, false);
        (ray, excluded) = (next, Some(leaves));
    }
    None
}

/// Counts the wrong coordinates of directions after three reflections, over a thousand rays; all coordinates count if
/// fewer than half of the rays hit three mirrors.
fn turned_wrongly(trial: &Trial<'_>, place: DAffine3, allowed: f32) -> Result<f64> {
    const RAYS: u32 = 1000;
    let mut scene = patch_scene(DVec3::splat(3.0), DVec3::ZERO, mirror(1.0));
    let (x, y, z) = ([2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]);
    for (u, v) in [(x, y), (y, z), (z, x)] {
        let mut wall = surface(rectangle([0.0; 3], u, v), 0.0);
        wall.transform = place;
        scene.shapes.push(wall);
    }
    let scene = ready(trial, &scene)?;
    let mut random = Random::new(trial.seed, 0);
    let (mut thrice, mut wrong) = (0, 0);
    for _ in 0..RAYS {
        let mut within = |size: f64| DVec3::from_array([0; 3].map(|_| random.between(0.1, size)));
        let (from, to) = (within(0.6), within(0.9));
        let origin = scene.normalisation.point(place.transform_point3(from));
        let dir = place.transform_vector3(-to.normalize()).as_vec3a();
        if let Some((out, 3)) = follow(&scene, Ray::new(origin, dir)) {
            thrice += 1;
            let apart = (out + dir).abs().to_array();
            wrong += apart.iter().filter(|&&apart| apart > allowed).count() as u32;
        }
    }
    Ok(f64::from(if 2 * thrice > RAYS { wrong } else { 3 * RAYS }))
}
