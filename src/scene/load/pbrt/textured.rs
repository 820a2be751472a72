//! Values that may vary over a surface, and functions of them.
//!
//! Measure: linear Rec. 709; texture coordinates in which v points up.
//! Range: constants, images and checkerboards.
//! Source: none needed. Tested in `tests/loading/pbrt/`.

use crate::geometry::texture::Texture;
use crate::math::rgb::Rgb;
use crate::math::vec::DVec2;
use crate::scene::description::ColourDescription;
use std::sync::Arc;

/// A texture, and how texture coordinates are changed before it is looked up.
#[derive(Debug, Clone)]
pub struct Textured {
    pub colour: ColourDescription,
    pub mapping: Mapping,
}

/// A linear change of texture coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mapping {
    pub scale: DVec2,
    pub delta: DVec2,
}

impl Default for Mapping {
    fn default() -> Self {
        Self {
            scale: DVec2::ONE,
            delta: DVec2::ZERO,
        }
    }
}

impl From<Rgb> for Textured {
    fn from(colour: Rgb) -> Self {
        Self {
            colour: colour.into(),
            mapping: Mapping::default(),
        }
    }
}

impl Textured {
    /// The mean of its values.
    pub fn mean(&self) -> Rgb {
        match &self.colour {
            ColourDescription::Constant(colour) => *colour,
            ColourDescription::Texture(texture) => texture.mean(),
        }
    }

    /// The texture with each of its values changed.
    pub fn map(&self, f: impl Fn(Rgb) -> Rgb) -> Self {
        let colour = match &self.colour {
            ColourDescription::Constant(colour) => f(*colour).into(),
            ColourDescription::Texture(texture) => {
                ColourDescription::Texture(Arc::new(texture.map(f)))
            }
        };
        Self {
            colour,
            mapping: self.mapping,
        }
    }

    /// The texture with values from 0 to 1.
    pub fn clamped(self) -> Self {
        if self.colour.brightest().max_channel() > 1.0 {
            self.map(|colour| colour.map(|x| x.clamp(0.0, 1.0)))
        } else {
            self
        }
    }

    /// A function of two textures; `None` if it is not one of one image or checkerboard.
    pub fn with(&self, other: &Self, f: impl Fn(Rgb, Rgb) -> Rgb) -> Option<Self> {
        match (self.colour.constant(), other.colour.constant()) {
            (_, Some(second)) => Some(self.map(|first| f(first, second))),
            (Some(first), None) => Some(other.map(|second| f(first, second))),
            (None, None) => {
                let image = |textured: &Self| match &textured.colour {
                    ColourDescription::Texture(texture) => match texture.as_ref() {
                        Texture::Image { image, scale } => Some((Arc::clone(image), *scale)),
                        Texture::Placed { .. } | Texture::Checker { .. } => None,
                    },
                    ColourDescription::Constant(_) => None,
                };
                let ((a, scale_a), (b, scale_b)) = (image(self)?, image(other)?);
                if a.size() != b.size() || self.mapping != other.mapping {
                    return None;
                }
                let mut others = b.texels();
                let image = Arc::new(a.map(|texel| {
                    let other = others.next().expect("both have equally many texels");
                    f(scale_a * texel, scale_b * other)
                }));
                let texture = Texture::Image { image, scale: 1.0 };
                Some(Self {
                    colour: ColourDescription::Texture(Arc::new(texture)),
                    mapping: self.mapping,
                })
            }
        }
    }
}
