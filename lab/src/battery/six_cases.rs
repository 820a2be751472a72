//! The six cases that none of the measured renderers passed: scale, distance from the origin, a light nearby, an
//! occluder before the light, a distant light, a closed box, and a plain image of very many samples.
//!
//! Measure: radiance.
//! Range: a light of 2 x 2 and radiance 1 over a floor of 2 x 2 and albedo 1/2, direct light only, the floor's middle.
//! Source: docs/hard-cases.md, which describes how the peers' numbers were measured. Tested in
//! `lab/tests/reports/battery.rs`.

use super::case::{Case, Effort, Peers};
use super::claim::Claim;
use super::closed_forms::parallel_rectangle;
use super::patch::{PatchSettings, bounces, direct, patch_scene, see_exactly};
use crate::scene_builder::{ceiling, diffuse, rectangle, sky, surface};
use etendue::internals::integrator::Roulette;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DAffine3, DVec3};
use etendue::internals::scene::description::{GeometryDescription, SceneDescription};

/// Every case, in the order of the published table.
pub fn cases(effort: Effort) -> Vec<Case> {
    [
        scaled(),
        moved(),
        near(),
        occluded(),
        distant(),
        closed_boxes(),
        plain_pictures(effort),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn peers(mitsuba: &'static str, cycles: &'static str, luxcore: &'static str) -> Peers {
    Peers {
        mitsuba,
        cycles,
        luxcore,
    }
}

/// The floor under a light at height `h`, seen from between them.
fn floor_under(h: f64, radiance: f32) -> SceneDescription {
    let eye = h.min(1.0) * DVec3::new(0.3, 0.2, 0.4);
    let mut scene = patch_scene(eye, DVec3::ZERO, diffuse(0.5));
    let floor = rectangle([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    let light = ceiling([-1.0, 1.0], [-1.0, 1.0], h);
    scene.shapes = vec![surface(floor, 0.0), surface(light, radiance)];
    scene
}

/// The exact radiance of the floor for a light of radiance 1.
fn lit(h: f64) -> f64 {
    0.5 * 4.0 * parallel_rectangle(1.0, 1.0, h)
}

/// The scene at height 1, with the camera, scaled and translated as a whole.
fn placed(scale: f64, by: f64) -> SceneDescription {
    let mut scene = floor_under(1.0, 1.0);
    let by = by * DVec3::new(1.0, -1.0, 1.0);
    let place = DAffine3::from_translation(by) * DAffine3::from_scale(DVec3::splat(scale));
    let camera = &mut scene.camera;
    camera.to_world.translation = place.transform_point3(camera.to_world.translation);
    camera.focus_distance *= scale;
    scene.shapes.iter_mut().for_each(|s| s.transform = place);
    scene
}

fn scaled() -> Vec<Case> {
    let table = [
        (1.0, peers("0.27711", "0.27695", "0.27712")),
        (1e-2, peers("0.2783", "-", "-")),
        (1e-3, peers("0.2856", "0.2769", "0.2787")),
        (1e-4, peers("0.3867", "0.2769", "0.2928")),
        (1e-6, peers("0.1885", "0", "0")),
        (1e3, peers("ok", "ok", "0.2147")),
        (1e6, peers("ok", "ok", "0.2097")),
    ];
    let case = |(scale, peers): (f64, Peers)| {
        let name = format!("scene scaled by {scale:e}");
        let claim = Claim::mean(lit(1.0), 1e-3);
        Case::seen(35, name, claim, placed(scale, 0.0), direct(1 << 10)).beside(peers)
    };
    table.into_iter().map(case).collect()
}

fn moved() -> Vec<Case> {
    let table = [
        (1e3, peers("0.2833", "ok", "0.2783")),
        (1e4, peers("0.3852", "ok", "0.2924")),
        (1e5, peers("0.1885", "0.2722", "0.2929")),
        (1e6, peers("0.188", "0.242", "0.296")),
        (1e7, peers("0", "0", "0")),
    ];
    let case = |(by, peers): (f64, Peers)| {
        let name = format!("scene moved by {by:e} along each axis");
        let claim = Claim::mean(lit(1.0), 1e-3);
        Case::seen(35, name, claim, placed(1.0, by), direct(1 << 10)).beside(peers)
    };
    table.into_iter().map(case).collect()
}

fn near() -> Vec<Case> {
    let table = [
        (1e-3, peers("ok", "0.4756", "-")),
        (1e-4, peers("ok", "0.401", "ok")),
        (5e-5, peers("0.00001", "-", "-")),
        (1e-5, peers("0", "0.1515", "0")),
    ];
    let case = |(h, peers): (f64, Peers)| {
        let name = format!("light {h:e} over the floor");
        let claim = Claim::mean(lit(h), 1e-3);
        Case::seen(25, name, claim, floor_under(h, 1.0), direct(1 << 10)).beside(peers)
    };
    table.into_iter().map(case).collect()
}

fn occluded() -> Vec<Case> {
    let table = [
        (0.9992, peers("0.1885", "ok", "ok")),
        (0.9999, peers("0.1885", "ok", "ok")),
        (0.99999, peers("0.1885", "ok", "0.189")),
    ];
    let case = |(share, peers): (f64, Peers)| {
        let mut scene = floor_under(1.0, 1.0);
        let cover = ceiling([-1.1, 1.1], [-1.1, 1.1], share);
        scene.shapes.push(surface(cover, 0.0));
        let name = format!("black occluder at {share} of the way to the light");
        Case::seen(30, name, Claim::exactly(0.0), scene, direct(1 << 10)).beside(peers)
    };
    table.into_iter().map(case).collect()
}

fn distant() -> Vec<Case> {
    let table = [
        (1e6, peers("ok", "ok", "ok")),
        (1e7, peers("-", "-", "0.030")),
        (1e8, peers("ok", "ok", "0.063")),
        (1e9, peers("ok", "ok", "0.098")),
        (1e10, peers("0", "0", "0")),
    ];
    let case = |(d, peers): (f64, Peers)| {
        // The radiance of the light for which the floor's radiance is 1/2.
        let radiance = (0.5 / lit(d)) as f32;
        let claim = Claim::mean(f64::from(radiance) * lit(d), 1e-3);
        let name = format!("the same irradiance from a light {d:e} away");
        let scene = floor_under(d, radiance);
        Case::seen(28, name, claim, scene, direct(1 << 10)).beside(peers)
    };
    table.into_iter().map(case).collect()
}

/// A box of edge 2 around a point, seen from inside, and a sky of radiance 1e6 outside.
fn closed_box(t: f64) -> SceneDescription {
    let centre = DVec3::new(t, -t, t);
    let eye = centre + DVec3::new(0.1, 0.2, 0.3);
    let mut scene = patch_scene(eye, centre + DVec3::new(0.3, 1.0, 0.1), diffuse(0.999));
    let walls = GeometryDescription::Box {
        min: centre - 1.0,
        max: centre + 1.0,
    };
    scene.shapes = vec![surface(walls, 0.0)];
    scene.lights = vec![sky(Rgb::grey(1e6))];
    scene
}

fn closed_boxes() -> Vec<Case> {
    let table = [
        (0.0, peers("0", "-", "-")),
        (1e3, peers("8.7e3", "-", "-")),
        (1e4, peers("2.0e5", "-", "-")),
        (1e5, peers("-", "-", "-")),
    ];
    let patch = bounces(1000, 16);
    let case = |(t, peers): (f64, Peers)| {
        let name = format!("light from outside in a closed white box at {t:e}");
        let claim = Claim::exactly(0.0);
        Case::seen(36, name, claim, closed_box(t), patch)
            .costing(3.0)
            .beside(peers)
    };
    table.into_iter().map(case).collect()
}

/// One pixel of a wall of radiance 0.1.
fn plain_pictures(effort: Effort) -> Vec<Case> {
    let table = [
        (16, peers("+0.06 %", "-", "-")),
        (18, peers("-0.25 %", "-", "-")),
        (20, peers("+0.99 %", "-", "-")),
        (24, peers("-", "-", "-")),
        (26, peers("-", "-", "-")),
    ];
    let rows = match effort {
        Effort::Quick => &table[..3],
        Effort::Full => &table,
    };
    let case = |&(exponent, peers): &(u32, Peers)| {
        let mut scene = patch_scene(DVec3::Z, DVec3::ZERO, diffuse(0.0));
        scene.film.size = (1, 1);
        let wall = rectangle([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
        scene.shapes = vec![surface(wall, 0.1)];
        let patch = PatchSettings {
            spp: 1 << exponent,
            max_bounces: Some(0),
            roulette: Roulette::None,
        };
        let name = format!("plain image of 0.1 at 2^{exponent} samples a pixel");
        let claim = Claim::without_noise(f64::from(0.1_f32), 1e-9);
        let measure = move |trial: &super::case::Trial<'_>| see_exactly(trial, &scene, patch);
        let cost = f64::exp2(f64::from(exponent) - 21.0);
        Case::new(57, name, claim, measure)
            .costing(cost)
            .beside(peers)
    };
    rows.iter().map(case).collect()
}
