//! The density on the unit square that is bilinear between four weights, one at each corner.
//!
//! Measure: densities per unit of area of the unit square.
//! Range: positive weights. Numbers outside [0, 1] are taken as lying at the rim.
//! Source: inversion of the cumulative distribution, first of the second coordinate, then of the first given the second.
//! Tested in `tests/sampling.rs`.

use crate::math::vec::{Vec2, Vec4};

/// A bilinear density.
#[derive(Debug, Clone, Copy)]
pub struct Bilinear {
    /// At (0, 0), (1, 0), (0, 1) and (1, 1); they sum to 4.
    corners: Vec4,
}

impl Bilinear {
    /// The density 1.
    pub const UNIFORM: Self = Self { corners: Vec4::ONE };

    /// The density in proportion to the weights at (0, 0), (1, 0), (0, 1) and (1, 1).
    #[inline]
    pub fn new(weights: Vec4) -> Self {
        Self {
            corners: weights * (4.0 / weights.element_sum()),
        }
    }

    /// The point for two uniform numbers.
    #[inline]
    pub fn sample(&self, u: Vec2) -> Vec2 {
        let [a, b, c, d] = self.corners.to_array();
        let y = sample_linear(a + b, c + d, u.y);
        let x = sample_linear(a + y * (c - a), b + y * (d - b), u.x);
        Vec2::new(x, y)
    }

    /// The density at a point.
    #[inline]
    pub fn pdf(&self, at: Vec2) -> f32 {
        let [a, b, c, d] = self.corners.to_array();
        let at = at.clamp(Vec2::ZERO, Vec2::ONE);
        let (low, high) = (a + at.y * (c - a), b + at.y * (d - b));
        low + at.x * (high - low)
    }
}

/// The number from 0 to 1 for a density that runs linearly from `a` to `b`.
///
/// It solves a x + (b - a) x^2 / 2 = u (a + b) / 2 with the root that does not cancel where a and b are close.
#[inline]
fn sample_linear(a: f32, b: f32, u: f32) -> f32 {
    let root = (a * a + u * (b * b - a * a)).sqrt();
    (u * (a + b) / (a + root)).min(1.0)
}
