//! A material: its textures looked up at a hit, it becomes a BSDF.
//!
//! Measure: as in `bsdf/types.rs`.
//! Range: what `load` lets through.
//! Source: none needed. Tested in `tests/prepare.rs`.

use super::description::{ColourDescription, MaterialModel};
use crate::bsdf::Bsdf;
use crate::geometry::texture::Texture;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use std::sync::Arc;

/// A colour that may vary over a surface; textures of one colour have become that colour.
#[derive(Debug, Clone)]
enum Colour {
    Constant(Rgb),
    Texture(Arc<Texture>),
}

impl Colour {
    fn new(description: &ColourDescription) -> Self {
        match description {
            ColourDescription::Constant(colour) => Self::Constant(*colour),
            ColourDescription::Texture(texture) => match texture.constant() {
                Some(colour) => Self::Constant(colour),
                None => Self::Texture(Arc::clone(texture)),
            },
        }
    }

    #[inline]
    fn at(&self, uv: Vec2) -> Rgb {
        match self {
            Self::Constant(colour) => *colour,
            Self::Texture(texture) => texture.lookup(uv),
        }
    }
}

/// A material, ready to be looked up.
#[derive(Debug, Clone)]
pub struct Material {
    reflectance: Colour,
}
impl Material {
    /// x
    pub fn new(model: &MaterialModel) -> Self {
        match model {
            MaterialModel::Diffuse { reflectance } => Self {
                reflectance: Colour::new(reflectance),
            },
            _ => panic!(),
        }
    }
    /// x
    #[inline]
    pub fn bsdf(&self, uv: Vec2) -> Bsdf {
        Bsdf::Diffuse(crate::bsdf::Diffuse::new(self.reflectance.at(uv)))
    }
    /// x
    #[inline]
    pub fn transmits(&self) -> bool {
        false
    }
}
