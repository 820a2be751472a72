//! The outer layers of a glTF file: the chunks of a GLB, the JSON, and the extensions that it requires.
//!
//! Measure: bytes.
//! Range: version 2 of both; a file that requires an extension that is not read here is refused.
//! Source: glTF 2.0, chapters 3.12 and 4. Tested in `tests/loading/gltf_bad.rs`.

use super::super::wording::shown;
use super::animations::without_animations;
use crate::error::{Error, Result};
use gltf::Document;
use gltf::json::validation::{self, Validate};
use gltf::json::{Root, deserialize};
use serde::Deserialize;

/// The extensions that a file may require.
const READ: &[&str] = &[
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Extensions that are not needed for the same image.
const WITHOUT_EFFECT: &[&str] = &[
    "FB_ngon_encoding",
    "KHR_materials_variants",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// The parts of a file.
#[derive(Debug, PartialEq, Eq)]
struct Chunks<'a> {
    json: &'a [u8],
    /// The binary chunk of a GLB: its first buffer.
    bin: Option<&'a [u8]>,
}

/// The fields that have to be known before the JSON is read as a whole.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Head {
    asset: AssetInfo,
    #[serde(default)]
    extensions_required: Vec<String>,
    #[serde(default)]
    extensions_used: Vec<String>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct AssetInfo {
    version: String,
    min_version: Option<String>,
}

/// A file whose JSON is valid: every index in it is in range.
#[derive(Debug)]
pub struct Container<'a> {
    pub document: Document,
    /// The binary chunk of a GLB.
    pub bin: Option<&'a [u8]>,
    /// The extensions that the file uses and that are not read.
    pub not_read: Vec<String>,
    /// Whether the file has animations that could not be read; the document is without them.
    pub has_odd_animations: bool,
}

impl<'a> Container<'a> {
    /// Parses a file.
    ///
    /// # Errors
    /// If it is not a valid glTF 2.0 file, or requires an extension that is not read.
    pub fn parse(bytes: &'a [u8]) -> Result<Self> {
        let is_binary = bytes.starts_with(b"glTF");
        let chunks = if is_binary {
            split(bytes)?
        } else {
            Chunks {
                json: bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes),
                bin: None,
            }
        };
        let not_json = |error: gltf::json::Error| {
            let message = shown(&error.to_string());
            if is_binary {
                Error::scene(format!("expected JSON of glTF: {message}")).in_field("JSON chunk")
            } else {
                Error::scene(format!("expected JSON of glTF: {message}")).at_line(error.line())
            }
        };
        let head: Head = deserialize::from_slice(chunks.json).map_err(not_json)?;
        check_version(&head.asset)?;
        let is_read = |name: &&String| {
            let name = name.as_str();
            READ.contains(&name) || WITHOUT_EFFECT.contains(&name)
        };
        if let Some(name) = head.extensions_required.iter().find(|name| !is_read(name)) {
            return Err(Error::scene(format!(
                "the file requires the extension {}, which is not read",
                shown(name)
            ))
            .in_field("extensionsRequired"));
        }
        let is_missed = |name: &String| !is_read(&name);
        let not_read = head.extensions_used.into_iter().filter(is_missed);
        let read = |json: &[u8]| {
            let root: Root = deserialize::from_slice(json).map_err(not_json)?;
            check(&root).map(|()| root)
        };
        let (root, has_odd_animations) = match read(chunks.json) {
            Ok(root) => (root, false),
            // Only if the animations are at fault, the rest can be read.
            Err(error) => match without_animations(chunks.json)? {
                Some(rest) => (read(&rest)?, true),
                None => return Err(error),
            },
        };
        Ok(Self {
            document: Document::from_json_without_validation(root),
            bin: chunks.bin,
            not_read: not_read.collect(),
            has_odd_animations,
        })
    }
}

fn check_version(asset: &AssetInfo) -> Result<()> {
    let needed = asset.min_version.as_ref().unwrap_or(&asset.version);
    if needed.starts_with("2.") && (asset.min_version.is_none() || needed == "2.0") {
        return Ok(());
    }
    let found = shown(needed);
    Err(Error::scene(format!("expected glTF 2.0, found version {found}")).in_field("asset.version"))
}

/// Checks that every index and every value of the JSON is in range.
fn check(root: &Root) -> Result<()> {
    check_attributes(root)?;
    let mut first = None;
    root.validate(root, gltf::json::Path::new, &mut |path, error| {
        if first.is_none() {
            first = Some((path().to_string(), error)).filter(|(path, _)| !is_tolerated(path));
        }
    });
    match first {
        None => Ok(()),
        Some((path, error)) => {
            let message = match (error, objects_at(root, &path)) {
                (validation::Error::IndexOutOfBounds, Some((0, objects))) => {
                    format!("expected no index, as the file has no {objects}")
                }
                (validation::Error::IndexOutOfBounds, Some((count, objects))) => {
                    format!("expected an index below {count}, the number of {objects}")
                }
                _ => format!("not valid: {}", error.to_string().to_lowercase()),
            };
            Err(Error::scene(message).in_field(shown(&path)))
        }
    }
}

