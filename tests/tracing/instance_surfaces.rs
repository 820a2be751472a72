//! Surfaces of instances in world space: points, normals and error bounds against the transformed shape in double
//! precision, and rays that leave them.

use crate::common::TestRng;
use crate::common::tracing::{
    direction, every_accel, moving, placed_once, point, transforms, triangle,
};
use etendue::internals::accel::{ExcludedPrimitive, PrimitiveId};
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::geometry::surface::SurfacePoint;
use etendue::internals::geometry::{Geometry, disk::Disk, mesh::Mesh, sphere::Sphere};
use etendue::internals::math::ray::Ray;
use etendue::internals::math::robust::offset_point;
use etendue::internals::math::vec::{DAffine3, DVec3, Vec2, Vec3};

const ID: PrimitiveId = PrimitiveId {
    shape: 0,
    primitive: 0,
};

/// Every transform, static and moving in 2 and in 3 steps.
fn motions(rng: &mut TestRng) -> Vec<(String, Vec<DAffine3>)> {
    let mut all = Vec::new();
    for (kind, transform) in transforms(rng) {
        all.push((kind.to_owned(), vec![transform]));
        for steps in [2, 3] {
            let name = format!("{kind} in {steps} steps");
            all.push((name, moving(rng, transform, steps)));
        }
    }
    all
}

/// The transform from group to world at `time`, interpolated here in double precision.
fn at(steps: &[DAffine3], time: f32) -> DAffine3 {
    let Some(last) = steps.len().checked_sub(2) else {
        return steps[0];
    };
    let scaled = f64::from(time) * (last + 1) as f64;
    let i = (scaled as usize).min(last);
    let f = scaled - i as f64;
    let (a, b) = (steps[i].to_cols_array(), steps[i + 1].to_cols_array());
    DAffine3::from_cols_array(&std::array::from_fn(|k| (1.0 - f) * a[k] + f * b[k]))
}

/// The ray in the world between two points of the group, and their distance in the world.
fn between(m: &DAffine3, from: DVec3, target: DVec3) -> (Ray, f32) {
    let (origin, end) = (m.transform_point3(from), m.transform_point3(target));
    let ray = Ray::new(origin.as_vec3a(), (end - origin).normalize().as_vec3a());
    (ray, (end - origin).length() as f32)
}

fn within(p: DVec3, surface: &SurfacePoint) -> bool {
    (p - surface.p.as_dvec3())
        .abs()
        .cmple(surface.error.as_dvec3())
        .all()
}

#[test]
fn instanced_triangle_surface_matches_the_world_space_triangle() {
    let mut rng = TestRng::new(21);
    for (name, steps) in motions(&mut rng) {
        for _ in 0..300 {
            let vertices = [0, 1, 2].map(|_| point(&mut rng));
            let normals = [0, 1, 2].map(|_| direction(&mut rng));
            let uvs = [0, 1, 2].map(|_| rng.uniform_2d());
            let mesh = Mesh::new(
                vertices.to_vec(),
                normals.to_vec(),
                uvs.to_vec(),
                vec![[0, 1, 2]],
            );
            let world = placed_once(vec![Geometry::Mesh(mesh.clone())], steps.clone());
            let (time, [u, v]) = (
                rng.uniform(),
                etendue::internals::sampling::warp::sample_triangle_uniform(rng.uniform_2d())
                    .to_array(),
            );
            let nowhere = Ray::new(Vec3::ZERO, Vec3::X);
            let surface = world.surface_at::<Everything>(ID, &nowhere, time, 0.0, [u, v]);

            let m = at(&steps, time);
            let [a, b, c] = vertices.map(|vertex| m.transform_point3(vertex.as_dvec3()));
            let weights = [1.0 - f64::from(u) - f64::from(v), u.into(), v.into()];
            let p = weights[0] * a + weights[1] * b + weights[2] * c;
            assert!(within(p, &surface), "{name} {p} {surface:?}");

            // A mirroring transform reverses the winding; the normal still points to the outside.
            let side = m.matrix3.determinant().signum();
            let ng = side * (b - a).cross(c - a).normalize();
            assert!(surface.ng.as_dvec3().distance(ng) < 1e-6, "{name}");
            let inverse_transpose = m.matrix3.inverse().transpose();
            let interpolated = (0..3).map(|k| weights[k] * normals[k].as_dvec3());
            let ns = (inverse_transpose * interpolated.sum::<DVec3>()).normalize();
            let ns = ns.dot(ng).signum() * ns;
            let cosine = surface.ns.as_dvec3().dot(ns);
            assert!(
                cosine > 1.0 - 1e-4 && surface.ns.dot(surface.ng) >= 0.0,
                "{name} {cosine}"
            );

            assert_eq!(
                world.uv_at::<Everything>(ID, time, surface.p, [u, v]),
                mesh.uv_at(0, [u, v])
            );
            // p(u, v) is linear: the tangents map the edges in texture space to those of the triangle.
            let [along_u, along_v] = world.tangents_at::<Everything>(ID, time, surface.p);
            let edge = uvs[1] - uvs[0];
            let carried = edge.x * along_u + edge.y * along_v;
            let size = along_u.abs() * edge.x.abs() + along_v.abs() * edge.y.abs();
            let apart = (carried.as_dvec3() - (b - a)).length();
            assert!(
                apart <= 1e-3 * f64::from(size.length()),
                "{name} {carried} {}",
                b - a
            );
        }
    }
}

