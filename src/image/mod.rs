//! Images in memory and in files.
//!
//! Measure: linear Rec. 709, 32-bit floats; row 0 is on top.
//! Range: 1 to 65536 pixels a side and 2^28 in all when read; every pixel that was read is finite. Anything else in a
//! file is an error that names it, never a panic.
//! Source: the specification of each format, named in its file here. Tested below: round trips of every format,
//! arbitrary bytes.

pub mod atomic;
mod exr;
mod exr_blocks;
mod exr_layers;
mod hdr;
mod jpeg;
mod layered;
pub mod metrics;
mod options;
mod pfm;
mod png;
mod raster;
pub mod srgb;
mod tga;
pub mod tiles;
mod write;

pub use layered::LayeredImage;
pub use options::{Layer, MetadataValue, WriteOptions};
pub use png::{codes, exact_codes, png_bytes, png_bytes_with_texts, write_codes};
pub use write::{check_writable, write};

use crate::error::{Error, Result};
use crate::math::rgb::Rgb;
use crate::memory;
use serde::Serialize;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The longest side of an image that is read or rendered.
pub const MAX_SIDE: usize = 1 << 16;
/// The most pixels of an image that is read: 4 GiB in memory.
const MAX_PIXELS: usize = 1 << 28;
/// The most bytes of memory for a pixel while an image is read: a colour, and its samples as they are in the file.
const BYTES_PER_PIXEL: u64 = 32;
/// The largest file that is read: twelve bytes for each of the most pixels, and a header.
const MAX_BYTES: u64 = 12 * MAX_PIXELS as u64 + (1 << 20);

/// The most pixels per byte of any format: PNG, of which one byte may encode 1032 bytes of eight black and white
/// pixels each.
const MAX_PIXELS_PER_BYTE: usize = 8 * 1032;

/// An image of linear colours, at least one pixel large.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<Rgb>,
}

/// The encoding of integer samples in a file. Files of floats are always linear.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum ColourSpace {
    /// Encoded by the sRGB transfer function: colours.
    #[default]
    Srgb,
    /// Linear: data, such as roughness or normals.
    Linear,
}

impl Image {
    /// Builds an image of the given pixels, row by row from the top.
    ///
    /// # Panics
    ///
    /// If there is no pixel, or their number is not `width * height`.
    pub fn new(width: u32, height: u32, pixels: Vec<Rgb>) -> Self {
        assert!(width > 0 && height > 0, "an image has at least one pixel");
        assert_eq!(
            pixels.len(),
            width as usize * height as usize,
            "an image has width * height pixels"
        );
        Self {
            width,
            height,
            pixels,
        }
    }

    /// Builds an image of one colour.
    ///
    /// # Panics
    ///
    /// If the image has no pixel.
    pub fn filled(width: u32, height: u32, colour: Rgb) -> Self {
        let pixels = vec![colour; width as usize * height as usize];
        Self::new(width, height, pixels)
    }

    /// Reads a PNG, JPEG, TGA, BMP, Radiance HDR, OpenEXR or PFM file; the format is detected by its first bytes.
    ///
    /// A file that cannot be read is an [`ErrorKind::Io`](crate::ErrorKind::Io); one that is not a valid image, is
    /// too large, or has a pixel that is not finite, is an [`ErrorKind::Scene`](crate::ErrorKind::Scene).
    pub fn read(path: &Path, space: ColourSpace) -> Result<Self> {
        Self::decode(&file_bytes(path)?, space).map_err(|error| error.in_file(path))
    }

    /// Reads the alpha channel of a file, as a grey image; `None` if it has none that is read, or is opaque.
    ///
    /// # Errors
    /// As [`Image::decode`], and if the file cannot be read.
    pub fn read_alpha(path: &Path) -> Result<Option<Self>> {
        let alpha = Self::decode_alpha(&file_bytes(path)?).map_err(|error| error.in_file(path))?;
        let is_not_opaque =
            |alpha: &Self| alpha.pixels.iter().any(|pixel| pixel.to_array()[0] < 1.0);
        Ok(alpha.filter(is_not_opaque))
    }

    /// Decodes the bytes of a file as [`Image::read`] does.
    pub fn decode(bytes: &[u8], space: ColourSpace) -> Result<Self> {
        let image = match bytes {
            [0x89, b'P', b'N', b'G', ..] => raster::decode_png(bytes, space),
            [0xFF, 0xD8, 0xFF, ..] => jpeg::decode(bytes, space),
            [b'#', b'?', ..] => raster::decode_hdr(bytes),
            [b'P', b'F' | b'f', b'\n' | b'\r' | b' ', ..] => pfm::decode(bytes),
            [b'B', b'M', ..] => raster::decode_bmp(bytes, space),
            _ if exr::is_one(bytes) => exr::decode(bytes),
            _ if tga::is_one(bytes) => tga::decode(bytes, space),
            _ => Err(Error::scene(
                "not an image: expected a PNG, JPEG, TGA, BMP, HDR, EXR or PFM file",
            )),
        }?;
        image.checked_finite()
    }

