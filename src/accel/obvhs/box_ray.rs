//! The ray for box tests, in single precision, prepared such that no box that the exact ray hits is missed.
//!
//! The direction is scaled by a power of two that brings its largest entry to between 1 and 2, so that the values of a
//! single-precision ray remain exact. Entries below 2^-63 are then set to 2^-63, so that no quotient is infinite and no
//! product is NaN. With such an entry, a ray that lies in a face of a box would leave the box immediately. The
//! parameter interval of the box along such an axis is therefore extended by 2^40 on either side, that is, by 2^-23
//! units across.
//!
//! A single-precision ray whose direction has no very small or large entry is used unchanged, without double precision:
//! none of these cases can occur.
//!
//! Measure: any unit of length; parameters in multiples of the scaled direction's length, from the start of the query.
//! Range: finite rays and boxes with coordinates up to 1e18 in magnitude.
//! Source: Pharr, Jakob, Humphreys, section 6.8.2 for the roundings. Tested below and in `tests/tracing/hard.rs`.

use crate::accel::primitive::DRay;
use crate::math::bounds::Bounds;
use crate::math::ray::Ray;
use crate::math::robust::gamma;
use crate::math::vec::DVec3;
use glam::Vec3A;

/// 2^-63: the smallest magnitude of direction entries.
const SMALLEST_ENTRY: f64 = 1.0 / (1u64 << 63) as f64;

/// 2^-32: a single-precision direction whose entries are between this and its inverse is used unchanged.
const SMALLEST_PLAIN_ENTRY: f32 = 1.0 / (1u64 << 32) as f32;

/// 2^40: the slack of parameters along an axis with a direction entry set to [`SMALLEST_ENTRY`].
const SLACK_ALONG: f32 = (1u64 << 40) as f32;

/// A ray for tests against boxes.
#[derive(Debug, Clone, Copy)]
pub struct BoxRay {
    /// The point where the ray starts.
    pub origin: Vec3A,
    /// The reciprocal of each entry of the direction.
    pub inverse: Vec3A,
    /// The error of the parameters at the planes of a box, in addition to roundings.
    pub slack: Vec3A,
    /// Whether the slack is nonzero along any axis.
    pub is_parallel: bool,
    /// Boxes that end before this parameter are ignored.
    pub t_min: f32,
    /// Boxes that begin beyond this parameter are ignored. Finite, even if the ray is infinite.
    pub t_max: f32,
}

/// The mapping of parameters of a ray to those of its [`BoxRay`].
#[derive(Debug, Clone, Copy)]
pub enum RayParameter {
    /// The parameters are equal.
    Same,
    /// The parameters count from `start` on, in multiples of `unit`.
    Scaled {
        /// The parameter at which the box ray starts.
        start: f64,
        /// The ratio of the length of the ray's direction to that of the box ray.
        unit: f64,
    },
}

impl BoxRay {
    /// Creates the box ray that is tested from the parameter `start` on, and the mapping of its parameters.
    #[inline]
    pub fn new(ray: &DRay, start: f64) -> (Self, RayParameter) {
        let exponent_bits = f64::INFINITY.to_bits();
        let unit = f64::from_bits(ray.dir.abs().max_element().to_bits() & exponent_bits);
        let unit = if unit > 0.0 { unit } else { 1.0 };
        let dir = ray.dir * (1.0 / unit);
        // Adding 0 makes -0 positive, so that the sign of the quotient is that of the direction's entry.
        let entries = dir.abs().max(DVec3::splat(SMALLEST_ENTRY)).as_vec3a();
        let small = dir.abs().cmple(DVec3::splat(SMALLEST_ENTRY));
        let slack = DVec3::select(small, DVec3::splat(SLACK_ALONG.into()), DVec3::ZERO);
        let parameter = RayParameter::Scaled { start, unit };
        let query = Self {
            origin: (ray.origin + start * ray.dir).as_vec3a(),
            inverse: (1.0 / entries).copysign((dir + DVec3::ZERO).as_vec3a()),
            slack: slack.as_vec3a(),
            is_parallel: small.any(),
            t_min: (((ray.t_min - start) * unit) as f32).next_down(),
            t_max: parameter.high(ray.t_max),
        };
        (query, parameter)
    }

    /// Creates the box ray of a single-precision ray, tested from its start. The values are unchanged, unless an entry
    /// of the direction is very small or large.
    #[inline]
    pub fn single(ray: &Ray) -> (Self, RayParameter) {
        let entries = ray.dir.abs();
        let small = entries.cmplt(Vec3A::splat(SMALLEST_PLAIN_ENTRY));
        let large = entries.cmpgt(Vec3A::splat(1.0 / SMALLEST_PLAIN_ENTRY));
        if (small | large).any() {
            return Self::of_extremes(ray);
        }
        let query = Self {
            origin: ray.origin,
            inverse: 1.0 / ray.dir,
            slack: Vec3A::ZERO,
            is_parallel: false,
            t_min: ray.t_min,
            t_max: ray.t_max.min(f32::MAX),
        };
        (query, RayParameter::Same)
    }

