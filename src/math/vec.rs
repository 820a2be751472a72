//! The vector types: glam's, in single precision for tracing and shading, in double precision for loading.
//!
//! `Vec3` is one SIMD register with an unused fourth number: the fastest for one vector at a time. `LaneVec3` is three
//! numbers, for loops over lanes, where the compiler keeps one component of sixteen vectors in a register. Formulas that
//! are needed for both are written once, over [`Vector`].
//!
//! Measure: positions in normalised scene units, directions of unit length unless said otherwise.
//! Range: that of `f32` and `f64`.
//! Source: glam. Tested there and below.

pub use glam::{
    DAffine2, DAffine3, DMat2, DMat3, DMat4, DQuat, DVec2, DVec3, Mat3, Vec2, Vec3 as LaneVec3,
    Vec3A as Vec3, Vec3Swizzles, Vec4,
};
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub};

/// The largest `f32` below one: the greatest value that a uniform random number takes.
pub const ONE_MINUS_EPSILON: f32 = 1.0 - f32::EPSILON / 2.0;

/// A vector of three `f32`: [`Vec3`] or [`LaneVec3`]. Both give the same bits.
pub trait Vector:
    Copy
    + Debug
    + Default
    + PartialEq
    + From<[f32; 3]>
    + Into<[f32; 3]>
    + From<Vec3>
    + Into<Vec3>
    + From<LaneVec3>
    + Into<LaneVec3>
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Neg<Output = Self>
    + Mul<Output = Self>
    + MulAssign
    + Mul<f32, Output = Self>
    + MulAssign<f32>
    + Div<Output = Self>
    + Div<f32, Output = Self>
{
    /// Creates a vector from its components.
    fn new(x: f32, y: f32, z: f32) -> Self;
    /// The first component.
    fn x(self) -> f32;
    /// The second component.
    fn y(self) -> f32;
    /// The third component.
    fn z(self) -> f32;
    /// The vector (y, z, x).
    fn yzx(self) -> Self;
    /// The vector (z, x, y).
    fn zxy(self) -> Self;
    /// The dot product.
    fn dot(self, other: Self) -> f32;
    /// The cross product.
    fn cross(self, other: Self) -> Self;
    /// The absolute values of the components.
    fn abs(self) -> Self;
    /// The signs of the components: -1, 0 or 1.
    fn signs(self) -> Self;
    /// The component-wise minimum.
    fn min(self, other: Self) -> Self;
    /// The component-wise maximum.
    fn max(self, other: Self) -> Self;
    /// The greatest component.
    fn max_element(self) -> f32;
    /// Whether all components are finite.
    fn is_finite(self) -> bool;

    /// The vector with this value in each component.
    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self::new(value, value, value)
    }

    /// The sum of the components.
    #[inline(always)]
    fn element_sum(self) -> f32 {
        self.x() + self.y() + self.z()
    }

    /// The squared length.
    #[inline(always)]
    fn length_squared(self) -> f32 {
        self.dot(self)
    }

    /// The length.
    #[inline(always)]
    fn length(self) -> f32 {
        self.dot(self).sqrt()
    }

    /// The unit vector along this one, or `fallback` if it has no finite length above zero.
    #[inline(always)]
    fn normalize_or(self, fallback: Self) -> Self {
        let reciprocal = 1.0 / self.length();
        if reciprocal.is_finite() & (reciprocal > 0.0) {
            self * reciprocal
        } else {
            fallback
        }
    }
}

macro_rules! implement_vector {
    ($vector:ty) => {
        impl Vector for $vector {
            #[inline(always)]
            fn new(x: f32, y: f32, z: f32) -> Self {
                Self::new(x, y, z)
            }
            #[inline(always)]
            fn x(self) -> f32 {
                self.x
            }
            #[inline(always)]
            fn y(self) -> f32 {
                self.y
            }
            #[inline(always)]
            fn z(self) -> f32 {
                self.z
            }
            #[inline(always)]
            fn yzx(self) -> Self {
                Vec3Swizzles::yzx(self)
            }
            #[inline(always)]
            fn zxy(self) -> Self {
                Vec3Swizzles::zxy(self)
            }
            #[inline(always)]
            fn dot(self, other: Self) -> f32 {
                self.dot(other)
            }
            #[inline(always)]
            fn cross(self, other: Self) -> Self {
                self.cross(other)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }
            #[inline(always)]
            fn signs(self) -> Self {
                Self::select(self.cmpeq(Self::ZERO), Self::ZERO, self.signum())
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                self.min(other)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                self.max(other)
            }
            #[inline(always)]
            fn max_element(self) -> f32 {
                self.max_element()
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                self.is_finite()
            }
        }
    };
}
implement_vector!(Vec3);
implement_vector!(LaneVec3);

/// The mirror image of `w` about the unit vector `n`; both point away from the surface.
#[inline(always)]
pub fn reflect<V: Vector>(w: V, n: V) -> V {
    n * (2.0 * w.dot(n)) - w
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflect_mirrors_the_direction_about_the_normal() {
        let n = Vec3::new(0.0, 0.0, 1.0);
        let w = Vec3::new(0.6, 0.0, 0.8);
        assert!((reflect(w, n) - Vec3::new(-0.6, 0.0, 0.8)).length() < 1e-6);
    }

    #[test]
    fn vec3_and_lane_vec3_operations_are_bit_identical() {
        let number = |i: i32| (i as f32 * 0.7).sin() * 2.0_f32.powi(i % 40 - 20);
        let all = |i: i32| [number(3 * i), number(3 * i + 1), number(3 * i + 2)];
        fn results<V: Vector>(a: V, b: V) -> Vec<u32> {
            let vectors = [
                a.cross(b),
                a.normalize_or(b),
                reflect(a, b),
                a.signs() * b.abs(),
                a.min(b) / b.max(a),
                a.yzx() - b * 0.3,
            ];
            let numbers = [a.dot(b), a.length(), a.element_sum(), a.max_element()];
            let components = vectors.into_iter().flat_map(Into::<[f32; 3]>::into);
            components.chain(numbers).map(f32::to_bits).collect()
        }
        for i in 0..1000 {
            let (a, b) = (all(i), all(i + 1000));
            let single = results(Vec3::from(a), Vec3::from(b));
            assert_eq!(
                single,
                results(LaneVec3::from(a), LaneVec3::from(b)),
                "{a:?} {b:?}"
            );
        }
    }
}
