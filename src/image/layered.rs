//! A picture with what its file holds beside it: further channels and facts about the render.
//!
//! Measure: of the picture linear Rec. 709; of a layer whatever it holds.
//! Range: the picture is finite, a layer need not be (a depth of infinity). Only OpenEXR has layers and facts; of a file with
//! several parts, those of the part that the picture is in.
//! Source: `image/exr_layers.rs`. Tested there and below.

use super::exr_layers::FACT_PREFIX;
use super::{ColourSpace, Image, Layer, MetadataValue, exr, exr_layers, file_bytes};
use crate::error::{Error, Result};
use std::path::{Path, PathBuf};

/// A picture, its layers and what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct LayeredImage {
    /// The picture.
    pub image: Image,
    /// Further channels, with the names that they have in the file.
    pub layers: Vec<Layer>,
    /// Facts whose names begin with `etendue.`: those that `render` writes.
    pub metadata: Vec<(String, MetadataValue)>,
    /// Where it was read from, for messages.
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

    /// The same from the bytes of a file.
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

    /// The samples of layers that something cannot do without.
    ///
    /// # Errors
    /// If one is missing: which one, and how to make it.
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

    /// One fact about the picture, such as `seed`, without `etendue.` before its name.
    pub fn fact(&self, name: &str) -> Option<&MetadataValue> {
        let is_it = |full: &str| full.strip_prefix(FACT_PREFIX) == Some(name);
        let found = self.metadata.iter().find(|(full, _)| is_it(full));
        found.map(|(_, value)| value)
    }
}

impl From<Image> for LayeredImage {
    /// A picture alone.
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
    fn every_format_is_read_and_a_missing_layer_is_named_with_its_file() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["a.exr", "a.png", "a.hdr", "a.pfm"] {
            let path = folder.path().join(name);
            write(&path, &sample_image(), &WriteOptions::default()).expect("written");
            let read = LayeredImage::read(&path, ColourSpace::Srgb).expect("a picture");
            let alone = Image::read(&path, ColourSpace::Srgb).expect("a picture");
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
