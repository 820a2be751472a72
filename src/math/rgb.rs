//! A colour or a spectral quantity in three channels.
//!
//! Measure: linear Rec. 709; a radiance in W m^-2 sr^-1, a reflectance without unit.
//! Range: that of `f32`; negative channels are allowed in intermediate results (filters), never in a reflectance.
//! Source: ITU-R BT.709 for the luminance weights. Tested below.

use super::vec::Vec3;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Sub};

/// Red, green and blue.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rgb(Vec3);

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

    /// Relative luminance Y of Rec. 709.
    #[inline]
    pub fn luminance(self) -> f32 {
        self.0.dot(Vec3::new(0.2126, 0.7152, 0.0722))
    }

    /// The largest channel.
    #[inline]
    pub fn max_channel(self) -> f32 {
        self.0.max_element()
    }

    /// Whether every channel is a finite number.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.0.is_finite()
    }

    /// Whether every channel is exactly zero.
    #[inline]
    pub fn is_black(self) -> bool {
        self.0 == Vec3::ZERO
    }

    /// Each channel mapped by `f`.
    #[inline]
    pub fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self::new(f(self.0.x), f(self.0.y), f(self.0.z))
    }

    /// Interpolates linearly from `self` at `t = 0` to `other` at `t = 1`.
    #[inline]
    pub fn lerp(self, other: Self, t: f32) -> Self {
        Self(self.0 + t * (other.0 - self.0))
    }
}

impl From<[f32; 3]> for Rgb {
    fn from(channels: [f32; 3]) -> Self {
        Self(Vec3::from_array(channels))
    }
}

impl Add for Rgb {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl AddAssign for Rgb {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
}

impl Sub for Rgb {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Mul for Rgb {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }
}

impl MulAssign for Rgb {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        self.0 *= other.0;
    }
}

impl Mul<f32> for Rgb {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f32) -> Self {
        Self(self.0 * factor)
    }
}

impl Mul<Rgb> for f32 {
    type Output = Rgb;
    #[inline]
    fn mul(self, colour: Rgb) -> Rgb {
        colour * self
    }
}

impl MulAssign<f32> for Rgb {
    #[inline]
    fn mul_assign(&mut self, factor: f32) {
        self.0 *= factor;
    }
}

impl Div<f32> for Rgb {
    type Output = Self;
    #[inline]
    fn div(self, divisor: f32) -> Self {
        Self(self.0 / divisor)
    }
}

impl Div for Rgb {
    type Output = Self;
    #[inline]
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
    fn lerp_meets_both_ends() {
        let (a, b) = (Rgb::new(1.0, 2.0, 3.0), Rgb::new(4.0, 0.0, -1.0));
        assert_eq!(a.lerp(b, 0.0), a);
        assert_eq!(a.lerp(b, 1.0), b);
    }
}
