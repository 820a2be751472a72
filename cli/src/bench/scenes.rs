//! The scenes of a benchmark: files, and scenes that it generates.
//!
//! Measure: load time in seconds.
//! Range: a name of the benchmark's own scenes takes precedence over a file of that name; any other unknown name is an
//! error that lists the names.
//! Source: none needed. Tested in `cli/tests/command/bench.rs`.

use crate::args::Fidelity;
use etendue::{Error, ErrorKind, Result};
use etendue_lab::bench::scenes::{SCENES, suzanne_room};
use etendue_lab::bench::settings::GivenScene;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The only one of the benchmark's own scenes that is loaded from files instead of generated.
const SUZANNE_ROOM: &str = "suzanne-room";

/// Returns the requested scenes, or all of the benchmark's own scenes if none was requested.
pub fn given(
    arguments: &[PathBuf],
    fidelity: Fidelity,
    note: &dyn Fn(&str),
) -> Result<Vec<GivenScene>> {
    if !arguments.is_empty() {
        return arguments
            .iter()
            .map(|argument| scene(argument, fidelity))
            .collect();
    }
    let without = |name: &&str| {
        let missing = *name == SUZANNE_ROOM && suzanne_room().is_none();
        if missing {
            note("suzanne-room is skipped: scenes/suzanne-room is not below the current folder");
        }
        !missing
    };
    names()
        .filter(without)
        .map(|name| scene(Path::new(name), fidelity))
        .collect()
}

/// Returns the names of the benchmark's own scenes.
fn names() -> impl Iterator<Item = &'static str> {
    let made = SCENES.iter().map(|scene| scene.name);
    made.chain([SUZANNE_ROOM])
}

fn scene(argument: &Path, fidelity: Fidelity) -> Result<GivenScene> {
    let start = Instant::now();
    let name = argument.display().to_string();
    let own = SCENES.iter().find(|scene| scene.name == name);
    let (description, scene) = match own {
        Some(own) => (own.sentence, own.describe(own.triangles)),
        None if name == SUZANNE_ROOM => (
            "A room with metal, glass and ceramic around a smooth head.",
            fidelity.load(&suzanne_room().ok_or_else(|| missing(argument))?)?,
        ),
        None if argument.extension().is_none() && !argument.exists() => {
            return Err(missing(argument));
        }
        None => ("", fidelity.load(argument)?),
    };
    Ok(GivenScene {
        name,
        description: description.to_owned(),
        scene,
        load: start.elapsed().as_secs_f64(),
    })
}

fn missing(argument: &Path) -> Error {
    let names: Vec<&str> = names().collect();
    let message = format!(
        "no such file, and no scene of this name among the benchmark's own: {}",
        names.join(", ")
    );
    let message = match argument == Path::new(SUZANNE_ROOM) {
        true => "its files are expected in scenes/suzanne-room below the current folder".to_owned(),
        false => message,
    };
    Error::new(ErrorKind::Io, message).in_file(argument)
}
