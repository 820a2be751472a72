//! Lights that are no shapes, as they were written.
//!
//! Measure: world units and radians; W/sr, W/m^2 or W m^-2 sr^-1 as said at each.
//! Range: what `load` lets through: at least 0 in every channel.
//! Source: docs/scene-format.md. Tested through `load`.

use super::{ColourDescription, Place};
use crate::math::rgb::Rgb;
use crate::math::vec::{DMat3, DVec3};

/// A light that is no shape.
#[derive(Debug, Clone)]
pub struct LightDescription {
    /// Where it was written.
    pub place: Place,
    /// What it is.
    pub model: LightModel,
}

/// The kinds of lights that are no shapes.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum LightModel {
    /// Light from everywhere beyond the scene.
    Environment {
        /// Radiance. A picture is a panorama: its middle is seen along -z, its right half towards +x, its top along +y.
        radiance: ColourDescription,
        /// From the panorama's axes to those of the world: a rotation.
        to_world: DMat3,
    },
    /// A point that shines evenly.
    Point {
        /// Where it is.
        position: DVec3,
        /// Radiant intensity, W/sr.
        intensity: Rgb,
    },
    /// A point that shines into a cone.
    Spot {
        /// Where it is.
        position: DVec3,
        /// Where its axis points; not `position`.
        target: DVec3,
        /// Radiant intensity along the axis, W/sr.
        intensity: Rgb,
        /// Angle from the axis to the edge, in radians, in (0, pi].
        cone: f64,
        /// The outer part of that angle over which the intensity falls off, in [0, cone].
        penumbra: f64,
    },
    /// Parallel light from beyond the scene.
    Distant {
        /// The direction in which light travels, not 0.
        direction: DVec3,
        /// Irradiance of a surface at right angles to it, W/m^2.
        irradiance: Rgb,
    },
}

impl LightDescription {
    /// The same radiance from everywhere beyond the scene.
    pub fn sky(place: Place, radiance: Rgb) -> Self {
        let radiance = ColourDescription::Constant(radiance);
        let to_world = DMat3::IDENTITY;
        Self {
            place,
            model: LightModel::Environment { radiance, to_world },
        }
    }
}
