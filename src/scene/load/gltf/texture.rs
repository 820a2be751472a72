//! Textures of glTF: the images, each read once for what it is used for, and where they lie on a surface.
//!
//! Measure: linear Rec. 709 of sRGB images, or linear data.
//! Range: PNG, JPEG and the other formats that are read as images; lookups are bilinear, whatever filter a sampler has.
//! Source: glTF 2.0, chapter 3.8, and KHR_texture_transform. Tested in `tests/loading/gltf.rs`.

use super::buffers::Asset;
use crate::error::Result;
use crate::geometry::texture::Texture;
use crate::geometry::texture_image::TextureImage;
use crate::geometry::uv_map::{UvMap, Wrap};
use crate::image::{ColourSpace, Image};
use crate::math::functions::sin_cos;
use crate::math::rgb::Rgb;
use gltf::json::Value;
use gltf::texture::{MagFilter, WrappingMode};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

/// The use of an image, which decides how it is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ImageUse {
    /// Colours.
    Srgb,
    /// Data.
    Linear,
    /// The alpha channel alone.
    Alpha,
}

/// A reference to a texture.
#[derive(Debug, Clone)]
pub struct TextureReference {
    /// The image; `None` if it has none of a format that is read.
    image: Option<usize>,
    /// The texture coordinates.
    pub uv_set: u32,
    uv_map: UvMap,
    /// Whether its sampler asks for the nearest texel where texels are large.
    pub is_nearest: bool,
    /// The place of the texture in the JSON.
    field: String,
}

impl TextureReference {
    /// Returns the reference of a material to a texture, with its transform.
    pub fn new(info: &gltf::texture::Info<'_>) -> Self {
        let transform = info.texture_transform();
        let transform = transform.map(|it| Transform {
            offset: it.offset(),
            rotation: it.rotation(),
            scale: it.scale(),
            uv_set: it.tex_coord(),
        });
        Self::with(&info.texture(), info.tex_coord(), transform)
    }

    /// Returns the reference of a material to its normal texture.
    pub fn of_normals(normals: &gltf::material::NormalTexture<'_>) -> Self {
        let transform = normals.extension_value("KHR_texture_transform").map(|it| {
            let numbers = |key: &str, default| numbers(it.get(key)).unwrap_or(default);
            let rotation = it.get("rotation").and_then(Value::as_f64).unwrap_or(0.0);
            let uv_set = it.get("texCoord").and_then(Value::as_u64);
            let uv_set = uv_set.and_then(|set| u32::try_from(set).ok());
            Transform {
                offset: numbers("offset", [0.0; 2]),
                rotation: rotation as f32,
                scale: numbers("scale", [1.0; 2]),
                uv_set,
            }
        });
        Self::with(&normals.texture(), normals.tex_coord(), transform)
    }

    fn with(texture: &gltf::Texture<'_>, uv_set: u32, transform: Option<Transform>) -> Self {
        let sampler = texture.sampler();
        let mut uv_map = UvMap {
            wrap: [sampler.wrap_s(), sampler.wrap_t()].map(wrap),
            ..UvMap::default()
        };
        let mut set = uv_set;
        if let Some(transform) = transform {
            uv_map.rows = rows(transform.offset, transform.rotation, transform.scale);
            set = transform.uv_set.unwrap_or(uv_set);
        }
        Self {
            image: texture.source().map(|image| image.index()),
            uv_set: set,
            uv_map,
            is_nearest: sampler.mag_filter() == Some(MagFilter::Nearest),
            field: format!("textures[{}]", texture.index()),
        }
    }
}

/// The extension KHR_texture_transform of a reference to a texture.
struct Transform {
    offset: [f32; 2],
    rotation: f32,
    scale: [f32; 2],
    /// The set of texture coordinates, if it replaces that of the reference.
    uv_set: Option<u32>,
}

fn numbers(value: Option<&Value>) -> Option<[f32; 2]> {
    let list = value?.as_array()?;
    let number = |i: usize| list.get(i)?.as_f64().map(|x| x as f32);
    Some([number(0)?, number(1)?])
}

fn wrap(mode: WrappingMode) -> Wrap {
    match mode {
        WrappingMode::ClampToEdge => Wrap::Clamp,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::Repeat => Wrap::Repeat,
    }
}

/// The rows of the transform, for coordinates with v up. That of the extension is for v down: translation times rotation
/// times scale.
fn rows([x, y]: [f32; 2], rotation: f32, [scale_u, scale_v]: [f32; 2]) -> [[f32; 3]; 2] {
    let (sin, cos) = sin_cos(f64::from(rotation));
    let [x, y, scale_u, scale_v] = [x, y, scale_u, scale_v].map(f64::from);
    let down = [
        [cos * scale_u, sin * scale_v, x],
        [-sin * scale_u, cos * scale_v, y],
    ];
    // u' = a u + b (1 - v) + c, and 1 - v' likewise.
    let [[a, b, c], [d, e, f]] = down;
    [[a, -b, b + c], [-d, e, 1.0 - e - f]].map(|row| row.map(|x| x as f32))
}

/// The images read so far.
#[derive(Debug, Default)]
pub struct ImageCache {
    known: HashMap<(usize, ImageUse), Option<Arc<TextureImage>>>,
}

impl ImageCache {
    /// Returns a texture with this factor of its values; `None` if it has no image, or its image no such channels.
    ///
    /// # Errors
    /// If the image cannot be read.
    pub fn texture(
        &mut self,
        asset: &Asset<'_>,
        reference: &TextureReference,
        channels: ImageUse,
        tint: Rgb,
    ) -> Result<Option<Texture>> {
        if !reference.uv_map.is_finite() {
            let message = "expected a transform of finite numbers";
            return Err(asset.error(&reference.field, message));
        }
        let Some(image) = self.image(asset, reference, channels)? else {
            return Ok(None);
        };
        let [scale, ..] = tint.to_array();
        Ok(Some(
            if reference.uv_map == UvMap::default() && tint == Rgb::grey(scale) {
                Texture::Image { image, scale }
            } else {
                Texture::Placed {
                    image,
                    tint,
                    uv_map: reference.uv_map,
                }
            },
        ))
    }

    fn image(
        &mut self,
        asset: &Asset<'_>,
        reference: &TextureReference,
        channels: ImageUse,
    ) -> Result<Option<Arc<TextureImage>>> {
        let Some(index) = reference.image else {
            return Ok(None);
        };
        match self.known.entry((index, channels)) {
            Entry::Occupied(known) => Ok(known.get().clone()),
            Entry::Vacant(place) => {
                let field = format!("images[{index}]");
                let read = || {
                    let bytes = asset.image(index)?;
                    match channels {
                        ImageUse::Srgb => Image::decode(&bytes, ColourSpace::Srgb).map(Some),
                        ImageUse::Linear => Image::decode(&bytes, ColourSpace::Linear).map(Some),
                        ImageUse::Alpha => Image::decode_alpha(&bytes),
                    }
                };
                let image = read().map_err(|error| asset.within(error, &field))?;
                let image = image.map(TextureImage::from);
                Ok(place.insert(image.map(Arc::new)).clone())
            }
        }
    }
}
