//! An image with the further channels and the metadata of its file.
//!
//! Measure: the image is linear Rec. 709; each layer has its own unit.
//! Range: the image is finite, a layer need not be (a depth of infinity). Only OpenEXR has layers and metadata; of a
//! file with several parts, those of the part with the image.
//! Source: `image/exr_layers.rs`. Tested there and below.

use super::exr_layers::FACT_PREFIX;
use super::{ColourSpace, Image, Layer, MetadataValue, exr, exr_layers, file_bytes};
use crate::error::{Error, Result};
use std::path::{Path, PathBuf};

/// An image, its layers and its metadata.
#[derive(Debug, Clone, PartialEq)]
pub struct LayeredImage {
    /// The image.
    pub image: Image,
    /// Further channels, with the names that they have in the file.
    pub layers: Vec<Layer>,
    /// Metadata whose names begin with `etendue.`: those that `render` writes.
    pub metadata: Vec<(String, MetadataValue)>,
    /// The file that it was read from, for messages.
    pub file: Option<PathBuf>,
}

impl LayeredImage {
    /// Reads any file that [`Image::read`] reads, with the same errors.
    pub fn read(path: &Path, space: ColourSpace) -> Result<Self> {
        let read = Self::decode(&file_bytes(path)?, space);
        let mut read = read.map_err(|error| error.in_file(path))?;
        read.file = Some(path.to_path_buf());
        Ok(read)
    }

    /// Decodes the bytes of a file as [`read`](Self::read) does.
    pub fn decode(bytes: &[u8], space: ColourSpace) -> Result<Self> {
        if exr::is_one(bytes) {
            let contents = exr_layers::decode(bytes)?;
            Ok(Self {
                image: contents.image.checked_finite()?,
                layers: contents.layers,
                metadata: contents.metadata,
                file: None,
            })
        } else {
            Image::decode(bytes, space).map(Self::from)
        }
    }

    /// The samples of a layer, row by row from the top; `None` if there is none of this name.
    pub fn layer(&self, name: &str) -> Option<&[f32]> {
        let found = self.layers.iter().find(|layer| layer.name == name);
        found.map(|layer| layer.samples.as_slice())
    }

    /// The samples of several layers, all of which are required.
    ///
    /// # Errors
    /// If a layer is missing; the message says which one, and how to make it.
    pub fn required_layers<const N: usize>(&self, names: [&str; N]) -> Result<[&[f32]; N]> {
        let mut found = [&[] as &[f32]; N];
        for (samples, name) in found.iter_mut().zip(names) {
            *samples = self.layer(name).ok_or_else(|| {
                let error = Error::scene(format!(
                    "has no layer `{name}`: expected an EXR that was written by \
                     `etendue render --layers`"
                ));
                match &self.file {
                    Some(file) => error.in_file(file),
                    None => error,
                }
            })?;
        }
        Ok(found)
    }

    /// The metadata value with this name, such as `seed`, without the prefix `etendue.`.
    pub fn fact(&self, name: &str) -> Option<&MetadataValue> {
        let is_it = |full: &str| full.strip_prefix(FACT_PREFIX) == Some(name);
        let found = self.metadata.iter().find(|(full, _)| is_it(full));
        found.map(|(_, value)| value)
    }
}

impl From<Image> for LayeredImage {
    /// Builds an image without layers or metadata.
    fn from(image: Image) -> Self {
        Self {
            image,
            layers: Vec::new(),
            metadata: Vec::new(),
            file: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::sample_image;
    use super::super::{WriteOptions, write};
    use super::*;
    use crate::ErrorKind;

    #[test]
    fn missing_layer_error_names_layer_and_file_in_every_format() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["a.exr", "a.png", "a.hdr", "a.pfm"] {
            let path = folder.path().join(name);
            write(&path, &sample_image(), &WriteOptions::default()).expect("written");
            let read = LayeredImage::read(&path, ColourSpace::Srgb).expect("an image");
            let alone = Image::read(&path, ColourSpace::Srgb).expect("an image");
            assert_eq!(read.image, alone);
            let missing = read.required_layers(["se.R"]).expect_err("no layers");
            assert_eq!(missing.kind(), ErrorKind::Scene);
            assert_eq!(missing.file(), Some(path.as_path()));
            for word in ["se.R", "etendue render --layers"] {
                assert!(missing.to_string().contains(word), "{missing}");
            }
        }
    }
}
