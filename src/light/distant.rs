//! A distant light: parallel light from infinity.
//!
//! Measure: irradiance in W/m^2 of a surface perpendicular to it, independent of the unit of length.
//! Range: any receiver.
//! Source: none needed. Tested in `tests/lights/light.rs`.

use super::types::{LightSample, ShadowRayEnd};
use crate::math::rgb::Rgb;
use crate::math::vec::Vec3;
use std::f64::consts::PI;

/// A light at infinity with a single direction.
#[derive(Debug, Clone, Copy)]
pub struct DistantLight {
    direction: Vec3,
    irradiance: Rgb,
}

impl DistantLight {
    /// Creates a light that travels along the unit vector `direction`.
    pub fn new(direction: Vec3, irradiance: Rgb) -> Self {
        Self {
            direction,
            irradiance,
        }
    }

    /// Radiant power in normalised units that enters the scene's bounding sphere: pi R^2 E.
    pub fn power(&self, scene_radius: f64) -> f64 {
        PI * scene_radius * scene_radius * f64::from(self.irradiance.luminance())
    }

    /// The unit vector along which the light travels.
    pub fn direction(&self) -> Vec3 {
        self.direction
    }

    /// Irradiance of a surface perpendicular to the light.
    pub fn irradiance(&self) -> Rgb {
        self.irradiance
    }

    /// Samples the direction to the light, a delta, the same for every receiver.
    #[inline]
    pub fn sample(&self) -> LightSample {
        LightSample {
            wi: -self.direction,
            radiance: self.irradiance,
            pdf: None,
            end: ShadowRayEnd::Infinity,
        }
    }
}
