//! Reads colours: numbers, sRGB codes, textures and checkerboards.
//!
//! Measure: linear Rec. 709.
//! Range: at least 0; a reflectance at most 1.
//! Source: docs/scene-format.md. Tested in `tests/loading/scene_files.rs`.

use super::reader::{Table, Value};
use super::wording::shown;
use crate::error::{Error, Result};
use crate::geometry::texture::Texture;
use crate::geometry::texture_image::TextureImage;
use crate::geometry::uv_map::{UvMap, Wrap};
use crate::image::{ColourSpace, Image, srgb};
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::scene::description::ColourDescription;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The upper bound of a colour's channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// A fraction of light: at most 1.
    Reflectance,
    /// Any value of at least 0.
    NonNegative,
}

/// A cache of textures, so that each file is read once.
#[derive(Debug, Default)]
pub struct TextureCache {
    images: HashMap<(PathBuf, ColourSpace), Arc<TextureImage>>,
    /// The alpha channels of images that have one and are not opaque.
    alphas: HashMap<PathBuf, Option<Arc<TextureImage>>>,
}

impl TextureCache {
    /// Returns the texture of an image file.
    ///
    /// # Errors
    /// If the file cannot be read or is not an image.
    pub fn read(&mut self, path: &Path, space: ColourSpace, scale: f32) -> Result<Texture> {
        let key = (path.to_path_buf(), space);
        let image = match self.images.entry(key) {
            Entry::Occupied(known) => Arc::clone(known.get()),
            Entry::Vacant(place) => {
                let image = TextureImage::from(Image::read(path, space)?);
                Arc::clone(place.insert(Arc::new(image)))
            }
        };
        Ok(Texture::Image { image, scale })
    }

    /// Returns the alpha channel of an image file; `None` if it has none that is read, or is opaque.
    ///
    /// # Errors
    /// If the file cannot be read, or its image is damaged.
    pub fn read_alpha(&mut self, path: &Path, scale: f32) -> Result<Option<Texture>> {
        let alpha = match self.alphas.entry(path.to_path_buf()) {
            Entry::Occupied(known) => known.get().clone(),
            Entry::Vacant(place) => {
                let alpha = Image::read_alpha(path)?.map(TextureImage::from);
                place.insert(alpha.map(Arc::new)).clone()
            }
        };
        Ok(alpha.map(|image| Texture::Image { image, scale }))
    }

    /// Returns the texture of an image file whose values are at most 1.
    ///
    /// # Errors
    /// As [`Self::read`]; and if a value is above 1.
    pub fn read_reflectance(
        &mut self,
        path: &Path,
        space: ColourSpace,
        scale: f32,
    ) -> Result<Texture> {
        let texture = self.read(path, space, scale)?;
        if texture.brightest().max_channel() > 1.0 {
            let why = "expected a reflectance, but the texture has values above 1";
            return Err(Error::scene(why).in_file(path));
        }
        Ok(texture)
    }
}

/// Reads a colour that may be a texture; the colour space is sRGB unless specified.
///
/// # Errors
/// If the value is not a colour, or is out of bounds.
pub fn colour(
    value: &Value<'_>,
    bound: Bound,
    folder: &Path,
    textures: &mut TextureCache,
) -> Result<ColourDescription> {
    colour_or_data(value, bound, ColourSpace::Srgb, folder, textures)
}

/// Reads a fraction that may be a texture; its values are linear unless specified.
///
/// # Errors
/// If the value is not a colour, or is not in [0, 1].
pub fn mask(
    value: &Value<'_>,
    folder: &Path,
    textures: &mut TextureCache,
) -> Result<ColourDescription> {
    let bound = Bound::Reflectance;
    colour_or_data(value, bound, ColourSpace::Linear, folder, textures)
}

fn colour_or_data(
    value: &Value<'_>,
    bound: Bound,
    default_space: ColourSpace,
    folder: &Path,
    textures: &mut TextureCache,
) -> Result<ColourDescription> {
    if value.is_list() || value.is_number() || value.is_text() {
        return constant(value, bound).map(ColourDescription::Constant);
    }
    let table = value.table().map_err(|_| value.expected("a colour"))?;
    let texture = texture(value, &table, bound, default_space, folder, textures)?;
    table.finish()?;
    if let Some(what) = no_colour(&texture) {
        let file = table.required("texture")?;
        return Err(value.error(format!("{}: {what}", shown(file.text()?))));
    }
    Ok(ColourDescription::Texture(Arc::new(texture)))
}

/// Reads the keys of a texture or a checker from its table, which may have further keys; `value` is the table's.
///
/// # Errors
/// If it is neither, or its colours are out of bounds.
pub fn texture(
    value: &Value<'_>,
    table: &Table<'_>,
    bound: Bound,
    default_space: ColourSpace,
    folder: &Path,
    textures: &mut TextureCache,
) -> Result<Texture> {
    let texture = match table.optional("texture") {
        Some(file) => image(table, &file, default_space, folder, textures)?,
        None => checker(table, bound)?,
    };
    if bound == Bound::Reflectance && texture.brightest().max_channel() > 1.0 {
        return Err(value.error(
            "expected a value from 0 to 1 in every channel, but the texture has values above 1",
        ));
    }
    Ok(texture)
}

