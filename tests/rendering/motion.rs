//! Motion blur: static objects with keys are bit-identical to those without keys, and moving ones match closed forms of the
//! average over the time that the shutter is open, on one backend in each case or, in `make nightly`, on every one.

use crate::common::closed_forms::parallel_rectangle;
use crate::common::nightly::{backends, one_in, samples_and_limit};
use crate::common::quadrature::integrate;
use crate::common::scene::{
    as_instance, diffuse, gallery, keys, patch_scene, picture, polygon, rectangle, see, slide,
    surface,
};
use crate::common::verdict::assert_mean;
use etendue::internals::accel::Backend;
use etendue::internals::geometry::texture::Texture;
use etendue::internals::integrator::Roulette;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DAffine3, DVec3, Vec2};
use etendue::internals::scene::description::{
    ColourDescription, GeometryDescription, Keyframe, MaterialDescription, MaterialModel, Place,
    SceneDescription,
};
use std::sync::Arc;

const SHUTTER: [f64; 2] = [0.0, 1.0];
const ALBEDO: f32 = 0.5;

/// Asserts that the rendered mean is the exact value, with a relative standard error of at most `power`.
fn check(what: &str, scene: &SceneDescription, bounces: u32, exact: f64, power: f64) {
    for &backend in backends(what) {
        let spp = if bounces == 0 { 1 << 12 } else { 1 << 14 };
        let seen = see(scene, backend, spp, Some(bounces), Roulette::None);
        let what = format!("{what}, {}", backend.name());
        println!("{what}: {seen:?}, exact {exact}");
        assert_mean(&what, &seen, exact, power);
    }
}

/// Sets of keys, each with a shutter, that leave an object at `there`: row 44 of the catalogue of hard cases.
fn static_world(
    there: DVec3,
    at: impl Fn(DVec3) -> DAffine3,
) -> Vec<(&'static str, [f64; 2], Vec<Keyframe>)> {
    let far = DVec3::new(-3.0, 8.0, 5.0);
    // Exactly p at a quarter of the way: 0.75 q + 0.25 (4 p - 3 q) = p, with p = `there` and q = `far`.
    let behind = 4.0 * there - 3.0 * far;
    vec![
        (
            "equal keys",
            SHUTTER,
            keys([(0.0, at(there)), (1.0, at(there))]),
        ),
        ("one key", SHUTTER, keys([(0.5, at(there))])),
        (
            "closed shutter",
            [0.25; 2],
            keys([(0.0, at(far)), (1.0, at(behind))]),
        ),
        (
            "closed at a key",
            [1.0; 2],
            keys([(0.0, at(far)), (1.0, at(there))]),
        ),
        (
            "keys before",
            SHUTTER,
            keys([(-3.0, at(far)), (-2.0, at(there))]),
        ),
        (
            "keys after",
            SHUTTER,
            keys([(1.0, at(there)), (2.0, at(far))]),
        ),
        (
            "equal while open",
            SHUTTER,
            keys([
                (-1.0, at(far)),
                (0.0, at(there)),
                (1.5, at(there)),
                (3.0, at(far)),
            ]),
        ),
    ]
}

#[test]
fn static_keyframes_are_bit_identical_to_static_transforms() {
    let there = DVec3::new(0.25, -0.5, 0.125);
    let turned = DAffine3::from_rotation_z(0.3) * DAffine3::from_scale(DVec3::new(1.0, -1.5, 0.7));
    let at = |p: DVec3| DAffine3 {
        translation: p,
        ..turned
    };
    for &backend in Backend::ALL {
        let mut written = gallery();
        written.shapes[0].transform = at(there);
        let shape_written = picture(&written, backend, 4);
        assert_ne!(
            shape_written,
            picture(&gallery(), backend, 4),
            "the transform changes the image"
        );
        let mut written = gallery();
        as_instance(&mut written, at(there), vec![]);
        let instance_written = picture(&written, backend, 4);
        let mut written = gallery();
        let pose = |p: DVec3| DAffine3 {
            translation: p,
            ..gallery().camera.to_world
        };
        let eye = gallery().camera.to_world.translation + there;
        written.camera.to_world = pose(eye);
        let camera_written = picture(&written, backend, 4);

        for (name, shutter, keys) in static_world(there, at) {
            let name = format!("{name}, {}", backend.name());
            let mut scene = gallery();
            scene.camera.shutter = shutter;
            scene.shapes[0].motion = keys.clone();
            assert_eq!(picture(&scene, backend, 4), shape_written, "shape: {name}");
            let mut scene = gallery();
            scene.camera.shutter = shutter;
            as_instance(&mut scene, DAffine3::IDENTITY, keys);
            assert_eq!(
                picture(&scene, backend, 4),
                instance_written,
                "instance: {name}"
            );
        }
        for (name, shutter, keys) in static_world(eye, pose) {
            let mut scene = gallery();
            scene.camera.to_world = DAffine3::IDENTITY;
            scene.camera.shutter = shutter;
            scene.camera.motion = keys;
            assert_eq!(
                picture(&scene, backend, 4),
                camera_written,
                "camera: {name}"
            );
        }
    }
}

