//! Pictures in memory and in files.
//!
//! Measure: linear Rec. 709; row 0 is the top one.
//! Range: sides of 1 to [`LARGEST_SIDE`] pixels; a picture that is read has finite values only.
//! Source: one file a format. Tested there and in `tests/bad_input.rs`.

mod atomic;
mod exr;
pub mod metrics;
mod pfm;
mod raster;
pub mod srgb;

pub use atomic::{check_place, write_atomically};

use crate::error::{Error, ErrorKind, Result};
use crate::math::rgb::Rgb;
use std::path::Path;

/// The longest side of a picture that is read or written, in pixels.
pub const LARGEST_SIDE: u32 = 65_536;

/// A picture of linear colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<Rgb>,
}

/// How the values of an 8-bit or 16-bit file are meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum ColourSpace {
    /// Encoded with the sRGB transfer function.
    #[default]
    Srgb,
    /// As they are.
    Linear,
}

/// A further channel of an EXR file.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// The channel's whole name, such as `albedo.R`.
    pub name: String,
    /// One value a pixel.
    pub samples: Vec<f32>,
}

/// A fact that an EXR file states of itself.
#[derive(Debug, Clone, PartialEq)]
pub enum MetadataValue {
    /// Words.
    Text(String),
    /// A number.
    Number(f64),
}

/// What goes into a file beside the picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WriteOptions {
    /// Stops; a PNG shows the picture times 2^exposure. Other formats keep the values.
    pub exposure: f32,
    /// Facts for formats that have room for them: EXR.
    pub metadata: Vec<(String, MetadataValue)>,
    /// Further channels for formats that have room for them: EXR.
    pub layers: Vec<Layer>,
}

/// The formats that are written, by their extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Exr,
    Png,
    Hdr,
    Pfm,
}

impl Image {
    /// A picture of these pixels, row by row from the top.
    ///
    /// # Panics
    /// If their number is not width x height.
    pub fn new(width: u32, height: u32, pixels: Vec<Rgb>) -> Self {
        assert_eq!(pixels.len(), width as usize * height as usize);
        Self {
            width,
            height,
            pixels,
        }
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> &[Rgb] {
        &self.pixels
    }

    /// The pixel in column `x` of row `y`.
    #[inline]
    pub fn get(&self, x: u32, y: u32) -> Rgb {
        self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// Reads a picture: PNG, JPEG, Radiance HDR, EXR or PFM, told apart by how they begin. `space` says how 8-bit and
    /// 16-bit values are meant; the others are linear.
    ///
    /// # Errors
    /// A file that cannot be read, that is no picture, or that has values which are not finite.
    pub fn read(path: &Path, space: ColourSpace) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|error| Error::io("cannot read", path, error))?;
        let image = match bytes.as_slice() {
            [0x76, 0x2f, 0x31, 0x01, ..] => exr::decode(&bytes),
            [b'P', b'F', ..] => pfm::decode(&bytes),
            _ => raster::decode(&bytes, space),
        };
        let image = image.map_err(|why| Error::scene(why).in_file(path))?;
        match image.pixels.iter().position(|pixel| !pixel.is_finite()) {
            None => Ok(image),
            Some(index) => {
                let (x, y) = (index as u32 % image.width, index as u32 / image.width);
                let why = format!("the pixel in column {x} of row {y} is not a finite number");
                Err(Error::scene(why).in_file(path))
            }
        }
    }
}

/// Writes a picture in the format of the file's extension: whole, or not at all.
///
/// # Errors
/// An extension that is not known, or a file that cannot be written.
pub fn write(path: &Path, image: &Image, options: &WriteOptions) -> Result<()> {
    let format = Format::of(path)?;
    atomic::write_atomically(path, |file| match format {
        Format::Exr => exr::encode(image, options, file),
        Format::Png => raster::encode_png(image, options.exposure, file),
        Format::Hdr => raster::encode_hdr(image, file),
        Format::Pfm => pfm::encode(image, file),
    })
}

/// Whether [`write`] will be able to write there: known before hours of rendering.
///
/// # Errors
/// An extension that is not known, or a folder that nothing can be written to.
pub fn check_writable(path: &Path) -> Result<()> {
    Format::of(path)?;
    check_place(path)
}

impl Format {
    fn of(path: &Path) -> Result<Self> {
        let extension = path
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .to_lowercase();
        match extension.as_str() {
            "exr" => Ok(Self::Exr),
            "png" => Ok(Self::Png),
            "hdr" => Ok(Self::Hdr),
            "pfm" => Ok(Self::Pfm),
            _ => Err(Error::new(
                ErrorKind::Usage,
                "expected an image file that ends in .exr, .png, .hdr or .pfm",
            )
            .in_file(path)),
        }
    }
}

