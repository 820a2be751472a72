//! Multiple scattering: closed rooms whose radiance is a geometric series, and Russian roulette.
//!
//! Measure: radiance.
//! Range: up to a million scattering events.
//! Source: L = Le (1 + rho + rho^2 + ...) in a closed room that emits everywhere; the integrating sphere. Tested in
//! `lab/tests/reports/battery.rs`.

use super::case::{Case, Effort, Trial};
use super::claim::Claim;
use super::closed_forms::parallel_rectangle;
use super::patch::{PatchSettings, bounces, mean, patch_scene, see, see_by, see_exactly};
use crate::scene_builder::{ceiling, diffuse, light, rectangle, sphere, surface};
use etendue::Result;
use etendue::internals::integrator::Roulette;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::DVec3;
use etendue::internals::scene::description::{GeometryDescription, LightModel, SceneDescription};
use std::f64::consts::PI;

/// Every case.
pub fn cases(effort: Effort) -> Vec<Case> {
    [
        grey_furnaces(),
        integrating_spheres(),
        white_rooms(effort),
        roulette(),
        techniques(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A closed box with an emitted radiance of 1 everywhere.
pub fn room(albedo: f32) -> SceneDescription {
    let eye = DVec3::new(0.1, 0.2, 0.3);
    let mut scene = patch_scene(eye, DVec3::new(0.3, 1.0, 0.1), diffuse(albedo));
    let (min, max) = (DVec3::splat(-1.0), DVec3::ONE);
    let mut walls = surface(GeometryDescription::Box { min, max }, 1.0);
    walls.two_sided_emission = true;
    scene.shapes = vec![walls];
    scene
}

/// The radiance in the room after `bounces` scattering events; `None` for the infinite series.
pub fn series(albedo: f64, bounces: Option<u32>) -> f64 {
    let rest = bounces.map_or(0.0, |n| albedo.powf(f64::from(n) + 1.0));
    (1.0 - rest) / (1.0 - albedo)
}

fn grey_furnaces() -> Vec<Case> {
    let table = [
        (Some(0), Roulette::None, 1 << 8),
        (Some(1), Roulette::None, 1 << 9),
        (Some(8), Roulette::None, 1 << 10),
        (Some(8), Roulette::Throughput, 1 << 13),
        (None, Roulette::Throughput, 1 << 13),
    ];
    let case = |(max_bounces, roulette, spp): (Option<u32>, Roulette, u64)| {
        let depth = max_bounces.map_or("without a limit".to_owned(), |d| format!("to depth {d}"));
        let ending = if roulette == Roulette::None {
            ""
        } else {
            ", with roulette"
        };
        let patch = PatchSettings {
            spp,
            max_bounces,
            roulette,
        };
        let name = format!("grey room that emits 1, {depth}{ending}");
        let claim = Claim::mean(series(0.5, max_bounces), 1e-3);
        Case::seen(2, name, claim, room(0.5), patch)
    };
    table.into_iter().map(case).collect()
}

/// A sphere around a point light, whose flux gives the surface the radiance of the series without its first term.
///
/// With a point of flux Phi in the middle of a sphere of radius R, L = rho Phi / (4 pi^2 R^2 (1 - rho)) everywhere.
pub fn integrating_sphere(radius: f64, albedo: f32) -> SceneDescription {
    let eye = radius * DVec3::new(0.2, -0.3, 0.1);
    let mut scene = patch_scene(eye, radius * DVec3::new(0.5, 0.6, 0.7), diffuse(albedo));
    scene.shapes = vec![surface(sphere(DVec3::ZERO, radius), 0.0)];
    scene.lights = vec![light(LightModel::Point {
        position: DVec3::ZERO,
        intensity: Rgb::grey((PI * radius * radius) as f32),
    })];
    scene
}

/// Integrating spheres: without roulette, every path returns the exact sum up to its last bounce.
fn integrating_spheres() -> Vec<Case> {
    let case = |(radius, albedo, max_bounces): (f64, f32, Option<u32>)| {
        let scene = integrating_sphere(radius, albedo);
        let exact = series(f64::from(albedo), max_bounces) - 1.0;
        let (claim, ending, patch) = match max_bounces {
            Some(depth) => (
                Claim::without_noise(exact, 1e-5),
                format!("to depth {depth}"),
                bounces(depth, 16),
            ),
            None => (
                Claim::mean(exact, 1e-3),
                "with roulette".to_owned(),
                PatchSettings {
                    spp: 1 << 14,
                    max_bounces: None,
                    roulette: Roulette::Throughput,
                },
            ),
        };
        let name = format!("integrating sphere of radius {radius:e} and albedo {albedo}, {ending}");
        Case::seen(48, name, claim, scene, patch)
    };
    [
        (1.0, 0.5, None),
        (1.0, 0.5, Some(50)),
        (1e5, 0.5, Some(50)),
        (1.0, 0.9, Some(200)),
    ]
    .map(case)
    .into()
}

/// A room of albedo 0.999: long paths, without roulette.
fn white_rooms(effort: Effort) -> Vec<Case> {
    let albedo = f64::from(0.999_f32);
    let long = |bounces: u32, spp: u64, power: f64, cost: f64| {
        let patch = PatchSettings {
            spp,
            max_bounces: Some(bounces),
            roulette: Roulette::None,
        };
        let name = format!("room of albedo 0.999 that emits 1, {bounces} bounces");
        let claim = Claim::mean(series(albedo, Some(bounces)), power);
        let measure = move |trial: &Trial<'_>| see_exactly(trial, &room(0.999), patch);
        Case::new(49, name, claim, measure).costing(cost)
    };
    match effort {
        Effort::Quick => vec![long(10_000, 4, 1e-3, 1.0)],
        Effort::Full => vec![
            long(10_000, 128, 2e-4, 40.0),
            long(1_000_000, 1, 2e-3, 30.0),
        ],
    }
}

/// The ratio of a render with roulette to one without.
fn roulette() -> Vec<Case> {
    let mut cases = Vec::new();
    for roulette in [Roulette::Throughput, Roulette::Albedo] {
        for (depth, spp) in [(1, 1 << 11), (3, 1 << 12)] {
            let name = format!("roulette by {} over none, to depth {depth}", roulette);
            let measure = move |trial: &Trial<'_>| ratio(trial, roulette, depth, spp);
            cases.push(Case::new(50, name, Claim::mean(1.0, 1e-3), measure));
        }
    }
    cases
}

/// A room with a spherical lamp, so that the radiance is not uniform.
pub fn lit_room() -> SceneDescription {
    let mut scene = room(0.4);
    scene.shapes[0].emission = None;
    let lamp = sphere(DVec3::new(-0.4, 0.3, -0.2), 0.3);
    scene.shapes.push(surface(lamp, 2.0));
    scene
}

fn ratio(trial: &Trial<'_>, roulette: Roulette, depth: u32, spp: u64) -> Result<Vec<f64>> {
    let scene = lit_room();
    let seen = |trial: &Trial<'_>, roulette| {
        let patch = PatchSettings {
            spp,
            max_bounces: Some(depth),
            roulette,
        };
        see(trial, &scene, patch)
    };
    ratio_of(trial, roulette, seen)
}

/// The ratio of the radiance with roulette to that without, replicate by replicate.
pub fn ratio_of(
    trial: &Trial<'_>,
    roulette: Roulette,
    seen: impl Fn(&Trial<'_>, Roulette) -> Result<Vec<f64>>,
) -> Result<Vec<f64>> {
    let off = seen(trial, Roulette::None)?;
    let other = Trial {
        seed: !trial.seed,
        ..*trial
    };
    let on = seen(&other, roulette)?;
    let mean = mean(&off);
    // Equal to the ratio of the means to first order.
    let pairs = on.iter().zip(&off);
    Ok(pairs.map(|(on, off)| 1.0 + (on - off) / mean).collect())
}

/// A floor of albedo 1/2 under a lamp of 2 x 2 and radiance 1 at height 1, and the exact radiance of the floor.
pub fn floor_under_a_lamp() -> (SceneDescription, f64) {
    let mut floor = patch_scene(DVec3::new(0.3, 0.2, 0.4), DVec3::ZERO, diffuse(0.5));
    let ground = rectangle([-0.5, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let lamp = ceiling([-1.0, 1.0], [-1.0, 1.0], 1.0);
    floor.shapes = vec![surface(ground, 0.0), surface(lamp, 1.0)];
    (floor, 0.5 * 4.0 * parallel_rectangle(1.0, 1.0, 1.0))
}

/// The integrators with BSDF sampling alone, with NEE alone, and with both.
fn techniques() -> Vec<Case> {
    let kinds = [
        IntegratorKind::Bsdf,
        IntegratorKind::NextEvent,
        IntegratorKind::Path,
    ];
    let (floor, lit) = floor_under_a_lamp();
    let scenes = [
        ("floor under a lamp", floor, lit, bounces(1, 1 << 15)),
        (
            "grey room to depth 3",
            room(0.5),
            series(0.5, Some(3)),
            bounces(3, 1 << 11),
        ),
    ];
    let mut cases = Vec::new();
    for kind in kinds {
        for (what, scene, exact, patch) in scenes.clone() {
            let name = format!("{what} by the integrator {}", kind.name());
            let measure = move |trial: &Trial<'_>| {
                let spp = trial.samples(patch.spp);
                see_by(trial, kind, &scene, PatchSettings { spp, ..patch })
            };
            cases.push(Case::new(51, name, Claim::mean(exact, 2e-3), measure));
        }
    }
    cases
}