    /// Handles directions with extreme entries; a separate function to keep the callers of the common case small.
    #[cold]
    fn of_extremes(ray: &Ray) -> (Self, RayParameter) {
        Self::new(&ray.into(), 0.0)
    }
}

impl RayParameter {
    /// Returns the parameter of the box ray, rounded up by at most two roundings; finite.
    #[inline]
    pub fn high(self, t: f64) -> f32 {
        let t = match self {
            Self::Same => t as f32,
            Self::Scaled { start, unit } => (((t - start) * unit) as f32).next_up(),
        };
        t.min(f32::MAX)
    }
}

/// The parameter at which a ray enters a box, or the start of the ray if it is inside; `None` for a miss.
pub fn clip(ray: &DRay, bounds: &Bounds) -> Option<f64> {
    // Double-precision rounding errors are far smaller than this padding.
    let padding = DVec3::splat(f64::from(gamma(1)) * largest_coordinate(bounds));
    let near = (bounds.min - padding - ray.origin) / ray.dir;
    let far = (bounds.max + padding - ray.origin) / ray.dir;
    let (mut from, mut to) = (ray.t_min, ray.t_max);
    for axis in 0..3 {
        // Along an axis with a zero direction entry a quotient is infinite, or NaN, which min and max ignore.
        from = from.max(near[axis].min(far[axis]));
        to = to.min(near[axis].max(far[axis]));
    }
    (from <= to && from.is_finite()).then_some(from)
}

/// The largest magnitude of a coordinate of a box.
pub fn largest_coordinate(bounds: &Bounds) -> f64 {
    bounds.min.abs().max(bounds.max.abs()).max_element()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(dir: DVec3) -> DRay {
        DRay {
            origin: DVec3::ONE,
            dir,
            t_min: 0.0,
            t_max: 8.0,
        }
    }

    #[test]
    fn box_ray_of_single_precision_values_is_exact() {
        let (query, parameter) = BoxRay::new(&ray(DVec3::new(0.25, -0.5, 0.375)), 2.0);
        assert_eq!(query.origin, Vec3A::new(1.5, 0.0, 1.75));
        assert_eq!(query.inverse, Vec3A::new(2.0, -1.0, 4.0 / 3.0));
        assert_eq!(query.t_max, 3.0_f32.next_up());
        assert_eq!(parameter.high(4.0), 1.0_f32.next_up());
    }

    #[test]
    fn reciprocal_direction_is_finite_for_extreme_components() {
        let entries = [0.0, -0.0, 1e-38, -1e-38, 1e-45, -1.0, 1e30];
        for x in entries {
            for y in entries {
                let (query, _) = BoxRay::new(&ray(DVec3::new(x, y, 1e-30)), 0.0);
                assert!(query.inverse.is_finite(), "{x} {y} {query:?}");
                assert_eq!(query.inverse.x > 0.0, x >= 0.0, "{x} {y} {query:?}");
                assert!(query.inverse.abs().max_element() <= 1.0 / SMALLEST_ENTRY as f32);
            }
        }
    }

    #[test]
    fn single_precision_setup_matches_double_precision() {
        for dir in [[0.5, -1.5, 1.25], [0.0, 1.0, 1.5], [1e-30, 2e-30, 2e-30]] {
            let single = Ray::new(Vec3A::new(1.0, -2.0, 3.0), Vec3A::from_array(dir));
            let (a, in_a) = BoxRay::single(&single);
            let (b, in_b) = BoxRay::new(&(&single).into(), 0.0);
            assert_eq!(
                (a.origin, a.inverse, a.slack),
                (b.origin, b.inverse, b.slack)
            );
            assert!(
                a.t_max == f32::MAX && b.t_max == f32::MAX,
                "finite without an end"
            );
            assert!(a.t_min >= b.t_min && in_a.high(7.0) <= in_b.high(7.0));
        }
    }

    #[test]
    fn clip_returns_the_box_entry_or_none_for_a_miss() {
        let bounds = Bounds::around([DVec3::new(3.0, 0.0, 0.0), DVec3::new(5.0, 2.0, 2.0)]);
        let from = clip(&ray(DVec3::X), &bounds).expect("it goes through the middle");
        assert!((from - 2.0).abs() < 1e-6);
        assert_eq!(clip(&ray(-DVec3::X), &bounds), None);
        let behind = DRay {
            t_max: 1.5,
            ..ray(DVec3::X)
        };
        assert_eq!(clip(&behind, &bounds), None);
    }
}