#[test]
fn instanced_sphere_and_disk_surfaces_match_their_equations() {
    let mut rng = TestRng::new(22);
    for (name, steps) in motions(&mut rng) {
        for _ in 0..300 {
            let center = point(&mut rng);
            let sphere = Sphere::new(center, 0.4);
            let normal = direction(&mut rng);
            let disk = Disk::new(center, normal, 0.4);
            let time = rng.uniform();
            let m = at(&steps, time);
            let n = direction(&mut rng).as_dvec3();

            let world = placed_once(vec![Geometry::Sphere(sphere)], steps.clone());
            let target = center.as_dvec3() + 0.4 * n;
            let inside = rng.uniform() < 0.5;
            let from = center.as_dvec3() + if inside { DVec3::ZERO } else { 2.0 * n };
            let (ray, t) = between(&m, from, target);
            let surface = world.surface_at::<Everything>(ID, &ray, time, t, [0.0; 2]);
            let inverse = m.inverse();
            let local = inverse.transform_point3(surface.p.as_dvec3()) - center.as_dvec3();
            let nearest = center.as_dvec3() + 0.4 * local.normalize();
            assert!(
                within(m.transform_point3(nearest), &surface),
                "{name} {surface:?}"
            );
            let ng = (inverse.matrix3.transpose() * local).normalize();
            assert!(
                surface.ng.as_dvec3().dot(ng) > 1.0 - 1e-4,
                "{name} {ng} {surface:?}"
            );
            assert_eq!(surface.ng.dot(ray.dir) > 0.0, inside, "{name}");

            let world = placed_once(vec![Geometry::Disk(disk)], steps.clone());
            let across = n.cross(normal.as_dvec3()).normalize_or(DVec3::ZERO);
            let target = center.as_dvec3() + 0.3 * across;
            let (ray, t) = between(&m, target + normal.as_dvec3(), target);
            let surface = world.surface_at::<Everything>(ID, &ray, time, t, [0.0; 2]);
            let ng = (inverse.matrix3.transpose() * normal.as_dvec3()).normalize();
            assert!(
                surface.ng.as_dvec3().distance(ng) < 1e-5,
                "{name} {ng} {surface:?}"
            );
            let to_plane = (surface.p.as_dvec3() - m.transform_point3(center.as_dvec3())).dot(ng);
            let bound = surface.error.as_dvec3().dot(ng.abs());
            assert!(to_plane.abs() <= bound, "{name} {to_plane} {bound}");
            let uv = world.uv_at::<Everything>(ID, time, surface.p, [0.0; 2]);
            let distance = (2.0 * uv - Vec2::ONE).length();
            assert!(
                (distance - 0.75 * across.length() as f32).abs() < 1e-2,
                "{name} {distance}"
            );
        }
    }
}

/// A unit vector to either side of a normal, every other one at a grazing angle down to 1e-7.
fn leaving(rng: &mut TestRng, ng: Vec3) -> (Vec3, bool) {
    let mut w = direction(rng);
    if rng.uniform() < 0.5 {
        let tangent = w.cross(ng).normalize_or(Vec3::X);
        let height = 10.0_f32.powf(-7.0 * rng.uniform());
        w = (tangent + height * w.dot(ng).signum() * ng).normalize();
    }
    (w, w.dot(ng) > 0.0)
}

