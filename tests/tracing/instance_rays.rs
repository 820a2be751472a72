//! Tests of rays against static and moving instances with every backend and precision: hits are compared with a
//! brute-force oracle in double precision.

use crate::common::TestRng;
use crate::common::tracing::{
    closed_mesh, direction, every_accel, in_single, moving, placed_once, point, soup, static_world,
    transforms,
};
use etendue::internals::accel::{Accel, AccelOptions, Backend, Hit, Precision, brute};
use etendue::internals::geometry::Geometry;
use etendue::internals::geometry::world::{Instance, World};
use etendue::internals::math::ray::Ray;
use etendue::internals::math::vec::{DAffine3, DVec3, Vec3};
use std::sync::Arc;

/// The allowed error of a query relative to the ray's length scale: a hundred rounding errors.
const ROUNDINGS: f64 = 100.0 / 16_777_216.0;

/// Generates a random ray near an instance at a time, and a bound on the offset that rounding in a query may cause.
fn ray_at(rng: &mut TestRng, instance: &Instance, time: f32) -> (Ray, f64) {
    let m = instance.at(time);
    let (from, to) = (1.5 * point(rng).as_dvec3(), 0.5 * point(rng).as_dvec3());
    let origin = m.transform_point3(from);
    let dir = m.transform_vector3(to - from).normalize();
    let norm = |m: glam::DMat3| m.to_cols_array().map(|x| x * x).iter().sum::<f64>().sqrt();
    let condition = norm(m.matrix3) * norm(m.matrix3.inverse());
    let lengths = origin.length() + m.translation.length() + norm(m.matrix3);
    (
        Ray::new(origin.as_vec3a(), dir.as_vec3a()),
        ROUNDINGS * condition * lengths,
    )
}

fn agree(a: Option<Hit>, b: Option<Hit>, bound: f64) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => f64::from((a.t - b.t).abs()) <= 1e-4 * f64::from(a.t) + bound,
        _ => false,
    }
}

/// Whether the oracle gives this hit for a ray that is shifted by no more than the bound.
fn is_rounding(
    world: &World,
    ray: &Ray,
    time: f32,
    hit: Option<Hit>,
    bound: f64,
    rng: &mut TestRng,
) -> bool {
    (0..200).any(|_| {
        let offset = bound as f32 * point(rng);
        let shifted = Ray {
            origin: ray.origin + offset,
            ..*ray
        };
        agree(brute::intersect(world, &shifted, time), hit, bound)
    })
}

/// Compares all backends with the oracle, with rays near every instance. Differences have to be explained by rounding,
/// and to be rare.
fn compare(world: &Arc<World>, rays: usize, rng: &mut TestRng) {
    for (name, accel) in every_accel(world) {
        let (mut found, mut off) = (0, 0);
        for i in 0..rays {
            let time = rng.uniform();
            let instance = &world.instances()[i % world.instances().len()];
            let (ray, bound) = ray_at(rng, instance, time);
            let expected = brute::intersect(world, &ray, time);
            found += usize::from(expected.is_some());
            let hit = accel.intersect(&ray, time, None);
            if !agree(expected, hit, bound) {
                off += 1;
                assert!(
                    is_rounding(world, &ray, time, hit, bound, rng),
                    "{name}: {hit:?} instead of {expected:?} on {ray:?} at {time}"
                );
                continue;
            }
            if let Some(expected) = expected {
                let slack = 1e-3 * expected.t + bound as f32;
                let until = |t_max: f32| Ray { t_max, ..ray };
                let before = until((expected.t - slack).max(0.0));
                assert!(!accel.occluded(&before, time), "{name} {before:?}");
                let behind = until(expected.t + slack);
                assert!(accel.occluded(&behind, time), "{name} {behind:?}");
            } else {
                assert!(!accel.occluded(&ray, time), "{name} {ray:?}");
            }
        }
        println!("{name}: {found} of {rays} hit, {off} off by rounding");
        assert!(found * 10 > rays, "{name}: only {found} rays hit anything");
        assert!(off * 100 < rays, "{name}: {off} of {rays} off by rounding");
    }
}

