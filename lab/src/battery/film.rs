//! Film and camera: reconstruction filters over a constant, empty scenes, and fields of view close to 0 and to 180
//! degrees.
//!
//! Measure: radiance; pixels.
//! Range: all filters; fields of view from 1e-6 to 179.9 degrees.
//! Source: a filter has unit integral. Tested in `lab/tests/reports/battery.rs`.

use super::case::{Case, Effort};
use super::claim::Claim;
use super::patch::{bounces, patch_scene};
use crate::scene_builder::{diffuse, rectangle, sky, surface};
use etendue::internals::film::filter::{FilterDescription, FilterKind};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::DVec3;
use etendue::internals::scene::description::SceneDescription;

/// Every case.
pub fn cases(_: Effort) -> Vec<Case> {
    [filters(), empty_scenes(), fields_of_view()]
        .into_iter()
        .flatten()
        .collect()
}

/// A wall of radiance 0.3.
fn wall() -> SceneDescription {
    let mut scene = patch_scene(DVec3::Z, DVec3::ZERO, diffuse(0.0));
    let square = rectangle([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    scene.shapes = vec![surface(square, 0.3)];
    scene
}

fn filters() -> Vec<Case> {
    let exact = f64::from(0.3_f32);
    let case = |&(name, kind): &(&str, FilterKind)| {
        let mut scene = wall();
        scene.film.filter = FilterDescription {
            kind,
            radius: kind.default_radius(),
        };
        // A filter with negative parts gives samples negative weights, and the sum of weights is only known by
        // sampling.
        let claim = match kind {
            FilterKind::Mitchell => Claim::mean(exact, 1e-3),
            _ => Claim::without_noise(exact, 1e-6),
        };
        let name = format!("{name} filter over a plain wall");
        Case::seen(64, name, claim, scene, bounces(0, 1 << 13))
    };
    FilterKind::ALL.iter().map(case).collect()
}

fn empty_scenes() -> Vec<Case> {
    let empty = || patch_scene(DVec3::Z, DVec3::ZERO, diffuse(0.5));
    let mut under_sky = empty();
    under_sky.lights = vec![sky(Rgb::grey(0.25))];
    let mut unlit = empty();
    unlit.shapes = wall().shapes;
    unlit.shapes[0].emission = None;
    [
        ("nothing but the sky", 0.25, under_sky),
        ("nothing at all", 0.0, empty()),
        ("a wall and no light", 0.0, unlit),
    ]
    .into_iter()
    .map(|(name, exact, scene)| Case::seen(65, name, Claim::exactly(exact), scene, bounces(4, 16)))
    .collect()
}

fn fields_of_view() -> Vec<Case> {
    let case = |degrees: f64| {
        let mut scene = patch_scene(DVec3::Z, DVec3::ZERO, diffuse(0.5));
        scene.lights = vec![sky(Rgb::grey(0.25))];
        scene.camera.fov = degrees.to_radians();
        let name = format!("the sky through a field of view of {degrees:e} degrees");
        Case::seen(65, name, Claim::exactly(0.25), scene, bounces(0, 16))
    };
    [1e-6, 90.0, 179.9].map(case).into()
}
