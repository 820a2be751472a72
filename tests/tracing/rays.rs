//! Ray queries of every backend and precision against brute-force intersection in double precision, rays that leave a
//! surface, and rays aimed at the edges and vertices of closed meshes.

use crate::common::TestRng;
use crate::common::tracing::{
    closed_mesh, direction, every_accel, point, same, soup, static_world, triangle,
};
use etendue::internals::accel::{ExcludedPrimitive, Hit, PrimitiveId, brute};
use etendue::internals::effects::Slot;
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::geometry::surface::SurfacePoint;
use etendue::internals::geometry::{Geometry, mesh::Mesh, sphere::Sphere};
use etendue::internals::light::types::ShadowRayEnd;
use etendue::internals::math::ray::Ray;
use etendue::internals::math::robust::offset_point;
use etendue::internals::math::vec::{Vec2, Vec3};
use etendue::internals::scene::interaction::Interaction;

#[test]
fn every_backend_agrees_with_brute_force_intersection() {
    let mut rng = TestRng::new(1);
    let mut found = 0;
    for _ in 0..4 {
        let world = static_world(soup(&mut rng));
        let accels = every_accel(&world);
        for _ in 0..5_000 {
            let ray = Ray::new(1.5 * point(&mut rng), direction(&mut rng));
            let expected = brute::intersect(&world, &ray, 0.0);
            found += usize::from(expected.is_some());
            for (name, accel) in &accels {
                let hit = accel.intersect(&ray, 0.0, None);
                assert!(
                    same(expected, hit),
                    "{name}: {hit:?} instead of {expected:?} on {ray:?}"
                );
                // A segment that ends before the first hit is unoccluded, one that ends behind it is occluded.
                if let Some(expected) = expected {
                    let until = |t_max| Ray { t_max, ..ray };
                    assert!(
                        !accel.occluded(&until(0.999 * expected.t), 0.0),
                        "{name} {ray:?}"
                    );
                    assert!(
                        accel.occluded(&until(1.001 * expected.t), 0.0),
                        "{name} {ray:?}"
                    );
                } else {
                    assert!(!accel.occluded(&ray, 0.0), "{name} {ray:?}");
                }
            }
        }
    }
    assert!(
        found > 2_000,
        "only {found} rays hit: the test has no power"
    );
}

#[test]
fn rays_leaving_a_sphere_hit_it_only_at_the_chord_end() {
    let mut rng = TestRng::new(3);
    for _ in 0..200 {
        let radius = 10.0_f32.powf(4.0 * rng.uniform() - 2.0);
        let sphere = Sphere::new(3.0 * radius * point(&mut rng), radius);
        let shapes = vec![Geometry::Sphere(sphere)];
        let id = PrimitiveId {
            shape: 0,
            primitive: 0,
        };
        for (name, accel) in every_accel(&static_world(shapes.clone())) {
            for _ in 0..50 {
                let n = direction(&mut rng);
                let surface = sphere.surface_along(n);
                let w = direction(&mut rng);
                let outwards = w.dot(n) > 0.0;
                let normal = if outwards { n } else { -n };
                let ray = Ray::new(offset_point(surface.p, surface.error, normal), w);
                let free_distance = sphere.free_distance(surface.p, w, outwards);
                let hit = accel.intersect(&ray, 0.0, Some(ExcludedPrimitive { id, free_distance }));
                if outwards {
                    assert_eq!(hit, None, "{name} {sphere:?} {ray:?}");
                } else {
                    // The far root of the quadratic, from the actual origin of the ray.
                    let offset = ray.origin.as_dvec3() - sphere.center.as_dvec3();
                    let b = offset.dot(w.as_dvec3());
                    let c = offset.length_squared() - f64::from(radius).powi(2);
                    let exit = -b + (b * b - c).sqrt();
                    let t = f64::from(hit.expect("every ray from inside hits the sphere").t);
                    assert!(
                        (t - exit).abs() < 1e-3 * f64::from(radius),
                        "{name} {t} {exit}"
                    );
                }
            }
        }
    }
}

