//! Loads the scene files of pbrt-v4.
//!
//! Measure: as written: world units, degrees, the spectra of pbrt.
//! Range: what docs/scene-formats.md says; errors name file and line, and notes what is approximated or left out.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt/`.

mod builder;
mod camera;
mod entities;
mod environment;
mod files;
mod gamut;
mod images;
mod library;
mod light;
mod material;
mod mesh;
mod models;
mod options;
mod parameter;
mod params;
mod placing;
mod radiance;
mod shape;
mod state;
mod statements;
mod texture;
mod textured;
mod tokens;

use crate::error::Result;
use crate::scene::description::SceneDescription;
use builder::Builder;
use std::path::Path;

/// Reads a scene file.
///
/// # Errors
/// If a statement is not as the format requires, or a file that it names is invalid.
pub fn load(path: &Path) -> Result<SceneDescription> {
    let mut builder = Builder::default();
    builder.library.folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
    builder.read(path)?;
    builder.finish(path)
}