/// The number and the name of the objects to which the index at a path of the JSON refers.
fn objects_at(root: &Root, path: &str) -> Option<(usize, &'static str)> {
    let key = path.rsplit('.').next()?.split('[').next()?;
    Some(match key {
        "bufferView" => (root.buffer_views.len(), "buffer views"),
        "buffer" => (root.buffers.len(), "buffers"),
        "camera" => (root.cameras.len(), "cameras"),
        "children" | "nodes" | "node" => (root.nodes.len(), "nodes"),
        "index" => (root.textures.len(), "textures"),
        "indices" => (root.accessors.len(), "accessors"),
        "material" => (root.materials.len(), "materials"),
        "mesh" => (root.meshes.len(), "meshes"),
        "scene" => (root.scenes.len(), "scenes"),
        "skin" => (root.skins.len(), "skins"),
        "source" => (root.images.len(), "images"),
        _ => return None,
    })
}

/// Checks the accessors of primitives, on which the crate's own check relies.
fn check_attributes(root: &Root) -> Result<()> {
    let count = root.accessors.len();
    for (mesh, primitives) in root.meshes.iter().map(|it| &it.primitives).enumerate() {
        for (primitive, attributes) in primitives.iter().map(|it| &it.attributes).enumerate() {
            let wrong = attributes.values().find(|it| it.value() >= count);
            if let Some(accessor) = wrong.map(|it| it.value()) {
                let message = format!("expected one of {count} accessors, found {accessor}");
                let field = format!("meshes[{mesh}].primitives[{primitive}].attributes");
                return Err(Error::scene(message).in_field(field));
            }
        }
    }
    Ok(())
}

/// Whether nothing depends on what is not valid at this place: bounds that are missing, attributes of an application's
/// own, and extensions, which are checked before, as the crate knows fewer of them.
fn is_tolerated(path: &str) -> bool {
    path.starts_with("extensionsRequired")
        || path.ends_with("attributes[\"POSITION\"].min")
        || path.ends_with("attributes[\"POSITION\"].max")
        || path.ends_with("attributes[\"<invalid semantic name>\"]")
}

/// Splits a GLB into its chunks.
fn split(bytes: &[u8]) -> Result<Chunks<'_>> {
    let number = |at: usize| {
        let four = bytes.get(at..at + 4)?.first_chunk()?;
        Some(u32::from_le_bytes(*four))
    };
    let at_byte = |at: usize, message: String| Error::scene(format!("at byte {at}: {message}"));
    let ends = |at: usize, what: &str| {
        let length = bytes.len();
        at_byte(
            at,
            format!("expected {what}, but the file has {length} bytes"),
        )
    };
    let version = number(4).ok_or_else(|| ends(4, "the version of the container"))?;
    if version != 2 {
        return Err(at_byte(4, format!("expected version 2, found {version}")));
    }
    let length = number(8).ok_or_else(|| ends(8, "the length of the file"))? as usize;
    if length > bytes.len() {
        return Err(ends(8, &format!("a file of {length} bytes")));
    }
    let chunk = |at: usize, kind: &[u8; 4]| {
        let what = || {
            String::from_utf8_lossy(kind)
                .trim_end_matches('\0')
                .to_owned()
        };
        let size = number(at).ok_or_else(|| ends(at, &format!("the chunk {}", what())))?;
        let found = bytes.get(at + 4..at + 8);
        if found != Some(kind) {
            return Err(at_byte(at + 4, format!("expected the chunk {}", what())));
        }
        let content = bytes.get(at + 8..at + 8 + size as usize);
        content.ok_or_else(|| ends(at, &format!("a chunk {} of {size} bytes", what())))
    };
    let json = chunk(12, b"JSON")?;
    let next = 20 + json.len();
    // Chunks after these two are to be ignored.
    let bin = (next < length).then(|| chunk(next, b"BIN\0")).transpose()?;
    Ok(Chunks { json, bin })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(json: &[u8], bin: &[u8]) -> Vec<u8> {
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend((28 + json.len() as u32 + bin.len() as u32).to_le_bytes());
        for (kind, content) in [(b"JSON", json), (b"BIN\0", bin)] {
            bytes.extend((content.len() as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(content);
        }
        bytes
    }

    #[test]
    fn glb_is_split_into_chunks_and_truncation_is_rejected() {
        let bytes = glb(b"{}  ", &[1, 2, 3, 4]);
        let chunks = split(&bytes).expect("whole");
        assert_eq!(chunks.json, b"{}  ");
        assert_eq!(chunks.bin, Some(&[1_u8, 2, 3, 4][..]));
        for length in 4..bytes.len() {
            let error = split(&bytes[..length]).expect_err("cut off");
            assert!(error.to_string().contains("at byte"), "{error}");
        }
    }

    #[test]
    fn wrong_glb_version_or_chunk_size_is_rejected() {
        for (at, value) in [(4, 1_u32), (12, u32::MAX), (12, 3), (24, 5), (24, u32::MAX)] {
            let mut bytes = glb(b"{}  ", &[1, 2, 3, 4]);
            bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
            let length = bytes.len();
            bytes[8..12].copy_from_slice(&(length as u32).to_le_bytes());
            assert!(split(&bytes).is_err(), "{at} {value}");
        }
    }
}
