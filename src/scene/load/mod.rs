//! Loads a [`SceneDescription`] from a file: a TOML scene, or a bare OBJ model.
//!
//! Measure: as written: world units, degrees, sRGB or linear values.
//! Range: every error names file, line, field and what was expected.
//! Source: docs/scene-format.md. Tested in `tests/loading/scene_files.rs` and `cli/tests/command/bad_input.rs`.

mod camera;
mod colour;
mod contents;
mod instance;
mod light;
mod material;
mod model;
mod motion;
mod mtl;
mod obj;
mod obj_text;
mod reader;
mod shape;
mod toml;
mod transform;
mod wording;

// Also used where render settings are read, since the names of integrators and samplers are known only there.
pub use wording::unknown_name;

use super::description::SceneDescription;
use crate::error::{Error, Result};
use std::path::Path;

/// Loads a scene: a `.toml` file, or a bare `.obj` model. The latter gets a camera and, if nothing in it emits, a sky.
///
/// # Errors
/// If the file, or a file that it refers to, is invalid.
pub fn load(path: &Path) -> Result<SceneDescription> {
    let extension = path
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_lowercase();
    match extension.as_str() {
        "toml" => toml::load(path),
        "obj" => model::load(path),
        _ => Err(
            Error::usage("expected a scene that ends in .toml, or a model that ends in .obj")
                .in_file(path),
        ),
    }
}

/// Reads a text file, without its byte order mark.
///
/// # Errors
/// If the file cannot be read, is not a regular file, or is not UTF-8.
fn read_text(path: &Path) -> Result<String> {
    let cannot_read = |error| Error::io("cannot read", path, error);
    // Reading a device such as /dev/zero would not terminate.
    if !std::fs::metadata(path).map_err(cannot_read)?.is_file() {
        return Err(cannot_read(std::io::Error::other("not a regular file")));
    }
    let bytes = std::fs::read(path).map_err(cannot_read)?;
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
    Ok(match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.to_owned(),
        None => text,
    })
}
