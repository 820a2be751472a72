//! A ray: an origin, a direction and a parameter range.
//!
//! Measure: origin in normalised scene units; `t` in multiples of the direction's length, which need not be one.
//! Range: hits are searched in (t_min, t_max]; both are at least 0.
//! Source: pbrt, "Rays". Tested through every tracing test.

use super::robust::reach_of_point;
use super::vec::{ONE_MINUS_EPSILON, Vec3, Vector};
use crate::planted::planted;

/// A ray through the scene; by default, one without length that hits nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ray<V = Vec3> {
    /// The origin.
    pub origin: V,
    /// The direction. Need not have unit length: a shadow ray spans its whole segment.
    pub dir: V,
    /// Hits at or before this parameter do not count.
    pub t_min: f32,
    /// Hits beyond this parameter do not count.
    pub t_max: f32,
}

impl<V: Vector> Ray<V> {
    /// Builds a ray of infinite length.
    #[inline(always)]
    pub fn new(origin: V, dir: V) -> Self {
        Self {
            origin,
            dir,
            t_min: 0.0,
            t_max: f32::INFINITY,
        }
    }

    /// Lets the ray begin after a hit at the distance `t`, and after where it began before: a hit that is found again has
    /// another distance, by rounding, which may be less than the one where the ray begins.
    #[inline]
    pub fn begin_after(&mut self, t: f32) {
        self.t_min = planted!("begin-before", t, t.max(self.t_min)).next_up();
    }

    /// The open segment from `a` to `b`: hits exactly at `b` do not count.
    #[inline(always)]
    pub fn between(a: V, b: V) -> Self {
        Self {
            origin: a,
            dir: b - a,
            t_min: 0.0,
            t_max: planted!("shadow-ray-cut-short", 1.0 - 1e-3, ONE_MINUS_EPSILON),
        }
    }

    /// The segment from `a` to a point `b` in free space. Hits at `b` within rounding error do not count: otherwise a
    /// surface through `b` would be hit or missed by chance.
    #[inline(always)]
    pub fn to_point(a: V, b: V) -> Self {
        let segment = Self::between(a, b);
        let reach = reach_of_point(a) + reach_of_point(b);
        let open = planted!("points-exact", 0.0, reach / segment.dir.length());
        // If both points are equal within rounding error, nothing is between them.
        Self {
            t_max: (segment.t_max - open).max(0.0),
            ..segment
        }
    }

    /// Whether origin and direction are finite numbers.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.origin.is_finite() && self.dir.is_finite()
    }

    /// The point at parameter `t`.
    #[inline(always)]
    pub fn at(&self, t: f32) -> V {
        self.origin + self.dir * t
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec::Vec3;

    /// A loop over the hits of a ray would not end otherwise.
    #[test]
    fn ray_begins_later_after_every_hit() {
        let mut ray = Ray::new(Vec3::ZERO, Vec3::X);
        let mut before = ray.t_min;
        for t in [0.0, 1.0, 1.0_f32.next_down(), 0.5, 1.0, 1e30, 2.0] {
            ray.begin_after(t);
            assert!(ray.t_min > before && ray.t_min > t, "{t}");
            before = ray.t_min;
        }
    }
}
