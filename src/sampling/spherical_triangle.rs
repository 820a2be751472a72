//! Uniform sampling of a triangle's solid angle: the solid angle, and points with density 1 / solid angle.
//!
//! Measure: densities per steradian; lengths in any unit. In double precision, because a small triangle's sides differ
//! from their sines in the last digits only.
//! Range: any triangle and any viewpoint off its plane; from a viewpoint in the plane nothing is visible. The relative
//! error of the solid angle is below 1e-6 for every size that vertices in single precision can have; callers fall back to
//! area sampling below [`MIN_SOLID_ANGLE`].
//! Source: Van Oosterom and Strackee 1983 with the triple product taken over edges; Arvo 1995, "Stratified Sampling of
//! Spherical Triangles". Tested in `tests/sampling/warps.rs`.

use crate::math::functions::{atan2, sin_cos};
use crate::math::triangle::{clamp_to_triangle, intersect_plane};
use crate::math::vec::{DVec3, Vec2};

/// The solid angle, in steradians, below which area sampling is better: the difference between the two is smaller than
/// rounding.
pub const MIN_SOLID_ANGLE: f64 = 1e-8;

/// The solid angle of a triangle whose vertices are given relative to the viewpoint.
///
/// tan(Omega / 2) = [a, b, c] / (abc + (a.b)c + (a.c)b + (b.c)a), with [a, b, c] = a . ((b - a) x (c - a)).
#[inline]
pub fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let triple = a.dot((b - a).cross(c - a)).abs();
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let denominator = la * lb * lc + a.dot(b) * lc + a.dot(c) * lb + b.dot(c) * la;
    2.0 * atan2(triple, denominator)
}

/// Samples a point uniformly by the solid angle `omega`; returns its barycentric coordinates (b1, b2).
///
/// `None` where rounding leaves no triangle to sample.
#[inline]
pub fn sample(vertices: [DVec3; 3], omega: f64, u: Vec2) -> Option<[f64; 2]> {
    let w = sample_direction(vertices.map(DVec3::normalize), omega, u);
    let (_, uv) = intersect_plane(vertices, DVec3::ZERO, w)?;
    uv.iter()
        .all(|x| x.is_finite())
        .then(|| clamp_to_triangle(uv))
}

/// Samples a direction by Arvo's construction: a point C' on the arc AC cuts off the area u_x omega; the result is on BC'.
fn sample_direction([a, b, c]: [DVec3; 3], omega: f64, u: Vec2) -> DVec3 {
    let (ab, ac) = (a.cross(b), a.cross(c));
    let scale = 1.0 / (ab.length() * ac.length());
    // The angle alpha at A, between the planes AB and AC.
    let cos_alpha = ab.dot(ac) * scale;
    let sin_alpha = a.dot((b - a).cross(c - a)).abs() * scale;
    let cos_c = a.dot(b);
    let (sin_area, cos_area) = sin_cos(f64::from(u.x) * omega);
    // s, t: sine and cosine of the cut-off area minus alpha.
    let s = sin_area * cos_alpha - cos_area * sin_alpha;
    let t = cos_area * cos_alpha + sin_area * sin_alpha;
    let p = t - cos_alpha;
    let v = s + sin_alpha * cos_c;
    let q = ((v * t - p * s) * cos_alpha - v) / ((v * s + p * t) * sin_alpha);
    // q is the cosine of the arc from A to C'; at u_x = 0 it is 0/0 and C' is A.
    let q = if q.is_nan() { 1.0 } else { q.clamp(-1.0, 1.0) };
    let c_cut = q * a + (1.0 - q * q).sqrt() * orthogonal_part(c, a);
    let one_minus_z = f64::from(u.y) * (1.0 - c_cut.dot(b));
    let z = 1.0 - one_minus_z;
    let sin = (one_minus_z * (1.0 + z)).max(0.0).sqrt();
    z * b + sin * orthogonal_part(c_cut, b)
}

/// The unit vector along the part of `v` at right angles to the unit vector `axis`.
#[inline]
fn orthogonal_part(v: DVec3, axis: DVec3) -> DVec3 {
    (v - v.dot(axis) * axis).normalize_or_zero()
}
