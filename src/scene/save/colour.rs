//! Writes colours and textures.
//!
//! Measure: linear Rec. 709.
//! Range: any colour of a valid description.
//! Source: docs/scene-format.md. Tested in `tests/loading/saving.rs`.

use super::assets::Assets;
use super::text::{list, rgb, single, string};
use crate::error::Result;
use crate::geometry::texture::Texture;
use crate::geometry::texture_image::TextureImage;
use crate::geometry::uv_map::Wrap;
use crate::image::ColourSpace;
use crate::math::rgb::Rgb;
use crate::scene::description::ColourDescription;
use std::sync::Arc;

/// The notation of a colour.
///
/// # Errors
/// If its image cannot be written.
pub fn colour(colour: &ColourDescription, assets: &mut Assets) -> Result<String> {
    match colour {
        ColourDescription::Constant(constant) => Ok(constant_colour(*constant)),
        ColourDescription::Texture(texture) => Ok(format!("{{ {} }}", keys(texture, assets)?)),
    }
}

/// The notation of a constant colour: a number if it is grey.
pub fn constant_colour(colour: Rgb) -> String {
    let [grey, ..] = colour.to_array();
    if colour == Rgb::grey(grey) {
        single(grey)
    } else {
        rgb(colour)
    }
}

/// The keys and values of a texture, to be put into braces.
///
/// # Errors
/// If its image cannot be written.
pub fn keys(texture: &Texture, assets: &mut Assets) -> Result<String> {
    Ok(match texture {
        Texture::Image { image, scale } => {
            let file = image_keys(image, assets)?;
            if *scale == 1.0 {
                file
            } else {
                format!("{file}, scale = {}", single(*scale))
            }
        }
        Texture::Placed {
            image,
            tint,
            uv_map,
        } => {
            let name = |wrap: Wrap| {
                let known = Wrap::ALL.iter().find(|(_, it)| *it == wrap);
                string(known.map_or("repeat", |(name, _)| name))
            };
            format!(
                "{}, scale = {}, uv_map = {}, wrap = {}",
                image_keys(image, assets)?,
                rgb(*tint),
                list(uv_map.rows.as_flattened().iter().copied().map(single)),
                list(uv_map.wrap.map(name))
            )
        }
        Texture::Checker { colours, repeat } => format!(
            "checker = {}, repeat = {}",
            list(colours.map(constant_colour)),
            list(repeat.to_array().map(single))
        ),
    })
}

fn image_keys(image: &Arc<TextureImage>, assets: &mut Assets) -> Result<String> {
    let file = assets.image(image)?;
    let space = match file.space {
        ColourSpace::Srgb => "srgb",
        ColourSpace::Linear => "linear",
    };
    Ok(format!(
        "texture = {}, space = \"{space}\"",
        string(&file.path)
    ))
}
