//! Lights of KHR_lights_punctual: point, spot and directional lights.
//!
//! Measure: glTF's intensities are photometric: candela, and lux of directional lights. They become W/sr and W/m^2 at
//! 683 lm/W, the conversion of Blender's exporter and importer.
//! Range: intensities of at least 0; `range`, a hint for other renderers, is ignored.
//! Source: KHR_lights_punctual. Between the angles of a spot light the intensity falls as that of our own, which the
//! extension leaves open. Tested in `tests/loading/gltf.rs`.

use super::buffers::Asset;
use crate::error::Result;
use crate::math::rgb::Rgb;
use crate::math::vec::{DAffine3, DVec3};
use crate::scene::description::{LightDescription, LightModel, Place};
use gltf::json::extensions::scene::khr_lights_punctual::Light;
use gltf::json::extensions::scene::khr_lights_punctual::Type;
use gltf::json::validation::Checked;

/// Lumens of a watt.
pub const LUMENS_PER_WATT: f32 = 683.0;

/// Returns the light of a node; `index` is that of the light in the file.
///
/// # Errors
/// If it has no valid intensity or angles.
pub fn light(
    asset: &Asset<'_>,
    light: &Light,
    index: usize,
    to_world: &DAffine3,
) -> Result<LightDescription> {
    let wrong = |message: &str| {
        let field = format!("extensions.KHR_lights_punctual.lights[{index}]");
        asset.error(field, message)
    };
    let watts = Rgb::from(light.color.map(|x| x * light.intensity / LUMENS_PER_WATT));
    if !watts.to_array().iter().all(|x| *x >= 0.0 && x.is_finite()) {
        return Err(wrong(
            "expected a finite intensity and colour of at least 0",
        ));
    }
    let position = to_world.translation;
    let direction = to_world.transform_vector3(DVec3::NEG_Z).try_normalize();
    let direction = direction.ok_or_else(|| wrong("expected a node that does not flatten it"));
    let model = match (light.type_, &light.spot) {
        (Checked::Valid(Type::Point), _) => LightModel::Point {
            position,
            intensity: watts,
        },
        (Checked::Valid(Type::Directional), _) => LightModel::Distant {
            direction: direction?,
            irradiance: watts,
        },
        (Checked::Valid(Type::Spot), Some(spot)) => {
            let (inner, outer) = (
                f64::from(spot.inner_cone_angle),
                f64::from(spot.outer_cone_angle),
            );
            // Equal angles, which Blender writes for a spot with a sharp edge, are no error of use to anybody.
            if !(0.0 <= inner && inner <= outer && 0.0 < outer && outer <= std::f64::consts::PI) {
                return Err(wrong(
                    "expected an inner cone angle from 0 to the outer one, and that above 0 and at most pi",
                ));
            }
            LightModel::Spot {
                position,
                target: position + direction?,
                intensity: watts,
                cone: outer,
                penumbra: outer - inner,
            }
        }
        (Checked::Valid(Type::Spot), None) => {
            return Err(wrong("expected the angles of a spot light"));
        }
        (Checked::Invalid, _) => {
            return Err(wrong("expected the type point, spot or directional"));
        }
    };
    Ok(LightDescription {
        place: Place::of_file(asset.path),
        model,
    })
}
