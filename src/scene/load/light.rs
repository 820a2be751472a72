//! Reads the `[[light]]` tables of a scene file: lights that are not shapes.
//!
//! Measure: world units, degrees; radiance, radiant intensity and irradiance.
//! Range: as docs/scene-format.md says for each key.
//! Source: docs/scene-format.md. Tested in `tests/loading/lights.rs`.

use super::colour::{Bound, TextureCache, colour, constant};
use super::reader::{Table, Value};
use super::transform::transform;
use crate::error::Result;
use crate::geometry::texture::Texture;
use crate::geometry::uv_map::UvMap;
use crate::math::rgb::Rgb;
use crate::math::transform::is_rotation;
use crate::math::vec::{DMat3, DVec3};
use crate::scene::description::{ColourDescription, LightDescription, LightModel, Place};
use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

/// The types of lights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LightType {
    Environment,
    Point,
    Spot,
    Distant,
}

const TYPES: &[(&str, LightType)] = &[
    ("environment", LightType::Environment),
    ("point", LightType::Point),
    ("spot", LightType::Spot),
    ("distant", LightType::Distant),
];

/// The keys of each light type.
const KEYS: &[(LightType, &[&str])] = &[
    (LightType::Environment, &["radiance", "transform"]),
    (LightType::Point, &["position", "intensity"]),
    (
        LightType::Spot,
        &["position", "intensity", "target", "cone", "penumbra"],
    ),
    (LightType::Distant, &["direction", "irradiance"]),
];

/// The default penumbra of a spot light, in degrees.
const PENUMBRA: f64 = 5.0;

/// Reads every `[[light]]` table.
///
/// # Errors
/// If an entry is not as the format requires, or an image cannot be used.
pub fn lights(
    values: &[Value<'_>],
    file: &Path,
    textures: &mut TextureCache,
) -> Result<Vec<LightDescription>> {
    let mut lights: Vec<LightDescription> = Vec::with_capacity(values.len());
    for value in values {
        let light = light(value, file, textures)?;
        if is_panorama(&light) && lights.iter().any(is_panorama) {
            return Err(value.error(
                "there is an image environment already: expected at most one, and any number of constant ones",
            ));
        }
        lights.push(light);
    }
    Ok(lights)
}

fn is_panorama(light: &LightDescription) -> bool {
    let LightModel::Environment { radiance, .. } = &light.model else {
        return false;
    };
    matches!(radiance, ColourDescription::Texture(_))
}

fn light(value: &Value<'_>, file: &Path, textures: &mut TextureCache) -> Result<LightDescription> {
    let table = value.table()?;
    let kind = table.required("type")?.one_of(TYPES)?;
    check_keys(&table, kind)?;
    let model = match kind {
        LightType::Environment => LightModel::Environment {
            radiance: radiance(&table.required("radiance")?, file, textures)?,
            to_world: match table.optional("transform") {
                Some(transform) => rotation(&transform)?,
                None => DMat3::IDENTITY,
            },
        },
        LightType::Point => LightModel::Point {
            position: table.required("position")?.vec3()?,
            intensity: emission(&table, "intensity")?,
        },
        LightType::Spot => spot(&table)?,
        LightType::Distant => LightModel::Distant {
            direction: direction(&table.required("direction")?)?,
            irradiance: emission(&table, "irradiance")?,
        },
    };
    table.finish()?;
    let place = Place::on_line(file, value.line());
    Ok(LightDescription { place, model })
}

fn spot(table: &Table<'_>) -> Result<LightModel> {
    let position = table.required("position")?.vec3()?;
    let towards = table.required("target")?;
    let target = towards.vec3()?;
    if (target - position).try_normalize().is_none() {
        return Err(towards.error("position and target are the same point"));
    }
    let cone = table
        .required("cone")?
        .angle_where("an angle in degrees above 0, at most 180", |x| {
            x > 0.0 && x <= PI
        })?;
    let penumbra = match table.optional("penumbra") {
        Some(penumbra) => penumbra.angle_where(
            &format!(
                "an angle in degrees from 0 to that of the cone, {}",
                cone.to_degrees()
            ),
            |x| (0.0..=cone).contains(&x),
        )?,
        None => PENUMBRA.to_radians().min(cone),
    };
    Ok(LightModel::Spot {
        position,
        target,
        intensity: emission(table, "intensity")?,
        cone,
        penumbra,
    })
}

/// Returns an error for keys that belong to another light type.
fn check_keys(table: &Table<'_>, kind: LightType) -> Result<()> {
    let keys_of = |kind| {
        KEYS.iter()
            .find(|(t, _)| *t == kind)
            .map_or(&[][..], |k| k.1)
    };
    for (other, other_kind) in TYPES {
        let foreign = keys_of(*other_kind)
            .iter()
            .filter(|key| !keys_of(kind).contains(key));
        for key in foreign {
            if let Some(value) = table.optional(key) {
                return Err(value.error(format!("only lights of the type {other} have this key")));
            }
        }
    }
    Ok(())
}

fn emission(table: &Table<'_>, key: &'static str) -> Result<Rgb> {
    constant(&table.required(key)?, Bound::NonNegative)
}

fn direction(value: &Value<'_>) -> Result<DVec3> {
    let direction = value.vec3()?;
    match direction.try_normalize() {
        Some(_) => Ok(direction),
        None => Err(value.expected("a direction that is not zero")),
    }
}

/// Reads a radiance: a colour or an image.
fn radiance(
    value: &Value<'_>,
    file: &Path,
    textures: &mut TextureCache,
) -> Result<ColourDescription> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let radiance = colour(value, Bound::NonNegative, folder, textures)?;
    let ColourDescription::Texture(texture) = &radiance else {
        return Ok(radiance);
    };
    match &**texture {
        Texture::Image { .. } => Ok(radiance),
        Texture::Placed {
            image,
            tint,
            uv_map,
        } if *uv_map == UvMap::default() => {
            let texture = Texture::Image {
                image: Arc::new(image.map(|texel| *tint * texel)),
                scale: 1.0,
            };
            Ok(ColourDescription::Texture(Arc::new(texture)))
        }
        Texture::Placed { .. } => {
            Err(value
                .error("expected an image without uv_map and wrap: to_world turns an environment"))
        }
        Texture::Checker { .. } => {
            Err(value.error("expected a colour or an image: an environment cannot be a checker"))
        }
    }
}

fn rotation(value: &Value<'_>) -> Result<DMat3> {
    let placed = transform(value, "the environment")?;
    if is_rotation(&placed.matrix3) && placed.translation == DVec3::ZERO {
        Ok(placed.matrix3)
    } else {
        Err(value.error("expected rotations only: an environment has no position or size"))
    }
}