#[test]
fn instance_hits_agree_with_brute_force() {
    let mut rng = TestRng::new(11);
    for (kind, transform) in transforms(&mut rng) {
        println!("{kind}");
        let world = placed_once(soup(&mut rng), vec![transform]);
        compare(&world, 3_000, &mut rng);
    }
}

#[test]
fn moving_instance_hits_agree_with_brute_force_at_ray_time() {
    let mut rng = TestRng::new(12);
    for steps in [2, 3, 9] {
        for (kind, transform) in transforms(&mut rng) {
            println!("{kind} in {steps} steps");
            let steps = moving(&mut rng, transform, steps);
            compare(&placed_once(soup(&mut rng), steps), 1_000, &mut rng);
        }
    }
}

#[test]
fn hits_and_ids_across_groups_agree_with_brute_force() {
    let mut rng = TestRng::new(13);
    let groups = vec![soup(&mut rng), vec![], soup(&mut rng)];
    let instances = (0..12).map(|i| {
        let mut start = crate::common::tracing::rotation(&mut rng);
        start.translation = 2.0 * point(&mut rng).as_dvec3();
        let steps = match i % 3 {
            0 => vec![in_single(start)],
            steps => moving(&mut rng, start, 1 + steps),
        };
        Instance {
            group: i % 3,
            steps,
        }
    });
    let instances: Vec<_> = instances.collect();
    let roots = soup(&mut rng);
    let world = Arc::new(World::new(roots, groups, instances));
    assert_eq!(world.shape_count(), 60 + 8 * 60);
    assert_eq!(world.first_shape(2), 120);
    assert!(world.placement(59).is_none());
    assert_eq!(world.placement(119).map(|instance| instance.group), Some(0));
    assert_eq!(world.placement(120).map(|instance| instance.group), Some(2));
    compare(&world, 4_000, &mut rng);
    // The identifiers of the hits agree with those of the oracle, which numbers shapes independently.
    let mut instanced = 0;
    for (name, accel) in every_accel(&world) {
        for _ in 0..2_000 {
            let ray = Ray::new(3.0 * point(&mut rng), direction(&mut rng));
            let time = rng.uniform();
            let expected = brute::intersect(&world, &ray, time).map(|hit| hit.id);
            let id = accel.intersect(&ray, time, None).map(|hit| hit.id);
            assert_eq!(id, expected, "{name} {ray:?} {time}");
            instanced += usize::from(id.is_some_and(|id| id.shape >= 60));
        }
    }
    assert!(instanced > 500, "only {instanced} hits on instances");
}

#[test]
fn identity_instance_hits_equal_those_of_its_shapes() {
    let mut rng = TestRng::new(14);
    let shapes = soup(&mut rng);
    let roots = every_accel(&static_world(shapes.clone()));
    let instance = every_accel(&placed_once(shapes, vec![DAffine3::IDENTITY]));
    let mut found = 0;
    for ((name, root), (_, instance)) in roots.iter().zip(&instance) {
        for _ in 0..5_000 {
            let ray = Ray::new(1.5 * point(&mut rng), direction(&mut rng));
            let hit = instance.intersect(&ray, 0.3, None);
            assert_eq!(hit, root.intersect(&ray, 0.3, None), "{name} {ray:?}");
            assert_eq!(instance.occluded(&ray, 0.3), root.occluded(&ray, 0.3));
            found += usize::from(hit.is_some());
        }
    }
    assert!(found > 1_000);
}

/// With obvhs the hits agree bit for bit. Embree inverts a moving transform for each ray and a static one at build time,
/// and rounds the two differently: its hits agree up to rounding.
#[test]
fn constant_motion_hits_match_those_of_a_static_instance() {
    let mut rng = TestRng::new(15);
    for (kind, transform) in transforms(&mut rng) {
        let shapes = soup(&mut rng);
        let static_world = placed_once(shapes.clone(), vec![transform]);
        let moving = every_accel(&placed_once(shapes, vec![transform; 3]));
        for ((name, still), (_, moving)) in every_accel(&static_world).iter().zip(&moving) {
            let mut off = 0;
            for i in 0..2_000 {
                let time = [0.0, 0.5, rng.uniform()][i % 3];
                let (ray, bound) = ray_at(&mut rng, &static_world.instances()[0], 0.0);
                let expected = still.intersect(&ray, time, None);
                let hit = moving.intersect(&ray, time, None);
                if name.starts_with("obvhs") {
                    assert_eq!(hit, expected, "{kind} {name} {ray:?} {time}");
                } else {
                    off += usize::from(!agree(hit, expected, bound));
                }
            }
            assert!(off < 20, "{kind} {name}: {off} hits differ");
        }
    }
}

