//! Rendering of instances: an instanced group equals its shapes written out, also if it is mirrored, stretched, nested or
//! contains emitters, on every backend (lamps only in `make nightly`).

use crate::common::TestRng;
use crate::common::nightly::backends;
use crate::common::scene::{
    as_instance, diffuse, patch_scene, polygon, ready, rectangle, see, sky, slide, surface,
};
use crate::common::scene::{mirrored_octahedron, seen_whole};
use crate::common::tracing::{direction, point};
use crate::common::verdict::assert_mean;
use etendue::internals::accel::{AccelOptions, Backend, Precision};
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::geometry::texture::Texture;
use etendue::internals::integrator::Roulette;
use etendue::internals::math::ray::Ray;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::stats::Moments;
use etendue::internals::math::vec::{DAffine3, DMat3, DVec3, Vec2};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::{
    ColourDescription, GeometryDescription, InstanceDescription, Keyframe, LightDescription,
    LightModel, MaterialDescription, Place, SceneDescription,
};
use etendue::internals::scene::prepare::prepare;
use std::f64::consts::PI;
use std::sync::Arc;

fn instance(of: usize, group: Option<usize>, transform: DAffine3) -> InstanceDescription {
    InstanceDescription {
        name: format!("instance of {of}"),
        place: Place::default(),
        of,
        group,
        transform,
        motion: vec![],
    }
}

fn sphere(center: DVec3, radius: f64) -> GeometryDescription {
    GeometryDescription::Sphere { center, radius }
}

fn standard_error(seen: &Moments) -> f64 {
    seen.standard_error().expect("32 pixels")
}

/// The point where a ray in world space hits a scene, with the geometric and the shading normal.
fn meets(scene: &Scene, origin: DVec3, dir: DVec3, time: f32) -> Option<[DVec3; 3]> {
    let ray = Ray::new(scene.normalisation.point(origin), dir.as_vec3a());
    let at = scene.intersect::<Everything>(&ray, time, None, 0.0)?;
    let p = scene.normalisation.world_point(at.p);
    Some([p, at.ng.as_dvec3(), at.frame.n.as_dvec3()])
}

/// The number of rays that two scenes are compared by.
const RAYS: usize = 20_000;

/// The number of random rays that hit the first of two scenes, and of those whose hits differ.
fn compared(scenes: &[Scene; 2], time: f32, rng: &mut TestRng) -> (usize, usize) {
    let (mut found, mut off) = (0, 0);
    for _ in 0..RAYS {
        let origin = 4.0 * direction(rng).as_dvec3();
        let dir = (1.5 * point(rng).as_dvec3() - origin).normalize();
        let hits = [0, 1].map(|i| meets(&scenes[i], origin, dir, time));
        found += usize::from(hits[0].is_some());
        let same = match hits {
            [None, None] => true,
            [Some([p, ng, ns]), Some([q, mg, ms])] => {
                p.distance(q) < 1e-4 && ng.distance(mg) < 1e-4 && ns.distance(ms) < 1e-3
            }
            _ => false,
        };
        off += usize::from(!same);
    }
    (found, off)
}