/// A wall of radiance 1 at z = 0, whose centre is seen from above.
fn wall() -> SceneDescription {
    let mut scene = patch_scene(DVec3::Z, DVec3::ZERO, diffuse(0.0));
    scene.camera.shutter = SHUTTER;
    let wall = rectangle([-3.0, -3.0, 0.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0]);
    scene.shapes = vec![surface(wall, 1.0)];
    scene
}

/// A black plate that starts at x = 0, halfway to the camera.
fn plate() -> GeometryDescription {
    rectangle([0.0, -1.0, 0.5], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0])
}

#[test]
fn moving_occluder_blocks_its_share_of_shutter_time() {
    for share in [0.03, 0.25, 0.5, 0.9] {
        // At unit speed the edge crosses the camera ray at the time `share`.
        let path = slide(-share * DVec3::X, (1.0 - share) * DVec3::X);
        let mut scene = wall();
        scene.shapes = vec![surface(plate(), 0.0)];
        as_instance(&mut scene, DAffine3::IDENTITY, path);
        scene.shapes.extend(wall().shapes);
        check(&format!("instance, {share}"), &scene, 0, 1.0 - share, 1e-3);
    }
}

#[test]
fn keyframed_motion_is_averaged_over_the_shutter_interval() {
    let at = |x: f64| DAffine3::from_translation(x * DVec3::X);
    let path = |time: f64| at(time - 2.0);
    for (name, shutter, keys, seen) in [
        // The edge crosses the camera ray at time 2.
        (
            "longer than the shutter",
            [1.0, 2.5],
            keys([(0.0, path(0.0)), (4.0, path(4.0))]),
            1.0 / 3.0,
        ),
        // The plate rests for half of the time.
        (
            "a rest",
            [0.0, 4.0],
            keys([
                (0.0, at(-1.0)),
                (1.0, at(-0.2)),
                (3.0, at(-0.2)),
                (4.0, at(0.6)),
            ]),
            0.1875,
        ),
        // The plate moves in the last tenth, and rests before and after.
        (
            "a late start",
            [0.0, 1.0],
            keys([(0.9, at(-0.5)), (0.95, at(1.5))]),
            0.087_5,
        ),
        // The plate moves back and forth: the ray is free for half of the time, in the middle.
        (
            "and back",
            [0.0, 2.0],
            keys([(0.0, at(-0.5)), (1.0, at(0.5)), (2.0, at(-0.5))]),
            0.5,
        ),
        (
            "negative times",
            [-5.0, -4.0],
            keys([(-5.0, at(-0.6)), (-4.0, at(0.4))]),
            0.4,
        ),
        (
            "long times",
            [1e9, 3e9],
            keys([(1e9, at(-0.6)), (3e9, at(0.4))]),
            0.4,
        ),
    ] {
        let mut scene = wall();
        scene.camera.shutter = shutter;
        scene.shapes.push(surface(plate(), 0.0));
        scene.shapes[1].motion = keys;
        check(name, &scene, 0, seen, 1e-3);
    }
}

#[test]
fn moving_disk_motion_blur_matches_chord_lengths() {
    const RADIUS: f64 = 0.3;
    const PATH: [f64; 2] = [-0.7, 0.6];
    for (x, y) in [
        (0.0, 0.0),
        (0.1, 0.2),
        (-0.2, -0.29),
        (-0.85, 0.1),
        (0.75, 0.05),
    ] {
        let target = DVec3::new(x, y, 0.0);
        let mut scene = patch_scene(target + DVec3::Z, target, diffuse(0.0));
        scene.camera.shutter = SHUTTER;
        let disk = GeometryDescription::Disk {
            center: DVec3::ZERO,
            normal: DVec3::Z,
            radius: RADIUS,
        };
        scene.shapes = vec![surface(disk, 2.0)];
        scene.shapes[0].motion = slide(PATH[0] * DVec3::X, PATH[1] * DVec3::X);
        let half = (RADIUS * RADIUS - y * y).sqrt();
        let covered = (x + half).min(PATH[1]) - (x - half).max(PATH[0]);
        let exact = 2.0 * covered / (PATH[1] - PATH[0]);
        check(&format!("at {x}, {y}"), &scene, 0, exact, 1e-3);
    }
}

