//! The arguments of `convert`.
//!
//! Measure: none.
//! Range: any scene that loads; the output ends in .toml.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/convert.rs`.

use super::SceneArguments;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `convert`.
#[derive(Debug, Args)]
pub struct ConvertArguments {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Scene file to write, which ends in .toml. Default: the scene's name with .toml, in the current folder.
    ///
    /// Its meshes (PLY, in double precision) and images (PNG where 8 bits hold them exactly, otherwise EXR) are written to
    /// the folder NAME-assets beside it, where NAME is that of the file without .toml. It renders the same bits as the
    /// original. Either all files are written or none.
    #[arg(short, long = "out", value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Print only errors.
    #[arg(short, long)]
    pub quiet: bool,
}
