//! Materials as tables of a scene file.
//!
//! Measure: reflectances in [0, 1]; roughness is perceptual, in [0, 1].
//! Range: as docs/scene-format.md says for each key.
//! Source: docs/scene-format.md. Tested in `tests/scene_loading.rs`.

use super::colour::{Bound, Textures, colour, constant};
use super::reader::{Table, Value};
use crate::bsdf::conductor;
use crate::error::Result;
use crate::math::rgb::Rgb;
use crate::scene::description::{ColourDescription, MaterialDescription, MaterialModel, Place};
use std::path::Path;

/// The types of materials.
#[derive(Debug, Clone, Copy)]
enum Type {
    Diffuse,
    Mirror,
    Conductor,
    Dielectric,
    Principled,
}

const TYPES: &[(&str, Type)] = &[
    ("diffuse", Type::Diffuse),
    ("mirror", Type::Mirror),
    ("conductor", Type::Conductor),
    ("dielectric", Type::Dielectric),
    ("principled", Type::Principled),
];

/// Reads one `[[material]]`.
///
/// # Errors
/// Whatever in it is not as the format says.
pub fn material(
    value: &Value<'_>,
    file: &Path,
    textures: &mut Textures,
) -> Result<MaterialDescription> {
    let table = value.table()?;
    let name = table.required("name")?.text()?.to_owned();
    let folder = file.parent().unwrap_or(Path::new(""));
    let mut reflectance = |key: &'static str, default: f32| match table.optional(key) {
        Some(value) => colour(&value, Bound::Reflectance, folder, textures),
        None => Ok(ColourDescription::Constant(Rgb::grey(default))),
    };
    let model = match table.required("type")?.one_of(TYPES)? {
        Type::Diffuse => MaterialModel::Diffuse {
            reflectance: reflectance("reflectance", 0.5)?,
        },
        Type::Mirror => MaterialModel::Mirror {
            reflectance: reflectance("reflectance", 1.0)?,
        },
        Type::Conductor => {
            let (eta, k) = index_of_metal(&table)?;
            MaterialModel::Conductor {
                eta,
                k,
                roughness: share(&table, "roughness", 0.0)?,
            }
        }
        Type::Dielectric => MaterialModel::Dielectric {
            ior: number(&table, "ior", 1.5, "a number above 0", |x| x > 0.0)?,
            roughness: share(&table, "roughness", 0.0)?,
            tint: reflectance("tint", 1.0)?,
        },
        Type::Principled => MaterialModel::Principled {
            base_color: reflectance("base_color", 0.8)?,
            metallic: share(&table, "metallic", 0.0)?,
            roughness: share(&table, "roughness", 0.5)?,
            ior: number(&table, "ior", 1.5, "a number of at least 1", |x| x >= 1.0)?,
            transmission: share(&table, "transmission", 0.0)?,
        },
    };
    table.finish()?;
    let place = Place {
        file: file.to_path_buf(),
        line: Some(value.line()),
    };
    Ok(MaterialDescription::new(name, place, model))
}

/// A metal's index: a preset, or `eta` and `k`.
fn index_of_metal(table: &Table<'_>) -> Result<(Rgb, Rgb)> {
    let (eta, k) = (table.optional("eta"), table.optional("k"));
    match (table.optional("preset"), eta, k) {
        (Some(preset), None, None) => {
            let presets = conductor::PRESETS
                .iter()
                .map(|&(name, eta, k)| (name, (eta, k)));
            preset.one_of(&presets.collect::<Vec<_>>())
        }
        (None, Some(eta), Some(k)) => {
            let (index, absorption) = (
                constant(&eta, Bound::NonNegative)?,
                constant(&k, Bound::NonNegative)?,
            );
            if index.to_array().contains(&0.0) {
                return Err(eta.expected("a refractive index above 0"));
            }
            Ok((index, absorption))
        }
        (Some(preset), _, _) => Err(preset.error("expected either preset, or eta and k, not both")),
        _ => Err(table.error("a conductor needs either `preset`, or `eta` and `k`")),
    }
}

fn share(table: &Table<'_>, key: &'static str, default: f32) -> Result<f32> {
    number(table, key, default, "a number from 0 to 1", |x| {
        (0.0..=1.0).contains(&x)
    })
}

fn number(
    table: &Table<'_>,
    key: &'static str,
    default: f32,
    what: &str,
    test: impl Fn(f32) -> bool,
) -> Result<f32> {
    table
        .optional(key)
        .map_or(Ok(default), |value| value.single_where(what, test))
}
