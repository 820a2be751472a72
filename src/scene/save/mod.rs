//! Writes a scene description as a scene file of our own format, with its meshes and images beside it.
//!
//! The file renders the same bits: numbers are written with all their digits, meshes as PLY in double precision, images
//! as PNG where 8 bits hold them exactly, and as EXR elsewhere.
//!
//! Measure: as in docs/scene-format.md.
//! Range: any valid description. Names of materials and groups that occur twice get a number. An instance of an empty
//! group is left out. Either the scene file is written and everything that it refers to, or no file is changed.
//! Source: docs/scene-format.md. Tested in `tests/loading/saving.rs`.

mod assets;
mod colour;
mod ply;
mod sections;
mod text;

use super::description::SceneDescription;
use crate::error::{Error, Result};
use crate::image::atomic::{check_creatable, make_folder, write_text};
use assets::Assets;
use sections::Sections;
use std::ffi::OsStr;
use std::path::Path;

/// Writes a scene to a `.toml` file, and its meshes and images to the folder `NAME-assets` beside it, where `NAME` is that
/// of the file.
///
/// # Errors
/// If the file does not end in `.toml`, or a file cannot be written.
pub fn save(scene: &SceneDescription, path: &Path) -> Result<()> {
    if path.extension() != Some(OsStr::new("toml")) {
        return Err(Error::usage("expected a scene file that ends in .toml").in_file(path));
    }
    check_creatable(path)?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name = format!("{stem}-assets");
    let folder = path.with_file_name(&name);
    let mut assets = Assets::new(&folder, &name)?;
    let text = Sections::new(scene, &mut assets).text()?;
    if !assets.is_empty() {
        make_folder(&folder)?;
    }
    assets.keep()?;
    write_text(path, &text)
}
