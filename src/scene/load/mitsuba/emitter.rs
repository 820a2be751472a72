//! The emitters of a Mitsuba scene.
//!
//! Measure: radiance, W/sr, W/m^2, as in Mitsuba.
//! Range: area, constant, envmap, point, spot and directional emitters; others are left out with a note.
//! Source: Mitsuba 3 documentation, "Emitters". Tested in `tests/loading/mitsuba.rs` and by
//! `scripts/against-mitsuba.py`.

use super::super::contents::SceneContents;
use super::super::wording::unknown_name;
use super::object::{Value, XmlObject};
use super::spectra::ColourMeaning;
use super::texture;
use crate::error::Result;
use crate::geometry::texture::Texture;
use crate::geometry::texture_image::TextureImage;
use crate::image::{ColourSpace, Image};
use crate::math::rgb::Rgb;
use crate::math::transform::is_rotation;
use crate::math::vec::{DAffine2, DMat3, DVec3};
use crate::scene::description::{ColourDescription, LightDescription, LightModel, NoteKind};
use std::sync::Arc;

const KNOWN: &[&str] = &["area", "constant", "envmap", "point", "spot", "directional"];
const LEFT_OUT: &[&str] = &[
    "projector",
    "directionalarea",
    "sunsky",
    "timed_sunsky",
    // Of versions before 2.
    "sky",
    "sun",
];

/// Returns the radiance of an emitting shape, and the transform of the coordinates of its texture.
///
/// # Errors
/// If the emitter is of another type, or invalid.
pub fn area(
    emitter: &XmlObject,
    contents: &mut SceneContents,
) -> Result<(ColourDescription, Option<DAffine2>)> {
    if emitter.kind != "area" {
        return Err(emitter.error("expected an emitter of type area within a shape"));
    }
    let radiance = match emitter.get("radiance") {
        None => (Rgb::WHITE.into(), None),
        Some(property) => match &property.value {
            Value::Object(object) => texture::texture(object, ColourMeaning::Light, contents)?,
            _ => (property.colour(ColourMeaning::Light)?.into(), None),
        },
    };
    emitter.note_unused(&["sampling_weight"], contents);
    Ok(radiance)
}

/// Returns a light that is not a shape; `None` if it has no counterpart.
///
/// # Errors
/// If the emitter is of an unknown type, or invalid.
pub fn light(
    emitter: &XmlObject,
    contents: &mut SceneContents,
) -> Result<Option<LightDescription>> {
    let to_world = emitter.transform("to_world")?;
    let position = || Ok(emitter.vector("position")?.unwrap_or(to_world.translation));
    let ahead = to_world.transform_vector3(DVec3::Z);
    let model = match emitter.kind.as_str() {
        "constant" => LightModel::Environment {
            radiance: colour(emitter, "radiance", contents)?.into(),
            to_world: DMat3::IDENTITY,
        },
        "envmap" => environment(emitter, contents)?,
        "point" => LightModel::Point {
            position: position()?,
            intensity: colour(emitter, "intensity", contents)?,
        },
        "spot" => {
            let cone = emitter.number_where(
                "cutoff_angle",
                20.0,
                "an angle above 0 and below 180",
                |x| x > 0.0 && x < 180.0,
            )?;
            let beam = emitter.number_where(
                "beam_width",
                0.75 * cone,
                "an angle from 0 to `cutoff_angle`",
                |x| (0.0..=cone).contains(&x),
            )?;
            if beam < 0.99 * cone {
                let text = "the edge of the cone falls off by another curve";
                contents.note(emitter.note(NoteKind::Approximation, text));
            }
            LightModel::Spot {
                position: position()?,
                target: position()? + ahead,
                intensity: colour(emitter, "intensity", contents)?,
                cone: cone.to_radians(),
                penumbra: (cone - beam).to_radians(),
            }
        }
        "directional" => {
            let direction = emitter.vector("direction")?.unwrap_or(ahead);
            if direction.try_normalize().is_none() {
                return Err(emitter.error_at("direction", "expected a direction that is not zero"));
            }
            LightModel::Distant {
                direction,
                irradiance: colour(emitter, "irradiance", contents)?,
            }
        }
        "area" => return Err(emitter.error("expected an area emitter within a shape")),
        other if LEFT_OUT.contains(&other) => {
            contents.note(emitter.note(NoteKind::Omission, "not supported: left out"));
            return Ok(None);
        }
        other => {
            return Err(emitter.error(&unknown_name(
                "emitter",
                other,
                &[KNOWN, LEFT_OUT].concat(),
            )));
        }
    };
    emitter.note_unused(&["sampling_weight", "mis_compensation"], contents);
    Ok(Some(LightDescription {
        place: emitter.place.clone(),
        model,
    }))
}

/// The colour of a light that is the same everywhere.
fn colour(emitter: &XmlObject, name: &str, contents: &mut SceneContents) -> Result<Rgb> {
    let Some(property) = emitter.get(name) else {
        return Ok(Rgb::WHITE);
    };
    let Value::Object(spectrum) = &property.value else {
        return property.colour(ColourMeaning::Light);
    };
    let (colour, _) = texture::texture(spectrum, ColourMeaning::Light, contents)?;
    let constant = colour.constant();
    constant.ok_or_else(|| property.expected("a colour, not a texture,"))
}

/// The middle of Mitsuba's maps is along +z, that of ours along -z.
fn environment(emitter: &XmlObject, contents: &mut SceneContents) -> Result<LightModel> {
    let path = emitter.file()?;
    let scale = emitter.number_where("scale", 1.0, "a number of at least 0", |x| {
        (0.0..1e30).contains(&x)
    })? as f32;
    let named = |error: crate::Error| emitter.error(&error.to_string()).of_kind(error.kind());
    let texture = contents
        .textures
        .read(&path, ColourSpace::Srgb, scale)
        .map_err(named)?;
    let Texture::Image { mut image, scale } = texture else {
        return Err(emitter.error("expected an image"));
    };
    image = texture::from_zero(image, emitter, contents);
    let axes = emitter.transform("to_world")?.matrix3;
    let unit = |axis: DVec3| axis.normalize_or_zero();
    let mut turn = DMat3::from_cols(unit(axes.x_axis), unit(axes.y_axis), unit(axes.z_axis));
    if turn.determinant() < 0.0 {
        turn.x_axis = -turn.x_axis;
        image = Arc::new(mirrored(&image));
    }
    if !is_rotation(&orthonormal(turn))
        || orthonormal(turn)
            .mul_vec3(DVec3::ONE)
            .distance(turn * DVec3::ONE)
            > 1e-4
    {
        return Err(emitter.error_at("to_world", "expected rotations and mirrors only"));
    }
    Ok(LightModel::Environment {
        radiance: ColourDescription::Texture(Arc::new(Texture::Image { image, scale })),
        to_world: orthonormal(turn) * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, -1.0)),
    })
}

/// The nearest rotation of axes that exporters rounded to single precision.
fn orthonormal(axes: DMat3) -> DMat3 {
    let z = axes.z_axis.normalize_or_zero();
    let x = (axes.x_axis - axes.x_axis.dot(z) * z).normalize_or_zero();
    DMat3::from_cols(x, z.cross(x), z)
}

/// Returns the image with left and right exchanged.
fn mirrored(image: &TextureImage) -> TextureImage {
    let (width, height) = image.size();
    let row = |y| (0..width).rev().map(move |x| image.get(x, y));
    Image::new(width, height, (0..height).flat_map(row).collect()).into()
}
