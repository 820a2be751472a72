//! Images as textures.
//!
//! Measure: linear Rec. 709 for colours; otherwise the unit of the textured quantity.
//! Range: from 1 to 65536 pixels per side.
//! Source: docs/scene-format.md.

use super::or_default;
use crate::memory::{Versioned, not_null, read_list, read_struct, room};
use crate::status::Failure;
use renderer::Image;
use renderer::Rgb;
use renderer::Texture;
use renderer::description::ColourDescription;
use std::sync::Arc;

/// An image in the caller's memory, which is copied.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdImage {
    /// sizeof(EtdImage)
    pub struct_size: usize,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green and blue of each pixel, linear Rec. 709, row by row from the top.
    pub rgb: *const f32,
    /// Bytes from one pixel to the next; 0 stands for three floats without a gap.
    pub pixel_stride: usize,
    /// Factor for every value; 0 stands for 1.
    pub scale: f32,
}

// SAFETY: numbers and pointers, of which zeros are values.
unsafe impl Versioned for EtdImage {
    const NAME: &'static str = "EtdImage";
}

/// Copies an image of the caller.
///
/// # Safety
/// The pointer is null, or the structure and its pointers are valid.
pub unsafe fn texture(pointer: *const EtdImage) -> Result<Arc<Texture>, Failure> {
    // SAFETY: the caller's promise.
    let image = unsafe { read_struct(pointer) }?;
    let (width, height) = (image.width as usize, image.height as usize);
    let is_side = |side| (1..=renderer::MAX_SIDE).contains(&side);
    if !(is_side(width) && is_side(height)) {
        return Err(Failure::argument(format!(
            "EtdImage: {width} x {height} pixels, expected 1 to 65536 on each side"
        )));
    }
    not_null(image.rgb, "EtdImage: rgb")?;
    let stride = image.pixel_stride;
    // SAFETY: as above.
    let pixels: Vec<[f32; 3]> =
        unsafe { read_list(image.rgb.cast(), width * height, stride, "rgb") }?;
    let mut colours = room(pixels.len(), "rgb")?;
    colours.extend(pixels.into_iter().map(Rgb::from));
    Ok(Arc::new(Texture::Image {
        image: Arc::new(Image::new(image.width, image.height, colours).into()),
        scale: or_default(image.scale, 1.0),
    }))
}

/// Copies an image of the caller; null stands for the colour.
///
/// # Safety
/// As [`texture`].
pub unsafe fn texture_or(
    pointer: *const EtdImage,
    colour: Rgb,
) -> Result<ColourDescription, Failure> {
    if pointer.is_null() {
        return Ok(colour.into());
    }
    // SAFETY: the caller's promise.
    unsafe { texture(pointer) }.map(ColourDescription::Texture)
}
