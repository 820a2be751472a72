//! Reads the `[[material]]` tables of a scene file.
//!
//! Measure: reflectances in [0, 1]; roughness is perceptual, in [0, 1].
//! Range: as docs/scene-format.md says for each key.
//! Source: docs/scene-format.md. Tested in `tests/loading/scene_files.rs`.

use super::colour::{Bound, TextureCache, colour, constant, mask, texture};
use super::reader::{Table, Value};
use crate::bsdf::conductor;
use crate::error::{Error, Result};
use crate::geometry::texture::Texture;
use crate::image::ColourSpace;
use crate::math::rgb::Rgb;
use crate::scene::description::{
    BumpMapDescription, ClearCoatDescription, ColourDescription, MaterialDescription,
    MaterialModel, NormalMapDescription, Place,
};
use std::path::Path;
use std::sync::Arc;

/// The types of materials.
#[derive(Debug, Clone, Copy)]
enum MaterialType {
    Diffuse,
    Mirror,
    Conductor,
    Dielectric,
    ThinDielectric,
    Phong,
    Plastic,
    Principled,
}

const TYPES: &[(&str, MaterialType)] = &[
    ("diffuse", MaterialType::Diffuse),
    ("mirror", MaterialType::Mirror),
    ("conductor", MaterialType::Conductor),
    ("dielectric", MaterialType::Dielectric),
    ("thin_dielectric", MaterialType::ThinDielectric),
    ("phong", MaterialType::Phong),
    ("plastic", MaterialType::Plastic),
    ("principled", MaterialType::Principled),
];

/// A number in [0, 1], in error messages.
const A_SHARE: &str = "a number from 0 to 1";

/// Reads one `[[material]]` table.
///
/// # Errors
/// If an entry is not as the format requires.
pub fn material(
    value: &Value<'_>,
    file: &Path,
    textures: &mut TextureCache,
) -> Result<MaterialDescription> {
    let table = value.table()?;
    let name = table.required("name")?.text()?.to_owned();
    let folder = file.parent().unwrap_or(Path::new(""));
    let place = Place::on_line(file, value.line());
    let model = model(&table, folder, textures)?;
    let mut material = MaterialDescription::new(name, place, model);
    if let Some(alpha) = table.optional("alpha") {
        material.alpha = mask(&alpha, folder, textures)?;
    }
    material.alpha_cutoff = table
        .optional("alpha_cutoff")
        .map(|cutoff| cutoff.single_where(A_SHARE, |x| (0.0..=1.0).contains(&x)))
        .transpose()?;
    if let Some(map) = table.optional("metallic_roughness_map") {
        if !matches!(material.model, MaterialModel::Principled { .. }) {
            return Err(map.error("only materials of the type principled have this key"));
        }
        material.metallic_roughness_map = Some(data_map(&map, folder, textures)?);
    }
    if let Some(coat) = table.optional("clear_coat") {
        material.clear_coat = Some(clear_coat(&coat, &material.model)?);
    }
    if let Some(map) = table.optional("normal_map") {
        material.normal_map = Some(normal_map(&map, folder, textures)?);
    }
    if let Some(map) = table.optional("bump_map") {
        if material.normal_map.is_some() {
            return Err(map.error("expected either normal_map or bump_map, not both"));
        }
        material.bump_map = Some(bump_map(&map, folder, textures)?);
    }
    if let Some(two_sided) = table.optional("two_sided") {
        material.two_sided = two_sided.truth()?;
        if !material.two_sided && material.transmits() {
            return Err(two_sided.error("a transmissive material has two sides"));
        }
    }
    table.finish()?;
    Ok(material)
}

/// Reads the scattering model of a material.
fn model(table: &Table<'_>, folder: &Path, textures: &mut TextureCache) -> Result<MaterialModel> {
    let mut reflectance = |key: &'static str, default: f32| match table.optional(key) {
        Some(value) => colour(&value, Bound::Reflectance, folder, textures),
        None => Ok(ColourDescription::Constant(Rgb::grey(default))),
    };
    Ok(match table.required("type")?.one_of(TYPES)? {
        MaterialType::Diffuse => MaterialModel::Diffuse {
            reflectance: reflectance("reflectance", 0.5)?,
        },
        MaterialType::Mirror => MaterialModel::Mirror {
            reflectance: reflectance("reflectance", 1.0)?,
        },
        MaterialType::Conductor => {
            let (eta, k) = index_of_metal(table)?;
            MaterialModel::Conductor {
                eta,
                k,
                roughness: share(table, "roughness", 0.0)?,
                tint: match table.optional("tint") {
                    Some(tint) => constant(&tint, Bound::Reflectance)?,
                    None => Rgb::WHITE,
                },
            }
        }
        MaterialType::Dielectric => MaterialModel::Dielectric {
            ior: number(table, "ior", 1.5, "a number above 0", |x| x > 0.0)?,
            roughness: share(table, "roughness", 0.0)?,
            tint: reflectance("tint", 1.0)?,
        },
        MaterialType::ThinDielectric => MaterialModel::ThinDielectric {
            ior: number(table, "ior", 1.5, "a number above 0", |x| x > 0.0)?,
            tint: reflectance("tint", 1.0)?,
        },
        MaterialType::Phong => {
            let (diffuse, specular) = (reflectance("diffuse", 0.5)?, reflectance("specular", 0.2)?);
            check_sum(table, &diffuse, &specular)?;
            MaterialModel::Phong {
                diffuse,
                specular,
                exponent: number(table, "exponent", 32.0, "a number from 0 to 1e6", |x| {
                    (0.0..=1e6).contains(&x)
                })?,
            }
        }
        MaterialType::Plastic => MaterialModel::Plastic {
            reflectance: reflectance("reflectance", 0.5)?,
            ior: index_of_coat(table)?,
            roughness: share(table, "roughness", 0.0)?,
        },
        MaterialType::Principled => MaterialModel::Principled {
            base_color: reflectance("base_color", 0.8)?,
            metallic: share(table, "metallic", 0.0)?,
            roughness: share(table, "roughness", 0.5)?,
            ior: index_of_coat(table)?,
            transmission: share(table, "transmission", 0.0)?,
        },
    })
}

