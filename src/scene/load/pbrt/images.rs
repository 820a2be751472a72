//! The image files that a pbrt file names: which of their channels count, and how these are encoded.
//!
//! Measure: linear Rec. 709, at least 0.
//! Range: the extension of a file decides, as in pbrt. The parameter `encoding` and the alpha channel count for PNG only;
//! EXR, HDR and PFM are linear, and others, such as JPEG, TGA and BMP, are sRGB.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pictures.rs`.

use super::library::Library;
use super::params::Parameters;
use crate::error::Result;
use crate::geometry::texture::Texture;
use crate::geometry::texture_image::TextureImage;
use crate::image::ColourSpace;
use crate::math::functions::powf;
use crate::math::rgb::Rgb;
use crate::scene::load::wording::shown;
use std::path::Path;
use std::sync::Arc;

/// The formats that pbrt distinguishes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PbrtImageFormat {
    Png,
    Floats,
    OtherCodes,
}

impl PbrtImageFormat {
    /// The format of a file of this name.
    fn of(path: &Path) -> Self {
        let extension = path.extension().unwrap_or_default();
        match &*extension.to_string_lossy().to_lowercase() {
            "png" => Self::Png,
            "exr" | "hdr" | "pfm" => Self::Floats,
            _ => Self::OtherCodes,
        }
    }
}

/// The parameter `encoding`.
#[derive(Debug, Clone, Copy, PartialEq)]
enum ColourEncoding {
    Space(ColourSpace),
    Gamma(f32),
}

impl Library {
    /// Reads the alpha channel of the image that a parameter names, which pbrt takes for its number, if the image has one that
    /// counts and is not opaque.
    ///
    /// # Errors
    /// If the image cannot be read.
    pub fn alpha_of(
        &mut self,
        params: &Parameters,
        name: &str,
    ) -> Result<Option<Arc<TextureImage>>> {
        let Some(file) = params.text(name)? else {
            return Ok(None);
        };
        let path = self.path(file);
        if PbrtImageFormat::of(&path) != PbrtImageFormat::Png {
            return Ok(None);
        }
        let alpha = self.contents.textures.read_alpha(&path, 1.0);
        let alpha = alpha.map_err(|error| self.about(params, name, &error))?;
        let Some(Texture::Image { image, .. }) = alpha else {
            return Ok(None);
        };
        // Alpha is never encoded.
        params.text("encoding")?;
        Ok(Some(image))
    }

    /// Reads the image that a parameter names, encoded as `encoding` says where that counts: sRGB by default.
    ///
    /// # Errors
    /// If it is left out, or cannot be read.
    pub fn image(&mut self, params: &Parameters, name: &str) -> Result<Arc<TextureImage>> {
        let Some(file) = params.text(name)? else {
            return Err(params.error(format!("expected a parameter `string {name}`")));
        };
        let path = self.path(file);
        let stated = encoding(params)?;
        let (space, gamma) = match (PbrtImageFormat::of(&path), stated) {
            (PbrtImageFormat::Png, ColourEncoding::Space(space)) => (space, None),
            (PbrtImageFormat::Png, ColourEncoding::Gamma(gamma)) => {
                (ColourSpace::Linear, Some(gamma))
            }
            (PbrtImageFormat::Floats, _) => (ColourSpace::Linear, None),
            (PbrtImageFormat::OtherCodes, _) => (ColourSpace::Srgb, None),
        };
        let texture = self.contents.textures.read(&path, space, 1.0);
        let texture = texture.map_err(|error| self.about(params, name, &error))?;
        let Texture::Image { image, .. } = texture else {
            return Err(params.error_of(name, "expected an image"));
        };
        let is_below_0 = |texel: Rgb| texel.to_array().iter().any(|x| *x < 0.0);
        let has_any = image.texels().any(is_below_0);
        let image = match has_any {
            false => image,
            true => {
                self.approximated(&params.place_of(name), "values below 0 are taken as 0");
                with_values(&image, |x| x.max(0.0))
            }
        };
        Ok(match gamma {
            None => image,
            Some(gamma) => with_values(&image, |x| powf(x, gamma)),
        })
    }
}

/// The image with each of its values changed.
fn with_values(image: &TextureImage, f: impl Fn(f32) -> f32) -> Arc<TextureImage> {
    Arc::new(image.map(|texel| texel.map(&f)))
}

fn encoding(params: &Parameters) -> Result<ColourEncoding> {
    let stated = params.text("encoding")?.unwrap_or("sRGB");
    let gamma = stated
        .strip_prefix("gamma ")
        .and_then(|gamma| gamma.trim().parse::<f32>().ok());
    match (stated, gamma) {
        ("sRGB", _) => Ok(ColourEncoding::Space(ColourSpace::Srgb)),
        ("linear", _) => Ok(ColourEncoding::Space(ColourSpace::Linear)),
        (_, Some(gamma)) if gamma > 0.0 => Ok(ColourEncoding::Gamma(gamma)),
        _ => {
            let found = shown(stated);
            let message = format!("expected sRGB, linear or gamma and a number, found `{found}`");
            Err(params.error_of("encoding", message))
        }
    }
}