/// Nested groups, one moving within another that moves, against the product of all transforms at a given time.
#[test]
fn nested_instances_match_shapes_with_composed_transforms() {
    let leaf = [
        surface(mirrored_octahedron(DVec3::new(0.3, 0.0, 0.1), 0.4), 0.0),
        surface(sphere(DVec3::new(-0.5, 0.2, 0.0), 0.3), 0.0),
        surface(
            rectangle([-0.5, -0.5, -0.4], [1.0, 0.0, 0.0], [0.0, 1.0, 0.2]),
            0.0,
        ),
    ];
    let rigid = |angle: f64, scale: DVec3, at: [f64; 3]| {
        DAffine3::from_translation(at.into())
            * DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), angle)
            * DAffine3::from_scale(scale)
    };
    let leaves = [
        rigid(0.4, DVec3::splat(0.8), [1.0, 0.3, 0.0]),
        rigid(2.0, DVec3::new(0.5, -0.5, 0.5), [-0.7, 0.0, 0.5]),
    ];
    let branches = [
        rigid(-1.0, DVec3::splat(1.3), [0.0, 2.0, 0.0]),
        rigid(0.9, DVec3::splat(-0.6), [0.5, -1.5, 0.4]),
    ];
    let (inner, outer) = (DVec3::new(0.5, -0.25, 0.125), DVec3::new(-1.0, 0.5, 0.25));
    let base = || {
        let mut scene = patch_scene(8.0 * DVec3::Z, DVec3::ZERO, diffuse(0.5));
        scene.camera.shutter = [0.0, 1.0];
        scene
    };
    let mut nested = base();
    nested.groups = vec!["leaf".into(), "branch".into()];
    for mut shape in leaf.clone() {
        shape.group = Some(0);
        nested.shapes.push(shape);
    }
    nested.instances = vec![
        instance(0, Some(1), leaves[0]),
        instance(0, Some(1), leaves[1]),
        instance(1, None, branches[0]),
        instance(1, None, branches[1]),
    ];
    nested.instances[1].motion = slide(DVec3::ZERO, inner);
    nested.instances[3].motion = slide(DVec3::ZERO, outer);
    let mut rng = TestRng::new(31);
    for time in [0.0, 0.375, 0.9] {
        let moved = |by: DVec3| DAffine3::from_translation(time * by);
        let mut flat = base();
        for branch in [branches[0], moved(outer) * branches[1]] {
            for transform in [leaves[0], moved(inner) * leaves[1]] {
                for mut shape in leaf.clone() {
                    shape.transform = branch * transform;
                    flat.shapes.push(shape);
                }
            }
        }
        for &backend in Backend::ALL {
            let scenes = [&nested, &flat].map(|scene| ready(scene, backend));
            let (found, off) = compared(&scenes, time as f32, &mut rng);
            println!(
                "{time} {}: {found} of {RAYS} hit, {off} off",
                backend.name()
            );
            assert!(found * 40 > RAYS, "only {found} rays hit");
            // Rays at edges may hit or miss.
            assert!(off * 2_000 < RAYS, "{time} {}: {off}", backend.name());
        }
    }
}

