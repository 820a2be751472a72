//! What every light answers.
//!
//! Measure: radiance in W m^-2 sr^-1, densities per steradian at the receiving point, lengths in normalised units.
//! Range: any receiving point; one that cannot be lit gets no sample.
//! Source: Veach 1997, section 8.2; Pharr, Jakob, Humphreys, "Light Interface". Tested in `tests/light.rs`.

use crate::geometry::surface::SurfacePoint;
use crate::math::measure::PdfSolidAngle;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec3;

/// A point on a light, chosen to light a given receiver.
#[derive(Debug, Clone, Copy)]
pub struct LightSample {
    /// The point on the light.
    pub point: SurfacePoint,
    /// Unit vector from the receiver to it.
    pub wi: Vec3,
    /// Radiance that leaves the light towards the receiver.
    pub radiance: Rgb,
    /// Density of `wi`, given this light.
    pub pdf: PdfSolidAngle,
}

/// What a surface emits, and on which side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Emission {
    /// Radiance.
    pub radiance: Rgb,
    /// Whether the back emits as well.
    pub two_sided: bool,
}

impl Emission {
    /// Radiance towards a direction whose cosine with the geometric normal is `cos`.
    #[inline]
    pub fn towards(&self, cos: f32) -> Rgb {
        if cos > 0.0 || (self.two_sided && cos < 0.0) {
            self.radiance
        } else {
            Rgb::BLACK
        }
    }

    /// Radiant power of a flat or convex emitter of this area: pi A L for each side that emits.
    pub fn power(&self, area: f64) -> f64 {
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        sides * std::f64::consts::PI * area * f64::from(self.radiance.luminance())
    }
}
