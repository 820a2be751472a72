//! The bytes that a glTF file refers to: buffers and images, in the file itself, in `data:` URIs and in other files.
//!
//! Measure: bytes.
//! Range: URIs of files are relative to the glTF file; other schemes than `data:` are errors.
//! Source: glTF 2.0, chapter 3.6; RFC 2397 and RFC 3986. Tested in `tests/loading/gltf_bad.rs`.

use super::super::wording::shown;
use super::super::{beside, read_bytes};
use super::container::Container;
use crate::error::{Error, Result};
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::Document;
use percent_encoding::percent_decode_str;
use std::borrow::Cow;
use std::path::Path;

/// Base 64 with padding or without: exporters write both.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// A glTF file with the bytes of its buffers.
pub struct Asset<'a> {
    /// The file.
    pub path: &'a Path,
    pub document: Document,
    buffers: Vec<Cow<'a, [u8]>>,
}

impl<'a> Asset<'a> {
    /// Reads the buffers of a file.
    ///
    /// # Errors
    /// If a buffer cannot be read, or is shorter than the file says.
    pub fn read(path: &'a Path, container: Container<'a>) -> Result<Self> {
        let mut buffers = Vec::with_capacity(container.document.buffers().len());
        for buffer in container.document.buffers() {
            let bytes = match buffer.source() {
                gltf::buffer::Source::Uri(uri) => read_uri(path, uri),
                gltf::buffer::Source::Bin => container.bin.map(Cow::Borrowed).ok_or_else(|| {
                    Error::scene("expected a uri: there is no binary chunk with this buffer")
                }),
            };
            let (needed, index) = (buffer.length(), buffer.index());
            let bytes = bytes.and_then(|bytes| {
                let found = bytes.len();
                if found >= needed {
                    return Ok(bytes);
                }
                Err(Error::scene(format!(
                    "expected {needed} bytes, found {found}"
                )))
            });
            buffers.push(bytes.map_err(|error| named(error, path, &format!("buffers[{index}]")))?);
        }
        Ok(Self {
            path,
            document: container.document,
            buffers,
        })
    }

    /// Returns an error about a part of the JSON, such as `accessors[3]`.
    pub fn error(&self, field: impl Into<String>, message: impl Into<String>) -> Error {
        Error::scene(message).in_file(self.path).in_field(field)
    }

    /// Wraps an error about something that a part of the JSON refers to.
    pub fn within(&self, error: Error, field: &str) -> Error {
        named(error, self.path, field)
    }

    /// The number of bytes of all buffers.
    pub fn size(&self) -> usize {
        self.buffers.iter().map(|bytes| bytes.len()).sum()
    }

    /// Returns the bytes of a view.
    ///
    /// # Errors
    /// If they are not within the view's buffer.
    pub fn view(&self, view: &gltf::buffer::View<'_>) -> Result<&[u8]> {
        let buffer = &self.buffers[view.buffer().index()];
        let (start, length) = (view.offset(), view.length());
        let end = start.checked_add(length);
        end.and_then(|end| buffer.get(start..end)).ok_or_else(|| {
            self.error(
                format!("bufferViews[{}]", view.index()),
                format!(
                    "expected {length} bytes from byte {start} on, but the buffer has {}",
                    buffer.len()
                ),
            )
        })
    }

    /// Returns the bytes of an image file.
    ///
    /// # Errors
    /// If they cannot be read.
    pub fn image(&self, index: usize) -> Result<Cow<'_, [u8]>> {
        let image = &self.document.as_json().images[index];
        if let Some(view) = image.buffer_view {
            let view = self.document.views().nth(view.value());
            let view = view.ok_or_else(|| Error::scene("expected the index of a buffer view"))?;
            return self.view(&view).map(Cow::Borrowed);
        }
        match &image.uri {
            Some(uri) => read_uri(self.path, uri),
            None => Err(Error::scene("expected a uri or a buffer view")),
        }
    }
}

/// Puts the place in the glTF file before an error about what it refers to.
fn named(error: Error, path: &Path, field: &str) -> Error {
    if error.file() == Some(path) {
        return error;
    }
    let kind = error.kind();
    Error::scene(error.to_string())
        .of_kind(kind)
        .in_file(path)
        .in_field(field)
}

/// Reads what a URI refers to; `path` is the file that contains it.
fn read_uri(path: &Path, uri: &str) -> Result<Cow<'static, [u8]>> {
    if let Some(data) = uri.strip_prefix("data:") {
        return decode(data).map(Cow::Owned);
    }
    let scheme = uri.split_once(':').map(|(scheme, _)| scheme);
    // A drive letter is no scheme.
    if let Some(scheme) = scheme.filter(|it| it.len() > 1 && !it.contains(['/', '.', '%'])) {
        let scheme = shown(scheme);
        return Err(Error::scene(format!(
            "expected the path of a file or a data: URI, found one of the scheme `{scheme}`"
        )));
    }
    let name = percent_decode_str(uri).decode_utf8();
    let name = name.map_err(|_| Error::scene("expected the path of a file in UTF-8"))?;
    read_bytes(&beside(path, &name)).map(Cow::Owned)
}

/// Decodes what follows `data:`.
fn decode(data: &str) -> Result<Vec<u8>> {
    let (kind, content) = data
        .split_once(',')
        .ok_or_else(|| Error::scene("expected a comma in the data: URI"))?;
    if !kind.ends_with(";base64") {
        return Ok(percent_decode_str(content).collect());
    }
    BASE64
        .decode(content)
        .map_err(|error| Error::scene(format!("expected base 64 in the data: URI: {error}")))
}
