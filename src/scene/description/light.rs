//! Descriptions of the lights that are not shapes: environment, point, spot and distant lights.
//!
//! Measure: world units and radians; W/sr, W/m^2 or W m^-2 sr^-1 as stated at each field.
//! Range: guaranteed by `load`: at least 0 in every channel.
//! Source: docs/scene-format.md. Tested through `load`.

use super::{ColourDescription, Place};
use crate::math::rgb::Rgb;
use crate::math::vec::{DMat3, DVec3};
use serde::Serialize;

/// A light that is not a shape.
#[derive(Debug, Clone, Serialize, PartialEq)]
pub struct LightDescription {
    /// The place in the scene file.
    #[serde(skip)]
    pub place: Place,
    /// The kind of the light and its parameters.
    pub model: LightModel,
}

/// The kinds of lights that are not shapes.
#[derive(Debug, Clone, Serialize, PartialEq)]
#[non_exhaustive]
pub enum LightModel {
    /// An environment light: radiance arriving from infinity in all directions.
    Environment {
        /// Radiance. A texture is a panorama: its middle is seen along -z, its right half towards +x, its top along +y.
        radiance: ColourDescription,
        /// Rotation from the panorama's axes to world axes.
        to_world: DMat3,
    },
    /// A point light of constant intensity in all directions.
    Point {
        /// Position.
        position: DVec3,
        /// Radiant intensity, W/sr.
        intensity: Rgb,
    },
    /// A spot light: a point that emits into a cone.
    Spot {
        /// Position.
        position: DVec3,
        /// The point at which the axis is aimed; not `position`.
        target: DVec3,
        /// Radiant intensity along the axis, W/sr.
        intensity: Rgb,
        /// Angle from the axis to the edge, in radians, in (0, pi].
        cone: f64,
        /// The outer part of the cone angle over which the intensity falls off, in [0, cone].
        penumbra: f64,
    },
    /// A distant light: parallel light from infinity.
    Distant {
        /// The direction in which light travels, not 0.
        direction: DVec3,
        /// Irradiance of a surface perpendicular to the direction, W/m^2.
        irradiance: Rgb,
    },
}

impl LightDescription {
    /// Returns an environment light of constant radiance.
    pub fn sky(place: Place, radiance: Rgb) -> Self {
        let radiance = ColourDescription::Constant(radiance);
        let to_world = DMat3::IDENTITY;
        Self {
            place,
            model: LightModel::Environment { radiance, to_world },
        }
    }
}
