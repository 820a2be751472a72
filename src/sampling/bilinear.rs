//! A density on the unit square that is bilinear: linear along each edge and each line parallel to one.
//!
//! Measure: densities per unit of area of the unit square.
//! Range: weights of the corners from 0 to 1e9 that are not all 0, of which those above 0 are at least 1e-9. Points outside the
//! square are clamped to it.
//! Source: inversion of the marginal and of the conditional distribution. Tested in `tests/sampling/warps.rs`.

use crate::math::vec::Vec2;
use crate::planted::planted;

/// A density in proportion to the bilinear interpolation of weights at the corners.
#[derive(Debug, Clone, Copy)]
pub struct BilinearSquare {
    /// The weights at (0, 0) and (0, 1).
    left: Vec2,
    /// The weights at (1, 0) and (1, 1).
    right: Vec2,
}

impl BilinearSquare {
    /// The uniform density, 1.
    pub const UNIFORM: Self = Self::new([1.0; 4]);

    /// Creates the density of the weights at (0, 0), (1, 0), (0, 1) and (1, 1).
    #[inline(always)]
    pub const fn new([w00, w10, w01, w11]: [f32; 4]) -> Self {
        Self {
            left: Vec2::new(w00, w01),
            right: Vec2::new(w10, w11),
        }
    }

    /// Samples a point from two uniform numbers.
    #[inline(always)]
    pub fn sample(&self, u: Vec2) -> Vec2 {
        let rows = self.left + self.right;
        let y = sample_linear(u.y, rows.x, rows.y);
        let left = self.left.x + y * (self.left.y - self.left.x);
        let right = self.right.x + y * (self.right.y - self.right.x);
        Vec2::new(sample_linear(u.x, left, right), y)
    }

    /// The density at a point.
    #[inline(always)]
    pub fn pdf(&self, at: Vec2) -> f32 {
        let at = at.clamp(Vec2::ZERO, Vec2::ONE);
        let row = self.left + at.x * (self.right - self.left);
        let sum = self.left + self.right;
        let pdf = 4.0 * (row.x + at.y * (row.y - row.x)) / (sum.x + sum.y);
        planted!("warp-without-density", 1.0, pdf)
    }
}

/// Samples the density on [0, 1] in proportion to a + x (b - a).
///
/// x solves a x + (b - a) x^2 / 2 = u (a + b) / 2, by the root that does not cancel where a and b are close.
#[inline(always)]
fn sample_linear(u: f32, a: f32, b: f32) -> f32 {
    let root = (a * a + u * (b * b - a * a)).max(0.0).sqrt();
    // 0 / 0 at u = 0 if a is 0.
    (u * (a + b) / (a + root).max(f32::MIN_POSITIVE)).min(1.0)
}
