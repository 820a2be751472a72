//! The arguments of every verb that reads a scene.
//!
//! Measure: none.
//! Range: any file that the library loads.
//! Source: docs/scene-formats.md. Tested in `cli/tests/command/bad_input.rs`.

use clap::Args;
use etendue::Result;
use etendue::description::SceneDescription;
use etendue::internals::scene::load;
use std::path::{Path, PathBuf};

/// A scene, and how to read it.
#[derive(Debug, Args)]
pub struct SceneArguments {
    /// Scene: .toml, Mitsuba 3 (.xml), pbrt-v4 (.pbrt), glTF 2.0 (.gltf, .glb), or a bare model: .obj, .ply.
    #[arg(value_name = "SCENE")]
    pub file: PathBuf,
    /// Camera of this name, of a file that has several. Default: the first.
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// The faithfulness with which it has to be read.
    #[command(flatten)]
    pub fidelity: Fidelity,
}

impl SceneArguments {
    /// Loads the scene.
    ///
    /// # Errors
    /// An invalid file, or, if that is requested, one that cannot be rendered as it is.
    pub fn load(&self) -> Result<SceneDescription> {
        let description = load::load_with(&self.file, self.camera.as_deref())?;
        self.fidelity.check(description)
    }
}

/// The faithfulness with which a scene has to be read.
#[derive(Debug, Clone, Copy, Args)]
pub struct Fidelity {
    /// Refuse a scene of which something would be approximated or left out, instead of printing notes.
    #[arg(long)]
    pub strict: bool,
}

impl Fidelity {
    /// Loads a scene.
    ///
    /// # Errors
    /// An invalid file, or, with `--strict`, one that cannot be rendered as it is.
    pub fn load(self, file: &Path) -> Result<SceneDescription> {
        self.check(load::load(file)?)
    }

    /// Returns the scene if it is as faithful as it has to be.
    fn check(self, description: SceneDescription) -> Result<SceneDescription> {
        if self.strict {
            description.check_faithful()?;
        }
        Ok(description)
    }
}
