//! Parallel light from beyond the scene.
//!
//! Measure: irradiance in W/m^2 of a surface at right angles to it, the same in all units of length.
//! Range: any receiver.
//! Source: none needed. Tested in `tests/lights/light.rs`.

use super::types::{LightSample, ShadowRayEnd};
use crate::math::rgb::Rgb;
use crate::math::vec::Vec3;
use std::f64::consts::PI;

/// A light at infinity, without a size.
#[derive(Debug, Clone, Copy)]
pub struct DistantLight {
    direction: Vec3,
    irradiance: Rgb,
}

impl DistantLight {
    /// Light that travels along the unit vector `direction`.
    pub fn new(direction: Vec3, irradiance: Rgb) -> Self {
        Self {
            direction,
            irradiance,
        }
    }

    /// Radiant power in normalised units that enters a sphere around the scene: pi R^2 E.
    pub fn power(&self, scene_radius: f64) -> f64 {
        PI * scene_radius * scene_radius * f64::from(self.irradiance.luminance())
    }

    /// The unit vector along which its light travels.
    pub fn direction(&self) -> Vec3 {
        self.direction
    }

    /// Irradiance at right angles.
    pub fn irradiance(&self) -> Rgb {
        self.irradiance
    }

    /// The direction from which it lights any point; a delta.
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
