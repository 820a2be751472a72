//! The textures of a Mitsuba scene.
//!
//! Measure: linear Rec. 709. Mitsuba's v points down an image, ours up: shapes mirror their coordinates, and so a
//! checkerboard exchanges its colours.
//! Range: bitmap and checkerboard; others are errors.
//! Source: Mitsuba 3 documentation, "Textures". Tested in `tests/loading/mitsuba.rs`.

use super::super::beside;
use super::super::contents::Contents;
use super::super::wording::unknown_name;
use super::object::Object;
use crate::error::Result;
use crate::geometry::texture::Texture;
use crate::image::ColourSpace;
use crate::math::rgb::Rgb;
use crate::math::vec::{DAffine2, DMat2, DVec2, Vec2};
use crate::scene::description::{ColourDescription, NoteKind};
use std::sync::Arc;

/// The meaning of a texture's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Colours, and numbers for which a colour stands: images of eight bits are sRGB codes unless `raw`.
    Colour,
    /// Normals, which are as they are.
    Normals,
}

/// Returns the colour, and the transform of the coordinates that it refers to.
///
/// # Errors
/// If the texture is of another type, its image cannot be read, or a value is out of its range.
pub fn texture(
    texture: &Object,
    kind: Kind,
    contents: &mut Contents,
) -> Result<(ColourDescription, Option<DAffine2>)> {
    let made = match texture.kind.as_str() {
        "bitmap" => bitmap(texture, kind, contents)?,
        "checkerboard" => {
            let colour = |name: &str, default: f32| match texture.get(name) {
                Some(property) => property.colour(),
                None => Ok(Rgb::grey(default)),
            };
            let colours = [colour("color1", 0.2)?, colour("color0", 0.4)?];
            let repeat = Vec2::splat(2.0);
            Texture::Checker { colours, repeat }
        }
        "srgb" | "uniform" | "d65" => {
            let value = texture.get("value").or_else(|| texture.get("color"));
            let colour = match value {
                Some(value) => value.colour()?,
                None if texture.kind == "d65" => Rgb::WHITE,
                None => return Err(texture.error("expected a `value`")),
            };
            let scale = texture.number("scale")?.unwrap_or(1.0);
            texture.note_unused(&[], contents);
            return Ok(((scale as f32 * colour).into(), None));
        }
        other => {
            let known = ["bitmap", "checkerboard"];
            return Err(texture.error(&unknown_name("texture", other, &known)));
        }
    };
    let to_uv = texture.transform("to_uv")?;
    let (x, y) = (to_uv.matrix3.x_axis, to_uv.matrix3.y_axis);
    let to_uv = DAffine2 {
        matrix2: DMat2::from_cols(DVec2::new(x.x, x.y), DVec2::new(y.x, y.y)),
        translation: DVec2::new(to_uv.translation.x, to_uv.translation.y),
    };
    texture.note_unused(&["format", "accel"], contents);
    Ok((ColourDescription::Texture(Arc::new(made)), Some(to_uv)))
}

fn bitmap(texture: &Object, kind: Kind, contents: &mut Contents) -> Result<Texture> {
    let name = texture.text("filename")?;
    let name = name.ok_or_else(|| texture.error("expected a `filename`"))?;
    let path = beside(&texture.place.file, name);
    let raw = texture.truth("raw", false)?;
    let space = match kind {
        Kind::Colour if !raw => ColourSpace::Srgb,
        _ => ColourSpace::Linear,
    };
    if texture
        .text("filter_type")?
        .is_some_and(|filter| filter != "bilinear")
    {
        contents.note(texture.note(NoteKind::Approximation, "interpolated bilinearly"));
    }
    if texture
        .text("wrap_mode")?
        .is_some_and(|mode| mode != "repeat")
    {
        contents.note(texture.note(NoteKind::Approximation, "repeats outside of [0, 1]"));
    }
    let wrong = |error: crate::Error| texture.error(&error.to_string()).of_kind(error.kind());
    let made = contents.textures.read(&path, space, 1.0).map_err(wrong)?;
    if let Texture::Image { image, .. } = &made
        && let Some(texel) = image
            .pixels()
            .iter()
            .find(|p| !p.is_finite() || p.to_array().iter().any(|x| *x < 0.0))
    {
        let why = format!(
            "expected pixels of at least 0, found {:?}",
            texel.to_array()
        );
        return Err(texture.error(&why));
    }
    Ok(made)
}

/// Returns the mean of the luminance.
pub fn mean(colour: &ColourDescription) -> f64 {
    match colour {
        ColourDescription::Constant(colour) => f64::from(colour.luminance()),
        ColourDescription::Texture(texture) => f64::from(texture.mean().luminance()),
    }
}
