//! Loads a scene of Mitsuba 3, from its XML format.
//!
//! Measure: world units, degrees; radiometric units are those of Mitsuba.
//! Range: docs/scene-formats.md lists what is read, approximated and refused.
//! Source: Mitsuba 3 documentation, "Scene XML file format". Tested in `tests/loading/mitsuba.rs` and the files beside it
//! of this prefix, and against Mitsuba by `scripts/against-mitsuba.py`.

mod document;
mod emitter;
mod folders;
mod material;
mod mesh;
mod metals;
mod object;
mod old;
mod parameters;
mod references;
mod round;
mod sensor;
mod serialized;
mod shape;
mod spectra;
mod texture;
mod transform;
mod values;
mod view;

use super::contents::SceneContents;
use crate::error::Result;
use crate::scene::check;
use crate::scene::description::{
    FilmDescription, Note, NoteKind, RenderDescription, SceneDescription,
};
use object::Value;
use shape::Shapes;
use std::path::Path;

/// Reads a scene.
///
/// # Errors
/// If the file, or one that it names, is invalid.
pub fn load(path: &Path) -> Result<SceneDescription> {
    let scene = document::read(path)?;
    let mut contents = SceneContents::default();
    let mut shapes = Shapes::default();
    let mut render = RenderDescription::default();
    let mut camera = None;
    let mut lights = Vec::new();
    for property in &scene.properties {
        let Value::Object(object) = &property.value else {
            continue;
        };
        match object.tag.as_str() {
            "integrator" => sensor::integrator(object, &mut render, &mut contents)?,
            "sensor" if camera.is_some() => {
                let text = "only the first sensor is used";
                contents.note(object.note(NoteKind::Decision, text));
            }
            "sensor" => camera = Some(sensor::sensor(object, &mut render, &mut contents)?),
            "emitter" => lights.extend(emitter::light(object, &mut contents)?),
            "shape" => shapes.add(object, None, &mut contents)?,
            // Used where something refers to them.
            "bsdf" | "texture" => {}
            _ => contents.note(Note::at(
                object.place.clone(),
                NoteKind::Omission,
                format!("{}: not supported: left out", object.title()),
            )),
        }
        property.used.set(true);
    }
    scene.note_unused(&[], &mut contents);
    let (camera, film) = match camera {
        Some(camera) => camera,
        None => {
            let camera = view::without_sensor(&scene, &mut contents)?;
            (camera, FilmDescription::default())
        }
    };
    let description = SceneDescription {
        film,
        render,
        materials: contents.materials,
        shapes: contents.shapes,
        groups: contents.groups,
        instances: contents.instances,
        lights,
        notes: contents.notes,
        ..SceneDescription::new(path, camera)
    };
    check::scene(&description).map_err(|error| error.in_file(path))?;
    Ok(description)
}