/// Closed meshes are watertight in instances as they are in the world (`tests/tracing/rays.rs`): the check of hits in
/// robust precision rejects no true hit.
#[test]
fn robust_tracing_is_watertight_at_instanced_mesh_edges() {
    const RAYS: usize = 2_000;
    let mut rng = TestRng::new(19);
    let mesh = closed_mesh(8, true);
    let edges: Vec<_> = mesh.indices().iter().map(|&[a, b, _]| [a, b]).collect();
    for (kind, transform) in transforms(&mut rng) {
        for steps in [vec![transform], moving(&mut rng, transform, 3)] {
            let world = placed_once(vec![Geometry::Mesh(mesh.clone())], steps);
            for (name, accel) in every_accel(&world) {
                if name.ends_with("fast") {
                    continue;
                }
                let mut escaped = [0; 3];
                for _ in 0..RAYS {
                    let time = rng.uniform();
                    let to_world = world.instances()[0].at(time);
                    let edge = edges[(rng.uniform() * edges.len() as f32) as usize];
                    let [a, b] = edge.map(|i| mesh.vertices()[i as usize].position());
                    let from = 0.5 * point(&mut rng);
                    let targets = [a, a + rng.uniform() * (b - a), from + direction(&mut rng)];
                    for (escaped, target) in escaped.iter_mut().zip(targets) {
                        let [from, to] =
                            [from, target].map(|p| to_world.transform_point3(p.as_dvec3()));
                        let ray = Ray::new(from.as_vec3a(), (to - from).normalize().as_vec3a());
                        let closest = accel.intersect(&ray, time, None);
                        *escaped += usize::from(closest.is_none() || !accel.occluded(&ray, time));
                    }
                }
                println!("{kind} {name}: {escaped:?} of {RAYS} escaped");
                assert_eq!(escaped[1..], [0, 0], "{kind} {name}");
                let at_vertices = if name.starts_with("embree") {
                    RAYS / 1_000
                } else {
                    0
                };
                assert!(escaped[0] <= at_vertices, "{kind} {name}: {escaped:?}");
            }
        }
    }
}

#[test]
fn instance_motion_with_singular_interpolation_is_rejected() {
    // Half a turn in one step: the interpolated transform moves every point through the axis.
    let half_turn = DAffine3::from_scale(DVec3::new(-1.0, 1.0, -1.0));
    for &backend in Backend::ALL {
        let steps = vec![DAffine3::IDENTITY, half_turn];
        let world = placed_once(soup(&mut TestRng::new(16)), steps);
        let error = Accel::build(world, robust(backend)).expect_err("a singular transform");
        assert!(error.to_string().contains("inverted"), "{error}");
    }
}

fn robust(backend: Backend) -> AccelOptions {
    AccelOptions {
        backend,
        precision: Precision::Robust,
        quality: None,
        threads: 1,
    }
}

#[test]
fn nan_rays_miss_instances() {
    let mut rng = TestRng::new(17);
    let world = placed_once(soup(&mut rng), vec![DAffine3::IDENTITY]);
    for (name, accel) in every_accel(&world) {
        let ray = Ray::new(Vec3::splat(f32::NAN), Vec3::X);
        assert_eq!(accel.intersect(&ray, 0.0, None), None, "{name}");
        assert!(!accel.occluded(&ray, 0.0), "{name}");
    }
}

#[cfg(feature = "embree")]
#[test]
fn more_motion_steps_than_embree_supports_are_rejected() {
    let mut rng = TestRng::new(18);
    let world = placed_once(soup(&mut rng), vec![DAffine3::IDENTITY; 130]);
    let error =
        Accel::build(world, robust(Backend::Embree)).expect_err("Embree supports 129 steps");
    assert!(error.to_string().contains("129 steps"), "{error}");
}
