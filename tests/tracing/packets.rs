//! Packets of rays, of every backend, precision and number of rays, against packets of one and against single rays: the hit of a
//! ray does not depend on the other rays of its packet, bit for bit.

use crate::common::TestRng;
use crate::common::tracing::{
    closed_mesh, direction, every_accel, in_single, moving, point, rotation, same, soup,
    static_world,
};
use etendue::internals::accel::lanes::{ExcludedLanes, RayHitLanes, RayLanes};
use etendue::internals::accel::{Accel, ExcludedPrimitive, Hit};
use etendue::internals::geometry::Geometry;
use etendue::internals::geometry::mesh::Mesh;
use etendue::internals::geometry::world::{Instance, World};
use etendue::internals::math::lanes::{ActiveLanes, LANES};
use etendue::internals::math::ray::Ray;
use std::sync::Arc;

/// A ray, its time, and the primitive that it leaves.
type TestRay = (Ray, f32, Option<ExcludedPrimitive>);

/// The ray without an end.
fn endless(ray: &Ray) -> Ray {
    Ray {
        t_max: f32::INFINITY,
        ..*ray
    }
}

/// The closest hit of each ray without its end, and whether the ray is occluded. The lanes are the last ones.
fn traced(accel: &Accel, rays: &[TestRay]) -> Vec<(Option<Hit>, bool)> {
    let (mut packet, mut excluded) = (RayHitLanes::default(), ExcludedLanes::NONE);
    let mut shadow = RayLanes::default();
    let mut active = ActiveLanes::NONE;
    let lanes = LANES - rays.len()..LANES;
    for (lane, (ray, time, left)) in lanes.clone().zip(rays) {
        active.set(lane, true);
        packet.rays.set(lane, &endless(ray));
        packet.rays.time[lane] = *time;
        excluded.set(lane, *left);
        shadow.set(lane, ray);
        shadow.time[lane] = *time;
    }
    // Hits of an earlier packet, to be overwritten.
    packet.hits.geometry = [0; LANES];
    accel.intersect_lanes(&active, &mut packet, &excluded, false);
    accel.occluded_lanes(&active, &mut shadow, false);
    lanes
        .map(|lane| (packet.hit(lane), shadow.t_max[lane] < 0.0))
        .collect()
}

/// Rays at vertices of a mesh, at its edges, and anywhere; from within, from outside, and one in 101 not finite: few enough that
/// most packets have finite rays only.
fn aimed(mesh: &Mesh, count: usize, rng: &mut TestRng) -> Vec<TestRay> {
    let ray = |index: usize| {
        let reach = if index.is_multiple_of(2) { 0.5 } else { 1.5 };
        let mut from = reach * point(rng);
        let corners = mesh.indices()[index % mesh.indices().len()];
        let [a, b, _] = corners.map(|i| mesh.vertices()[i as usize].position());
        let to = [a, a + rng.uniform() * (b - a), from + direction(rng)][index % 3];
        if index.is_multiple_of(101) {
            from[index % 3] = [f32::NAN, f32::INFINITY][index / 101 % 2];
        }
        let ray = match index % 5 {
            0 => Ray::between(from, to),
            _ => Ray::new(from, (to - from).normalize_or_zero()),
        };
        (ray, rng.uniform(), None)
    };
    (0..count).map(ray).collect()
}

/// Worlds of meshes, one of them twice at the same place, of shapes of all kinds, and of static and moving instances.
fn worlds(mesh: &Mesh, rng: &mut TestRng) -> Vec<(&'static str, Arc<World>)> {
    let mesh = || Geometry::Mesh(mesh.clone());
    let groups = vec![vec![Geometry::Mesh(closed_mesh(4, true))], soup(rng)];
    let mut instances = |steps: usize| {
        let instances = (0..12).map(|i| {
            let mut start = rotation(rng) * glam::DAffine3::from_scale(glam::DVec3::splat(0.4));
            start.translation = 0.7 * point(rng).as_dvec3();
            let steps = match steps {
                1 => vec![in_single(start)],
                _ => moving(rng, start, steps),
            };
            Instance {
                group: i % 2,
                steps,
            }
        });
        instances.collect::<Vec<_>>()
    };
    let (still, moving) = (instances(1), instances(3));
    let world = |shapes, instances| Arc::new(World::new(shapes, groups.clone(), instances));
    vec![
        ("mesh", static_world(vec![mesh()])),
        ("mesh twice", static_world(vec![mesh(), mesh()])),
        (
            "fine mesh",
            static_world(vec![Geometry::Mesh(closed_mesh(40, true))]),
        ),
        ("shapes", static_world(soup(rng))),
        ("instances", world(soup(rng), still)),
        ("moving", world(vec![mesh()], moving)),
    ]
}