/// A floor at z = 0 whose centre is seen from 0.2 above it.
fn floor() -> SceneDescription {
    let eye = DVec3::new(0.15, 0.1, 0.2);
    let mut scene = patch_scene(eye, DVec3::ZERO, diffuse(0.5));
    let floor = rectangle([-0.5, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    scene.shapes = vec![surface(floor, 0.0)];
    scene
}

/// Shapes of lamps; the flat ones face down.
fn lamps() -> Vec<(&'static str, GeometryDescription)> {
    let disk = GeometryDescription::Disk {
        center: DVec3::ZERO,
        normal: -DVec3::Z,
        radius: 0.3,
    };
    let corners = [(-0.2, -0.3), (0.0, 0.4), (0.3, 0.1), (0.2, -0.3)];
    let corners = corners.map(|(x, y)| DVec3::new(x, y, 0.0));
    vec![
        ("sphere", sphere(DVec3::ZERO, 0.2)),
        ("disk", disk),
        ("polygon", polygon(corners.to_vec())),
    ]
}

/// A lamp in a group has the same mean as the lamp written out, and no more noise, for it is sampled as a light. A ball or
/// disk with a tiny motion is hit by scattered rays alone, with much more noise: the comparison can detect that.
#[test]
fn instanced_and_flattened_area_lights_agree() {
    let place = |mirror: DVec3| {
        DAffine3::from_translation(DVec3::new(0.3, -0.2, 1.0))
            * DAffine3::from_rotation_y(0.3)
            * DAffine3::from_scale(0.7 * mirror)
    };
    for (mirror, sides) in [
        ("plain", DVec3::ONE),
        ("mirrored", DVec3::new(-1.0, 1.0, 1.0)),
    ] {
        for (form, geometry) in lamps() {
            let mut lamp = surface(geometry, 3.0);
            lamp.transform = place(sides);
            let mut written = floor();
            written.shapes.push(lamp.clone());
            let mut grouped = floor();
            lamp.transform = DAffine3::IDENTITY;
            grouped.shapes = vec![lamp];
            as_instance(&mut grouped, place(sides), vec![]);
            grouped.shapes.extend(floor().shapes);
            let mut moving = grouped.clone();
            moving.camera.shutter = [0.0, 1.0];
            moving.instances[0].motion = slide(DVec3::ZERO, 1e-5 * DVec3::X);
            for &backend in backends(&format!("{mirror} {form}")) {
                let [a, b, c] = [&written, &grouped, &moving]
                    .map(|scene| see(scene, backend, 1 << 12, Some(1), Roulette::None));
                let name = format!("{mirror} {form}, {}", backend.name());
                println!("{name}: {a:?} {b:?} {c:?}");
                let joint = standard_error(&a).hypot(standard_error(&b));
                assert!(
                    (a.mean() - b.mean()).abs() <= 5.2 * joint + 4e-6 * a.mean(),
                    "{name}"
                );
                assert!(joint <= 1e-3 * a.mean(), "{name}: too noisy to tell");
                assert!(standard_error(&b) < 3.0 * standard_error(&a), "{name}");
                let is_found_by_scattering = form != "polygon";
                assert!(
                    !is_found_by_scattering || standard_error(&c) > 4.0 * standard_error(&b),
                    "{name}"
                );
                assert_mean(&name, &c, a.mean(), 2e-2);
            }
        }
    }
}

/// The transform of a unit sphere, stretched and rotated.
fn ellipsoid() -> DAffine3 {
    DAffine3::from_translation(DVec3::new(0.2, 0.1, -0.3))
        * DAffine3::from_axis_angle(DVec3::new(1.0, 1.0, 0.3).normalize(), 0.8)
        * DAffine3::from_scale(DVec3::new(1.0, 2.0, 0.4))
}

/// The transformed point of the unit sphere in direction `n`, and the outward normal there.
fn on_ellipsoid(m: &DAffine3, n: DVec3) -> (DVec3, DVec3) {
    let normal = m.matrix3.inverse().transpose() * n;
    (m.transform_point3(n), normal.normalize())
}

fn seen_ellipsoid(m: &DAffine3, n: DVec3, albedo: f32) -> SceneDescription {
    let (target, normal) = on_ellipsoid(m, n);
    let mut scene = patch_scene(target + 0.7 * normal, target, diffuse(albedo));
    scene.shapes = vec![surface(sphere(DVec3::ZERO, 1.0), 0.0)];
    as_instance(&mut scene, *m, vec![]);
    scene
}

#[test]
fn white_ellipsoid_passes_the_furnace_test() {
    let mut rng = TestRng::new(32);
    for _ in 0..12 {
        let mut scene = seen_ellipsoid(&ellipsoid(), direction(&mut rng).as_dvec3(), 1.0);
        scene.lights = vec![sky(Rgb::WHITE)];
        for &backend in Backend::ALL {
            let seen = see(&scene, backend, 1 << 8, None, Roulette::None);
            assert_mean("ellipsoid", &seen, 1.0, 1e-6);
        }
    }
}

/// Lambert's cosine law with the normal of the ellipsoid's equation, without noise under a distant light.
#[test]
fn ellipsoid_shading_follows_analytic_normals() {
    let towards = DVec3::new(0.3, 0.5, 0.8).normalize();
    let mirrored = ellipsoid() * DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0));
    let mut rng = TestRng::new(33);
    for m in [ellipsoid(), mirrored] {
        let mut lit = 0;
        for _ in 0..30 {
            let n = direction(&mut rng).as_dvec3();
            let cosine = on_ellipsoid(&m, n).1.dot(towards);
            if cosine.abs() < 0.05 {
                continue;
            }
            let mut scene = seen_ellipsoid(&m, n, 0.5);
            let model = LightModel::Distant {
                direction: -towards,
                irradiance: Rgb::WHITE,
            };
            let place = Place::default();
            scene.lights = vec![LightDescription { place, model }];
            for &backend in Backend::ALL {
                let seen = see(&scene, backend, 1 << 8, Some(1), Roulette::None);
                if cosine < 0.0 {
                    assert_eq!(seen.mean(), 0.0, "the point faces away from the light");
                } else {
                    lit += 1;
                    assert_mean("Lambert", &seen, 0.5 / PI * cosine, 1e-3);
                }
            }
        }
        assert!(lit >= 8, "{lit}");
    }
}