/// Checks that a Phong material reflects at most the incident light, even where the maxima of both textures coincide.
fn check_sum(
    table: &Table<'_>,
    diffuse: &ColourDescription,
    specular: &ColourDescription,
) -> Result<()> {
    let (diffuse, specular) = (diffuse.brightest(), specular.brightest());
    if (diffuse + specular).max_channel() <= 1.0 {
        return Ok(());
    }
    let message = format!(
        "expected `diffuse` and `specular` of at most 1 together in every channel, found up to {} and {}",
        channels(diffuse),
        channels(specular)
    );
    let written = table
        .optional("specular")
        .or_else(|| table.optional("diffuse"));
    Err(written.map_or_else(|| table.error(&message), |value| value.error(&message)))
}

/// Formats a colour in the notation of the scene format.
fn channels(colour: Rgb) -> String {
    let [r, g, b] = colour.to_array();
    format!("[{r}, {g}, {b}]")
}

/// Reads a map of factors: a file, or a table of a texture. Its values are linear unless specified.
fn data_map(value: &Value<'_>, folder: &Path, textures: &mut TextureCache) -> Result<Arc<Texture>> {
    if value.is_text() {
        let path = folder.join(value.text()?);
        let texture = textures.read_reflectance(&path, ColourSpace::Linear, 1.0);
        return texture
            .map(Arc::new)
            .map_err(|error| of_file(value, &error));
    }
    let table = table_of_map(value)?;
    let (bound, space) = (Bound::Reflectance, ColourSpace::Linear);
    let texture = Arc::new(texture(value, &table, bound, space, folder, textures)?);
    table.finish()?;
    Ok(texture)
}

/// Reads a map of normals: a file, or a table of a texture and how it is applied.
fn normal_map(
    value: &Value<'_>,
    folder: &Path,
    textures: &mut TextureCache,
) -> Result<NormalMapDescription> {
    if value.is_text() {
        let path = folder.join(value.text()?);
        let texture = textures.read(&path, ColourSpace::Linear, 1.0);
        return Ok(NormalMapDescription {
            texture: Arc::new(texture.map_err(|error| of_file(value, &error))?),
            strength: 1.0,
            is_right_handed: false,
        });
    }
    let table = table_of_map(value)?;
    let strength = number(&table, "strength", 1.0, "a finite number", f32::is_finite)?;
    let is_right_handed = table.optional("right_handed");
    let is_right_handed = is_right_handed.map_or(Ok(false), |value| value.truth())?;
    let (bound, space) = (Bound::NonNegative, ColourSpace::Linear);
    let texture = Arc::new(texture(value, &table, bound, space, folder, textures)?);
    table.finish()?;
    Ok(NormalMapDescription {
        texture,
        strength,
        is_right_handed,
    })
}

fn table_of_map<'a>(value: &Value<'a>) -> Result<Table<'a>> {
    value
        .table()
        .map_err(|_| value.expected("a file in quotes, or a table of a texture"))
}

/// The error of a file that a value names.
fn of_file(value: &Value<'_>, error: &Error) -> Error {
    value.error(error.to_string()).of_kind(error.kind())
}

/// Reads a clear coat over a surface of this model.
fn clear_coat(value: &Value<'_>, model: &MaterialModel) -> Result<ClearCoatDescription> {
    if !model.takes_clear_coat() {
        return Err(value.error(
            "only conductors, and principled materials without transmission, have a clear coat",
        ));
    }
    let table = value
        .table()
        .map_err(|_| value.expected("a table of `weight`, `roughness` and `ior`"))?;
    let coat = ClearCoatDescription {
        weight: share(&table, "weight", 1.0)?,
        roughness: share(&table, "roughness", 0.0)?,
        ior: index_of_coat(&table)?,
    };
    table.finish()?;
    Ok(coat)
}

fn index_of_coat(table: &Table<'_>) -> Result<f32> {
    number(table, "ior", 1.5, "a number of at least 1", |x| x >= 1.0)
}

/// Reads a table of heights: a texture, whose values are linear unless specified, and the height of a value of 1.
fn bump_map(
    value: &Value<'_>,
    folder: &Path,
    textures: &mut TextureCache,
) -> Result<BumpMapDescription> {
    let table = value
        .table()
        .map_err(|_| value.expected("a table of a texture and its `height`"))?;
    let height = table.required("height")?;
    let height = height.single_where("a finite number", f32::is_finite)?;
    let space = ColourSpace::Linear;
    let texture = texture(value, &table, Bound::NonNegative, space, folder, textures)?;
    table.finish()?;
    Ok(BumpMapDescription {
        texture: Arc::new(texture),
        height,
    })
}

/// Reads the complex refractive index of a metal: a preset, or `eta` and `k`.
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
    number(table, key, default, A_SHARE, |x| (0.0..=1.0).contains(&x))
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
