//! An exact sphere.
//!
//! Measure: normalised scene units.
//! Range: radius above 0.
//! Source: Pharr, Jakob, Humphreys, section 6.8.4 for the refined point. Tested in `tests/tracing/rays.rs`.

use super::surface::SurfacePoint;
use crate::math::bounds::Bounds;
use crate::math::functions::{acos, atan2};
use crate::math::ray::Ray;
use crate::math::robust::gamma;
use crate::math::vec::{DVec3, Mat3, Vec2, Vec3, Vector, reflect};
use std::f32::consts::{FRAC_1_PI, PI, TAU};

/// The point of a sphere in the direction of the unit vector `n` from its centre.
#[inline(always)]
pub fn surface_along<V: Vector>(center: V, radius: f32, n: V) -> SurfacePoint<V> {
    SurfacePoint {
        p: center + n * radius,
        error: (center.abs() + V::splat(radius)) * gamma(8),
        ng: n,
        ns: n,
    }
}

/// A sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Centre.
    pub center: Vec3,
    /// Radius.
    pub radius: f32,
    /// The transform from the axes of the sphere, which texture coordinates refer to, to those of the scene: a
    /// rotation, possibly with a reflection.
    pub turn: Mat3,
}

impl Sphere {
    /// Creates a sphere whose axes are those of the scene.
    pub fn new(center: Vec3, radius: f32) -> Self {
        Self {
            center,
            radius,
            turn: Mat3::IDENTITY,
        }
    }

    /// The bounding box.
    pub fn bounds(&self) -> Bounds {
        let (center, radius) = (self.center.as_dvec3(), f64::from(self.radius));
        Bounds {
            min: center - DVec3::splat(radius),
            max: center + DVec3::splat(radius),
        }
    }

    /// The surface point where a ray hits the sphere at parameter `t`.
    #[inline]
    pub fn surface_at(&self, ray: &Ray, t: f32) -> SurfacePoint {
        let near = ray.at(t).as_dvec3();
        let passed = ray.t_min > 0.0;
        self.surface_near(near, ray.origin.as_dvec3(), ray.dir.normalize(), passed)
    }

    /// The surface point closest to `near`, hit by a ray from `origin` in the unit direction `d`; `passed` states
    /// whether the ray may have passed through surfaces with partial alpha. The normal faces a ray from outside and
    /// points away from one from inside, even at a grazing hit, where rounding could reverse it.
    #[inline]
    pub fn surface_near(&self, near: DVec3, origin: DVec3, d: Vec3, passed: bool) -> SurfacePoint {
        // In double precision: for a sphere far from the origin the centre is exact, but a single-precision point is
        // not.
        let from_center = |p: DVec3| p - self.center.as_dvec3();
        let n = from_center(near).normalize_or(DVec3::Z).as_vec3a();
        let enters = if passed {
            // The ray may have passed through this sphere before, so the half of the chord decides, not the origin.
            from_center(near).dot(d.as_dvec3()) < 0.0
        } else {
            let radius = f64::from(self.radius);
            from_center(origin).length_squared() > radius * radius
        };
        let faces_ray = n.dot(d) < 0.0;
        self.surface_along(if enters == faces_ray {
            n
        } else {
            -reflect(n, d)
        })
    }

    /// The surface point in the direction of the unit vector `n` from the centre.
    #[inline]
    pub fn surface_along(&self, n: Vec3) -> SurfacePoint {
        surface_along(self.center, self.radius, n)
    }

    /// The texture coordinate of a point of the sphere: the longitude about its y axis, and the latitude from the lower
    /// pole.
    #[inline]
    pub fn uv_at(&self, p: Vec3) -> Vec2 {
        let n = self.turn.transpose() * (p - self.center).normalize_or(Vec3::Z);
        Vec2::new(
            (atan2(n.z, n.x) / TAU).rem_euclid(1.0),
            acos(-n.y.clamp(-1.0, 1.0)) * FRAC_1_PI,
        )
    }

    /// The derivatives of a point of the sphere by u and v; 0 at the poles.
    pub fn tangents_at(&self, p: Vec3) -> [Vec3; 2] {
        let n = self.turn.transpose() * (p - self.center);
        let along_u = Vec3::new(-n.z, 0.0, n.x);
        let along_v = along_u.cross(n).normalize_or_zero();
        [TAU * along_u, PI * self.radius * along_v].map(|tangent| self.turn * tangent)
    }

    /// The parameter up to which a ray that starts on the sphere cannot truly hit it again. A ray to the outside never
    /// does. A ray to the inside hits the far side at the end of its chord; half the chord separates the end from the
    /// start.
    #[inline]
    pub fn free_distance(&self, from: Vec3, w: Vec3, to_outside: bool) -> f32 {
        if to_outside {
            f32::INFINITY
        } else {
            -w.dot(from - self.center)
        }
    }
}
