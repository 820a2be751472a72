//! Colours of materials, constant or textured.
//!
//! Measure: linear Rec. 709.
//! Range: textures that `load` accepts.
//! Source: none needed. Tested in `tests/scattering/materials.rs`.

use super::super::description::ColourDescription;
use crate::geometry::texture::Texture;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use std::sync::Arc;

/// A colour that may vary over a surface; constant textures are stored as constants.
#[derive(Debug, Clone)]
pub(super) enum Colour {
    Constant(Rgb),
    Texture(Arc<Texture>),
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
        }
    }
}
