//! A colour or a spectral quantity in three channels.
//!
//! Measure: linear Rec. 709; a radiance in W m^-2 sr^-1, a reflectance without unit.
//! Range: that of `f32`; negative channels are allowed in intermediate results (filters), never in a reflectance.
//! Source: ITU-R BT.709 for the luminance weights. Tested below.

use super::vec::{Vec3, Vector};
use serde::Serialize;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Sub};

/// Red, green and blue.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Rgb<V = Vec3>(V);

impl Rgb {
    /// Zero in every channel.
    pub const BLACK: Self = Self(Vec3::ZERO);
    /// One in every channel.
    pub const WHITE: Self = Self(Vec3::ONE);

    /// A colour from its channels.
    #[inline]
    pub const fn new(r: f32, g: f32, b: f32) -> Self {
        Self(Vec3::new(r, g, b))
    }

    /// A colour with this value in every channel.
    #[inline]
    pub const fn grey(value: f32) -> Self {
        Self(Vec3::splat(value))
    }

    /// The channels.
    #[inline]
    pub const fn to_array(self) -> [f32; 3] {
        self.0.to_array()
    }

    /// Interpolates linearly from `self` at `t = 0` to `other` at `t = 1`.
    #[inline]
    pub fn lerp(self, other: Self, t: f32) -> Self {
        Self(self.0 + t * (other.0 - self.0))
    }
}

impl<V: Vector> Rgb<V> {
    /// Relative luminance Y of Rec. 709.
    #[inline(always)]
    pub fn luminance(self) -> f32 {
        self.0.dot(V::new(0.2126, 0.7152, 0.0722))
    }

    /// The largest channel.
    #[inline(always)]
    pub fn max_channel(self) -> f32 {
        self.0.max_element()
    }

    /// Whether every channel is a finite number.
    #[inline(always)]
    pub fn is_finite(self) -> bool {
        self.0.is_finite()
    }

    /// Whether every channel is exactly zero.
    #[inline(always)]
    pub fn is_black(self) -> bool {
        self.0 == V::splat(0.0)
    }

    /// Each channel mapped by `f`.
    #[inline(always)]
    pub fn map(self, f: impl Fn(f32) -> f32) -> Self {
        let channels: [f32; 3] = self.0.into();
        Self(V::from(channels.map(f)))
    }
}

impl<V: Vector> From<[f32; 3]> for Rgb<V> {
    #[inline(always)]
    fn from(channels: [f32; 3]) -> Self {
        Self(V::from(channels))
    }
}

impl<V: Vector> From<Rgb<V>> for [f32; 3] {
    #[inline(always)]
    fn from(colour: Rgb<V>) -> Self {
        colour.0.into()
    }
}

impl<V: Vector> Add for Rgb<V> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl<V: Vector> AddAssign for Rgb<V> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
}

impl<V: Vector> Sub for Rgb<V> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl<V: Vector> Mul for Rgb<V> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }
}

impl<V: Vector> MulAssign for Rgb<V> {
    #[inline(always)]
    fn mul_assign(&mut self, other: Self) {
        self.0 *= other.0;
    }
}

impl<V: Vector> Mul<f32> for Rgb<V> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f32) -> Self {
        Self(self.0 * factor)
    }
}

impl<V: Vector> Mul<Rgb<V>> for f32 {
    type Output = Rgb<V>;
    #[inline(always)]
    fn mul(self, colour: Rgb<V>) -> Rgb<V> {
        colour * self
    }
}

impl<V: Vector> MulAssign<f32> for Rgb<V> {
    #[inline(always)]
    fn mul_assign(&mut self, factor: f32) {
        self.0 *= factor;
    }
}

impl<V: Vector> Div<f32> for Rgb<V> {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: f32) -> Self {
        Self(self.0 / divisor)
    }
}

impl<V: Vector> Div for Rgb<V> {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: Self) -> Self {
        Self(self.0 / divisor.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn luminance_of_white_is_one() {
        assert!((Rgb::WHITE.luminance() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn lerp_returns_the_endpoints_at_zero_and_one() {
        let (a, b) = (Rgb::new(1.0, 2.0, 3.0), Rgb::new(4.0, 0.0, -1.0));
        assert_eq!(a.lerp(b, 0.0), a);
        assert_eq!(a.lerp(b, 1.0), b);
    }
}