    /// Decodes the alpha channel of the bytes of a PNG, TGA or BMP file, grey; `None` if it has none. Images of other formats
    /// have none that is read.
    ///
    /// # Errors
    /// As [`Image::decode`].
    pub fn decode_alpha(bytes: &[u8]) -> Result<Option<Self>> {
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => raster::decode_png_alpha(bytes),
            [b'B', b'M', ..] => raster::decode_bmp_alpha(bytes),
            _ if tga::is_one(bytes) => tga::decode_alpha(bytes),
            _ => Ok(None),
        }
    }

    /// The image, if every pixel is finite; else an error that names the first that is not.
    fn checked_finite(self) -> Result<Self> {
        match self.pixels.iter().position(|pixel| !pixel.is_finite()) {
            None => Ok(self),
            Some(index) => {
                let (x, y) = (index % self.width as usize, index / self.width as usize);
                let pixel = self.pixels[index].to_array();
                Err(Error::scene(format!(
                    "pixel ({x}, {y}) is {pixel:?}: expected finite numbers"
                )))
            }
        }
    }

    /// The width in pixels.
    #[inline]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// The height in pixels.
    #[inline]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All pixels, row by row from the top.
    #[inline]
    pub fn pixels(&self) -> &[Rgb] {
        &self.pixels
    }

    /// All pixels, mutable.
    #[inline]
    pub fn pixels_mut(&mut self) -> &mut [Rgb] {
        &mut self.pixels
    }

    /// The pixel in column `x` of row `y`.
    ///
    /// # Panics
    ///
    /// If the pixel lies below or, in the last row, right of the image.
    #[inline]
    pub fn get(&self, x: u32, y: u32) -> Rgb {
        debug_assert!(x < self.width);
        self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// The mean of each channel over all pixels.
    pub fn mean(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for pixel in &self.pixels {
            for (sum, channel) in sum.iter_mut().zip(pixel.to_array()) {
                *sum += f64::from(channel);
            }
        }
        sum.map(|sum| sum / self.pixels.len() as f64)
    }
}

/// All bytes of a file; an error if it is larger than any image that is read.
fn file_bytes(path: &Path) -> Result<Vec<u8>> {
    let cannot_read = |cause| Error::io("cannot read", path, cause);
    // Reading a device such as /dev/zero would take long, and a pipe would block.
    if !std::fs::metadata(path).map_err(cannot_read)?.is_file() {
        return Err(cannot_read(std::io::Error::other("not a regular file")));
    }
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes))
        .map_err(cannot_read)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(
            Error::scene(format!("larger than {MAX_BYTES} bytes, too large an image"))
                .in_file(path),
        );
    }
    Ok(bytes)
}

