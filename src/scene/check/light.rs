//! Checks lights that are not shapes by the rules of `load`.
//!
//! Measure: as in the description.
//! Range: any light.
//! Source: docs/scene-format.md. Tested in `tests/loading/built_scenes.rs`.

use super::values::{colour, direction, finite, not_negative, require};
use crate::error::Result;
use crate::geometry::texture::Texture;
use crate::math::transform::is_rotation;
use crate::scene::description::{ColourDescription, LightDescription, LightModel};
use std::f64::consts::PI;

/// Checks a light that is not a shape.
///
/// # Errors
/// If the light is invalid.
pub fn light(light: &LightDescription) -> Result<()> {
    let field = |key: &str| format!("light: {key}");
    match &light.model {
        LightModel::Environment { radiance, to_world } => {
            colour(radiance, f32::MAX, || field("radiance"))?;
            if let ColourDescription::Texture(texture) = radiance {
                let is_picture = matches!(**texture, Texture::Image { .. });
                let expected = "expected a colour or a plain image: an environment has neither a checker nor a place on a surface";
                require(is_picture, || field("radiance"), expected)?;
            }
            let is_turned = to_world.is_finite() && is_rotation(to_world);
            require(is_turned, || field("to_world"), "expected a rotation")
        }
        LightModel::Point {
            position,
            intensity,
        } => {
            finite(*position, || field("position"))?;
            not_negative(*intensity, || field("intensity"))
        }
        LightModel::Spot {
            position,
            target,
            intensity,
            cone,
            penumbra,
        } => {
            finite(*position, || field("position"))?;
            finite(*target, || field("target"))?;
            direction(*target - *position, || field("target"))?;
            not_negative(*intensity, || field("intensity"))?;
            let expected = "expected an angle above 0, at most 180 degrees";
            require(*cone > 0.0 && *cone <= PI, || field("cone"), expected)?;
            let expected = "expected an angle from 0 to that of the cone";
            let is_within = (0.0..=*cone).contains(penumbra);
            require(is_within, || field("penumbra"), expected)
        }
        LightModel::Distant {
            direction: d,
            irradiance,
        } => {
            direction(*d, || field("direction"))?;
            not_negative(*irradiance, || field("irradiance"))
        }
    }
}

/// Checks the lights of a scene together: at most one environment map.
///
/// # Errors
/// If there are several.
pub fn panoramas(lights: &[LightDescription]) -> Result<()> {
    let is_panorama = |light: &&LightDescription| {
        matches!(
            light.model,
            LightModel::Environment {
                radiance: ColourDescription::Texture(_),
                ..
            }
        )
    };
    require(
        lights.iter().filter(is_panorama).count() <= 1,
        || "light: radiance".to_owned(),
        "there is an image environment already: expected at most one, and any number of constant ones",
    )
}