/// The sides that a file declares, if they are such that a picture can have.
fn checked_size(width: usize, height: usize) -> std::result::Result<(u32, u32), String> {
    let side = |length: usize| {
        u32::try_from(length)
            .ok()
            .filter(|side| (1..=LARGEST_SIDE).contains(side))
    };
    match (side(width), side(height)) {
        (Some(width), Some(height)) => Ok((width, height)),
        _ => Err(format!(
            "a picture of {width} x {height} pixels; expected sides from 1 to {LARGEST_SIDE}"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Image {
        let colour = |i: u32| Rgb::new(0.1 * i as f32, 1.0 / (1.0 + i as f32), 3.5);
        Image::new(5, 3, (0..15).map(colour).collect())
    }

    fn round_trip(name: &str, options: &WriteOptions) -> Image {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join(name);
        write(&path, &sample(), options).expect("the folder is writable");
        assert_eq!(
            std::fs::read_dir(folder.path()).expect("it exists").count(),
            1
        );
        Image::read(&path, ColourSpace::Srgb).expect("it was just written")
    }

    #[test]
    fn exact_formats_come_back_exactly() {
        let options = WriteOptions {
            exposure: 3.0,
            metadata: vec![
                (
                    "etendue.seed".to_owned(),
                    MetadataValue::Text("7".to_owned()),
                ),
                ("etendue.seconds".to_owned(), MetadataValue::Number(1.5)),
            ],
            layers: vec![Layer {
                name: "depth.Z".to_owned(),
                samples: vec![2.0; 15],
            }],
        };
        for name in ["a.exr", "a.pfm", "a.EXR"] {
            assert_eq!(round_trip(name, &options), sample(), "{name}");
        }
    }

    #[test]
    fn hdr_keeps_a_shared_exponent_and_png_eight_bits() {
        for (got, want) in round_trip("a.hdr", &WriteOptions::default())
            .pixels()
            .iter()
            .zip(sample().pixels())
        {
            let (got, want) = (got.to_array(), want.to_array());
            assert!(
                (0..3).all(|c| (got[c] - want[c]).abs() <= 3.5 / 128.0),
                "{got:?} {want:?}"
            );
        }
        let options = WriteOptions {
            exposure: -2.0,
            ..WriteOptions::default()
        };
        for (got, want) in round_trip("a.png", &options)
            .pixels()
            .iter()
            .zip(sample().pixels())
        {
            let code = |x: f32| srgb::encode(x) * 255.0;
            let (got, want) = (got.to_array(), want.to_array());
            assert!((0..3).all(|c| (code(got[c]) - code(0.25 * want[c])).abs() <= 0.501));
        }
    }

    #[test]
    fn what_is_no_picture_is_refused_in_words() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("not.png");
        for bytes in [
            &b""[..],
            b"hello",
            b"PF\n2 2\n-1\nxx",
            b"PF\n99999999 1\n-1\n",
            b"\x89PNG\r\n\x1a\n",
            b"\x76\x2f\x31\x01\x02\0\0\0",
        ] {
            std::fs::write(&path, bytes).expect("the folder is writable");
            let error = Image::read(&path, ColourSpace::Srgb).expect_err("this is no picture");
            assert_eq!(error.kind(), ErrorKind::Scene, "{error}");
            assert!(error.to_string().contains("not.png"));
        }
        let missing = Image::read(&folder.path().join("none.png"), ColourSpace::Srgb);
        assert_eq!(missing.expect_err("it is missing").kind(), ErrorKind::Io);
    }

    #[test]
    fn a_pixel_that_is_not_finite_is_named() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("nan.pfm");
        let mut pixels = sample().pixels().to_vec();
        pixels[7] = Rgb::grey(f32::NAN);
        write(&path, &Image::new(5, 3, pixels), &WriteOptions::default()).expect("writable");
        let error = Image::read(&path, ColourSpace::Linear).expect_err("there is a NaN");
        assert!(error.to_string().contains("column 2 of row 1"), "{error}");
    }

    #[test]
    fn an_unknown_extension_is_a_usage_error() {
        let error = check_writable(Path::new("a.bmp")).expect_err("bmp is not written");
        assert_eq!(error.kind(), ErrorKind::Usage);
    }

    proptest::proptest! {
        #[test]
        fn no_bytes_make_reading_panic(bytes in proptest::collection::vec(proptest::num::u8::ANY, 0..200), kind in 0..5_usize) {
            let heads: [&[u8]; 5] = [b"", b"PF\n3 2\n-1.0\n", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", b"#?RADIANCE\n", b"\x76\x2f\x31\x01"];
            let all = [heads[kind], &bytes].concat();
            let _ = raster::decode(&all, ColourSpace::Srgb);
            let _ = pfm::decode(&all);
            let _ = exr::decode(&all);
        }
    }
}
