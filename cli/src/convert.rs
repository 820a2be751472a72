//! `etendue convert`: any scene that is read, as a scene file of our own format.
//!
//! Measure: none.
//! Range: any scene that loads.
//! Source: docs/scene-format.md. Tested in `cli/tests/command/convert.rs`.

use super::args::ConvertArguments;
use super::{Outcome, named_after};
use etendue::internals::scene::save::save;
use etendue::{Error, Result};
use std::path::{Path, PathBuf};

/// Converts a scene according to the arguments.
pub fn run(arguments: &ConvertArguments) -> Result<Outcome> {
    let input = &arguments.scene.file;
    let output = output(arguments);
    let same = |path: &Path| path.canonicalize().ok();
    if same(input).is_some() && same(input) == same(&output) {
        let message = "expected another file for the output than the scene itself";
        return Err(Error::usage(message).in_file(&output));
    }
    let scene = arguments.scene.load()?;
    save(&scene, &output)?;
    if !arguments.quiet {
        for note in &scene.notes {
            say!("note: {note}");
        }
        let (shapes, materials) = (scene.shapes.len(), scene.materials.len());
        let instances = scene.instances.len();
        say!(
            "{}: {shapes} shapes, {instances} instances, {materials} materials",
            output.display()
        );
    }
    Ok(Outcome::Done)
}

/// Returns the file to write.
fn output(arguments: &ConvertArguments) -> PathBuf {
    let beside = || named_after(&arguments.scene.file, "toml");
    arguments.out.clone().unwrap_or_else(beside)
}
