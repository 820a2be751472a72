//! Intersection of a ray with one primitive in double precision, the reference for the single-precision tests.
//!
//! Measure: normalised scene units, or the units of a group with the ray transformed into them.
//! Range: any ray and primitive; a degenerate triangle is never hit.
//! Source: `math/triangle.rs` for triangles; the sphere's quadratic in the stable form of Kahan. Tested in
//! `tests/tracing/rays.rs`.

use crate::geometry::Geometry;
use crate::math::ray::Ray;
use crate::math::triangle::Line;
use crate::math::vec::{DAffine3, DVec3};

/// A ray in double precision.
#[derive(Debug, Clone, Copy)]
pub struct DRay {
    /// The point where the ray starts.
    pub origin: DVec3,
    /// The direction, of any length.
    pub dir: DVec3,
    /// Hits at or before this parameter are ignored.
    pub t_min: f64,
    /// Hits beyond this parameter are ignored.
    pub t_max: f64,
}

impl From<&Ray> for DRay {
    #[inline]
    fn from(ray: &Ray) -> Self {
        Self {
            origin: ray.origin.as_dvec3(),
            dir: ray.dir.as_dvec3(),
            t_min: ray.t_min.into(),
            t_max: ray.t_max.into(),
        }
    }
}

impl DRay {
    /// Transforms the ray to other coordinates, keeping its parameters.
    #[inline]
    pub fn transformed(&self, transform: &DAffine3) -> Self {
        Self {
            origin: transform.transform_point3(self.origin),
            dir: transform.transform_vector3(self.dir),
            ..*self
        }
    }
}

/// Returns the parameter and the barycentric coordinates of the first hit in (t_min, t_max] on a primitive.
pub fn intersect(geometry: &Geometry, primitive: u32, ray: &DRay) -> Option<(f64, [f64; 2])> {
    let DRay { origin, dir, .. } = *ray;
    let inside = |t: f64| t > ray.t_min && t <= ray.t_max;
    match geometry {
        Geometry::Mesh(mesh) => {
            let (t, uv) = Line::new(origin, dir).intersect(&mesh.triangle(primitive))?;
            inside(t).then_some((t, uv))
        }
        Geometry::Sphere(sphere) => {
            let offset = origin - sphere.center.as_dvec3();
            let roots = sphere_roots(offset, dir, f64::from(sphere.radius))?;
            let t = roots.into_iter().find(|&t| inside(t))?;
            Some((t, [0.0; 2]))
        }
        Geometry::Disk(disk) => {
            let normal = disk.normal.as_dvec3();
            let to_center = disk.center.as_dvec3() - origin;
            let t = to_center.dot(normal) / dir.dot(normal);
            let radius = f64::from(disk.radius);
            let within = (t * dir - to_center).length_squared() <= radius * radius;
            (within && inside(t)).then_some((t, [0.0; 2]))
        }
    }
}

/// The two parameters at which a line intersects a sphere about the origin, in ascending order.
fn sphere_roots(origin: DVec3, dir: DVec3, radius: f64) -> Option<[f64; 2]> {
    let a = dir.length_squared();
    let half_b = origin.dot(dir);
    // The discriminant is computed from the distance of the line to the centre; b^2 - ac suffers from cancellation far
    // away.
    let nearest = origin - half_b / a * dir;
    let discriminant = a * (radius * radius - nearest.length_squared());
    if discriminant < 0.0 {
        return None;
    }
    let q = -(half_b + discriminant.sqrt().copysign(half_b));
    let c = (origin.length() - radius) * (origin.length() + radius);
    let (t0, t1) = (q / a, if q == 0.0 { 0.0 } else { c / q });
    Some([t0.min(t1), t0.max(t1)])
}
