//! Direct light of area lights, compared with configuration factors.
//!
//! Measure: radiance of a floor of albedo 1/2 under light of radiance 1; form factors.
//! Range: lights at distances from a millionth of their size to 1e12 times their size.
//! Source: Howell's catalogue; Lambert 1760. Tested in `lab/tests/reports/battery.rs`.

use super::case::{Case, Effort, Trial};
use super::claim::Claim;
use super::closed_forms::{
    coaxial_discs, lambert_polygon, parallel_rectangle, perpendicular_rectangle,
    perpendicular_sphere,
};
use super::form_factor::form_factor;
use super::patch::{direct, patch_scene};
use crate::scene_builder::{ceiling, diffuse, polygon, rectangle, sphere, surface};
use etendue::internals::math::vec::{DAffine3, DVec3};
use etendue::internals::scene::description::{GeometryDescription, SceneDescription};
use std::f64::consts::TAU;

const ALBEDO: f32 = 0.5;

/// Every case.
pub fn cases(_: Effort) -> Vec<Case> {
    [
        form_factors(),
        spheres(),
        polygons(),
        rectangles_nearby(),
        walls(),
        distant_spheres(),
        winding(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A floor at z = 0 whose centre, the origin, is seen from nearer than `reach`, under a light of the given radiance.
fn floor_under(light: GeometryDescription, radiance: f32, reach: f64) -> SceneDescription {
    let eye = reach * DVec3::new(0.3, 0.2, 0.4);
    let mut scene = patch_scene(eye, DVec3::ZERO, diffuse(ALBEDO));
    let floor = rectangle([-0.5, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    scene.shapes = vec![surface(floor, 0.0), surface(light, radiance)];
    scene
}

/// The radiance of the floor for a configuration factor and a light of radiance 1.
fn lit(factor: f64) -> f64 {
    f64::from(ALBEDO) * factor
}

fn form_factors() -> Vec<Case> {
    let between = |row, name: &str, [receiver, light]: [GeometryDescription; 2], claim, point| {
        let mut scene = patch_scene(DVec3::Z, DVec3::ZERO, diffuse(ALBEDO));
        scene.shapes = vec![surface(receiver, 0.0), surface(light, 1.0)];
        // Discs are sampled by area, which is noisy at short distances.
        let points = match row {
            18 => 1 << 18,
            19 => 1 << 16,
            _ => 1 << 14,
        };
        let point: fn(f64, f64) -> DVec3 = point;
        let measure =
            move |trial: &Trial<'_>| form_factor(trial, &scene, DVec3::Z, (point, points));
        Case::new(row, name, claim, measure).costing(points as f64 / f64::from(1 << 14))
    };
    let disc = |z: f64, radius: f64, up: f64| GeometryDescription::Disk {
        center: z * DVec3::Z,
        normal: up * DVec3::Z,
        radius,
    };
    let discs = |r1, r2, h| [disc(0.0, r1, 1.0), disc(h, r2, -1.0)];
    let floor = |a: f64| rectangle([0.0; 3], [a, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let above = |a: f64, z: f64| [floor(a), ceiling([0.0, a], [0.0, 1.0], z)];
    let wall = rectangle([0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let precise = |exact| Claim::mean(exact, 5e-4);
    vec![
        between(
            18,
            "coaxial discs of radius and distance 1",
            discs(1.0, 1.0, 1.0),
            precise(coaxial_discs(1.0, 1.0, 1.0)),
            |u, v| on_disc(1.0, u, v),
        ),
        between(
            18,
            "coaxial discs of radius 1/2 and 1 at distance 2",
            discs(0.5, 1.0, 2.0),
            precise(coaxial_discs(0.5, 1.0, 2.0)),
            |u, v| on_disc(0.5, u, v),
        ),
        between(
            19,
            "opposite unit squares",
            above(1.0, 1.0),
            precise(0.199_824_895_7),
            |u, v| DVec3::new(u, v, 0.0),
        ),
        between(
            19,
            "adjacent unit squares",
            [floor(1.0), wall],
            precise(0.200_043_776_1),
            |u, v| DVec3::new(u, v, 0.0),
        ),
        between(
            20,
            "rectangles of 4 x 1 at distance 0.01",
            above(4.0, 0.01),
            Claim::mean(0.987_639_372_8, 1e-3),
            |u, v| DVec3::new(4.0 * u, v, 0.0),
        ),
    ]
}

fn on_disc(radius: f64, u: f64, v: f64) -> DVec3 {
    let (sin, cos) = (TAU * v).sin_cos();
    radius * u.sqrt() * DVec3::new(cos, sin, 0.0)
}

fn spheres() -> Vec<Case> {
    let case = |name, center, factor| {
        let scene = floor_under(sphere(center, 1.0), 1.0, 0.5);
        Case::seen(
            21,
            name,
            Claim::mean(lit(factor), 1e-3),
            scene,
            direct(1 << 9),
        )
    };
    let disk = GeometryDescription::Disk {
        center: 1.5 * DVec3::Z,
        normal: -DVec3::Z,
        radius: 0.75,
    };
    let under_disk = floor_under(disk, 1.0, 1.0);
    vec![
        case("sphere at two radii, facing", 2.0 * DVec3::Z, 0.25),
        case(
            "sphere at two radii, half below the horizon",
            2.0 * DVec3::X,
            perpendicular_sphere(2.0),
        ),
        Case::seen(
            21,
            "disk at two radii, facing",
            Claim::mean(lit(0.2), 1e-3),
            under_disk,
            direct(1 << 9),
        ),
    ]
}

fn polygons() -> Vec<Case> {
    let places = [
        (0.0, 1.0),
        (0.4, 1.0),
        (0.0, 0.1),
        (0.0, 1e-2),
        (0.0, 1e-3),
        (1.3, 2.0),
    ];
    let all = [3, 4, 7]
        .into_iter()
        .flat_map(|corners| places.map(|p| (corners, p)));
    let case = |(corners, (tilt, size)): (u32, (f64, f64))| {
        let to_world = DAffine3::from_translation(DVec3::new(0.1, -0.2, 1.0))
            * DAffine3::from_rotation_y(tilt)
            * DAffine3::from_scale(DVec3::splat(size));
        // Clockwise from above: the normal points down.
        let corner = |i: u32| {
            let (sin, cos) = (-f64::from(i) * TAU / f64::from(corners)).sin_cos();
            to_world.transform_point3(DVec3::new(cos, sin, 0.0))
        };
        let vertices: Vec<DVec3> = (0..corners).map(corner).collect();
        let claim = Claim::mean(lit(lambert_polygon(&vertices)), 5e-4);
        let mut scene = floor_under(polygon(vertices), 1.0, 0.5);
        // The floor is small, so that polygons that extend below the horizon do not intersect it.
        scene.shapes[0].transform = DAffine3::from_scale(DVec3::splat(0.25));
        let name = format!("polygon of {corners} corners, radius {size}, tilted by {tilt}");
        // Polygons that extend below the horizon are noisier.
        let spp = if tilt > 1.0 { 1 << 12 } else { 1 << 9 };
        Case::seen(24, name, claim, scene, direct(spp))
    };
    all.map(case).collect()
}

fn rectangles_nearby() -> Vec<Case> {
    let case = |row, name, light, reach, claim| {
        let scene = floor_under(light, 1.0, reach);
        Case::seen(row, name, claim, scene, direct(1 << 9))
    };
    let lit_by = |factor| Claim::mean(lit(factor), 1e-3);
    let middle = [1e-1, 1e-2, 1e-4, 1e-6].map(|h| {
        let name = format!("2 x 2 light {h:e} over its middle");
        let light = ceiling([-1.0, 1.0], [-1.0, 1.0], h);
        let claim = lit_by(4.0 * parallel_rectangle(1.0, 1.0, h));
        case(25, name, light, h, claim)
    });
    let corner = [1.0, 1e-2, 1e-4].map(|h| {
        let name = format!("2 x 2 light {h:e} over its corner");
        let light = ceiling([0.0, 2.0], [0.0, 2.0], h);
        // Right under a corner the factor changes by 1 / (4 h) a unit of length, along either axis; the hit point on
        // the floor is known to one rounding of the scene's size.
        let rounding = 2.5 * f64::from(f32::EPSILON) / 2.0 / (2.0 * h);
        let claim = lit_by(parallel_rectangle(2.0, 2.0, h)).within(lit(rounding));
        case(25, name, light, h, claim)
    });
    let huge = case(
        27,
        "light of half-width 1e6 at distance 1".to_owned(),
        ceiling([-1e6, 1e6], [-1e6, 1e6], 1.0),
        1.0,
        lit_by(4.0 * parallel_rectangle(1e6, 1e6, 1.0)),
    );
    middle.into_iter().chain(corner).chain([huge]).collect()
}

fn walls() -> Vec<Case> {
    let case = |c: f64| {
        let wall = rectangle([c, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 2.0, 0.0]);
        let mut scene = floor_under(wall, 1.0, c.min(0.5));
        // The floor ends at the wall, and the camera looks from the other side.
        let floor = rectangle([c - 2.0, -0.5, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        scene.shapes[0] = surface(floor, 0.0);
        let eye = c.min(0.5) * DVec3::new(-0.3, 0.2, 0.4);
        scene.camera = patch_scene(eye, DVec3::ZERO, diffuse(ALBEDO)).camera;
        let claim = Claim::mean(lit(2.0 * perpendicular_rectangle(1.0, 1.0, c)), 2e-3);
        let name = format!("{c:e} from where the floor meets a wall of light");
        Case::seen(26, name, claim, scene, direct(1 << 9))
    };
    [1.0, 0.5, 1e-2, 1e-4, 1e-6].map(case).into()
}

fn distant_spheres() -> Vec<Case> {
    let case = |d: f64| {
        let scene = floor_under(sphere(d * DVec3::Z, 1.0), (d * d) as f32, 1.0);
        let name = format!("sphere of radius 1 and irradiance pi, {d:e} away");
        let claim = Claim::without_noise(lit(1.0), 1e-5);
        Case::seen(28, name, claim, scene, direct(1 << 8))
    };
    [1e6, 1e8, 1e10, 1e12].map(case).into()
}

/// Surfaces scatter on both sides, independent of the winding of their triangles; area lights emit on the side of their
/// normal.
fn winding() -> Vec<Case> {
    let square = |z: f64, reversed: bool| {
        let mut corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        if reversed {
            corners.reverse();
        }
        polygon(corners.map(|(x, y)| DVec3::new(x, y, z)).to_vec())
    };
    let exact = lit(4.0 * parallel_rectangle(1.0, 1.0, 1.0));
    let case = |(floor, lamp): (bool, bool)| {
        let mut scene = floor_under(square(1.0, lamp), 1.0, 1.0);
        scene.shapes[0] = surface(square(0.0, floor), 0.0);
        let claim = if lamp {
            Claim::mean(exact, 1e-3)
        } else {
            Claim::exactly(0.0)
        };
        let way = |down: bool| if down { "down" } else { "up" };
        let name = format!(
            "floor wound to face {}, lamp above it {}",
            way(floor),
            way(lamp)
        );
        Case::seen(42, name, claim, scene, direct(1 << 9))
    };
    [(false, true), (true, true), (false, false)]
        .map(case)
        .into()
}
