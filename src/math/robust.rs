//! Bounds on rounding error, and ray origins pushed past them: no epsilon anywhere.
//!
//! Measure: normalised scene units.
//! Range: any finite point; the bounds hold while no intermediate result underflows.
//! Source: Higham 2002, section 3.1 (gamma_n); Pharr, Jakob, Humphreys, "Physically Based Rendering", section 6.8.
//! Tested below and by the self-intersection tests of `tests/tracing/rays.rs`.

use super::vec::Vec3;
use crate::planted::planted;

/// Unit roundoff of `f32`, 2^-24.
pub const UNIT_ROUNDOFF: f32 = f32::EPSILON / 2.0;

/// gamma_n = n u / (1 - n u): the relative error of n roundings in a row.
#[inline]
pub const fn gamma(n: u32) -> f32 {
    let nu = n as f32 * UNIT_ROUNDOFF;
    nu / (1.0 - nu)
}

/// An error bound that is nowhere zero, for a primitive of this size. A point in an axis-aligned plane may be exact, but a
/// ray from exactly there meets the plane at exactly 0, which a watertight kernel counts as a hit.
#[inline]
pub fn never_zero(error: Vec3, size: f32) -> Vec3 {
    error + Vec3::splat(UNIT_ROUNDOFF * UNIT_ROUNDOFF * size)
}

/// The point `p`, known to within `error` in each coordinate, moved along the unit normal `n` until it surely lies on
/// that side of the surface.
#[inline]
pub fn offset_point(p: Vec3, error: Vec3, n: Vec3) -> Vec3 {
    let offset = n.abs().dot(error) * n;
    let moved = planted!("origin-not-offset", p, p + offset);
    // Adding may round back towards the surface: one more unit in the last place away from it. Not along axes that the
    // normal has no part in, where it would be through the wall that an edge is shared with.
    let away = Vec3::select(offset.cmpeq(Vec3::ZERO), Vec3::ZERO, offset.signum());
    planted!(
        "offset-rounds-back",
        moved,
        moved + away * (f32::EPSILON * moved.abs())
    )
}

/// How far a surface through a point in free space may seem to be from it: the point and the surface are rounded, and so is
/// what a ray query makes of both. A bound but for surfaces much larger than the point is far from the origin, and for rays
/// that graze them.
#[inline]
pub fn reach_of_point(p: Vec3) -> f32 {
    gamma(8) * p.abs().element_sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_offset_point_is_beyond_its_error_bound_on_the_asked_side() {
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
