//! White objects under uniform illumination, in which they are invisible, and shading normals under it.
//!
//! Measure: radiance, under a sky of radiance 1.
//! Range: from the centre of a sphere to a hundred-thousandth before its limb; cameras outside of it, on a surface and
//! inside.
//! Source: conservation of energy; the fraction of a hemisphere above a plane, (1 + cos t) / 2. Tested in
//! `lab/tests/reports/battery.rs`.

use super::case::{Case, Effort};
use super::claim::Claim;
use super::patch::{PatchSettings, bounces, direct, patch_scene};
use crate::scene_builder::{ceiling, diffuse, glass, rectangle, sky, sphere, surface};
use etendue::internals::integrator::Roulette;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::DVec3;
use etendue::internals::scene::description::{
    GeometryDescription, MaterialDescription, MaterialModel, MeshDescription, Place,
    SceneDescription,
};
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

/// Without roulette, and with a limit that ends paths inside of closed white objects.
const PATIENT: PatchSettings = PatchSettings {
    spp: 64,
    max_bounces: Some(1000),
    roulette: Roulette::None,
};

/// Every case.
pub fn cases(_: Effort) -> Vec<Case> {
    [
        white_spheres(),
        gaps(),
        cameras_in_odd_places(),
        tilted_normals(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Shapes of one material under a white sky.
fn under_the_sky(
    eye: DVec3,
    target: DVec3,
    model: MaterialModel,
    shapes: impl IntoIterator<Item = GeometryDescription>,
) -> SceneDescription {
    let mut scene = patch_scene(eye, target, model);
    scene.lights = vec![sky(Rgb::WHITE)];
    scene.shapes = shapes.into_iter().map(|form| surface(form, 0.0)).collect();
    scene
}

fn ball() -> GeometryDescription {
    sphere(DVec3::ZERO, 1.0)
}

fn white_spheres() -> Vec<Case> {
    let models = [(1, "white", diffuse(1.0)), (3, "glass", glass(1.5, 0.0))];
    // The centre, halfway, and towards the limb.
    let all = models
        .into_iter()
        .flat_map(|model| [0.0, 0.5, 0.99, 0.9999, 0.99999].map(move |x: f64| (model.clone(), x)));
    let case = |((row, kind, model), x): ((u32, &str, MaterialModel), f64)| {
        let target = DVec3::new(x, 0.0, f64::sqrt(1.0 - x * x));
        let scene = under_the_sky(DVec3::new(x, 0.0, 5.0), target, model, [ball()]);
        let name = format!("{kind} sphere seen {x} of the way to its limb");
        Case::seen(row, name, Claim::without_noise(1.0, 2e-6), scene, PATIENT)
    };
    all.map(case).collect()
}

/// A second surface so close that an offset ray origin could lie behind it.
fn gaps() -> Vec<Case> {
    let spheres = [4e-5, 1e-6].map(|gap: f64| {
        // Glass with air inside: a shell as thick as the gap.
        let eye = DVec3::new(0.3, 0.0, 5.0);
        let target = DVec3::new(0.3, 0.0, f64::sqrt(1.0 - 0.09));
        let shells = [sphere(DVec3::ZERO, 1.0 + gap), ball()];
        let mut scene = under_the_sky(eye, target, glass(1.5, 0.0), shells);
        let air = MaterialDescription::new("air", Place::default(), glass(1.0 / 1.5, 0.0));
        scene.materials.push(air);
        scene.shapes[1].material = 1;
        let name = format!("glass shell {gap:e} thick");
        Case::seen(41, name, Claim::without_noise(1.0, 4e-6), scene, PATIENT)
    });
    let sheets = [1e-4, 1e-6].map(|gap: f64| {
        let floor = rectangle([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
        let cover = ceiling([-1.0, 1.0], [-1.0, 1.0], gap);
        let eye = gap * DVec3::new(0.3, 0.2, 0.4);
        let scene = under_the_sky(eye, DVec3::ZERO, diffuse(1.0), [floor, cover]);
        let name = format!("light between two sheets {gap:e} apart");
        Case::seen(41, name, Claim::exactly(0.0), scene, direct(1 << 8))
    });
    spheres.into_iter().chain(sheets).collect()
}

fn cameras_in_odd_places() -> Vec<Case> {
    let seen = |name: &str, exact, scene| {
        Case::seen(47, name, Claim::without_noise(exact, 4e-6), scene, PATIENT)
    };
    let across = under_the_sky(1.5 * DVec3::Z, DVec3::Z, diffuse(1.0), [ball()]);
    let floor = || rectangle([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    let on_floor = under_the_sky(DVec3::ZERO, DVec3::Z, diffuse(1.0), [floor()]);
    let along = under_the_sky(DVec3::ZERO, DVec3::X, diffuse(1.0), [floor()]);
    // Radiance is n^2 times as large in glass.
    let within = under_the_sky(DVec3::ZERO, DVec3::X, glass(1.5, 0.0), [ball()]);
    let at_lamp = {
        let mut scene = patch_scene(DVec3::ZERO, DVec3::X, diffuse(0.0));
        scene.shapes = vec![surface(ball(), 0.5)];
        scene.shapes[0].two_sided_emission = true;
        scene
    };
    vec![
        seen("camera half a radius above a white sphere", 1.0, across),
        seen("camera on a white floor, looking up", 1.0, on_floor),
        seen("camera on a white floor, looking along it", 1.0, along),
        seen("camera in the middle of a glass sphere", 2.25, within),
        Case::seen(
            47,
            "camera within a lamp",
            Claim::exactly(0.5),
            at_lamp,
            bounces(0, 64),
        ),
    ]
}

fn tilted(angle: f64) -> DVec3 {
    DVec3::new(angle.sin(), 0.0, angle.cos())
}

/// Triangles with tilted shading normals. On a matte surface, light below the geometric surface is lost:
/// (1 + cos t) / 2 remains for a normal at an angle t. Seen along the shading normal, t is its tilt; seen from straight
/// above, the normal is corrected to 45 degrees. A normal on the other side is flipped, and one of zero length is
/// ignored.
fn tilted_normals() -> Vec<Case> {
    let kept = |t: f64| 0.5 * (1.0 + t.cos());
    let tilt = 60.0_f64.to_radians();
    let table = [
        (
            "60 degrees off, seen along it",
            tilted(tilt),
            tilted(tilt),
            kept(tilt),
        ),
        (
            "60 degrees off, seen from above",
            DVec3::Z,
            tilted(tilt),
            kept(FRAC_PI_4),
        ),
        (
            "60 degrees off and flipped",
            tilted(tilt),
            -tilted(tilt),
            kept(tilt),
        ),
        ("of no length", DVec3::Z, DVec3::ZERO, 1.0),
        ("flipped", DVec3::Z, -DVec3::Z, 1.0),
    ];
    let all = table
        .into_iter()
        .flat_map(|row| [("", 1.0), (", from below", -1.0)].map(|side| (row, side)));
    let case =
        |((name, wo, normal, exact), (side, sign)): ((&str, DVec3, DVec3, f64), (&str, f64))| {
            let corners = [(-3.0, -3.0), (3.0, -3.0), (0.0, 4.0)];
            let mesh = MeshDescription {
                positions: corners.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec(),
                normals: vec![normal; 3],
                uvs: vec![],
                indices: vec![[0, 1, 2]],
            };
            let plane = [GeometryDescription::Mesh(Arc::new(mesh))];
            let scene = under_the_sky(3.0 * sign * wo, DVec3::ZERO, diffuse(1.0), plane);
            let name = format!("white triangle with shading normals {name}{side}");
            Case::seen(17, name, Claim::mean(exact, 2e-3), scene, direct(1 << 11))
        };
    all.map(case).collect()
}