/// Checks the size that a file of `bytes` bytes declares for its image, and that there is memory for it, before that is
/// allocated.
fn checked_size(width: usize, height: usize, bytes: usize) -> Result<(u32, u32)> {
    let refuse = |why: &str| {
        Err(Error::scene(format!(
            "an image of {width} x {height} pixels {why}"
        )))
    };
    if width == 0 || height == 0 {
        return refuse("is empty");
    }
    if width > MAX_SIDE || height > MAX_SIDE || width * height > MAX_PIXELS {
        return refuse(&format!(
            "is too large: at most {MAX_SIDE} a side and {MAX_PIXELS} in all"
        ));
    }
    if width * height > MAX_PIXELS_PER_BYTE * bytes {
        return refuse(&format!("does not fit in {bytes} bytes"));
    }
    let memory = (width * height) as u64 * BYTES_PER_PIXEL;
    memory::check(memory, || format!("an image of {width} x {height} pixels"))?;
    Ok((width as u32, height as u32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ErrorKind;
    use proptest::prelude::*;

    /// An image with every kind of pixel that a render has.
    pub(super) fn sample_image() -> Image {
        let pixels = (0..13 * 7)
            .map(|i| {
                let t = i as f32 / 91.0;
                Rgb::new(t, 40.0 * t * t, (0.5 - t).max(0.0))
            })
            .collect();
        Image::new(13, 7, pixels)
    }

    /// The bytes of the sample in every format that is written.
    fn encoded() -> Vec<Vec<u8>> {
        let folder = tempfile::tempdir().expect("a folder");
        ["exr", "png", "hdr", "pfm"]
            .iter()
            .map(|extension| {
                let path = folder.path().join("a").with_extension(extension);
                write(&path, &sample_image(), &WriteOptions::default()).expect("written");
                std::fs::read(path).expect("read")
            })
            .collect()
    }

    /// The bytes of images in the formats that are read only.
    fn read_only() -> [Vec<u8>; 3] {
        [
            jpeg::tests::square(),
            tga::tests::colours(),
            raster::tests::bmp(),
        ]
    }

    #[test]
    fn image_mean_averages_each_channel_over_all_pixels() {
        let image = Image::new(2, 1, vec![Rgb::new(0.0, 1.0, 2.0), Rgb::new(1.0, 1.0, 4.0)]);
        assert_eq!(image.mean(), [0.5, 1.0, 3.0]);
    }

    #[test]
    fn unreadable_file_is_io_error_and_invalid_image_scene_error() {
        let folder = tempfile::tempdir().expect("a folder");
        let missing = Image::read(&folder.path().join("missing.png"), ColourSpace::Srgb)
            .expect_err("missing");
        assert_eq!(missing.kind(), ErrorKind::Io);
        let is_folder = Image::read(folder.path(), ColourSpace::Srgb).expect_err("a folder");
        assert_eq!(is_folder.kind(), ErrorKind::Io);

        let text = folder.path().join("text.png");
        std::fs::write(&text, "no image").expect("written");
        let no_picture = Image::read(&text, ColourSpace::Srgb).expect_err("text");
        assert_eq!(no_picture.kind(), ErrorKind::Scene);
        assert_eq!(no_picture.file(), Some(text.as_path()));
    }

    #[test]
    fn non_finite_pixel_is_rejected_with_its_coordinates() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut image = sample_image();
        image.pixels_mut()[13 * 2 + 5] = Rgb::new(0.0, f32::NAN, 0.0);
        for name in ["a.exr", "a.pfm"] {
            let path = folder.path().join(name);
            write(&path, &image, &WriteOptions::default()).expect("written");
            let error = Image::read(&path, ColourSpace::Srgb).expect_err("not a number");
            assert_eq!(error.kind(), ErrorKind::Scene);
            assert!(error.to_string().contains("pixel (5, 2)"), "{error}");
        }
    }

    #[test]
    fn out_of_range_image_sizes_are_rejected() {
        for (width, height) in [(0, 1), (1, 0), (65537, 1), (1, usize::MAX), (65536, 65536)] {
            assert!(
                checked_size(width, height, 1 << 30).is_err(),
                "{width} x {height}"
            );
        }
        assert!(checked_size(65536, 4096, 1 << 10).is_err());
        assert_eq!(
            checked_size(65536, 4096, 1 << 30).expect("allowed"),
            (65536, 4096)
        );
    }

    #[test]
    fn truncated_image_files_are_rejected() {
        for bytes in encoded().into_iter().chain(read_only()) {
            for length in [bytes.len() / 2, bytes.len() - bytes.len() / 4, 20, 5] {
                let error = Image::decode(&bytes[..length], ColourSpace::Srgb);
                assert_eq!(error.expect_err("cut").kind(), ErrorKind::Scene);
            }
        }
    }

    proptest! {
        #[test]
        fn arbitrary_bytes_after_any_signature_do_not_panic(
            signature in prop::sample::select(vec![
                &b"\x89PNG\r\n\x1a\n"[..], b"\xFF\xD8\xFF", b"#?RADIANCE\n", b"\x76\x2F\x31\x01\x02\0\0\0", b"PF\n", b"BM",
                b"BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0",
                b"\0\0\x0a\0\0\0\0\0\0\0\0\0\x04\0\x04\0\x18\0",
                b"\0\x01\x09\0\0\x04\0\x18\0\0\0\0\x04\0\x04\0\x08\0", b"",
            ]),
            rest in prop::collection::vec(any::<u8>(), 0..300),
        ) {
            let bytes = [signature, &rest].concat();
            let _ = Image::decode(&bytes, ColourSpace::Srgb);
            let _ = LayeredImage::decode(&bytes, ColourSpace::Srgb);
        }

        #[test]
        fn damaged_files_do_not_panic(
            damages in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        ) {
            for mut bytes in encoded().into_iter().chain(read_only()) {
                for (place, value) in &damages {
                    let place = place.index(bytes.len());
                    bytes[place] = *value;
                }
                let _ = Image::decode(&bytes, ColourSpace::Srgb);
                let _ = LayeredImage::decode(&bytes, ColourSpace::Srgb);
            }
        }
    }
}