/// A ray whose origin lies slightly in front of the primitive that it left, as rounding may place it.
#[test]
fn excluded_primitive_is_skipped_up_to_its_free_distance() {
    let square = |z: f32| {
        triangle([(-1.0, -1.0), (3.0, -1.0), (-1.0, 3.0)].map(|(x, y)| Vec3::new(x, y, z)))
    };
    let id = |shape| PrimitiveId {
        shape,
        primitive: 0,
    };
    for (name, accel) in every_accel(&static_world(vec![square(0.0), square(1.0)])) {
        let ray = Ray::new(Vec3::new(0.1, 0.2, -0.125), Vec3::Z);
        let met = |left, free_distance| {
            let left = ExcludedPrimitive {
                id: id(left),
                free_distance,
            };
            let hit = accel.intersect(&ray, 0.0, Some(left));
            hit.expect("both triangles are ahead").id
        };
        assert_eq!(met(0, f32::INFINITY), id(1), "{name}");
        assert_eq!(met(0, 0.25), id(1), "{name}");
        assert_eq!(met(0, 0.0625), id(0), "{name}");
        assert_eq!(met(1, f32::INFINITY), id(0), "{name}");
    }
}

/// Counts rays that escape from within closed meshes, of 20,000 each: aimed at vertices, at points of edges, anywhere.
///
/// Embree's robust mode is watertight along edges. At a vertex it is not quite (Embree issue 181): of rays aimed
/// exactly at one, about one in 10^4 escapes here, and more if the mesh is finer. That of obvhs lets none escape. Fast mode
/// is measured and printed without a limit.
#[test]
fn robust_tracing_is_watertight_at_closed_mesh_edges() {
    const RAYS: usize = 20_000;
    let mut rng = TestRng::new(4);
    for (n, round) in [(1, false), (6, false), (8, true)] {
        let mesh = closed_mesh(n, round);
        let vertices: Vec<Vec3> = mesh.positions().collect();
        let triangles = mesh.indices().to_vec();
        let shapes = vec![Geometry::Mesh(mesh)];
        for (name, accel) in every_accel(&static_world(shapes.clone())) {
            let mut escaped = [0; 3];
            for _ in 0..RAYS {
                let from = 0.5 * point(&mut rng);
                let corners = triangles[(rng.uniform() * triangles.len() as f32) as usize];
                let [a, b, _] = corners.map(|i| vertices[i as usize]);
                let targets = [a, a + rng.uniform() * (b - a), from + direction(&mut rng)];
                for (escaped, target) in escaped.iter_mut().zip(targets) {
                    let ray = Ray::new(from, (target - from).normalize());
                    let closest = accel.intersect(&ray, 0.0, None);
                    *escaped += usize::from(closest.is_none() || !accel.occluded(&ray, 0.0));
                }
            }
            println!("{name}, {n} squares an edge, round {round}: {escaped:?} of {RAYS} escaped");
            if name.ends_with("robust") {
                assert_eq!(escaped[1..], [0, 0], "{name}");
                let at_vertices = if name.starts_with("embree") {
                    RAYS / 1_000
                } else {
                    0
                };
                assert!(escaped[0] <= at_vertices, "{name}: {escaped:?}");
            }
        }
    }
}