#[test]
fn rays_leaving_flat_instanced_shapes_do_not_self_intersect() {
    let mut rng = TestRng::new(23);
    for (name, steps) in motions(&mut rng) {
        for i in 0..12 {
            let size = 10.0_f32.powf(2.0 * rng.uniform() - 1.5);
            let away = 3.0 * rng.uniform() * point(&mut rng);
            let normal = direction(&mut rng);
            let disk = Disk::new(away, normal, size);
            let shape = if i % 2 == 0 {
                triangle([0, 1, 2].map(|_| away + size * point(&mut rng)))
            } else {
                Geometry::Disk(disk)
            };
            let world = placed_once(vec![shape.clone()], steps.clone());
            for (backend, accel) in every_accel(&world) {
                for _ in 0..100 {
                    let time = rng.uniform();
                    let u = etendue::internals::sampling::warp::sample_triangle_uniform(
                        rng.uniform_2d(),
                    );
                    // For a disk, the surface point nearest to a point off its plane.
                    let beside = away + 0.5 * size * direction(&mut rng);
                    let beside = at(&steps, time).transform_point3(beside.as_dvec3());
                    let near = Ray::new(beside.as_vec3a(), Vec3::X);
                    let surface =
                        world.surface_at::<Everything>(ID, &near, time, 0.0, u.to_array());
                    let (w, outside) = leaving(&mut rng, surface.ng);
                    let normal = if outside { surface.ng } else { -surface.ng };
                    let ray = Ray::new(offset_point(surface.p, surface.error, normal), w);
                    let free_distance =
                        world.free_distance::<Everything>(ID, time, surface.p, w, outside);
                    let left = ExcludedPrimitive {
                        id: ID,
                        free_distance,
                    };
                    let hit = accel.intersect(&ray, time, Some(left));
                    assert_eq!(hit, None, "{name} {backend} {shape:?} {ray:?}");
                    assert!(
                        !accel.occluded(&ray, time),
                        "{name} {backend}: self-shadowing, {shape:?} {surface:?} {ray:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn rays_leaving_an_ellipsoid_hit_it_only_at_the_chord_end() {
    let mut rng = TestRng::new(24);
    let (mut long, mut short) = (0, 0);
    for (name, steps) in motions(&mut rng) {
        for _ in 0..10 {
            let radius = 10.0_f32.powf(2.0 * rng.uniform() - 1.5);
            let center = 3.0 * radius * point(&mut rng);
            let sphere = Sphere::new(center, radius);
            let world = placed_once(vec![Geometry::Sphere(sphere)], steps.clone());
            for (backend, accel) in every_accel(&world) {
                for _ in 0..100 {
                    let time = rng.uniform();
                    let m = at(&steps, time);
                    let n = direction(&mut rng).as_dvec3();
                    let target = center.as_dvec3() + f64::from(radius) * n;
                    let (ray, t) = between(&m, target + f64::from(radius) * n, target);
                    let surface = world.surface_at::<Everything>(ID, &ray, time, t, [0.0; 2]);
                    let w = direction(&mut rng);
                    let outside = w.dot(surface.ng) > 0.0;
                    let normal = if outside { surface.ng } else { -surface.ng };
                    let ray = Ray::new(offset_point(surface.p, surface.error, normal), w);
                    let free_distance =
                        world.free_distance::<Everything>(ID, time, surface.p, w, outside);
                    let left = ExcludedPrimitive {
                        id: ID,
                        free_distance,
                    };
                    let hit = accel.intersect(&ray, time, Some(left));
                    if outside {
                        assert_eq!(hit, None, "{name} {backend} {sphere:?} {ray:?}");
                        assert!(!accel.occluded(&ray, time), "{name} {backend} {ray:?}");
                        continue;
                    }
                    // The far root of the quadratic in the sphere's own frame, from the actual origin of the ray.
                    let local = m.inverse();
                    let d = local.transform_vector3(w.as_dvec3());
                    let o = local.transform_point3(ray.origin.as_dvec3()) - center.as_dvec3();
                    let (a, b) = (d.length_squared(), o.dot(d));
                    let c = o.length_squared() - f64::from(radius).powi(2);
                    let exit = (-b + (b * b - a * c).sqrt()) / a;
                    // Chords that are not longer than the rounding error are inconclusive.
                    let error = f64::from(surface.error.length());
                    if exit < 10.0 * error {
                        short += 1;
                        continue;
                    }
                    long += 1;
                    let t = f64::from(hit.expect("a ray from inside hits the ellipsoid").t);
                    let size = f64::from(radius) / a.sqrt();
                    let bound = size.mul_add(1e-3, 20.0 * error);
                    assert!((t - exit).abs() < bound, "{name} {backend} {t} {exit}");
                }
            }
        }
    }
    println!("{short} chords too short to tell, {long} long enough");
    assert!(
        short * 50 < long,
        "{short} chords too short, {long} long enough"
    );
}

/// Row 42 of the catalogue of hard cases: the normals of a mirrored closed shape still point to the outside.
#[test]
fn mirrored_box_geometric_normals_point_outward() {
    let corner = |i: usize| {
        let side = |axis: usize| if i >> axis & 1 == 1 { 1.0 } else { -1.0 };
        Vec3::new(side(0), side(1), side(2))
    };
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles = faces
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let mesh = Mesh::new(
        (0..8).map(corner).collect(),
        vec![],
        vec![],
        triangles.collect(),
    );
    let mut rng = TestRng::new(25);
    let (mut mirrored, mut found) = (0, 0);
    for (name, steps) in motions(&mut rng) {
        let world = placed_once(vec![Geometry::Mesh(mesh.clone())], steps.clone());
        for (backend, accel) in every_accel(&world) {
            for _ in 0..100 {
                let time = rng.uniform();
                let m = at(&steps, time);
                mirrored += usize::from(m.matrix3.determinant() < 0.0);
                let from = 4.0 * direction(&mut rng).as_dvec3();
                let (ray, _) = between(&m, from, 0.5 * point(&mut rng).as_dvec3());
                let Some(hit) = accel.intersect(&ray, time, None) else {
                    panic!("{name} {backend}: {ray:?} misses the box");
                };
                let surface = world.surface_at::<Everything>(hit.id, &ray, time, hit.t, hit.uv);
                assert!(surface.ng.dot(ray.dir) < 0.0, "{name} {backend} {ray:?}");
                found += 1;
            }
        }
    }
    assert!(mirrored * 10 > found, "{mirrored} of {found}");
}
