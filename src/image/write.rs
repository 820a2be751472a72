//! Writing an image in the format of its file name's extension.
//!
//! Measure: pixels are linear; `exposure` is in stops.
//! Range: `.exr`, `.png`, `.hdr` and `.pfm` in any case; another extension is an error of usage that lists them.
//! Source: one file a format. Tested below and in each format's file.

use super::atomic::{check_creatable, write_atomically};
use super::options::WriteOptions;
use super::{Image, exr, hdr, pfm, png};
use crate::error::{Error, Result};
use std::path::Path;

/// The formats that are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum OutputFormat {
    Exr,
    Png,
    Hdr,
    Pfm,
}

impl OutputFormat {
    fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().unwrap_or_default();
        match extension.to_ascii_lowercase().to_str() {
            Some("exr") => Ok(Self::Exr),
            Some("png") => Ok(Self::Png),
            Some("hdr") => Ok(Self::Hdr),
            Some("pfm") => Ok(Self::Pfm),
            _ => Err(Error::usage(format!(
                "cannot write an image as \"{}\": expected a name that ends in .exr, .png, .hdr or .pfm",
                path.display()
            ))),
        }
    }
}

/// Writes `image` to `path` atomically, in the format of its extension.
///
/// # Panics
///
/// If a layer does not have one sample per pixel.
pub fn write(path: &Path, image: &Image, options: &WriteOptions) -> Result<()> {
    let format = OutputFormat::of(path)?;
    for layer in &options.layers {
        assert_eq!(
            layer.samples.len(),
            image.pixels().len(),
            "layer {} has one sample a pixel",
            layer.name
        );
    }
    write_atomically(path, |writer| match format {
        OutputFormat::Exr => exr::encode(writer, image, options),
        OutputFormat::Png => png::encode(writer, image, options.exposure, &[]),
        OutputFormat::Hdr => hdr::encode(writer, image),
        OutputFormat::Pfm => pfm::encode(writer, image),
    })
}

/// Checks that [`write()`] could write to `path` now, to fail before a long render. Leaves no new file behind and an
/// existing file unchanged.
pub fn check_writable(path: &Path) -> Result<()> {
    OutputFormat::of(path)?;
    check_creatable(path)
}

#[cfg(test)]
mod tests {
    use super::super::ColourSpace;
    use super::super::tests::sample_image;
    use super::*;
    use crate::ErrorKind;

    #[test]
    fn every_extension_round_trips_the_image_size() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["a.exr", "a.EXR", "a.png", "a.hdr", "a.pfm"] {
            let path = folder.path().join(name);
            write(&path, &sample_image(), &WriteOptions::default()).expect("written");
            let read = Image::read(&path, ColourSpace::Srgb).expect("read");
            assert_eq!((read.width(), read.height()), (13, 7), "{name}");
        }
    }

    #[test]
    fn unknown_extension_is_rejected_without_writing_a_file() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["a.tiff", "a", "exr"] {
            let path = folder.path().join(name);
            for result in [
                write(&path, &sample_image(), &WriteOptions::default()),
                check_writable(&path),
            ] {
                let error = result.expect_err("unknown");
                assert_eq!(error.kind(), ErrorKind::Usage);
                assert!(error.to_string().contains(".exr, .png, .hdr or .pfm"));
            }
        }
        assert_eq!(folder.path().read_dir().expect("a folder").count(), 0);
    }
}
