//! The textures and spectra of a Mitsuba scene.
//!
//! Measure: linear Rec. 709. Mitsuba's v points down an image, ours up: shapes mirror their coordinates, and so a
//! checkerboard exchanges its colours.
//! Range: bitmap, checkerboard, and the documented spectra; attributes of meshes and volumes become grey with a note;
//! others are errors.
//! Source: Mitsuba 3 documentation, "Textures", "Spectra". Tested in `tests/loading/mitsuba.rs` and
//! `tests/loading/mitsuba_spectra.rs`.

use super::super::contents::SceneContents;
use super::super::spectrum::{Spectrum, blackbody_radiance};
use super::super::wording::unknown_name;
use super::object::{Value, XmlObject};
use super::spectra::{ColourMeaning, Spectral};
use crate::error::Result;
use crate::geometry::texture::Texture;
use crate::geometry::texture_image::TextureImage;
use crate::geometry::uv_map::Wrap;
use crate::image::ColourSpace;
use crate::math::rgb::Rgb;
use crate::math::vec::{DAffine2, DMat2, DVec2, Vec2};
use crate::scene::description::{ColourDescription, NoteKind};
use std::sync::Arc;

/// Returns the colour, and the transform of the coordinates that it refers to.
///
/// # Errors
/// If the texture is of another type, its image cannot be read, or a value is out of its range.
pub fn texture(
    texture: &XmlObject,
    kind: ColourMeaning,
    contents: &mut SceneContents,
) -> Result<(ColourDescription, Option<DAffine2>)> {
    let made = match texture.kind.as_str() {
        "bitmap" => bitmap(texture, kind, contents)?,
        "checkerboard" => {
            let mut colour = |name: &str, default: f32| match texture.get(name) {
                Some(property) => match &property.value {
                    Value::Object(nested) => colour_of(nested, kind, contents),
                    _ => property.colour(kind),
                },
                None => Ok(Rgb::grey(default)),
            };
            let colours = [colour("color1", 0.2)?, colour("color0", 0.4)?];
            let repeat = Vec2::splat(2.0);
            Texture::Checker { colours, repeat }
        }
        "srgb" | "uniform" | "d65" => {
            let value = texture.get("value").or_else(|| texture.get("color"));
            let colour = match value {
                Some(value) => value.colour(ColourMeaning::Colour)?,
                None if texture.kind == "d65" => Rgb::WHITE,
                None => return Err(texture.error("expected a `value`")),
            };
            let scale = texture.number("scale")?.unwrap_or(1.0);
            texture.note_unused(&[], contents);
            return Ok(((scale as f32 * colour).into(), None));
        }
        "regular" | "irregular" => {
            let colour = sampled(texture)?.colour(kind);
            texture.note_unused(&[], contents);
            return Ok((colour.into(), None));
        }
        "blackbody" => {
            let colour = blackbody(texture)?;
            texture.note_unused(&[], contents);
            return Ok((colour.into(), None));
        }
        "mesh_attribute" | "volume" => {
            let text = "not supported: replaced by 0.5";
            contents.note(texture.note(NoteKind::Approximation, text));
            return Ok((Rgb::grey(0.5).into(), None));
        }
        other => {
            let known = [
                "bitmap",
                "checkerboard",
                "regular",
                "irregular",
                "blackbody",
                "srgb",
                "uniform",
                "d65",
            ];
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

/// The colour of a spectrum, or the mean of a texture, with a note.
fn colour_of(nested: &XmlObject, kind: ColourMeaning, contents: &mut SceneContents) -> Result<Rgb> {
    match texture(nested, kind, contents)?.0 {
        ColourDescription::Constant(colour) => Ok(colour),
        ColourDescription::Texture(texture) => {
            let text = "its mean is the colour of a checkerboard's fields";
            contents.note(nested.note(NoteKind::Approximation, text));
            Ok(texture.mean())
        }
    }
}

/// The image with 0 in place of values below it, and a note if there are any.
pub fn from_zero(
    image: Arc<TextureImage>,
    of: &XmlObject,
    contents: &mut SceneContents,
) -> Arc<TextureImage> {
    let is_below = |texel: Rgb| texel.to_array().iter().any(|x| *x < 0.0);
    if !image.texels().any(is_below) {
        return image;
    }
    contents.note(of.note(NoteKind::Approximation, "values below 0 are taken as 0"));
    Arc::new(image.map(|texel| texel.map(|x| if x < 0.0 { 0.0 } else { x })))
}

fn bitmap(
    texture: &XmlObject,
    kind: ColourMeaning,
    contents: &mut SceneContents,
) -> Result<Texture> {
    let path = texture.file()?;
    let raw = texture.truth("raw", false)?;
    let space = match kind {
        ColourMeaning::Normals => ColourSpace::Linear,
        _ if raw => ColourSpace::Linear,
        _ => ColourSpace::Srgb,
    };
    if texture
        .text("filter_type")?
        .is_some_and(|filter| filter != "bilinear")
    {
        contents.note(texture.note(NoteKind::Approximation, "interpolated bilinearly"));
    }
    let wrap = match texture.text("wrap_mode")? {
        None => Wrap::Repeat,
        Some(mode) => {
            let known = Wrap::ALL.iter().find(|(name, _)| *name == mode);
            let (_, wrap) = known.ok_or_else(|| {
                let names = Wrap::ALL.iter().map(|(name, _)| *name);
                let why = unknown_name("wrap mode", mode, &names.collect::<Vec<_>>());
                texture.error_at("wrap_mode", &why)
            })?;
            *wrap
        }
    };
    let wrong = |error: crate::Error| texture.error(&error.to_string()).of_kind(error.kind());
    let made = contents.textures.read(&path, space, 1.0).map_err(wrong)?;
    let Texture::Image { image, scale } = made else {
        return Err(texture.error("expected an image"));
    };
    let image = from_zero(image, texture, contents);
    if let Some(texel) = image.texels().find(|texel| !texel.is_finite()) {
        let why = format!("expected finite pixels, found {:?}", texel.to_array());
        return Err(texture.error(&why));
    }
    Ok(Texture::Image { image, scale }.continued(wrap))
}

/// A spectrum of samples, at equal distances or not.
fn sampled(texture: &XmlObject) -> Result<Spectral> {
    if let Some(property) = texture.get("value") {
        return match &property.value {
            Value::Spectrum(spectrum) => Ok(spectrum.clone()),
            _ => Err(property.expected("a spectrum")),
        };
    }
    let values = texture.list("values")?;
    let wavelengths = if texture.kind == "regular" {
        let limit = |name: &str| {
            let limit = texture.number(name)?;
            limit.ok_or_else(|| texture.error(&format!("expected a `{name}`")))
        };
        let (from, to) = (limit("wavelength_min")?, limit("wavelength_max")?);
        let steps = values.len().saturating_sub(1) as f64;
        let step = |i: usize| from + (to - from) * (i as f64 / steps);
        (0..values.len()).map(step).collect()
    } else {
        texture.list("wavelengths")?
    };
    if wavelengths.len() != values.len() || values.len() < 2 {
        let why = "expected at least two values, and as many wavelengths";
        return Err(texture.error_at("values", why));
    }
    let samples = wavelengths.into_iter().zip(values);
    Spectrum::new(samples.map(|(nm, value)| [nm, value]).collect())
        .and_then(Spectral::of_samples)
        .map_err(|why| texture.error(&why))
}

/// The radiance of a black body.
fn blackbody(texture: &XmlObject) -> Result<Rgb> {
    let from = texture.number("wavelength_min")?.unwrap_or(0.0);
    let to = texture.number("wavelength_max")?.unwrap_or(f64::INFINITY);
    let expected = "a temperature above 0 and at most 1e9 K";
    let is_one = |kelvin: f64| kelvin > 0.0 && kelvin <= 1e9;
    if texture.get("temperature").is_none() {
        return Err(texture.error("expected a `temperature`"));
    }
    let kelvin = texture.number_where("temperature", 0.0, expected, is_one)?;
    Ok(blackbody_radiance(kelvin, [from, to]))
}

/// Returns the mean of the luminance.
pub fn mean(colour: &ColourDescription) -> f64 {
    match colour {
        ColourDescription::Constant(colour) => f64::from(colour.luminance()),
        ColourDescription::Texture(texture) => f64::from(texture.mean().luminance()),
    }
}
