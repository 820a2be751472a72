//! Checks every hit on a triangle in robust precision, because Embree's robust mode is known to report hits far off the
//! triangle (Embree issue 387).
//!
//! A hit passes if the point along the ray and the point from the barycentric coordinates are as near to each other as
//! their rounding errors allow. Otherwise the intersection is recomputed in double precision. Hits of a packet on
//! triangles of the world are compared in lanes, and only those that do not pass one by one.
//!
//! Measure: normalised scene units.
//! Range: coordinates up to 1e18 in magnitude; finite rays.
//! Source: the bounds are those of `geometry/mesh.rs`. Tested below and in `tests/tracing/rays.rs`, `batches.rs` and
//! `packets.rs`.

use super::EmbreeAccel;
use crate::accel::lanes::{NO_ID, RayHitLanes};
use crate::accel::{Hit, Precision};
use crate::geometry::Geometry;
use crate::geometry::mesh::triangle_point;
use crate::geometry::placed::PlacedShape;
use crate::math::lanes::{ActiveLanes, vectorised};
use crate::math::ray::Ray;
use crate::math::robust::gamma;
use crate::math::triangle::{intersect_plane, nearest_in_triangle};
use crate::math::vec::{DVec3, LaneVec3, Vector};
use crate::planted::planted;

impl EmbreeAccel {
    /// Returns the hit that Embree found on a ray, or, if it fails the check, the first one beyond it that passes.
    #[inline]
    pub(super) fn confirm(&self, ray: &Ray, time: f32, mut hit: Hit) -> Option<Hit> {
        if self.options.precision == Precision::Fast {
            return Some(hit);
        }
        let mut ray = *ray;
        loop {
            if let Some(checked) = self.check(&ray, time, hit) {
                return Some(checked);
            }
            ray.begin_after(hit.t);
            hit = self.query(&ray, time)?;
        }
    }

    /// The lanes whose hits have to be [confirmed](Self::confirm) one by one: those that the comparison in lanes does not
    /// accept, and those on other shapes than meshes and on instances. None in fast precision.
    pub(super) fn lanes_to_confirm<const N: usize>(
        &self,
        active: &ActiveLanes<N>,
        packet: &RayHitLanes<N>,
    ) -> ActiveLanes<N> {
        if self.options.precision == Precision::Fast {
            return ActiveLanes::NONE;
        }
        let hits = &packet.hits;
        let hit_lanes = active.and(|lane| hits.geometry[lane] != NO_ID);
        let mut triangles = [[[0.0; N]; 3]; 3];
        let mut accepted = hit_lanes.and(|lane| hits.instance[lane] == NO_ID);
        for lane in accepted.each() {
            match self.world.geometry(hits.geometry[lane]) {
                Geometry::Mesh(mesh) => {
                    let vertices = mesh.triangle(hits.primitive[lane]);
                    for (to, vertex) in triangles.iter_mut().zip(vertices) {
                        [to[0][lane], to[1][lane], to[2][lane]] = vertex.to_array();
                    }
                }
                _ => accepted.set(lane, false),
            }
        }
        deactivate_distant(&triangles, packet, &mut accepted);
        hit_lanes.without(&accepted)
    }

    /// Returns the hit, if necessary recomputed in double precision; `None` if it is not near its triangle.
    #[inline]
    fn check(&self, ray: &Ray, time: f32, hit: Hit) -> Option<Hit> {
        if let Some(placed) = self.world.placed(hit.id.shape, time) {
            return check_placed(&placed, ray, hit);
        }
        let Geometry::Mesh(mesh) = self.world.geometry(hit.id.shape) else {
            return Some(hit);
        };
        let triangle = mesh.triangle(hit.id.primitive);
        let (apart, bound) = compare(triangle, (ray.origin, ray.dir), hit.t, hit.uv);
        if is_within(apart, bound) {
            return Some(hit);
        }
        recheck(triangle.map(|v| v.as_dvec3()), ray, hit, bound.as_dvec3())
    }
}

/// The distances, along the axes, between the point along a ray and the point of a triangle at barycentric coordinates, and
/// the bound of their rounding errors. Free of branches.
#[inline(always)]
fn compare<V: Vector>(triangle: [V; 3], (origin, dir): (V, V), t: f32, uv: [f32; 2]) -> (V, V) {
    let point = triangle_point(triangle, uv);
    let along = dir * t;
    let bound = point.error + (origin.abs() + along.abs()) * gamma(4);
    ((origin + along - point.p).abs(), bound)
}

/// Whether no component of a vector exceeds that of the bound.
#[inline(always)]
fn is_within<V: Vector>(apart: V, bound: V) -> bool {
    (apart.x() <= bound.x()) & (apart.y() <= bound.y()) & (apart.z() <= bound.z())
}

vectorised! {
    /// Deactivates the lanes whose hits are not near their triangles.
    fn deactivate_distant<const N: usize>(
        triangles: &[[[f32; N]; 3]; 3],
        packet: &RayHitLanes<N>,
        active: &mut ActiveLanes<N>,
    ) {
        let RayHitLanes { rays, hits } = packet;
        for lane in 0..N {
            let vector = |[x, y, z]: &[[f32; N]; 3]| LaneVec3::new(x[lane], y[lane], z[lane]);
            let triangle = triangles.each_ref().map(vector);
            let ray = (vector(&rays.origin), vector(&rays.dir));
            let uv = [hits.u[lane], hits.v[lane]];
            let (apart, bound) = compare(triangle, ray, rays.t_max[lane], uv);
            let is_near = planted!("distant-hits-accepted", true, is_within(apart, bound));
            active.0[lane] &= if is_near { -1 } else { 0 };
        }
    }
}