/// The projection of an ellipsoid with half axes a, b, and c along the view, seen from d: an ellipse of half axes
/// a d / sqrt(d^2 - c^2) and b d / sqrt(d^2 - c^2) in the plane through its centre.
#[test]
fn ellipsoid_silhouette_area_matches_closed_form() {
    let [a, b, c, d] = [0.4, 0.9, 1.5, 4.0_f64];
    let mut scene = patch_scene(d * DVec3::Z, DVec3::ZERO, diffuse(0.0));
    scene.camera.fov = 2.0 * (2.0 / d).atan();
    scene.shapes = vec![surface(sphere(DVec3::ZERO, 1.0), 1.0)];
    // The film covers 8 x 4 in that plane, whichever way is up.
    let exact = PI * a * b * d * d / (d * d - c * c) / 32.0;
    for mirror in [1.0, -1.0] {
        let mut scene = scene.clone();
        let stretch = DAffine3::from_scale(DVec3::new(a, mirror * b, c));
        as_instance(&mut scene, stretch, vec![]);
        for &backend in Backend::ALL {
            let seen = Moments::of((0..32).map(|seed| seen_whole(&scene, backend, 1024, seed)));
            assert_mean("outline", &seen, exact, 2e-3);
        }
    }
}

fn mirrors() -> [DAffine3; 4] {
    let turned = DAffine3::from_translation(DVec3::new(0.3, -0.2, 0.4))
        * DAffine3::from_axis_angle(DVec3::new(0.2, -1.0, 0.6).normalize(), 1.1);
    [
        [1.0, 1.0, 1.0],
        [-1.0, 1.0, 1.0],
        [1.0, 1.0, -1.0],
        [-2.0, -0.5, -1.0],
    ]
    .map(|axes| turned * DAffine3::from_scale(axes.into()))
}

fn checker(low: f32, high: f32) -> ColourDescription {
    ColourDescription::Texture(Arc::new(Texture::Checker {
        colours: [Rgb::grey(low), Rgb::grey(high)],
        repeat: Vec2::new(4.0, 3.0),
    }))
}

