//! Direct light against exact answers, through the whole renderer and on every backend.

mod common;

use common::closed_forms::{
    coaxial_discs, lambert_polygon, parallel_rectangle, perpendicular_rectangle,
};
use common::scene::{diffuse, looking, polygon, ready, rectangle, see, shape};
use common::verdict::{Verdict, assert_mean, judge};
use etendue::accel::{Backend, Hit, PrimitiveId};
use etendue::effects::Slot;
use etendue::effects::kernel::types::Everything;
use etendue::geometry::surface::SurfacePoint;
use etendue::integrator::Roulette;
use etendue::light::types::PointRule;
use etendue::math::ray::Ray;
use etendue::math::stats::Moments;
use etendue::math::vec::{DAffine3, DVec3, Vec2, Vec3};
use etendue::sampler::{Decision, Sampler, Sobol};
use etendue::scene::description::{GeometryDescription, SceneDescription};
use etendue::scene::interaction::Interaction;

const ALBEDO: f32 = 0.5;

/// A floor at z = 0 whose middle, the origin, is seen from nearer than `reach`, under a light of the given radiance.
fn floor_under(light: GeometryDescription, radiance: f32, reach: f64) -> SceneDescription {
    let eye = reach * DVec3::new(0.3, 0.2, 0.4);
    let mut scene = looking(eye, DVec3::ZERO, diffuse(ALBEDO));
    let floor = rectangle([-0.5, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    scene.shapes = vec![shape(floor, 0.0), shape(light, radiance)];
    scene
}

/// A rectangle at height `z` over [x0, x1] x [y0, y1] that looks down.
fn ceiling([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], z: f64) -> GeometryDescription {
    rectangle([x0, y0, z], [0.0, y1 - y0, 0.0], [x1 - x0, 0.0, 0.0])
}

/// Compares what is seen of each scene with its exact radiance, on all backends, and panics with all failures together.
fn check(power: f64, cases: impl IntoIterator<Item = (String, SceneDescription, f64)>) {
    let mut failures = Vec::new();
    for (name, scene, exact) in cases {
        for &backend in Backend::ALL {
            let seen = see(&scene, backend, 1 << 12, Some(1), Roulette::None);
            let (mean, error) = (seen.mean(), seen.standard_error().expect("32 pixels"));
            println!(
                "{name}, {}: {mean:.9} +- {error:.1e}, exact {exact:.9}",
                backend.name()
            );
            let verdict = judge(mean, error, exact, power);
            if verdict != Verdict::Pass {
                failures.push(format!(
                    "{name}, {}: {verdict:?}, {mean:.9} +- {error:.1e}, exact {exact:.9}",
                    backend.name()
                ));
            }
        }
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

/// The radiance of the floor for a configuration factor and a light of radiance 1.
fn lit(factor: f64) -> f64 {
    f64::from(ALBEDO) * factor
}

#[test]
fn rectangles() {
    let middle = |h: f64| floor_under(ceiling([-1.0, 1.0], [-1.0, 1.0], h), 1.0, h.min(1.0));
    let near = [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6];
    check(
        1e-3,
        near.map(|h| {
            (
                format!("middle at {h}"),
                middle(h),
                lit(4.0 * parallel_rectangle(1.0, 1.0, h)),
            )
        }),
    );
    let corner = |h: f64| floor_under(ceiling([0.0, 2.0], [0.0, 2.0], h), 1.0, h.min(1.0));
    check(
        1e-3,
        [1.0, 1e-2].map(|h| {
            (
                format!("corner at {h}"),
                corner(h),
                lit(parallel_rectangle(2.0, 2.0, h)),
            )
        }),
    );
    let huge = floor_under(ceiling([-1e6, 1e6], [-1e6, 1e6], 1.0), 1.0, 1.0);
    check(
        1e-3,
        [(
            "huge".into(),
            huge,
            lit(4.0 * parallel_rectangle(1e6, 1e6, 1.0)),
        )],
    );
}

#[test]
fn walls() {
    let wall = |c: f64| {
        let wall = rectangle([c, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 2.0, 0.0]);
        let mut scene = floor_under(wall, 1.0, c.min(0.5));
        // The floor ends at the wall, and the view comes from the other side.
        scene.shapes[0] = shape(
            rectangle([c - 1.0, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            0.0,
        );
        let eye = c.min(0.5) * DVec3::new(-0.3, 0.2, 0.4);
        scene.camera = looking(eye, DVec3::ZERO, diffuse(ALBEDO)).camera;
        (
            format!("wall at {c}"),
            scene,
            lit(2.0 * perpendicular_rectangle(1.0, 1.0, c)),
        )
    };
    check(2e-3, [0.5, 1e-2, 1e-4, 1e-6].map(wall));
}

#[test]
fn spheres_and_disks() {
    let sphere = |center: DVec3, radius: f64| GeometryDescription::Sphere { center, radius };
    let disk = GeometryDescription::Disk {
        center: 1.5 * DVec3::Z,
        normal: -DVec3::Z,
        radius: 0.75,
    };
    let x = 2.0_f64;
    let root = (x * x - 1.0).sqrt();
    let perpendicular = ((1.0 / root).atan() - root / (x * x)) / std::f64::consts::PI;
    check(
        1e-3,
        [
            (
                "facing sphere".into(),
                floor_under(sphere(2.0 * DVec3::Z, 1.0), 1.0, 0.5),
                lit(0.25),
            ),
            (
                "perpendicular sphere".into(),
                floor_under(sphere(2.0 * DVec3::X, 1.0), 1.0, 0.5),
                lit(perpendicular),
            ),
            ("disk".into(), floor_under(disk, 1.0, 1.0), lit(0.2)),
        ],
    );
    // Irradiance pi from ever farther away.
    check(
        1e-4,
        [1e2, 1e4, 1e6, 1e8].map(|d: f64| {
            let scene = floor_under(sphere(d * DVec3::Z, 1.0), (d * d) as f32, 1.0);
            (format!("sphere at {d:e}"), scene, lit(1.0))
        }),
    );
}

#[test]
fn polygons() {
    let mut cases = Vec::new();
    for corners in [3, 4, 7] {
        for (tilt, size) in [
            (0.0, 1.0),
            (0.4, 1.0),
            (0.0, 0.1),
            (0.0, 1e-2),
            (0.0, 1e-3),
            (1.3, 2.0),
        ] {
            let to_world = DAffine3::from_translation(DVec3::new(0.1, -0.2, 1.0))
                * DAffine3::from_rotation_y(tilt)
                * DAffine3::from_scale(DVec3::splat(size));
            // Clockwise from above: the normal looks down.
            let vertices: Vec<DVec3> = (0..corners)
                .map(|i| {
                    let (sin, cos) =
                        (-f64::from(i) * std::f64::consts::TAU / f64::from(corners)).sin_cos();
                    to_world.transform_point3(DVec3::new(cos, sin, 0.0))
                })
                .collect();
            let exact = lit(lambert_polygon(&vertices));
            let mut scene = floor_under(polygon(vertices), 1.0, 0.5);
            // What is under the horizon meets no floor.
            scene.shapes[0].transform = DAffine3::from_scale(DVec3::splat(0.25));
            cases.push((
                format!("{corners} corners, tilt {tilt}, size {size}"),
                scene,
                exact,
            ));
        }
    }
    check(5e-4, cases);
}

#[test]
fn moved_and_scaled() {
    let exact = lit(4.0 * parallel_rectangle(1.0, 1.0, 1.0));
    assert!((exact - 0.277_063).abs() < 1e-6);
    let placed = |name: String, transform: DAffine3, scale: f64| {
        let mut scene = floor_under(ceiling([-1.0, 1.0], [-1.0, 1.0], 1.0), 1.0, 1.0);
        let camera = &mut scene.camera.to_world;
        camera.translation = transform.transform_point3(camera.translation);
        scene.camera.focus_distance *= scale;
        scene
            .shapes
            .iter_mut()
            .for_each(|s| s.transform = transform);
        (name, scene, exact)
    };
    let moved = [1e3, 1e4, 1e5, 1e6, 1e7].map(|t| {
        placed(
            format!("moved by {t:e}"),
            DAffine3::from_translation(DVec3::new(t, -t, t)),
            1.0,
        )
    });
    let scaled = [1e-6, 1e-4, 1e-2, 1e3, 1e6].map(|s| {
        placed(
            format!("scaled by {s:e}"),
            DAffine3::from_scale(DVec3::splat(s)),
            s,
        )
    });
    check(1e-3, moved.into_iter().chain(scaled));
}

#[test]
fn occluders_next_to_the_light() {
    for share in [0.5, 0.99, 0.9992, 0.9999, 0.99999] {
        let mut scene = floor_under(ceiling([-1.0, 1.0], [-1.0, 1.0], 1.0), 1.0, 0.5);
        scene
            .shapes
            .push(shape(ceiling([-1.1, 1.1], [-1.1, 1.1], share), 0.0));
        for &backend in Backend::ALL {
            let seen = see(&scene, backend, 1 << 10, Some(1), Roulette::None);
            assert_eq!(seen.mean(), 0.0, "{share} {}", backend.name());
        }
    }
}

/// The share of the light that leaves the first shape, point by point as `point` maps the unit square, and meets the
/// second, the light, of radiance 1.
fn form_factor(
    scene: &SceneDescription,
    normal: DVec3,
    point: impl Fn(f64, f64) -> DVec3,
) -> Moments {
    let scene = ready(scene, Backend::ALL[0]);
    let normal = normal.as_vec3a();
    Moments::of((0..16).map(|seed| {
        let mut sampler = Sobol::new(seed);
        let n = 1 << 18;
        let mut sum = 0.0;
        for sample in 0..n {
            sampler.start([0, 0], sample);
            let [u, v] = sampler.draw(Decision::Camera);
            let p = scene.normalisation.point(point(f64::from(u), f64::from(v)));
            let id = PrimitiveId {
                shape: 0,
                primitive: 0,
            };
            let surface = SurfacePoint {
                p,
                error: Vec3::splat(1e-7),
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
            let [u, v, u_choice, v_choice] = sampler.draw(Decision::Light(0));
            let choice = scene.lights.choose::<Everything>([u_choice, v_choice]);
            let choice = choice.expect("something shines");
            let (points, u) = (PointRule::SolidAngle, Vec2::new(u, v));
            let Some(s) = scene.sample_light::<Everything>(choice, points, p, 0.0, u) else {
                continue;
            };
            let cos = f64::from(s.wi.dot(normal)).max(0.0);
            let shadow_ray = at.ray_to(&s.end, s.wi, false);
            if !s.radiance.is_black() && scene.visibility::<Everything>(&shadow_ray, 0.0) > 0.0 {
                sum += cos / (f64::from(s.pdf.expect("no delta light").0) * std::f64::consts::PI);
            }
        }
        sum / n as f64
    }))
}

#[test]
fn form_factors() {
    let scene = |receiver, light| {
        let mut scene = looking(DVec3::Z, DVec3::ZERO, diffuse(ALBEDO));
        scene.shapes = vec![shape(receiver, 0.0), shape(light, 1.0)];
        scene
    };
    let disc = |z: f64, radius: f64, up: f64| GeometryDescription::Disk {
        center: z * DVec3::Z,
        normal: up * DVec3::Z,
        radius,
    };
    for (r1, r2, h) in [(1.0, 1.0, 1.0), (0.5, 1.0, 2.0)] {
        let on_disc = |u: f64, v: f64| {
            let (sin, cos) = (std::f64::consts::TAU * v).sin_cos();
            r1 * u.sqrt() * DVec3::new(cos, sin, 0.0)
        };
        let factor = form_factor(
            &scene(disc(0.0, r1, 1.0), disc(h, r2, -1.0)),
            DVec3::Z,
            on_disc,
        );
        assert_mean(
            &format!("discs {r1} {r2} {h}"),
            &factor,
            coaxial_discs(r1, r2, h),
            5e-4,
        );
    }
    let floor = |a: f64, b: f64| rectangle([0.0; 3], [a, 0.0, 0.0], [0.0, b, 0.0]);
    let wall = rectangle([0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let [opposite, adjacent] = [ceiling([0.0, 1.0], [0.0, 1.0], 1.0), wall].map(|light| {
        form_factor(&scene(floor(1.0, 1.0), light), DVec3::Z, |u, v| {
            DVec3::new(u, v, 0.0)
        })
    });
    assert_mean("opposite squares", &opposite, 0.199_824_895_7, 5e-4);
    assert_mean("adjacent squares", &adjacent, 0.200_043_776_1, 5e-4);
    let near = scene(floor(4.0, 1.0), ceiling([0.0, 4.0], [0.0, 1.0], 0.01));
    let near = form_factor(&near, DVec3::Z, |u, v| DVec3::new(4.0 * u, v, 0.0));
    assert_mean("4 x 1 at 0.01", &near, 0.987_639_372_8, 1e-3);
}
