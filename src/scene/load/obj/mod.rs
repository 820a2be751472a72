//! Reads Wavefront OBJ files: one shape per group and material.
//!
//! Measure: the file's own units, in double precision; v of texture coordinates points up.
//! Range: a file with at least one face; polygons are cut into triangles. Faces without a material have the colours of their
//! vertices, if these have any.
//! Source: the OBJ format. Tested in `tests/loading/scene_files.rs`, `tests/loading/odd_models.rs` and
//! `cli/tests/command/bad_input.rs`.

mod chunks;
mod lines;
mod model;
mod vertices;
mod words;

use self::model::{ObjModel, PartMesh};
use super::contents::SceneContents;
use super::mtl;
use super::polygon::note_on_uncovered;
use super::wording::{LineError, shown, unknown_name};
use super::{beside, read_any_text, vertex_colours};
use crate::error::{Error, Result};
use crate::image::srgb;
use crate::math::rgb::Rgb;
use crate::scene::description::{
    ColourDescription, GeometryDescription, MeshDescription, Note, NoteKind, Place,
    ShapeDescription,
};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A material of a model: its index and its emission.
type ObjMaterial = (usize, Option<ColourDescription>);

/// Reads a model and returns its shapes. Adds its materials to `contents`, unless `material` overrides all of them.
///
/// # Errors
/// If a line of the file or of its material libraries is invalid.
pub fn load(
    path: &Path,
    material: Option<usize>,
    contents: &mut SceneContents,
) -> Result<Vec<ShapeDescription>> {
    let obj = parse(path, false)?;
    shapes(path, &obj, material, contents)
}

/// Reads the meshes of a model, without its groups and materials.
///
/// # Errors
/// As [`load`].
pub fn load_whole(path: &Path, contents: &mut SceneContents) -> Result<Vec<MeshDescription>> {
    let obj = parse(path, true)?;
    // Any material, as none is returned.
    let shapes = shapes(path, &obj, Some(0), contents)?;
    let meshes = shapes.into_iter().filter_map(|shape| match shape.geometry {
        GeometryDescription::Mesh(mesh) => Some(Arc::unwrap_or_clone(mesh)),
        _ => None,
    });
    Ok(meshes.collect())
}

/// Parses a file, without its groups and materials if `is_whole`.
fn parse(path: &Path, is_whole: bool) -> Result<ObjModel> {
    let text = read_any_text(path)?;
    lines::read(&text, is_whole).map_err(at(path))
}

fn shapes(
    path: &Path,
    obj: &ObjModel,
    material: Option<usize>,
    contents: &mut SceneContents,
) -> Result<Vec<ShapeDescription>> {
    if obj.parts.is_empty() {
        return Err(Error::scene("expected a model, found no faces").in_file(path));
    }
    if obj.left_out > 0 {
        let count = obj.left_out;
        contents.note(Note::at(
            Place::of_file(path),
            NoteKind::Omission,
            format!("{count} points and lines were left out"),
        ));
    }
    let has_colours = material.is_none() && obj.has_valid_colours();
    if material.is_none()
        && let Some(text) = note_on_colours(obj)
    {
        contents.note(Note::at(Place::of_file(path), NoteKind::Omission, text));
    }
    let surfaces = || -> Result<Vec<ObjMaterial>> {
        match material {
            Some(index) => Ok(vec![(index, None); obj.materials.len()]),
            // No face is grey.
            None if has_colours && obj.libraries.is_empty() && obj.materials.is_empty() => {
                Ok(vec![])
            }
            None => surfaces(path, obj, contents),
        }
    };
    // Images of materials take as long as meshes.
    let meshes = || -> Vec<PartMesh> {
        let parts = obj.parts.par_iter();
        parts.map(|part| obj.mesh(part, has_colours)).collect()
    };
    let (surfaces, meshes) = rayon::join(surfaces, meshes);
    let surfaces = surfaces?;
    let unnamed = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut shapes = Vec::with_capacity(meshes.len());
    let mut uncovered = 0;
    for (part, parsed) in obj.parts.iter().zip(meshes) {
        let group = part.group.map(|group| obj.groups[group].as_str());
        let name = group.filter(|name| !name.is_empty()).unwrap_or(&unnamed);
        let place = Place::on_line(path, part.line);
        uncovered += parsed.uncovered;
        let mut mesh = parsed.mesh;
        let (material, emission) = match (part.material, material) {
            (Some(name), _) => surfaces[name].clone(),
            (None, Some(index)) => (index, None),
            (None, None) if has_colours => {
                let colours = linear(&parsed.colours);
                let place = place.clone();
                let index = vertex_colours::to_material(&mut mesh, &colours, place, contents)?;
                (index, None)
            }
            (None, None) => (contents.default_material(), None),
        };
        let geometry = GeometryDescription::Mesh(Arc::new(mesh));
        shapes.push(ShapeDescription {
            material,
            emission,
            // Many shapes may share a name of any length; messages need only its beginning.
            ..ShapeDescription::new(shown(name), place, geometry)
        });
    }
    if let Some(note) = note_on_uncovered(uncovered, Place::of_file(path)) {
        contents.note(note);
    }
    Ok(shapes)
}

