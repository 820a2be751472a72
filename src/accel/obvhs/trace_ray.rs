//! Ray types by the precision of their triangle intersection: single for speed, double for watertightness.
//!
//! Measure: normalised scene units, or the units of a group with the ray transformed into them.
//! Range: any ray and triangle; a triangle seen edge-on, or with zero area, is never hit.
//! Source: `math/triangle.rs` for double precision; Möller and Trumbore 1997 for single precision, in the form that
//! measures the distance along the geometric normal, which the error bounds of surface points assume. Tested below, in
//! `tests/tracing/rays.rs` and in `tests/tracing/hard.rs`.

use super::box_ray::{BoxRay, RayParameter};
use crate::accel::primitive::DRay;
use crate::math::ray::Ray;
use crate::math::triangle::Line;
use crate::math::vec::Vec3;

/// A ray that can be intersected with triangles.
pub trait TraceRay: Copy {
    /// The ray in double precision.
    fn widen(&self) -> DRay;

    /// Creates the ray from a double-precision ray.
    fn narrow(ray: &DRay) -> Self;

    /// The ray for box tests from the parameter `start` on, and the mapping of its parameters.
    fn to_boxes(&self, start: f64) -> (BoxRay, RayParameter);

    /// Intersects a triangle: the parameter, in (t_min, t_max], and the barycentric coordinates of the hit.
    fn intersect(&self, triangle: &[Vec3; 3]) -> Option<(f64, [f32; 2])>;

    /// Sets the end of the ray.
    fn end_at(&mut self, t: f64);
}

/// A double-precision ray with a triangle test that is watertight at edges and vertices.
#[derive(Debug, Clone, Copy)]
pub struct WatertightRay {
    ray: DRay,
    line: Line,
}

impl TraceRay for WatertightRay {
    #[inline]
    fn widen(&self) -> DRay {
        self.ray
    }

    #[inline]
    fn narrow(ray: &DRay) -> Self {
        Self {
            ray: *ray,
            line: Line::new(ray.origin, ray.dir),
        }
    }

    #[inline]
    fn to_boxes(&self, start: f64) -> (BoxRay, RayParameter) {
        BoxRay::new(&self.ray, start)
    }

    #[inline(always)]
    fn intersect(&self, triangle: &[Vec3; 3]) -> Option<(f64, [f32; 2])> {
        let (t, [u, v]) = self.line.intersect(triangle)?;
        (t > self.ray.t_min && t <= self.ray.t_max).then_some((t, [u as f32, v as f32]))
    }

    #[inline]
    fn end_at(&mut self, t: f64) {
        self.ray.t_max = t;
    }
}

impl TraceRay for Ray {
    #[inline]
    fn widen(&self) -> DRay {
        self.into()
    }

    #[inline]
    fn narrow(ray: &DRay) -> Self {
        Self {
            origin: ray.origin.as_vec3a(),
            dir: ray.dir.as_vec3a(),
            t_min: ray.t_min as f32,
            t_max: ray.t_max as f32,
        }
    }

    #[inline]
    fn to_boxes(&self, start: f64) -> (BoxRay, RayParameter) {
        if start == 0.0 {
            BoxRay::single(self)
        } else {
            BoxRay::new(&self.into(), start)
        }
    }

    #[inline(always)]
    fn intersect(&self, &[a, b, c]: &[Vec3; 3]) -> Option<(f64, [f32; 2])> {
        let (e1, e2) = (b - a, c - a);
        let normal = e1.cross(e2);
        let to_a = a - self.origin;
        let across = self.dir.cross(to_a);
        let determinant = self.dir.dot(normal);
        // The barycentric coordinates, times the magnitude of the determinant.
        let towards = 1.0_f32.copysign(determinant);
        let (u, v) = (-towards * across.dot(e2), towards * across.dot(e1));
        // Divided only after an inside test, which most triangles fail. NaN counts as outside.
        let inside = u >= 0.0 && v >= 0.0 && u + v <= determinant.abs();
        if !inside || determinant == 0.0 {
            return None;
        }
        let t = to_a.dot(normal) / determinant;
        let scale = 1.0 / determinant.abs();
        (t > self.t_min && t <= self.t_max).then(|| (t.into(), [u * scale, v * scale]))
    }

    #[inline]
    fn end_at(&mut self, t: f64) {
        self.t_max = t as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [Vec3; 3] = [
        Vec3::new(0.0, 0.0, 2.0),
        Vec3::new(4.0, 0.0, 2.0),
        Vec3::new(0.0, 4.0, 2.0),
    ];

    fn intersect(ray: &Ray) -> Option<(f64, [f32; 2])> {
        let watertight = WatertightRay::narrow(&ray.widen());
        let (single, double) = (ray.intersect(&TRIANGLE), watertight.intersect(&TRIANGLE));
        assert_eq!(single, double, "{ray:?}");
        single
    }

    #[test]
    fn triangle_hits_are_correct_in_both_precisions() {
        let ray = Ray::new(Vec3::new(1.0, 2.0, 0.0), Vec3::new(0.0, 0.0, 0.5));
        assert_eq!(intersect(&ray), Some((4.0, [0.25, 0.5])));
        let from_behind = Ray::new(Vec3::new(1.0, 2.0, 4.0), Vec3::new(0.0, 0.0, -0.5));
        assert_eq!(intersect(&from_behind), Some((4.0, [0.25, 0.5])));
        for beside in [
            Vec3::new(-1.0, 2.0, 0.0),
            Vec3::new(2.0, -1.0, 0.0),
            Vec3::new(3.0, 2.0, 0.0),
        ] {
            assert_eq!(intersect(&Ray::new(beside, Vec3::Z)), None);
        }
        assert_eq!(
            intersect(&Ray::new(Vec3::new(-1.0, 1.0, 2.0), Vec3::X)),
            None
        );
    }

    #[test]
    fn hit_requires_t_above_t_min_and_at_most_t_max() {
        let up_to = |t_min, t_max| {
            let (origin, dir) = (Vec3::new(1.0, 1.0, 0.0), Vec3::Z);
            let ray = Ray {
                origin,
                dir,
                t_min,
                t_max,
            };
            intersect(&ray).is_some()
        };
        assert!(up_to(0.0, 2.0) && up_to(2.0_f32.next_down(), 3.0));
        assert!(!up_to(2.0, 3.0) && !up_to(0.0, 2.0_f32.next_down()));
    }
}