/// Of 100 000 rays that are traced in packets of 16 by Embree's own packet functions, about 30 are occluded at an edge that
/// they miss when traced alone.
#[test]
fn packet_hits_are_independent_of_other_lanes() {
    const RAYS: usize = 60_000;
    let mut rng = TestRng::new(41);
    let mesh = closed_mesh(6, true);
    for (name, world) in worlds(&mesh, &mut rng) {
        let rays = aimed(&mesh, RAYS, &mut rng);
        for (accel_name, accel) in every_accel(&world) {
            let alone: Vec<_> = rays
                .iter()
                .flat_map(|ray| traced(&accel, &[*ray]))
                .collect();
            let met = alone.iter().filter(|(hit, _)| hit.is_some()).count();
            assert!(met * 10 > RAYS, "{name}, {accel_name}: {met} hits");
            let mut rest = (rays.as_slice(), alone.as_slice());
            let mut length = LANES;
            while !rest.0.is_empty() {
                let (some, others) = rest.0.split_at(length.min(rest.0.len()));
                let (want, others_want) = rest.1.split_at(some.len());
                let got = traced(&accel, some);
                for ((ray, got), want) in some.iter().zip(&got).zip(want) {
                    assert_eq!(got, want, "{name}, {accel_name}, {length} rays: {ray:?}");
                }
                rest = (others, others_want);
                // Half of the packets are full.
                length = match length {
                    LANES => 1 + (rng.uniform() * LANES as f32) as usize,
                    _ => LANES,
                };
            }
        }
    }
}

#[test]
fn packet_and_single_ray_hits_agree_with_excluded_primitives() {
    const RAYS: usize = 20_000;
    let mut rng = TestRng::new(42);
    let mesh = closed_mesh(6, true);
    for (name, world) in worlds(&mesh, &mut rng) {
        for (accel_name, accel) in every_accel(&world) {
            let mut left = 0;
            let mut rays = aimed(&mesh, RAYS, &mut rng);
            for (index, (ray, time, excluded)) in rays.iter_mut().enumerate() {
                // Every second ray leaves the primitive that it would hit first.
                let first = accel.intersect(&endless(ray), *time, None);
                if let Some(hit) = first.filter(|_| index.is_multiple_of(2)) {
                    *excluded = Some(ExcludedPrimitive {
                        id: hit.id,
                        free_distance: 1.001 * hit.t,
                    });
                    left += 1;
                }
            }
            assert!(
                left * 20 > RAYS,
                "{name}, {accel_name}: {left} rays leave a primitive"
            );
            let mut off = 0;
            for some in rays.chunks(LANES) {
                for ((ray, time, excluded), (hit, occluded)) in
                    some.iter().zip(traced(&accel, some))
                {
                    let single = accel.intersect(&endless(ray), *time, *excluded);
                    let is_returned = |it: &ExcludedPrimitive| {
                        hit.is_some_and(|hit| hit.id == it.id && hit.t < it.free_distance)
                    };
                    assert!(
                        !excluded.as_ref().is_some_and(is_returned),
                        "{name}, {accel_name}"
                    );
                    let agree = same(hit, single) && occluded == accel.occluded(ray, *time);
                    off += usize::from(!agree);
                }
            }
            // Rounding, at edges that rays are aimed at.
            println!("{name}, {accel_name}: {off} of {RAYS} differ");
            assert!(off * 1000 <= RAYS, "{name}, {accel_name}: {off}");
        }
    }
}