/// Returns the note on colours of vertices that are left out, if there are any: those out of range, and those of faces with a
/// material.
fn note_on_colours(obj: &ObjModel) -> Option<String> {
    if obj.colours.is_empty() {
        return None;
    }
    if !obj.has_valid_colours() {
        return Some(format!(
            "the colours of {} vertices were left out: expected numbers from 0 to 1",
            obj.colours.len()
        ));
    }
    let text = "the colours of vertices of faces with a material were left out";
    let have_material = obj.parts.iter().any(|part| part.material.is_some());
    have_material.then(|| text.to_owned())
}

/// Decodes the colours of vertices, which programs write as sRGB values.
fn linear(encoded: &[[f64; 3]]) -> Vec<Rgb> {
    let decoded = |colour: &[f64; 3]| Rgb::from(colour.map(|x| srgb::to_linear(x) as f32));
    encoded.iter().map(decoded).collect()
}

/// Converts a complaint about a line of a file into an error.
fn at(path: &Path) -> impl Fn(LineError) -> Error {
    move |(line, why)| Error::scene(why).in_file(path).at_line(line)
}

/// Reads the materials that the faces refer to from the file's libraries.
fn surfaces(path: &Path, obj: &ObjModel, contents: &mut SceneContents) -> Result<Vec<ObjMaterial>> {
    if obj.libraries.is_empty() {
        let grey = contents.default_material();
        contents.note(Note::at(
            Place::of_file(path),
            NoteKind::Decision,
            "has no material library; drawn grey",
        ));
        return Ok(vec![(grey, None); obj.materials.len()]);
    }
    let mut known = BTreeMap::new();
    for (line, written) in &obj.libraries {
        for library in library_files(path, written) {
            if !library.exists() {
                let text = format!("the library {} is missing", shown(written));
                contents.note(Note::at(
                    Place::on_line(path, *line),
                    NoteKind::Omission,
                    text,
                ));
                continue;
            }
            mtl::read(&library, &mut known, contents)
                .map_err(|error| named_in(error, path, *line))?;
        }
    }
    let mut surface = |(line, name): &(usize, String)| -> Result<ObjMaterial> {
        let Some(entry) = known.get(name) else {
            let names: Vec<&str> = known.keys().map(String::as_str).collect();
            let text = format!("{}; drawn grey", unknown_name("material", name, &names));
            contents.note(Note::at(
                Place::on_line(path, *line),
                NoteKind::Omission,
                text,
            ));
            return Ok((contents.default_material(), None));
        };
        entry.omitted_images().for_each(|note| contents.note(note));
        let here = |error| named_in(error, path, *line);
        let material = entry.material(&mut contents.textures).map_err(here)?;
        let emission = entry.emission(&mut contents.textures).map_err(here)?;
        let heights = entry.omitted_heights(&mut contents.textures);
        if let Some(note) = heights.map_err(here)? {
            contents.note(note);
        }
        Ok((contents.add_material(material), emission))
    };
    obj.materials.iter().map(&mut surface).collect()
}

/// Wraps an error about a file in one about the line of the model that refers to it; both places are reported.
fn named_in(error: Error, path: &Path, line: usize) -> Error {
    let kind = error.kind();
    at(path)((line, error.to_string())).of_kind(kind)
}

/// Returns the files of one `mtllib`: a name that may contain spaces, or else several names.
fn library_files(path: &Path, written: &str) -> Vec<PathBuf> {
    let whole = beside(path, written);
    if whole.exists() || !written.contains(char::is_whitespace) {
        vec![whole]
    } else {
        written
            .split_whitespace()
            .map(|name| beside(path, name))
            .collect()
    }
}
