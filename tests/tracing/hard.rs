//! Rays that are difficult for a BVH, in both layouts and qualities of obvhs, against brute-force intersection: parallel to
//! axes, from far away, from the faces of boxes, with extreme directions, with t_min and t_max; and geometry that is
//! difficult for a BVH: deep trees, flat boxes, tiny and huge triangles side by side.
//!
//! In robust precision triangles are intersected as by brute force, so that a hit at another distance means a missed box.

use crate::common::TestRng;
use crate::common::tracing::{
    closed_mesh, direction, placed_once, point, same, soup, static_world, triangle,
};
use etendue::internals::accel::{Accel, AccelOptions, Backend, Precision, Quality, brute};
use etendue::internals::geometry::Geometry;
use etendue::internals::geometry::mesh::Mesh;
use etendue::internals::geometry::world::World;
use etendue::internals::math::ray::Ray;
use etendue::internals::math::vec::{DAffine3, Vec3};
use std::sync::Arc;

/// The acceleration structures of every obvhs backend and quality in a precision.
fn accels(world: &Arc<World>, precision: Precision) -> Vec<(String, Accel)> {
    let mut all = Vec::new();
    for backend in [Backend::ObvhsBvh2, Backend::ObvhsCwbvh] {
        for (quality, threads) in [(Quality::Medium, 1), (Quality::High, 2)] {
            let options = AccelOptions {
                backend,
                precision,
                quality: Some(quality),
                threads,
            };
            let accel = Accel::build(Arc::clone(world), options).expect("a small scene");
            let names = [backend.name(), precision.name(), quality.name()];
            all.push((names.join(" "), accel));
        }
    }
    all
}

/// Triangles from 10^-5 to 10^5 units, all about the origin; the large ones lie in the plane y = 0.
fn all_sizes(rng: &mut TestRng) -> Vec<Geometry> {
    let detail = (0..100).map(|_| {
        let size = 10.0_f32.powf(-5.0 * rng.uniform());
        let center = size * point(rng);
        triangle([0, 1, 2].map(|_| center + size * point(rng)))
    });
    let detail: Vec<_> = detail.collect();
    let flat = (0..5).map(|i| {
        let corner = |x: f32, z: f32| 10.0_f32.powi(i + 1) * Vec3::new(x, 0.0, z);
        triangle([corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0)])
    });
    detail.into_iter().chain(flat).collect()
}

/// The squares of a grid in a plane of constant y: every box is flat, and every edge is also an edge of boxes.
fn grid(n: u32, y: f32) -> Geometry {
    let at = |i: u32, j: u32| Vec3::new(i as f32 / n as f32, y, j as f32 / n as f32);
    let corners = (0..=n).flat_map(|i| (0..=n).map(move |j| at(i, j)));
    let place = |i: u32, j: u32| i * (n + 1) + j;
    let squares = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let halves = squares.flat_map(|(i, j)| {
        let [a, b] = [place(i, j), place(i + 1, j + 1)];
        [[a, place(i + 1, j), b], [a, b, place(i, j + 1)]]
    });
    let (corners, halves) = (corners.collect(), halves.collect());
    Geometry::Mesh(Mesh::new(corners, vec![], vec![], halves))
}

/// A point of a random triangle: inside, on an edge, or a vertex; the centre of any other shape.
fn target(rng: &mut TestRng, shapes: &[Geometry]) -> Vec3 {
    let shape = &shapes[(rng.uniform() * shapes.len() as f32) as usize];
    let primitive = (rng.uniform() * shape.primitive_count() as f32) as u32;
    let Geometry::Mesh(mesh) = shape else {
        return shape.bounds().centre().as_vec3a();
    };
    let [a, b, c] = mesh.triangle(primitive);
    let (u, v) = (rng.uniform(), rng.uniform());
    match (3.0 * rng.uniform()) as u32 {
        0 => a,
        1 => a + u * (b - a),
        _ => a + u * (1.0 - v) * (b - a) + u * v * (c - a),
    }
}