#[test]
fn shadow_rays_hit_near_occluders_but_not_the_light_itself() {
    let square = |y: f32, half: f32| {
        let corner = |x: f32, z: f32| Vec3::new(half * x, y, half * z);
        let corners = vec![
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        Geometry::Mesh(Mesh::new(
            corners,
            vec![],
            vec![],
            vec![[0, 1, 2], [0, 2, 3]],
        ))
    };
    let nowhere = Ray::new(Vec3::ZERO, Vec3::X);
    for gap in [0.0, 1e-2, 1e-4, 1e-5] {
        let mut shapes = vec![square(0.0, 1.0), square(1.0, 0.5)];
        if gap > 0.0 {
            // Slightly larger than the light, to occlude it from everywhere below.
            shapes.push(square(1.0 - gap, 0.51));
        }
        for (name, accel) in every_accel(&static_world(shapes.clone())) {
            for i in 0..100 {
                let at = |k: u32| (i * k % 101) as f32 / 202.0;
                let floor: SurfacePoint = shapes[0].surface_at(0, &nowhere, 0.0, [at(7), at(13)]);
                let light: SurfacePoint = shapes[1].surface_at(1, &nowhere, 0.0, [at(31), at(57)]);
                let w = (light.p - floor.p).normalize();
                let down = Ray::new(floor.p + Vec3::Y, -Vec3::Y);
                let id = PrimitiveId {
                    shape: 0,
                    primitive: 0,
                };
                let hit = Hit {
                    id,
                    t: 1.0,
                    uv: [0.0; 2],
                };
                let uv = Slot::new(|| Vec2::ZERO);
                let at = Interaction::<Everything>::new(&down, &hit, &floor, false, uv);
                let segment = at.ray_to(&ShadowRayEnd::Surface(light, [0.0; 2]), w, false);
                assert_eq!(
                    accel.occluded(&segment, 0.0),
                    gap > 0.0,
                    "{name} {gap} {segment:?}"
                );
            }
        }
    }
}

/// A point light in the plane of a surface, as in a ceiling: rounding decides on which side it is.
#[test]
fn surface_through_a_point_light_does_not_occlude_it() {
    let mut rng = TestRng::new(11);
    let mut met = 0;
    for round in 0..200 {
        let light = point(&mut rng);
        let [u, v] = [0, 1].map(|_| direction(&mut rng));
        // Slivers are left out: fast tracing does not resolve their plane.
        if u.cross(v).length() < 0.3 {
            continue;
        }
        let normal = u.cross(v).normalize();
        let [s, t] = [0, 1].map(|_| 0.2 + 0.2 * rng.uniform());
        let corner = light - s * u - t * v;
        let around = Geometry::Mesh(Mesh::new(
            vec![corner, corner + u, corner + v],
            vec![],
            vec![],
            vec![[0, 1, 2]],
        ));
        for (name, accel) in every_accel(&static_world(vec![around])) {
            for _ in 0..20 {
                let from = point(&mut rng);
                // Grazing views are left out: the rounding error along the ray grows with 1 / cosine.
                if (from - light).normalize().dot(normal).abs() < 0.3 {
                    continue;
                }
                assert!(
                    !accel.occluded(&Ray::to_point(from, light), 0.0),
                    "{name}, round {round}: {from} {light}"
                );
                // The light is unoccluded from a point right at it, too.
                for near in [light, light.map(f32::next_up)] {
                    assert!(!accel.occluded(&Ray::to_point(near, light), 0.0), "{name}");
                }
                // A point behind the surface by much more than rounding is occluded.
                let behind = light + 1e-4 * (light - from).normalize();
                assert!(accel.occluded(&Ray::to_point(from, behind), 0.0), "{name}");
                met += 1;
            }
        }
    }
    assert!(met > 5000, "{met}");
}

/// The rounding error at the end of a segment grows with its length: a small light about the origin is exact, the end of a
/// ray from far away is not.
#[test]
fn long_shadow_rays_do_not_hit_their_target_light() {
    let mut rng = TestRng::new(7);
    let nowhere = Ray::new(Vec3::ZERO, Vec3::X);
    for _ in 0..200 {
        let light = triangle([0, 1, 2].map(|_| 1e-3 * point(&mut rng)));
        let accels = every_accel(&static_world(vec![light.clone()]));
        for _ in 0..20 {
            let u = etendue::internals::sampling::warp::sample_triangle_uniform(rng.uniform_2d());
            let end: SurfacePoint = light.surface_at(0, &nowhere, 0.0, u.to_array());
            let normal = direction(&mut rng);
            let p = 10.0_f32.powf(3.0 * rng.uniform()) * -normal;
            let receiver = SurfacePoint {
                p,
                error: 1e-6 * p.abs(),
                ng: normal,
                ns: normal,
            };
            let hit = Hit {
                id: PrimitiveId {
                    shape: 1,
                    primitive: 0,
                },
                t: 1.0,
                uv: [0.0; 2],
            };
            let uv = Slot::new(|| Vec2::ZERO);
            let from_above = Ray::new(p + normal, -normal);
            let at = Interaction::<Everything>::new(&from_above, &hit, &receiver, false, uv);
            let w = (end.p - p).normalize();
            let segment = at.ray_to(&ShadowRayEnd::Surface(end, [0.0; 2]), w, false);
            for (name, accel) in &accels {
                assert!(
                    !accel.occluded(&segment, 0.0),
                    "{name} {light:?} {segment:?}"
                );
            }
        }
    }
}

#[test]
fn non_finite_rays_hit_nothing() {
    let shapes = soup(&mut TestRng::new(5));
    for (name, accel) in every_accel(&static_world(shapes.clone())) {
        for bad in [f32::NAN, f32::INFINITY] {
            for ray in [
                Ray::new(Vec3::splat(bad), Vec3::X),
                Ray::new(Vec3::ZERO, Vec3::new(bad, 0.0, 0.0)),
            ] {
                assert_eq!(accel.intersect(&ray, 0.0, None), None, "{name}");
                assert!(!accel.occluded(&ray, 0.0), "{name}");
            }
        }
    }
}

#[test]
fn rays_in_a_scene_without_shapes_hit_nothing() {
    for (name, accel) in every_accel(&static_world(vec![])) {
        let ray = Ray::new(Vec3::ZERO, Vec3::X);
        assert_eq!(accel.intersect(&ray, 0.0, None), None, "{name}");
        assert!(!accel.occluded(&ray, 0.0), "{name}");
    }
}