#[test]
fn moving_camera_averages_a_checker_over_the_shutter() {
    // Fields of length 1 from x = -2 on, of radiance 1 and 3 alternately.
    let exact = |from: f64, to: f64| {
        let radiance = |x: f64| {
            if x.floor().rem_euclid(2.0) < 0.5 {
                1.0
            } else {
                3.0
            }
        };
        let panels = 1 << 16;
        let middle = |i: u32| from + (to - from) * (f64::from(i) + 0.5) / f64::from(panels);
        (0..panels).map(|i| radiance(middle(i))).sum::<f64>() / f64::from(panels)
    };
    for (from, to) in [(-1.25, 0.5), (0.75, -1.75), (-0.875, -0.125)] {
        let eye = |x: f64| DVec3::new(x, 0.0, 1.0);
        let camera = |x: f64| {
            patch_scene(eye(x), eye(x) - DVec3::Z, diffuse(0.0))
                .camera
                .to_world
        };
        let mut scene = wall();
        scene.camera.motion = keys([(0.0, camera(from)), (1.0, camera(to))]);
        let floor = rectangle([-2.0, -1.0, 0.0], [4.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
        scene.shapes = vec![surface(floor, 1.0)];
        scene.shapes[0].emission = Some(ColourDescription::Texture(Arc::new(Texture::Checker {
            colours: [Rgb::grey(1.0), Rgb::grey(3.0)],
            repeat: Vec2::new(4.0, 1.0),
        })));
        check(&format!("{from} to {to}"), &scene, 0, exact(from, to), 1e-3);
    }
}

/// A blade turns at constant angular speed: it covers every angle for the same time. With linear interpolation of points
/// between keys it would be faster in the middle.
#[test]
fn rotation_keyframes_have_constant_angular_speed() {
    // A wedge of 22.5 degrees whose tip is the axis.
    let half = 11.25_f64.to_radians();
    let corner = |angle: f64| DVec3::new(angle.cos(), angle.sin(), 0.0);
    let blade = polygon(vec![DVec3::ZERO, corner(-half), corner(half)]);
    let turn = |degrees: f64| DAffine3::from_rotation_z(degrees.to_radians());
    let quarter = keys([(0.0, turn(0.0)), (1.0, turn(90.0))]);
    let half_turn = keys([(0.0, turn(0.0)), (0.5, turn(90.0)), (1.0, turn(180.0))]);
    for (path, whole, angles) in [
        (quarter, 90.0, vec![12.0, 20.0, 33.75, 45.0, 61.0, 78.0]),
        (half_turn, 180.0, vec![15.0, 88.0, 90.0, 150.0]),
    ] {
        for angle in angles {
            let target = 0.6 * corner(f64::to_radians(angle));
            let mut scene = patch_scene(target + DVec3::Z, target, diffuse(0.0));
            scene.camera.shutter = SHUTTER;
            scene.shapes = vec![surface(blade.clone(), 1.0)];
            scene.shapes[0].motion = path.clone();
            check(
                &format!("{angle} of {whole}"),
                &scene,
                0,
                22.5 / whole,
                1e-3,
            );
        }
    }
}

/// Rotating the camera about its position, or moving it, equals the inverse motion of everything else. The lamp, a ball, is
/// hit by scattered rays alone if the scene moves, and sampled as a light, too, if the camera moves.
#[test]
fn camera_motion_agrees_with_inverse_scene_motion() {
    let ball = |center: [f64; 3], radius: f64| GeometryDescription::Sphere {
        center: center.into(),
        radius,
    };
    let mut room = patch_scene(DVec3::ZERO, DVec3::new(0.0, -1.0, -2.0), diffuse(0.7));
    room.camera.shutter = SHUTTER;
    let floor = rectangle([-4.0, -1.0, -4.0], [0.0, 0.0, 8.0], [8.0, 0.0, 0.0]);
    let crate_ = GeometryDescription::Box {
        min: DVec3::new(-0.9, -1.0, -2.2),
        max: DVec3::new(-0.5, -0.6, -1.8),
    };
    room.shapes = vec![
        surface(floor, 0.0),
        surface(crate_, 0.0),
        surface(ball([0.3, 0.2, -2.0], 0.5), 2.0),
    ];
    let turn = |degrees: f64| DAffine3::from_rotation_y(degrees.to_radians());
    let away = |x: f64| DAffine3::from_translation(x * DVec3::new(1.0, 0.1, -0.2));
    let paths: [(&str, &dyn Fn(f64) -> DAffine3); 2] = [
        ("turned", &|share| turn(40.0 * share)),
        ("moved", &|share| away(-1.2 * share)),
    ];
    let (spp, limit) = samples_and_limit(1 << 14, 5e-3);
    for (name, path) in paths {
        for &backend in backends(name) {
            let mut moving_camera = room.clone();
            let to_world = room.camera.to_world;
            let times = [0.0, 1.0];
            moving_camera.camera.motion = keys(times.map(|t| (t, path(t) * to_world)));
            let mut moving_scene = room.clone();
            let back = keys(times.map(|t| (t, path(t).inverse())));
            as_instance(&mut moving_scene, DAffine3::IDENTITY, back);
            let [a, b] = [&moving_camera, &moving_scene]
                .map(|scene| see(scene, backend, spp, Some(2), Roulette::None));
            let error = |it: &etendue::internals::math::stats::Moments| {
                it.standard_error().expect("32 pixels")
            };
            let joint = error(&a).hypot(error(&b));
            println!("{name} {}: {a:?} {b:?}", backend.name());
            let apart = (a.mean() - b.mean()).abs();
            assert!(
                apart <= 5.2 * joint,
                "{name}, {}: {apart} > 5.2 {joint}",
                backend.name()
            );
            assert!(
                joint <= limit * a.mean(),
                "{name}: too noisy to tell, {joint}"
            );
            // The result differs from that of the static scene.
            let still = see(&room, backend, 1 << 10, Some(2), Roulette::None);
            assert!(
                (still.mean() - a.mean()).abs() > 20.0 * joint,
                "{name}: {still:?}"
            );
        }
    }
}

/// A floor at z = 0 whose centre is seen from 0.2 above it.
fn floor() -> SceneDescription {
    let eye = DVec3::new(0.15, 0.1, 0.2);
    let mut scene = patch_scene(eye, DVec3::ZERO, diffuse(ALBEDO));
    scene.camera.shutter = SHUTTER;
    let floor = rectangle([-0.5, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    scene.shapes = vec![surface(floor, 0.0)];
    scene
}

/// The square [-1, 1]^2 at height `z`, facing down.
fn ceiling(z: f64) -> GeometryDescription {
    rectangle([-1.0, -1.0, z], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0])
}

/// The edge of a plate moves at constant speed across all segments from a point of the floor to the light. A segment through
/// the plate's plane at x is occluded for (x + 1 - c) / 2 of the time, and the mean of x over the light is 0.
#[test]
fn moving_shadows_average_over_time() {
    let lit = f64::from(ALBEDO) * 4.0 * parallel_rectangle(1.0, 1.0, 1.0);
    let mirror = MaterialModel::Mirror {
        reflectance: ColourDescription::Constant(Rgb::WHITE),
    };
    for (name, model) in [("black", diffuse(0.0)), ("mirror", mirror)] {
        for c in one_in(2, 0, [-0.35, 0.0, 0.3]) {
            let mut scene = floor();
            let occluder = MaterialDescription::new("occluder", Place::default(), model.clone());
            scene.materials.push(occluder);
            let plate = rectangle([0.0, -3.0, 0.6], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0]);
            scene
                .shapes
                .extend([surface(ceiling(1.0), 1.0), surface(plate, 0.0)]);
            scene.shapes[2].material = 1;
            scene.shapes[2].motion = slide((c - 1.0) * DVec3::X, (c + 1.0) * DVec3::X);
            check(
                &format!("{name}, {c}"),
                &scene,
                1,
                0.5 * (1.0 + c) * lit,
                2e-3,
            );
        }
    }
}

/// The irradiance is the mean of configuration factors, with light sampling and with scattered rays.
#[test]
fn moving_area_light_irradiance_matches_its_time_average() {
    for (height, from, to) in [(0.5, -1.5, 1.0), (1.0, 0.5, 3.0), (0.3, 0.0, 0.2)] {
        let corner = |x: f64| x.signum() * parallel_rectangle(x.abs(), 1.0, height);
        let factor = |x: f64| 2.0 * (corner(x + 1.0) - corner(x - 1.0));
        let mean = integrate(factor, from, to, 64) / (to - from);
        let mut scene = floor();
        scene.shapes.push(surface(ceiling(height), 1.0));
        scene.shapes[1].motion = slide(from * DVec3::X, to * DVec3::X);
        let exact = f64::from(ALBEDO) * mean;
        check(&format!("{height}, {from} to {to}"), &scene, 1, exact, 3e-3);
    }
}