/// A ray of a random difficult kind towards a point, which it reaches at about t = 1, or 1 over the direction's scale.
fn hard_ray(rng: &mut TestRng, target: Vec3) -> Ray {
    let distance = 10.0_f32.powf(9.0 * rng.uniform() - 5.0);
    let mut dir = distance * direction(rng);
    let axis = (3.0 * rng.uniform()) as usize;
    match (5.0 * rng.uniform()) as u32 {
        // Parallel to an axis, with zeros of either sign.
        0 => {
            let zero = if rng.uniform() < 0.5 { 0.0 } else { -0.0 };
            let along = dir[axis];
            dir = Vec3::splat(zero);
            dir[axis] = along;
        }
        // Parallel to a plane, or nearly.
        1 => dir[axis] = [0.0, -0.0, 1e-8, -1e-12, 1e-30][(5.0 * rng.uniform()) as usize],
        _ => {}
    }
    let origin = target - dir;
    let scale = [1.0, 1.0, 1e-30, 1e20][(4.0 * rng.uniform()) as usize];
    let mut ray = Ray::new(origin, scale * dir);
    if rng.uniform() < 0.3 {
        // t_min and t_max on either side of the target, or at it.
        let around = |rng: &mut TestRng| [0.5, 1.0, 1.5][(3.0 * rng.uniform()) as usize] / scale;
        (ray.t_min, ray.t_max) = (around(rng).min(0.9 / scale), around(rng));
    }
    ray
}

/// Geometry that is difficult for a BVH.
fn worlds(rng: &mut TestRng) -> Vec<(&'static str, Vec<Geometry>)> {
    let axes = [false, true].map(|round| Geometry::Mesh(closed_mesh(6, round)));
    let [cube, ball] = axes;
    vec![
        ("soup", soup(rng)),
        ("all sizes", all_sizes(rng)),
        ("grids", vec![grid(16, 0.0), grid(12, 0.25), grid(1, -1.0)]),
        ("cube", vec![cube]),
        ("ball", vec![ball]),
    ]
}

#[test]
fn robust_hit_distances_equal_brute_force_on_hard_rays() {
    const RAYS: usize = 20_000;
    let mut rng = TestRng::new(31);
    for (kind, shapes) in worlds(&mut rng) {
        let world = static_world(shapes.clone());
        let accels = accels(&world, Precision::Robust);
        let mut found = 0;
        for _ in 0..RAYS {
            let target = target(&mut rng, &shapes);
            let ray = hard_ray(&mut rng, target);
            let expected = brute::intersect(&world, &ray, 0.0).map(|hit| hit.t);
            found += usize::from(expected.is_some());
            for (name, accel) in &accels {
                let t = accel.intersect(&ray, 0.0, None).map(|hit| hit.t);
                assert_eq!(t, expected, "{kind} {name} {ray:?}");
                let occluded = accel.occluded(&ray, 0.0);
                assert_eq!(occluded, expected.is_some(), "{kind} {name} {ray:?}");
            }
        }
        println!("{kind}: {found} of {RAYS} hit");
        assert!(found * 4 > RAYS, "{kind}: only {found} rays hit");
    }
}

/// Single precision displaces a triangle by the rounding error of the distance: rays from further than its size are left out,
/// and some rays that are aimed at edges and vertices miss.
#[test]
fn fast_hits_mostly_match_brute_force() {
    const RAYS: usize = 20_000;
    let mut rng = TestRng::new(32);
    for (kind, shapes) in worlds(&mut rng) {
        let world = static_world(shapes.clone());
        for (name, accel) in accels(&world, Precision::Fast) {
            let (mut aimed, mut off) = (0, 0);
            for _ in 0..RAYS {
                let inner = point(&mut rng);
                let ray = Ray::new(1.5 * point(&mut rng), direction(&mut rng));
                let ray = if kind == "all sizes" {
                    Ray::new(inner, target(&mut rng, &shapes) - inner)
                } else {
                    ray
                };
                let expected = brute::intersect(&world, &ray, 0.0);
                let hit = accel.intersect(&ray, 0.0, None);
                aimed += usize::from(expected.is_some());
                off += usize::from(!same(expected, hit));
                assert_eq!(accel.occluded(&ray, 0.0), hit.is_some(), "{name} {ray:?}");
            }
            println!("{kind} {name}: {off} of {RAYS} differ, {aimed} hit");
            let one_of = if kind == "all sizes" { 10 } else { 1_000 };
            assert!(off * one_of <= RAYS, "{kind} {name}: {off}");
            assert!(aimed * 20 > RAYS, "{kind} {name}: only {aimed} rays hit");
        }
    }
}

