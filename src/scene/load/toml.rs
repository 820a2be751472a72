//! Reads the TOML scene file.
//!
//! Measure: world units, degrees.
//! Range: version 1 of the format.
//! Source: docs/scene-format.md. Tested in `tests/loading/scene_files.rs` and `cli/tests/command/bad_input.rs`.

use super::camera::camera;
use super::contents::SceneContents;
use super::reader::{Table, TomlDocument, Value};
use super::{instance, light, material, read_text, shape};
use crate::error::Result;
use crate::film::filter::MAX_RADIUS;
use crate::image::MAX_SIDE;
use crate::scene::description::{
    FilmDescription, FilterDescription, FilterKind, Note, NoteKind, RenderDescription,
    SceneDescription, WithLine,
};
use std::path::Path;

/// Reads a scene file.
///
/// # Errors
/// If an entry is not as the format requires, or a file that it names is invalid.
pub fn load(path: &Path) -> Result<SceneDescription> {
    let text = read_text(path)?;
    let document = TomlDocument::new(path, &text);
    let parsed = document.parse()?;
    let root = Table::root(&document, &parsed);
    let version = root.required("version")?;
    if version.number()? != 1.0 {
        return Err(version.expected("1, the version of the format that this program reads"));
    }
    let camera = camera(&root.required("camera")?.table()?)?;
    let film = film(root.optional("film").map(|film| film.table()).transpose()?)?;
    let render = match root.optional("render") {
        Some(render) => render_table(render.table()?)?,
        None => RenderDescription::default(),
    };
    let mut contents = SceneContents::default();
    for entry in list(&root, "material")? {
        let material = material::material(&entry, path, &mut contents.textures)?;
        let name = material.name.clone();
        if !contents.add_named_material(material) {
            return Err(entry.error(format!("there is a material `{name}` already")));
        }
    }
    for (index, entry) in list(&root, "shape")?.iter().enumerate() {
        shape::shape(entry, path, index, &mut contents)?;
    }
    instance::instances(&list(&root, "instance")?, path, &mut contents)?;
    let lights = light::lights(&list(&root, "light")?, path, &mut contents.textures)?;
    root.finish()?;
    let [open, close] = camera.shutter;
    let motions = contents.shapes.iter().map(|shape| &shape.motion);
    let motions = motions.chain(contents.instances.iter().map(|instance| &instance.motion));
    if open == close && motions.chain([&camera.motion]).any(|keys| keys.len() > 1) {
        contents.note(Note::of_scene(
            NoteKind::Decision,
            "motion is given, but the shutter is never open: nothing moves",
        ));
    }
    Ok(SceneDescription {
        file: path.to_path_buf(),
        camera,
        film,
        render,
        materials: contents.materials,
        shapes: contents.shapes,
        groups: contents.groups,
        instances: contents.instances,
        lights,
        notes: contents.notes,
    })
}

/// Returns the tables of `[[key]]`, or none if the key is missing.
fn list<'a>(root: &Table<'a>, key: &'static str) -> Result<Vec<Value<'a>>> {
    root.optional(key)
        .map_or(Ok(Vec::new()), |value| value.list())
}

fn film(table: Option<Table<'_>>) -> Result<FilmDescription> {
    let default = FilmDescription::default();
    let Some(table) = table else {
        return Ok(default);
    };
    let size = match table.optional("size") {
        Some(size) => {
            let sides = size.list()?;
            let [width, height] = sides.as_slice() else {
                return Err(size.expected("a list of width and height"));
            };
            let side = |value: &Value<'_>| value.whole(1, MAX_SIDE as u64).map(|side| side as u32);
            (side(width)?, side(height)?)
        }
        None => default.size,
    };
    let filter = match table.optional("filter") {
        None => default.filter,
        Some(name) if name.is_text() => {
            let kind = name.one_of(FilterKind::ALL)?;
            FilterDescription {
                kind,
                radius: kind.default_radius(),
            }
        }
        Some(filter) => {
            let filter = filter.table()?;
            let kind = filter.required("type")?.one_of(FilterKind::ALL)?;
            let radius = filter
                .optional("radius")
                .map_or(Ok(kind.default_radius()), |radius| {
                    radius.number_where("a number of pixels above 0, up to 32", |x| {
                        x > 0.0 && x <= MAX_RADIUS
                    })
                })?;
            filter.finish()?;
            FilterDescription { kind, radius }
        }
    };
    table.finish()?;
    Ok(FilmDescription { size, filter })
}

fn render_table(table: Table<'_>) -> Result<RenderDescription> {
    let name = |key| -> Result<Option<WithLine<String>>> {
        let Some(value) = table.optional(key) else {
            return Ok(None);
        };
        Ok(Some(WithLine {
            value: value.text()?.to_owned(),
            line: value.line(),
        }))
    };
    let whole = |key, least, most| {
        table
            .optional(key)
            .map(|value| value.whole(least, most))
            .transpose()
    };
    let render = RenderDescription {
        integrator: name("integrator")?,
        sampler: name("sampler")?,
        spp: whole("spp", 1, u64::MAX)?,
        max_bounces: whole("max_bounces", 0, u64::from(u32::MAX))?.map(|n| n as u32),
        roulette: name("roulette")?,
        light_paths: name("light_paths")?,
        reuse: name("reuse")?,
        adaptive: name("adaptive")?,
        occlusion_distance: table
            .optional("occlusion_distance")
            .map(|value| value.number_where("a number above 0", |x| x > 0.0))
            .transpose()?,
        cache_error: table
            .optional("cache_error")
            .map(|value| {
                value.number_where("a number from 0 to below 1", |x| (0.0..1.0).contains(&x))
            })
            .transpose()?,
        seed: whole("seed", 0, u64::MAX)?,
    };
    table.finish()?;
    Ok(render)
}