/// Reads the keys of an image.
fn image(
    table: &Table<'_>,
    file: &Value<'_>,
    default_space: ColourSpace,
    folder: &Path,
    textures: &mut TextureCache,
) -> Result<Texture> {
    let space = table.optional("space").map_or(Ok(default_space), |space| {
        space.one_of(&[("srgb", ColourSpace::Srgb), ("linear", ColourSpace::Linear)])
    })?;
    let scale = table.optional("scale");
    let tint = match &scale {
        Some(scale) if scale.is_list() => constant(scale, Bound::NonNegative)?,
        Some(scale) => Rgb::grey(scale.single_where("a number of at least 0", |x| x >= 0.0)?),
        None => Rgb::WHITE,
    };
    let uv_map = uv_map(table)?;
    let [scale, ..] = tint.to_array();
    let image = textures
        .read(&folder.join(file.text()?), space, scale)
        .map_err(|error| file.error(error.to_string()).of_kind(error.kind()))?;
    Ok(match (image, uv_map) {
        (image, None) if tint == Rgb::grey(scale) => image,
        (Texture::Image { image, .. }, uv_map) => Texture::Placed {
            image,
            tint,
            uv_map: uv_map.unwrap_or_default(),
        },
        (other, _) => other,
    })
}

/// Reads the place of an image on the surface; `None` if it simply repeats.
fn uv_map(table: &Table<'_>) -> Result<Option<UvMap>> {
    let (rows, wrap) = (table.optional("uv_map"), table.optional("wrap"));
    if rows.is_none() && wrap.is_none() {
        return Ok(None);
    }
    let mut uv_map = UvMap::default();
    if let Some(rows) = rows {
        let numbers = rows.numbers::<6>()?.map(|x| x as f32);
        if !numbers.iter().all(|x| x.is_finite()) {
            return Err(rows.expected("six numbers within single precision"));
        }
        let [a, b, c, d, e, f] = numbers;
        uv_map.rows = [[a, b, c], [d, e, f]];
    }
    if let Some(wrap) = wrap {
        uv_map.wrap = if wrap.is_list() {
            let both = wrap.list()?;
            let [u, v] = both.as_slice() else {
                return Err(wrap.expected("a list of two names, for u and for v"));
            };
            [u.one_of(Wrap::ALL)?, v.one_of(Wrap::ALL)?]
        } else {
            [wrap.one_of(Wrap::ALL)?; 2]
        };
    }
    Ok(Some(uv_map))
}

/// Reads the keys of a checkerboard.
fn checker(table: &Table<'_>, bound: Bound) -> Result<Texture> {
    let checker = table.required("checker").map_err(|_| {
        table.error("expected a colour: a list of three numbers, a number, \"#rrggbb\", a texture or a checker")
    })?;
    let colours = checker.list()?;
    let [first, second] = colours.as_slice() else {
        return Err(checker.expected("a list of two colours"));
    };
    let colours = [constant(first, bound)?, constant(second, bound)?];
    let repeat = match table.optional("repeat") {
        Some(repeat) => repeat.vec2()?.as_vec2(),
        None => Vec2::ONE,
    };
    Ok(Texture::Checker { colours, repeat })
}

/// Reads a constant colour.
///
/// # Errors
/// If the value is not a colour, or is out of bounds.
pub fn constant(value: &Value<'_>, bound: Bound) -> Result<Rgb> {
    let colour = if value.is_text() {
        hexadecimal(value.text()?).ok_or_else(|| value.expected("a colour such as \"#ff8000\""))?
    } else if value.is_number() {
        Rgb::grey(value.number()? as f32)
    } else if value.is_list() {
        Rgb::from(value.numbers::<3>()?.map(|x| x as f32))
    } else {
        return Err(value.expected("a colour"));
    };
    let most = if bound == Bound::Reflectance {
        1.0
    } else {
        f32::MAX
    };
    if colour.to_array().iter().all(|x| (0.0..=most).contains(x)) {
        Ok(colour)
    } else if bound == Bound::Reflectance {
        Err(value.error("expected a value from 0 to 1 in every channel"))
    } else {
        Err(value
            .error("expected a colour of at least 0 in every channel, within single precision"))
    }
}

/// Parses `#rrggbb`, in sRGB codes.
fn hexadecimal(text: &str) -> Option<Rgb> {
    let digits = text.strip_prefix('#')?;
    // from_str_radix would accept a sign.
    if digits.len() != 6 || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    let channel = |i: usize| {
        let code = u8::from_str_radix(&digits[2 * i..2 * i + 2], 16).ok()?;
        Some(srgb::to_linear(f64::from(code) / 255.0) as f32)
    };
    Some(Rgb::new(channel(0)?, channel(1)?, channel(2)?))
}

/// Describes the first texel that is negative, or not finite once scaled. EXR, HDR and PFM files may contain such
/// texels; the colours of a checkerboard were already checked.
fn no_colour(texture: &Texture) -> Option<String> {
    let (image, scale) = match texture {
        Texture::Image { image, scale } => (image, Rgb::grey(*scale)),
        Texture::Placed { image, tint, .. } => (image, *tint),
        Texture::Checker { .. } => return None,
    };
    let is_bad =
        |texel: Rgb| texel.to_array().iter().any(|x| *x < 0.0) || !(scale * texel).is_finite();
    let index = image.texels().position(is_bad)? as u32;
    let (x, y) = (index % image.width(), index / image.width());
    let texel = image.get(x, y).to_array();
    let expected = if texel.iter().any(|x| *x < 0.0) {
        "expected no values below 0".to_owned()
    } else {
        let scale = scale.max_channel();
        format!("multiplied by {scale} it is too large for single precision")
    };
    Some(format!("pixel ({x}, {y}) is {texel:?}: {expected}"))
}
