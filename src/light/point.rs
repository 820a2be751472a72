//! A point light of uniform intensity.
//!
//! Measure: radiant intensity in W/sr for a scene in normalised units: that in world units times the square of the
//! normalisation's scale, as the irradiance I / d^2 requires.
//! Range: any receiver except the point itself, and those so near that the irradiance is not finite.
//! Source: the inverse square law. Tested in `tests/lights/light.rs`.

use super::types::{LightSample, ShadowRayEnd};
use crate::math::rgb::Rgb;
use crate::math::vec::Vec3;
use std::f64::consts::PI;

/// A point light.
#[derive(Debug, Clone, Copy)]
pub struct PointLight {
    position: Vec3,
    intensity: Rgb,
}

impl PointLight {
    /// Creates a light at a position, with a radiant intensity, both in normalised units.
    pub fn new(position: Vec3, intensity: Rgb) -> Self {
        Self {
            position,
            intensity,
        }
    }

    /// Radiant power in normalised units: 4 pi I.
    pub fn power(&self) -> f64 {
        4.0 * PI * f64::from(self.intensity.luminance())
    }

    /// Position of the light.
    pub fn position(&self) -> Vec3 {
        self.position
    }

    /// Radiant intensity in every direction.
    pub fn intensity(&self) -> Rgb {
        self.intensity
    }

    /// Samples the direction to the light for the receiver `p`, a delta.
    #[inline]
    pub fn sample(&self, p: Vec3) -> Option<LightSample> {
        // In double precision, no square of a distance overflows.
        let towards = self.position.as_dvec3() - p.as_dvec3();
        let distance2 = towards.length_squared();
        let irradiance = self.intensity * (1.0 / distance2) as f32;
        irradiance.is_finite().then(|| LightSample {
            wi: (towards / distance2.sqrt()).as_vec3a(),
            radiance: irradiance,
            pdf: None,
            end: ShadowRayEnd::Point(self.position),
        })
    }
}
