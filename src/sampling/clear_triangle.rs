//! Uniform sampling of the solid angle of a well-conditioned ("clear") triangle: as [`spherical_triangle`], at a third of
//! its cost.
//!
//! Measure: densities per steradian; lengths in any unit. In single precision, in forms that do not cancel: edges instead of
//! differences of unit vectors, tangents of half angles instead of cosines.
//! Range: clear triangles, which have at most pi / 2 sr and are seen at more than some four degrees from their plane; for
//! others [`ClearTriangle::new`] is `None`. The relative error of the solid angle is below 1e-6, that of the fractions
//! which a point cuts off below 2e-5.
//! Source: Van Oosterom and Strackee 1983, whose formula is linear in each unit vector, solved for the one that cuts off
//! a part; the points are those of Arvo 1995. Tested in `tests/sampling/warps.rs`.
//!
//! [`spherical_triangle`]: super::spherical_triangle

use crate::math::trig::{atan_unit, sin_cos_eighth};
use crate::math::vec::{LaneVec3, Vec2};

/// The least sine of the angle between the triangle's plane and the direction to each vertex.
const MIN_SINE: f32 = 1.0 / 16.0;

/// A triangle as seen from the origin.
#[derive(Debug, Clone, Copy)]
pub struct ClearTriangle {
    a: LaneVec3,
    b: LaneVec3,
    ab: LaneVec3,
    ac: LaneVec3,
    length_a: f32,
    length_b: f32,
    /// |a . (b x c)|
    triple: f32,
    half_angle: f32,
}

impl ClearTriangle {
    /// Creates the triangle of the given vertices, if it is clear. `triple` is |a . (ab x ac)| and `double_area` |ab x ac|.
    #[inline]
    pub fn new(vertices: [LaneVec3; 3], triple: f32, double_area: f32) -> Option<Self> {
        let (triangle, is_clear) = Self::and_whether_clear(vertices, triple, double_area);
        is_clear.then_some(triangle)
    }

    /// Creates the triangle and tests if it is clear, without a branch. Results of a triangle that is not are meaningless.
    #[inline(always)]
    pub fn and_whether_clear(
        [a, b, c]: [LaneVec3; 3],
        triple: f32,
        double_area: f32,
    ) -> (Self, bool) {
        let (length_a, length_b, length_c) = (a.length(), b.length(), c.length());
        let lengths = length_a * length_b * length_c;
        let rest = a.dot(b) * length_c + a.dot(c) * length_b + b.dot(c) * length_a;
        // As the triple product is at most the product of the lengths, the solid angle is at most pi / 2.
        let is_small = rest >= 0.0;
        let is_off_plane = triple >= MIN_SINE * double_area * length_a.max(length_b).max(length_c);
        // Below this, digits are lost to gradual underflow.
        let has_digits = triple >= f32::MIN_POSITIVE / f32::EPSILON;
        let triangle = Self {
            a,
            b,
            ab: b - a,
            ac: c - a,
            length_a,
            length_b,
            triple,
            half_angle: atan_unit(triple / (lengths + rest)),
        };
        (triangle, is_small & is_off_plane & has_digits)
    }

    /// The solid angle, in steradians.
    #[inline(always)]
    pub fn solid_angle(&self) -> f32 {
        2.0 * self.half_angle
    }

    /// Samples a point uniformly by solid angle; returns its barycentric coordinates (b1, b2).
    #[inline(always)]
    pub fn sample(&self, u: Vec2) -> [f32; 2] {
        let s = self.cut_edge(u.x);
        let to_cut = s * self.ac - self.ab;
        let r = self.along_arc(to_cut, u.y);
        [1.0 - r, r * s]
    }

    /// The point C' on the edge AC, as a fraction of the edge, for which A B C' has the fraction `u` of the solid angle:
    /// with the unit vector N in the plane A C perpendicular to A, C' = cos(phi) A + sin(phi) N, and
    ///
    ///   tan(phi / 2) = t (1 + A.B) / ([A, B, N] - t N.B),   t = tan(u Omega / 2).
    #[inline(always)]
    fn cut_edge(&self, u: f32) -> f32 {
        let (sin, cos) = sin_cos_eighth(u * self.half_angle);
        let over_a = 1.0 / self.length_a;
        let axis = over_a * self.a;
        let along = self.ac.dot(axis);
        let across = self.ac - along * axis;
        let length_across = across.length();
        let over_across = 1.0 / length_across;
        let y = sin * (self.length_b + axis.dot(self.b));
        let x = over_across * (cos * self.triple * over_a - sin * self.ab.dot(across));
        // Of an edge that begins at A, the ray at the angle phi from A cuts off the fraction
        // |a| sin(phi) / (across cos(phi) - along sin(phi)).
        let (sin_phi, cos_phi) = (2.0 * x * y, (x - y) * (x + y));
        to_unit(self.length_a * sin_phi / (length_across * cos_phi - along * sin_phi))
    }

    /// The point on the segment from B to C' = B + `to_cut`, as a fraction of it, whose arc from B has the fraction `v` of
    /// 1 - cos of the whole arc.
    #[inline(always)]
    fn along_arc(&self, to_cut: LaneVec3, v: f32) -> f32 {
        let over_b = 1.0 / self.length_b;
        let axis = over_b * self.b;
        let along = to_cut.dot(axis);
        let across2 = (to_cut - along * axis).length_squared();
        // C' has the coordinates `c_along` and `across`.
        let c_along = self.length_b + along;
        let c2 = c_along * c_along + across2;
        // 1 - cos = sin^2 / (1 + cos).
        let one_minus_z = v * across2 / (c2 + c2.sqrt() * c_along);
        let z = 1.0 - one_minus_z;
        let sin = (one_minus_z * (1.0 + z)).sqrt();
        to_unit(self.length_b * sin / (across2.sqrt() * z - along * sin))
    }
}

/// Clamps results of rounding, and of 0 / 0, to [0, 1].
#[inline(always)]
fn to_unit(x: f32) -> f32 {
    if x > 0.0 { x.min(1.0) } else { 0.0 }
}
