//! A density on the unit square that is the product of a linear density of each coordinate.
//!
//! Measure: densities per unit of area of the unit square.
//! Range: positive weights between 1e-9 and 1e9. Points outside the square are clamped to it.
//! Source: inversion of the cumulative distribution. Tested in `tests/sampling/warps.rs`.

use crate::math::vec::Vec2;

/// A density in proportion to (a + x (b - a)) (c + y (d - c)).
#[derive(Debug, Clone, Copy)]
pub struct LinearSquare {
    /// The weights where each coordinate is 0: a and c.
    start: Vec2,
    /// The weights where it is 1: b and d.
    end: Vec2,
}

impl LinearSquare {
    /// The uniform density, 1.
    pub const UNIFORM: Self = Self::new(Vec2::ONE, Vec2::ONE);

    /// Creates the density whose factors run linearly from `start` to `end`.
    #[inline(always)]
    pub const fn new(start: Vec2, end: Vec2) -> Self {
        Self { start, end }
    }

    /// Samples a point from two uniform numbers.
    ///
    /// Each coordinate solves a x + (b - a) x^2 / 2 = u (a + b) / 2, by the root that does not cancel where a and b are
    /// close.
    #[inline(always)]
    pub fn sample(&self, u: Vec2) -> Vec2 {
        let (a, b) = (self.start, self.end);
        let square = a * a + u * (b * b - a * a);
        let root = Vec2::new(square.x.sqrt(), square.y.sqrt());
        (u * (a + b) / (a + root)).min(Vec2::ONE)
    }

    /// The density at a point.
    #[inline(always)]
    pub fn pdf(&self, at: Vec2) -> f32 {
        let at = at.clamp(Vec2::ZERO, Vec2::ONE);
        let value = self.start + at * (self.end - self.start);
        let sum = self.start + self.end;
        4.0 * (value.x * value.y) / (sum.x * sum.y)
    }
}
