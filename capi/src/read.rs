//! Reading the image of a render into the caller's memory, and writing it to a file.
//!
//! Measure: linear Rec. 709; bytes.
//! Range: any strides and sizes; if they do not fit, that is an error, and nothing is written.
//! Source: none needed.

use crate::memory::{not_null, text, write_list};
use crate::render::{EtdRender, RENDERS};
use crate::status::{EtdStatus, Failure};
use renderer::{Image, WriteOptions, write};
use std::ffi::c_char;
use std::path::Path;

/// The destination of an image in the caller's memory; `EtdRenderInfo` holds its width and height. Strides are bytes
/// from one pixel to the next and from one row to the next; 0 stands for no gap.
struct Target {
    pixels: *mut f32,
    pixel_stride: usize,
    row_stride: usize,
    /// Available bytes.
    size: usize,
}

impl Target {
    /// Writes the rows of an image.
    ///
    /// # Safety
    /// `size` bytes may be written, unless the pointer is null.
    unsafe fn fill<T: Copy>(&self, width: usize, pixels: &[T]) -> Result<(), Failure> {
        not_null(self.pixels, "pixels")?;
        let stride_or = |stride: usize, least: usize, what: &str| match stride {
            0 => Ok(least),
            stride if stride >= least => Ok(stride),
            stride => Err(Failure::argument(format!(
                "{what}: {stride} bytes, expected at least {least}"
            ))),
        };
        let item = size_of::<T>();
        let pixel = stride_or(self.pixel_stride, item, "pixel_stride")?;
        let overflow = || Failure::argument("the strides are larger than memory");
        let row = (width - 1).checked_mul(pixel).ok_or_else(overflow)?;
        let row = row.checked_add(item).ok_or_else(overflow)?;
        let gapless = width.checked_mul(pixel).ok_or_else(overflow)?;
        let row_stride = match self.row_stride {
            0 => gapless,
            stride => stride_or(stride, row, "row_stride")?,
        };
        let height = pixels.len() / width;
        let before = (height - 1).checked_mul(row_stride).ok_or_else(overflow)?;
        let needed = before.checked_add(row).ok_or_else(overflow)?;
        if needed > self.size {
            return Err(Failure::argument(format!(
                "size: {width} x {height} pixels with these strides take {needed} bytes, but the buffer has {}",
                self.size
            )));
        }
        for (y, row) in pixels.chunks(width).enumerate() {
            // SAFETY: the row lies within the bytes that may be written, as was just checked.
            unsafe {
                let start = self.pixels.cast::<u8>().add(y * row_stride);
                write_list(start.cast(), pixel, row.iter().copied(), "pixels")?;
            }
        }
        Ok(())
    }
}

fn channels(image: &Image) -> Vec<[f32; 3]> {
    let pixels = image.pixels().iter();
    pixels.map(|pixel| pixel.to_array()).collect()
}

/// Copies the image to `pixels`, where `size` bytes may be written: red, green and blue of each pixel as three floats,
/// linear Rec. 709, row by row from the top. Strides are bytes from one pixel or row to the next; 0 stands for no gap.
///
/// # Safety
/// `pixels` is null, or `size` bytes may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_render_read_pixels(
    render: *const EtdRender,
    pixels: *mut f32,
    size: usize,
    pixel_stride: usize,
    row_stride: usize,
) -> EtdStatus {
    RENDERS.call(render, |render| {
        let image = render.with(|state| Ok(state.rendering.image()))?;
        let target = Target {
            pixels,
            pixel_stride,
            row_stride,
            size,
        };
        // SAFETY: the caller's promise.
        unsafe { target.fill(image.width() as usize, &channels(&image)) }?;
        Ok(EtdStatus::Ok)
    })
}

/// Copies the standard error of each pixel, like `etd_render_read_pixels`; requires at least four samples per pixel. The
/// 95 % confidence interval is two standard errors to either side; for other levels, the layer "freedom.Y" holds the
/// degrees of freedom of Student's t, scaled to variance 1.
///
/// # Safety
/// As `etd_render_read_pixels`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_render_read_standard_errors(
    render: *const EtdRender,
    pixels: *mut f32,
    size: usize,
    pixel_stride: usize,
    row_stride: usize,
) -> EtdStatus {
    RENDERS.call(render, |render| {
        let errors = render.with(|state| {
            let bars = state.rendering.error_bars().ok_or_else(|| {
                Failure::argument(
                    "fewer than four samples per pixel: error bars need at least four",
                )
            })?;
            Ok(bars.standard_errors)
        })?;
        let target = Target {
            pixels,
            pixel_stride,
            row_stride,
            size,
        };
        // SAFETY: the caller's promise.
        unsafe { target.fill(errors.width() as usize, &channels(&errors)) }?;
        Ok(EtdStatus::Ok)
    })
}

/// Copies a layer, one float per pixel, like `etd_render_read_pixels`; its name is one of those of docs/accuracy.md,
/// such as "albedo.R", "depth.Z" or "spp.Y". For renders with `ETD_LAYERS`. First hits are traced when a layer is read
/// for the first time.
///
/// # Safety
/// As `etd_render_read_pixels`; `name` is null, or a NUL-terminated string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_render_read_layer(
    render: *const EtdRender,
    name: *const c_char,
    pixels: *mut f32,
    size: usize,
    pixel_stride: usize,
    row_stride: usize,
) -> EtdStatus {
    RENDERS.call(render, |render| {
        not_null(name, "name")?;
        // SAFETY: the caller's promise.
        let name = unsafe { text(name, "name") }?.unwrap_or_default();
        let target = Target {
            pixels,
            pixel_stride,
            row_stride,
            size,
        };
        render.with(|state| {
            let picture = state.layered(&render.ready)?;
            let Some(layer) = picture.layer(name) else {
                let names: Vec<&str> = picture.layers.iter().map(|it| it.name.as_str()).collect();
                return Err(Failure::argument(format!(
                    "name: there is no layer {name:?}, only {}",
                    names.join(", ")
                )));
            };
            // SAFETY: the caller's promise.
            unsafe { target.fill(picture.image.width() as usize, layer) }?;
            Ok(EtdStatus::Ok)
        })
    })
}

/// Writes the image to a file, completely or not at all: `.exr`, with all layers if the render has them, `.png`, `.hdr`
/// or `.pfm`.
///
/// # Safety
/// `path` is null, or a NUL-terminated string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_render_write(
    render: *const EtdRender,
    path: *const c_char,
) -> EtdStatus {
    RENDERS.call(render, |render| {
        not_null(path, "path")?;
        // SAFETY: the caller's promise.
        let path = unsafe { text(path, "path") }?.unwrap_or_default();
        render.with(|state| {
            let mut options = WriteOptions::default();
            if state.rendering.settings().layers {
                options
                    .layers
                    .clone_from(&state.layered(&render.ready)?.layers);
            }
            write(Path::new(path), &state.rendering.image(), &options)?;
            Ok(EtdStatus::Ok)
        })
    })
}