/// A rectangle in a group, seen at (u, v), and whether the checker has its low value there.
fn seen_field(m: &DAffine3, [u, v]: [f64; 2], motion: Vec<Keyframe>) -> (SceneDescription, bool) {
    let target = m.transform_point3(DVec3::new(u, v, 0.0));
    let normal = (m.matrix3.inverse().transpose() * DVec3::Z).normalize();
    let mut scene = patch_scene(target + 0.4 * normal, target, diffuse(0.0));
    let field = rectangle([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    scene.shapes = vec![surface(field, 0.0)];
    as_instance(&mut scene, *m, motion);
    let odd = |x: f64| x.floor().rem_euclid(2.0) > 0.5;
    (scene, odd(4.0 * u) == odd(3.0 * v))
}

const FIELDS: [[f64; 2]; 6] = [
    [0.1, 0.1],
    [0.4, 0.1],
    [0.9, 0.2],
    [0.1, 0.5],
    [0.6, 0.9],
    [0.3, 0.4],
];

/// Textured rectangles, whose two sides a mirroring transform could swap.
#[test]
fn textures_keep_their_uv_positions_on_mirrored_instances() {
    for m in mirrors() {
        for uv in FIELDS {
            let (mut shining, low) = seen_field(&m, uv, vec![]);
            shining.shapes[0].emission = Some(checker(1.0, 3.0));
            let (mut scattering, _) = seen_field(&m, uv, vec![]);
            scattering.materials[0] = MaterialDescription::new(
                "checker",
                Place::default(),
                etendue::internals::scene::description::MaterialModel::Diffuse {
                    reflectance: checker(0.25, 0.75),
                },
            );
            scattering.lights = vec![sky(Rgb::WHITE)];
            for &backend in Backend::ALL {
                let see = |scene| see(scene, backend, 16, Some(1), Roulette::None).mean();
                let name = format!("{m} {uv:?} {}", backend.name());
                assert_eq!(see(&shining), if low { 1.0 } else { 3.0 }, "{name}");
                let expected = if low { 0.25 } else { 0.75 };
                assert!((see(&scattering) - expected).abs() < 1e-6, "{name}");
            }
        }
    }
}

#[test]
fn alpha_on_instances_transmits_light_by_one_minus_alpha() {
    for m in mirrors() {
        for uv in FIELDS {
            let drift = slide(DVec3::ZERO, 1e-3 * DVec3::ONE);
            for (motion, shutter) in [(vec![], [0.0; 2]), (drift, [0.0, 1.0])] {
                let (mut scene, low) = seen_field(&m, uv, motion);
                scene.camera.shutter = shutter;
                scene.lights = vec![sky(Rgb::WHITE)];
                let mut partly = scene.clone();
                scene.materials[0].alpha = checker(0.0, 1.0);
                partly.materials[0].alpha = ColourDescription::Constant(Rgb::grey(0.3));
                for &backend in Backend::ALL {
                    let see = |scene| see(scene, backend, 64, Some(1), Roulette::None);
                    let name = format!("{m} {uv:?} {}", backend.name());
                    assert_eq!(see(&scene).mean(), f64::from(low), "{name}");
                    assert_mean(&name, &see(&partly), 0.7, 1e-2);
                }
            }
        }
    }
}

/// Row 42 of the catalogue of hard cases: an emitter that emits to its outside still does so if it is mirrored.
#[test]
fn mirrored_area_lights_emit_only_on_their_outside() {
    for m in mirrors() {
        // A ball may be stretched non-uniformly; the front of a flat lamp is given by its transformed normal.
        let normal = (m.matrix3.inverse().transpose() * -DVec3::Z).normalize();
        for (form, geometry) in lamps() {
            for (side, expected) in [(1.0, 2.0), (-1.0, 0.0)] {
                let inside = side < 0.0 && form == "sphere";
                let point = DVec3::new(0.0, 0.0, if form == "sphere" { -0.2 } else { 0.0 });
                let target = m.transform_point3(point);
                // The inside of the ball is seen from its centre.
                let eye = if inside {
                    m.transform_point3(DVec3::ZERO)
                } else {
                    target + 0.3 * side * normal
                };
                let mut scene = patch_scene(eye, target, diffuse(0.0));
                scene.shapes = vec![surface(geometry.clone(), 2.0)];
                as_instance(&mut scene, m, vec![]);
                for &backend in Backend::ALL {
                    let seen = see(&scene, backend, 4, Some(0), Roulette::None);
                    assert_eq!(seen.mean(), expected, "{form} {side} {m}");
                }
            }
        }
    }
}

/// Row 43 of the catalogue of hard cases: an instance that single precision cannot invert is an error that names it.
#[test]
fn noninvertible_instance_is_rejected_by_name() {
    let flat = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::X, DVec3::Z));
    for (what, transform) in [
        ("tiny", DAffine3::from_scale(DVec3::splat(1e-20))),
        ("flat", DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0))),
        ("one axis twice", flat),
    ] {
        let mut scene = floor();
        as_instance(&mut scene, transform, vec![]);
        scene.shapes.extend(floor().shapes);
        scene.instances[0].name = "the oak".into();
        for &backend in Backend::ALL {
            let options = AccelOptions {
                backend,
                precision: Precision::Robust,
                quality: None,
                threads: 1,
            };
            let error = prepare(&scene, options).expect_err(what).to_string();
            assert!(error.contains("the oak"), "{what}: {error}");
        }
    }
}