/// Checks a hit on a shape of an instance, against the triangle in world space.
fn check_placed(placed: &PlacedShape, ray: &Ray, hit: Hit) -> Option<Hit> {
    let Geometry::Mesh(mesh) = placed.geometry else {
        return Some(hit);
    };
    let local = triangle_point(mesh.triangle(hit.id.primitive), hit.uv);
    let origin = ray.origin.as_dvec3();
    let along = f64::from(hit.t) * ray.dir.as_dvec3();
    let rounding = f64::from(gamma(4)) * (origin.abs() + along.abs());
    let is_near = |bound: DVec3| {
        let apart = origin + along - placed.to_world(local.p.as_dvec3());
        apart.abs().cmple(bound).all()
    };
    // Nearly every hit passes with this bound; the larger bound, with the errors of instancing, is more expensive to
    // compute.
    if is_near(rounding) {
        return Some(hit);
    }
    let (_, error) = placed.point(local.p, local.error, along.abs());
    let bound = error + rounding;
    if is_near(bound) {
        return Some(hit);
    }
    recheck(placed.triangle(mesh, hit.id.primitive), ray, hit, bound)
}

/// Recomputes a hit in double precision. A hit that is outside the triangle by no more than rounding is kept and
/// moved to the triangle's edge; otherwise edges would not be watertight.
#[cold]
fn recheck(vertices: [DVec3; 3], ray: &Ray, hit: Hit, bound: DVec3) -> Option<Hit> {
    let (origin, dir) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());
    let (t, uv) = intersect_plane(vertices, origin, dir)?;
    let [a, b, c] = vertices;
    let [u, v] = nearest_in_triangle(vertices, uv);
    let nearest = (1.0 - u - v) * a + u * b + v * c;
    let apart = (origin + t * dir - nearest).abs();
    let t = t as f32;
    // At oblique incidence Embree's rounding error on one axis may appear on another, hence the maxima over the axes.
    let is_near = apart.max_element() <= 4.0 * bound.max_element();
    (is_near && t > ray.t_min && t <= ray.t_max).then_some(Hit {
        t,
        uv: [u as f32, v as f32],
        ..hit
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{AccelOptions, Backend};
    use crate::geometry::mesh::Mesh;
    use crate::geometry::sphere::Sphere;
    use crate::geometry::world::World;
    use crate::math::lanes::LANES;
    use crate::math::vec::Vec3;
    use std::sync::Arc;

    /// The structure over a large triangle in the plane z = 0 and a sphere.
    fn structure(precision: Precision) -> EmbreeAccel {
        let corners = [[-8.0, -8.0, 0.0], [8.0, -8.0, 0.0], [0.0, 8.0, 0.0]].map(Vec3::from);
        let mesh = Mesh::new(corners.to_vec(), vec![], vec![], vec![[0, 1, 2]]);
        let sphere = Sphere::new(Vec3::new(0.0, 0.0, -2.0), 0.5);
        let options = AccelOptions {
            backend: Backend::Embree,
            precision,
            quality: None,
            threads: 1,
        };
        let shapes = vec![Geometry::Mesh(mesh), Geometry::Sphere(sphere)];
        let world = World::new(shapes, vec![], vec![]);
        EmbreeAccel::build(Arc::new(world), options).expect("a small scene")
    }

    /// Rays to the triangle with their hits: one on the sphere, one whose distance is wrong by a thousandth, one whose
    /// barycentric coordinates are, and one that misses.
    #[test]
    fn only_hits_that_may_be_wrong_are_confirmed_one_by_one() {
        let [on_sphere, too_far, beside, missed] = [3, 5, 8, 11];
        let accel = structure(Precision::Robust);
        let active = ActiveLanes::<LANES>::first(14);
        let mut packet = RayHitLanes::<LANES>::default();
        for lane in 0..LANES {
            let target = Vec3::new(0.3 * lane as f32 - 2.0, 0.1 * lane as f32 - 1.0, 0.0);
            let origin = Vec3::new(1.0, -2.0, 3.0 + lane as f32);
            packet.rays.set(lane, &Ray::new(origin, target - origin));
        }
        accel.intersect_lanes(&active, &mut packet, false);
        let correct = accel.lanes_to_confirm(&active, &packet);
        assert_eq!(correct, ActiveLanes::NONE);
        packet.hits.geometry[on_sphere] = 1;
        packet.rays.t_max[too_far] *= 1.001;
        packet.hits.u[beside] += 0.001;
        packet.hits.geometry[missed] = NO_ID;
        let lanes: Vec<usize> = accel.lanes_to_confirm(&active, &packet).each().collect();
        assert_eq!(lanes, [on_sphere, too_far, beside]);
        let fast = structure(Precision::Fast);
        let lanes = fast.lanes_to_confirm(&active, &packet);
        assert_eq!(lanes, ActiveLanes::NONE);
    }
}
