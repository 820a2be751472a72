//! Loads a [`SceneDescription`] from a file: our own TOML, another renderer's scene, or a bare model.
//!
//! Measure: as written: world units, degrees, sRGB or linear values.
//! Range: every error names file, line, field and what was expected; notes name what is approximated and left out.
//! Source: docs/scene-format.md, docs/scene-formats.md. Tested in `tests/loading/scene_files.rs` and `cli/tests/command/bad_input.rs`.

mod bounds;
mod camera;
mod cie;
mod colour;
mod contents;
mod gltf;
mod instance;
mod light;
mod material;
mod mesh_files;
mod mitsuba;
mod model;
mod motion;
mod mtl;
mod named_spectra;
mod obj;
mod pbrt;
mod ply;
mod polygon;
mod reader;
mod revolution;
mod shape;
mod spectrum;
mod toml;
mod transform;
mod vertex_colours;
mod wording;

// Also used where render settings are read, since the names of integrators and samplers are known only there.
pub use wording::unknown_name;

use super::description::SceneDescription;
use crate::error::{Error, Result};
use crate::memory;
use rayon::prelude::*;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

/// The loader of a format.
type Load = fn(&Path) -> Result<SceneDescription>;

/// The formats: extension in lower case, and loader.
const FORMATS: &[(&str, Load)] = &[
    ("toml", toml::load),
    ("obj", model::load_obj),
    ("ply", model::load_ply),
    ("pbrt", pbrt::load),
    ("xml", mitsuba::load),
    ("gltf", |path| gltf::load(path, None)),
    ("glb", |path| gltf::load(path, None)),
];

/// Loads a scene by the file's extension. A bare model gets a camera and, if nothing in it emits, a sky.
///
/// # Errors
/// If the file, or a file that it refers to, is invalid.
pub fn load(path: &Path) -> Result<SceneDescription> {
    load_with(path, None)
}

/// Loads a scene as [`load`] does, with the camera of this name if the file has several.
///
/// # Errors
/// As [`load`]; and if there is no such camera, or the format has no names of cameras.
pub fn load_with(path: &Path, camera: Option<&str>) -> Result<SceneDescription> {
    let extension = path
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_lowercase();
    if let Some(name) = camera {
        if ["gltf", "glb"].contains(&extension.as_str()) {
            return gltf::load(path, camera);
        }
        let message = format!("cameras of .{extension} files have no names, found `{name}`");
        return Err(Error::usage(message).in_file(path));
    }
    let format = FORMATS.iter().find(|(known, _)| *known == extension);
    let (_, load) = format.ok_or_else(|| {
        let known: Vec<String> = FORMATS
            .iter()
            .map(|(known, _)| format!(".{known}"))
            .collect();
        let known = known.join(", ");
        Error::usage(format!(
            "expected a scene or a model that ends in one of: {known}"
        ))
        .in_file(path)
    })?;
    load(path)
}

/// The file of this name in the folder of another file.
fn beside(path: &Path, name: &str) -> PathBuf {
    within(path.parent().unwrap_or(Path::new("")), name)
}

/// The file of this name in a folder. Programs on Windows write backslashes between folders.
fn within(folder: &Path, name: &str) -> PathBuf {
    let file = folder.join(name);
    if name.contains('\\') && !file.exists() {
        folder.join(name.replace('\\', "/"))
    } else {
        file
    }
}

/// Reads a text of any encoding that extends ASCII: UTF-8, or else each byte as the character of its number. Names in it
/// that two files have in common remain equal.
///
/// # Errors
/// If the file cannot be read, or is not a regular file.
fn read_any_text(path: &Path) -> Result<String> {
    let bytes = read_bytes(path)?;
    let text = String::from_utf8(bytes)
        .unwrap_or_else(|error| error.into_bytes().into_iter().map(char::from).collect());
    Ok(without_mark(text))
}

/// Returns a text without its byte order mark.
fn without_mark(text: String) -> String {
    match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.to_owned(),
        None => text,
    }
}

/// Reads a text file, without its byte order mark.
///
/// # Errors
/// If the file cannot be read, is not a regular file, or is not UTF-8.
fn read_text(path: &Path) -> Result<String> {
    let bytes = read_bytes(path)?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..valid]
            .iter()
            .filter(|&&byte| byte == b'\n')
            .count();
        Error::scene("expected UTF-8 text, found other bytes")
            .in_file(path)
            .at_line(line)
    })?;
    Ok(without_mark(text))
}

/// Reads a file.
///
/// # Errors
/// If the file cannot be read, is not a regular file, or there is no memory for it.
fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    let length = length_of(path)?;
    memory::check(length, || format!("{}", path.display()))?;
    let cannot_read = |error| Error::io("cannot read", path, error);
    if length < 2 * READ_SIZE as u64 {
        return std::fs::read(path).map_err(cannot_read);
    }
    // Threads share the time that the system takes to provide memory.
    let file = File::open(path).map_err(cannot_read)?;
    let mut bytes = vec![0; length as usize];
    let parts = bytes.par_chunks_mut(READ_SIZE).enumerate();
    parts
        .try_for_each(|(part, bytes)| file.read_exact_at(bytes, (part * READ_SIZE) as u64))
        .map_err(cannot_read)?;
    Ok(bytes)
}

/// Bytes that a thread reads at a time.
const READ_SIZE: usize = 1 << 20;

/// Opens a file of which only parts are read, and returns its length in bytes, too.
///
/// # Errors
/// If the file cannot be read, or is not a regular file.
fn open(path: &Path) -> Result<(File, u64)> {
    let length = length_of(path)?;
    let file = File::open(path).map_err(|error| Error::io("cannot read", path, error))?;
    Ok((file, length))
}

/// Returns the length of a file in bytes.
fn length_of(path: &Path) -> Result<u64> {
    let cannot_read = |error| Error::io("cannot read", path, error);
    // Reading a device such as /dev/zero would not terminate.
    let metadata = std::fs::metadata(path).map_err(cannot_read)?;
    if !metadata.is_file() {
        return Err(cannot_read(std::io::Error::other("not a regular file")));
    }
    Ok(metadata.len())
}
