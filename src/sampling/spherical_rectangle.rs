//! Uniform sampling of a rectangle's solid angle: the solid angle, and points with density 1 / solid angle.
//!
//! Measure: densities per steradian; lengths in any unit. All in double precision: the angles' sum minus 2 pi cancels.
//! Range: any rectangle and any viewpoint off its plane; in the plane the result is `None`. The relative error of the
//! solid angle is below 1e-7 down to 1e-9 sr; callers fall back to area sampling below [`MIN_SOLID_ANGLE`].
//! Source: Ureña, Fajardo and King 2013, "An Area-Preserving Parametrization for Spherical Rectangles"; the angles are
//! summed as a product of complex numbers, formed without cancellation. Tested in `tests/sampling/warps.rs`.

use crate::math::functions::{atan2, sin_cos};
use crate::math::vec::{DVec3, Vec2};
use std::f64::consts::TAU;

/// The solid angle, in steradians, below which area sampling is better: the difference between the two is smaller than
/// rounding.
pub const MIN_SOLID_ANGLE: f64 = 1e-8;

/// A rectangle seen from a viewpoint, in the frame where the viewpoint is the origin and z is the rectangle's normal.
#[derive(Debug, Clone, Copy)]
pub struct SphericalRectangle {
    /// Extent along the first edge.
    x: [f64; 2],
    /// Extent along the second edge.
    y: [f64; 2],
    /// Distance of the plane, squared.
    z2: f64,
    /// gamma_2 + gamma_3 as a complex number, not of unit length.
    far_angles: [f64; 2],
    solid_angle: f64,
}

impl SphericalRectangle {
    /// Creates the rectangle at `corner` (relative to the viewpoint) along the orthogonal unit vectors `axes`.
    #[inline]
    pub fn new(corner: DVec3, axes: [DVec3; 2], lengths: [f64; 2]) -> Option<Self> {
        let z = corner.dot(axes[0].cross(axes[1])).abs();
        if z == 0.0 {
            return None;
        }
        let (x0, y0) = (corner.dot(axes[0]), corner.dot(axes[1]));
        let (x, y) = ([x0, x0 + lengths[0]], [y0, y0 + lengths[1]]);
        let z2 = z * z;
        // The angle between the planes through the edges that meet at the corner (x, y) has the tangent z r / (+-x y),
        // where r is the corner's distance: a complex number that needs no normal of unit length.
        let angle = |x: f64, y: f64, sign: f64| [sign * x * y, z * (x * x + y * y + z2).sqrt()];
        let near_angles = add_angles(angle(x[1], y[0], 1.0), angle(x[1], y[1], -1.0));
        let far_angles = add_angles(angle(x[0], y[1], 1.0), angle(x[0], y[0], -1.0));
        let [cos, sin] = add_angles(near_angles, far_angles);
        let sum = atan2(sin, cos);
        // The sum exceeds 2 pi by the solid angle, which exceeds pi only above the rectangle. Elsewhere a negative sum is a
        // rounding error.
        let is_above = x[0] < 0.0 && x[1] > 0.0 && y[0] < 0.0 && y[1] > 0.0;
        let solid_angle = match sum < 0.0 {
            true if is_above => sum + TAU,
            true => 0.0,
            false => sum,
        };
        Some(Self {
            x,
            y,
            z2,
            far_angles,
            solid_angle,
        })
    }

    /// The solid angle, in steradians.
    #[inline]
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// Samples a point of the rectangle uniformly by solid angle, as fractions of its two edges.
    #[inline]
    pub fn sample(&self, u: Vec2) -> [f64; 2] {
        // The paper's b_0 and b_1: cosines of the normals of the planes through the edges at y0 and y1.
        let b = [-self.y[0], self.y[1]].map(|y| y / (y * y + self.z2).sqrt());
        // phi_u = u S + k with k = 2 pi - gamma_2 - gamma_3, as a complex number of any length: f is a ratio of its
        // parts and of that length.
        let (sin, cos) = sin_cos(f64::from(u.x) * self.solid_angle);
        let [far_cos, far_sin] = self.far_angles;
        let [cos_phi, sin_phi] = add_angles([cos, sin], [far_cos, -far_sin]);
        let length = (far_cos * far_cos + far_sin * far_sin).sqrt();
        let f = (cos_phi * b[0] - length * b[1]) / sin_phi;
        // x = -c z / sqrt(1 - c^2) with c = sign(f) / sqrt(f^2 + b_0^2); past the ends it becomes infinite.
        let x = (self.z2 / (f * f + b[0] * b[0] - 1.0).max(0.0))
            .sqrt()
            .copysign(f);
        // Results of rounding, and of 0/0 at u = 0, are clamped to the range.
        let x = if x.is_nan() {
            self.x[0]
        } else {
            x.clamp(self.x[0], self.x[1])
        };
        let d2 = x * x + self.z2;
        let h = self.y.map(|y| y / (d2 + y * y).sqrt());
        let h_v = h[0] + f64::from(u.y) * (h[1] - h[0]);
        let y = h_v * (d2 / (1.0 - h_v * h_v)).sqrt();
        let y = if y.is_nan() {
            self.y[0]
        } else {
            y.clamp(self.y[0], self.y[1])
        };
        [
            (x - self.x[0]) / (self.x[1] - self.x[0]),
            (y - self.y[0]) / (self.y[1] - self.y[0]),
        ]
    }
}

/// The sum of two angles, given as complex numbers of any length.
#[inline]
fn add_angles(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}
