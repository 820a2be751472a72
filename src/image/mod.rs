//! Pictures in memory and in files.

use crate::math::rgb::Rgb;

/// A picture of linear colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<Rgb>,
}
