//! Uniform directions towards a rectangle: its solid angle, and points on it with density 1 / solid angle.
//!
//! Measure: densities per steradian; lengths in any unit. All in double precision: the angles' sum minus 2 pi cancels.
//! Range: any rectangle and any point off its plane; a point in the plane sees nothing. The relative error of the solid
//! angle is below 1e-7 down to 1e-9 sr; users fall back to area sampling below [`SMALLEST`].
//! Source: Ureña, Fajardo and King 2013, "An Area-Preserving Parametrization for Spherical Rectangles"; the angles are
//! summed as a product of complex numbers, whose sines are formed without cancellation. Tested in `tests/sampling.rs`.

use crate::math::vec::{DVec3, Vec2};
use std::f64::consts::TAU;

/// Solid angles below this, in steradians, are better sampled by area: the difference between the two is smaller than
/// rounding.
pub const SMALLEST: f64 = 1e-8;

/// A rectangle seen from a point, in the frame where the point is the origin and z is at right angles to the rectangle.
#[derive(Debug, Clone, Copy)]
pub struct SphericalRectangle {
    /// Extent along the first edge.
    x: [f64; 2],
    /// Extent along the second edge.
    y: [f64; 2],
    /// Distance of the plane, negative.
    z: f64,
    /// Cosines of the edge planes' normals with z: n_0 at y0, n_2 at y1 (the paper's b_0 and b_1).
    b: [f64; 2],
    /// gamma_2 + gamma_3 as (cos, sin).
    far_angles: [f64; 2],
    solid_angle: f64,
}

impl SphericalRectangle {
    /// The rectangle at `corner` (relative to the viewpoint) along the orthogonal unit vectors `x_axis` and `y_axis`.
    #[inline]
    pub fn new(corner: DVec3, axes: [DVec3; 2], lengths: [f64; 2]) -> Option<Self> {
        let z = -corner.dot(axes[0].cross(axes[1])).abs();
        let x0 = corner.dot(axes[0]);
        let y0 = corner.dot(axes[1]);
        let (x, y) = ([x0, x0 + lengths[0]], [y0, y0 + lengths[1]]);
        let z2 = z * z;
        if z2 == 0.0 {
            return None;
        }
        // Lengths of the edge planes' unscaled normals.
        let rx = x.map(|x| (x * x + z2).sqrt());
        let ry = y.map(|y| (y * y + z2).sqrt());
        let n = [-y[0] / ry[0], x[1] / rx[1], y[1] / ry[1], -x[0] / rx[0]];
        // The inner angle between edge planes i and j has cosine -n_i n_j and sine sqrt(1 - n_i^2 n_j^2).
        let angle = |n_i: f64, n_j: f64, x: f64, rx: f64, y: f64, ry: f64| {
            [-n_i * n_j, -z * (x * x + y * y + z2).sqrt() / (rx * ry)]
        };
        let near_angles = add_angles(
            angle(n[0], n[1], x[1], rx[1], y[0], ry[0]),
            angle(n[1], n[2], x[1], rx[1], y[1], ry[1]),
        );
        let far_angles = add_angles(
            angle(n[2], n[3], x[0], rx[0], y[1], ry[1]),
            angle(n[3], n[0], x[0], rx[0], y[0], ry[0]),
        );
        let [cos, sin] = add_angles(near_angles, far_angles);
        let sum = sin.atan2(cos);
        // The sum exceeds 2 pi by the solid angle, which is below 2 pi itself.
        let solid_angle = if sum < 0.0 { sum + TAU } else { sum };
        Some(Self {
            x,
            y,
            z,
            b: [n[0], n[2]],
            far_angles,
            solid_angle,
        })
    }

    /// The solid angle, in steradians.
    #[inline]
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// The point of the rectangle for `u`, as fractions of its two edges: uniform in solid angle.
    #[inline]
    pub fn sample(&self, u: Vec2) -> [f64; 2] {
        let z2 = self.z * self.z;
        // phi_u = u S + k with k = 2 pi - gamma_2 - gamma_3, by its sine and cosine.
        let (sin, cos) = (f64::from(u.x) * self.solid_angle).sin_cos();
        let [cos_phi, sin_phi] = add_angles([cos, sin], [self.far_angles[0], -self.far_angles[1]]);
        let f = (cos_phi * self.b[0] - self.b[1]) / sin_phi;
        let c = (1.0_f64.copysign(f) / (f * f + self.b[0] * self.b[0]).sqrt()).clamp(-1.0, 1.0);
        let x = -c * self.z / (1.0 - c * c).sqrt();
        // The end points of the range absorb 0/0 and rounding.
        let x = if x.is_nan() {
            self.x[0]
        } else {
            x.clamp(self.x[0], self.x[1])
        };
        let d2 = x * x + z2;
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

/// The sum of two angles given as (cos, sin).
#[inline]
fn add_angles(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}
