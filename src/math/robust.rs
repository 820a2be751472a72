//! Bounds on rounding error, and ray origins offset beyond them, without any epsilon.
//!
//! Measure: normalised scene units.
//! Range: any finite point; the bounds hold while no intermediate result underflows.
//! Source: Higham 2002, section 3.1 (gamma_n); Pharr, Jakob, Humphreys, "Physically Based Rendering", section 6.8.
//! Tested below and by the self-intersection tests of `tests/tracing/rays.rs`.

use super::vec::Vector;
use crate::planted::planted;

/// Unit roundoff of `f32`, 2^-24.
pub const UNIT_ROUNDOFF: f32 = f32::EPSILON / 2.0;

/// gamma_n = n u / (1 - n u): the relative error of n roundings in a row.
#[inline]
pub const fn gamma(n: u32) -> f32 {
    let nu = n as f32 * UNIT_ROUNDOFF;
    nu / (1.0 - nu)
}

/// Makes an error bound nonzero in every coordinate, for a primitive of this size. A point in an axis-aligned plane
/// may be exact, but a ray from that point intersects the plane at exactly 0, which a watertight kernel counts as a
/// hit.
#[inline(always)]
pub fn never_zero<V: Vector>(error: V, size: f32) -> V {
    error + V::splat(UNIT_ROUNDOFF * UNIT_ROUNDOFF * size)
}

/// Moves the point `p`, known to within `error` in each coordinate, along the unit normal `n` until it surely lies on
/// that side of the surface.
#[inline(always)]
pub fn offset_point<V: Vector>(p: V, error: V, n: V) -> V {
    let offset = n * n.abs().dot(error);
    let moved = planted!("origin-not-offset", p, p + offset);
    // The sum may round back towards the surface: move one more unit in the last place away from it. Not along axes
    // in which the offset is 0: that could cross a wall that shares an edge with the surface.
    planted!(
        "offset-rounds-back",
        moved,
        moved + offset.signs() * (moved.abs() * f32::EPSILON)
    )
}

/// The largest apparent distance between a point in free space and a surface through it: the point, the surface and
/// the ray query are rounded. It is not a bound for surfaces much larger than the point's distance from the origin,
/// and for grazing rays.
#[inline(always)]
pub fn reach_of_point<V: Vector>(p: V) -> f32 {
    gamma(8) * p.abs().element_sum()
}

#[cfg(test)]
mod tests {
    use super::super::vec::Vec3;
    use super::*;

    #[test]
    fn offset_point_clears_its_error_bound_on_the_given_side() {
        for i in 0..6000 {
            let (turn, exponent) = (i as f32, i % 60 - 30);
            let n = Vec3::new(turn.sin(), (1.7 * turn).cos(), (0.3 * turn).sin()).normalize();
            let p = Vec3::new(0.7, -1.3, (0.01 * turn).cos()) * 2.0_f32.powi(exponent);
            // Also where rounding brings the sum back to the point itself.
            for error in [
                gamma(7) * p.abs(),
                gamma(1) * p.abs(),
                1e-3 * gamma(1) * p.abs(),
            ] {
                for side in [n, -n] {
                    let q = offset_point(p, error, side);
                    let moved = (q.as_dvec3() - p.as_dvec3()).dot(side.as_dvec3());
                    let bound = f64::from(error.dot(n.abs()));
                    assert!(
                        moved >= bound * (1.0 - 1e-6),
                        "{p} {error} {side}: {moved:e}"
                    );
                }
            }
        }
    }
}
