//! Colours of materials, constant or textured.
//!
//! Measure: linear Rec. 709.
//! Range: textures that `load` accepts.
//! Source: none needed. Tested in `tests/scattering/materials.rs`.

use super::super::description::ColourDescription;
use crate::geometry::packed::{PackedImage, PackedImages};
use crate::geometry::texture::Texture;
use crate::geometry::uv_map::UvMap;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use std::sync::Arc;

/// A colour that may vary over a surface; constant textures are stored as constants.
#[derive(Debug, Clone)]
pub(super) enum Colour {
    Constant(Rgb),
    Texture(Arc<Texture>),
    /// A packed image and its scale.
    Packed(Arc<PackedImage>, f32),
    /// A packed image, its tint and its place.
    PackedPlaced(Arc<PackedImage>, Rgb, UvMap),
}

impl Colour {
    /// The colour of a description.
    pub(super) fn new(description: &ColourDescription) -> Self {
        match (description, description.constant()) {
            (_, Some(colour)) => Self::Constant(colour),
            (ColourDescription::Constant(colour), None) => Self::Constant(*colour),
            (ColourDescription::Texture(texture), None) => Self::Texture(Arc::clone(texture)),
        }
    }

    /// Replaces an image texture by a packed one, for faster lookups.
    pub(super) fn pack(&mut self, images: &mut PackedImages) {
        let Self::Texture(texture) = self else { return };
        *self = match texture.as_ref() {
            Texture::Image { image, scale } => Self::Packed(images.pack(image), *scale),
            Texture::Placed {
                image,
                tint,
                uv_map,
            } => Self::PackedPlaced(images.pack(image), *tint, *uv_map),
            Texture::Checker { .. } => return,
        };
    }

    /// Whether it may vary.
    pub(super) fn is_textured(&self) -> bool {
        !matches!(self, Self::Constant(_))
    }

    /// The colour at a texture coordinate.
    #[inline]
    pub(super) fn at(&self, uv: Vec2) -> Rgb {
        match self {
            Self::Constant(colour) => *colour,
            Self::Texture(texture) => texture.lookup(uv),
            Self::Packed(image, scale) => *scale * image.lookup(uv),
            Self::PackedPlaced(image, tint, uv_map) => {
                *tint * image.lookup(uv_map.apply(image.size(), uv))
            }
        }
    }
}
