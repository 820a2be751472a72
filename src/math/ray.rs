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