#[test]
fn occlusion_equals_existence_of_a_closest_hit() {
    let mut rng = TestRng::new(33);
    for (kind, shapes) in worlds(&mut rng) {
        let worlds = [
            static_world(shapes.clone()),
            placed_once(shapes.clone(), vec![DAffine3::IDENTITY]),
        ];
        for world in &worlds {
            for precision in [Precision::Robust, Precision::Fast] {
                let accels = accels(world, precision);
                for _ in 0..5_000 {
                    let target = target(&mut rng, &shapes);
                    let ray = hard_ray(&mut rng, target);
                    for (name, accel) in &accels {
                        let hit = accel.intersect(&ray, 0.0, None);
                        let occluded = accel.occluded(&ray, 0.0);
                        assert_eq!(occluded, hit.is_some(), "{kind} {name} {ray:?} {hit:?}");
                        let within = |t: f32| t >= ray.t_min && t <= ray.t_max;
                        assert!(hit.is_none_or(|hit| within(hit.t)), "{kind} {name} {ray:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn hits_at_t_max_count_and_hits_at_t_min_do_not() {
    let shapes = vec![grid(3, 2.0)];
    let worlds = [
        static_world(shapes.clone()),
        placed_once(shapes, vec![DAffine3::IDENTITY]),
    ];
    for world in &worlds {
        for precision in [Precision::Robust, Precision::Fast] {
            for (name, accel) in accels(world, precision) {
                let hits = |t_min, t_max| {
                    let (origin, dir) = (Vec3::new(0.4, 1.0, 0.3), Vec3::new(-0.0, 0.5, 0.0));
                    let ray = Ray {
                        origin,
                        dir,
                        t_min,
                        t_max,
                    };
                    accel.intersect(&ray, 0.0, None).is_some()
                };
                assert!(hits(0.0, 2.0) && hits(2.0_f32.next_down(), 2.0), "{name}");
                assert!(!hits(2.0, 3.0) && !hits(0.0, 2.0_f32.next_down()), "{name}");
            }
        }
    }
}

/// Triangles, each half as large as the one before and half as far: the tree is one long branch, deeper than the traversal
/// stacks of obvhs.
#[test]
fn deep_bvh_traversal_matches_brute_force() {
    let nested = (0..120).map(|k| {
        let size = 0.5_f32.powi(k);
        let corner = |y: f32, z: f32| size * Vec3::new(1.0, y, z);
        triangle([corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0)])
    });
    let world = static_world(nested.collect());
    let mut rng = TestRng::new(34);
    for (name, accel) in accels(&world, Precision::Robust) {
        for _ in 0..2_000 {
            let from = Vec3::new(if rng.uniform() < 0.5 { -1.0 } else { 2.0 }, 0.0, 0.0);
            let aim = 0.5_f32.powf(140.0 * rng.uniform()) * point(&mut rng);
            let ray = Ray::new(from, aim - from);
            let expected = brute::intersect(&world, &ray, 0.0).map(|hit| hit.t);
            let t = accel.intersect(&ray, 0.0, None).map(|hit| hit.t);
            assert_eq!(t, expected, "{name} {ray:?}");
            let none_before = Ray {
                t_max: expected.map_or(f32::INFINITY, f32::next_down),
                ..ray
            };
            let occluded = brute::occluded(&world, &none_before, 0.0);
            assert_eq!(
                accel.occluded(&none_before, 0.0),
                occluded,
                "{name} {ray:?}"
            );
        }
    }
}
