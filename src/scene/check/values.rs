//! Checks of single values: numbers, points, colours, transforms and keyframes.
//!
//! Measure: as in the description.
//! Range: any value; a violation is an error that names the field.
//! Source: docs/scene-format.md. Tested in `tests/loading/built_scenes.rs`.

use crate::error::{Error, Result};
use crate::geometry::texture::Texture;
use crate::math::rgb::Rgb;
use crate::math::transform::is_invertible;
use crate::math::vec::{DAffine3, DVec3};
use crate::scene::description::{ColourDescription, Keyframe};

/// Checks the keyframes of an object of this name: in order of time, with invertible transforms.
pub fn keys(keys: &[Keyframe], object: &str) -> Result<()> {
    let field = || format!("{object}: motion");
    for key in keys {
        require(key.time.is_finite(), field, "expected finite times")?;
        placed(&key.transform, field)?;
    }
    let in_order = keys.windows(2).all(|pair| pair[0].time < pair[1].time);
    require(in_order, field, "expected keys in order of time")
}

/// Checks that a transform is invertible.
pub fn placed(transform: &DAffine3, field: impl Fn() -> String) -> Result<()> {
    require(
        transform.is_finite() && is_invertible(&transform.matrix3),
        field,
        "expected finite numbers, and a transform that is not singular",
    )
}

/// Checks that a colour is from 0 to `most` in every channel, everywhere.
pub fn colour(colour: &ColourDescription, most: f32, field: impl Fn() -> String) -> Result<()> {
    let is_within = |c: Rgb| c.to_array().iter().all(|x| (0.0..=most).contains(x));
    let all_within = match colour {
        ColourDescription::Constant(colour) => is_within(*colour),
        ColourDescription::Texture(texture) => match texture.as_ref() {
            Texture::Image { image, scale } => {
                image.texels().all(|texel| is_within(*scale * texel))
            }
            Texture::Placed {
                image,
                tint,
                uv_map,
            } => uv_map.is_finite() && image.texels().all(|texel| is_within(*tint * texel)),
            Texture::Checker { colours, repeat } => {
                repeat.is_finite() && colours.iter().all(|&c| is_within(c))
            }
        },
    };
    let expected = if most == 1.0 {
        "expected a value from 0 to 1 in every channel"
    } else {
        "expected a finite value of at least 0 in every channel"
    };
    require(all_within, field, expected)
}

/// Checks that a colour is above 0 in every channel.
pub fn positive(colour: Rgb, field: impl Fn() -> String) -> Result<()> {
    let is_fine = colour.to_array().iter().all(|&x| x > 0.0 && x.is_finite());
    let expected = "expected a finite value above 0 in every channel";
    require(is_fine, field, expected)
}

/// Checks that a colour is at least 0 in every channel.
pub fn not_negative(colour: Rgb, field: impl Fn() -> String) -> Result<()> {
    let is_fine = colour.to_array().iter().all(|&x| x >= 0.0 && x.is_finite());
    let expected = "expected a finite value of at least 0 in every channel";
    require(is_fine, field, expected)
}

/// Checks that a point is finite.
pub fn finite(point: DVec3, field: impl Fn() -> String) -> Result<()> {
    require(point.is_finite(), field, "expected finite numbers")
}

/// Checks that a length is above 0.
pub fn length(length: f64, field: impl Fn() -> String) -> Result<()> {
    let is_fine = length > 0.0 && length.is_finite();
    require(is_fine, field, "expected a finite number above 0")
}

/// Checks that a direction is finite and not zero.
pub fn direction(direction: DVec3, field: impl Fn() -> String) -> Result<()> {
    let is_fine = direction.try_normalize().is_some();
    require(
        is_fine,
        field,
        "expected a finite direction that is not zero",
    )
}

/// Returns an error that states what was expected of a field, unless `is_fine`.
pub fn require(is_fine: bool, field: impl Fn() -> String, expected: &str) -> Result<()> {
    if is_fine {
        Ok(())
    } else {
        Err(Error::scene(expected).in_field(field()))
    }
}
