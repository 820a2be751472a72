//! Reads Wavefront OBJ files: one shape per group and material.
//!
//! Measure: the file's own units, in double precision; v of texture coordinates points up.
//! Range: a file with at least one face; polygons are cut into triangles.
//! Source: the OBJ format, through tobj. Tested in `tests/loading/scene_files.rs` and `cli/tests/command/bad_input.rs`.

use super::contents::Contents;
use super::mtl;
use super::obj_text::{Complaint, ObjText};
use super::polygon::{Fans, note_on_uncovered};
use super::wording::{shown, unknown_name};
use super::{beside, read_any_text};
use crate::error::{Error, Result};
use crate::math::vec::{DVec2, DVec3};
use crate::scene::description::{
    ColourDescription, GeometryDescription, MeshDescription, Note, NoteKind, Place,
    ShapeDescription,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A material of a model: its index and its emission.
type Surface = (usize, Option<ColourDescription>);

/// Reads a model and returns its shapes. Adds its materials to `contents`, unless `material` overrides all of them.
///
/// # Errors
/// If a line of the file or of its material libraries is invalid.
pub fn load(
    path: &Path,
    material: Option<usize>,
    contents: &mut Contents,
) -> Result<Vec<ShapeDescription>> {
    let mut obj = ObjText::read(&read_any_text(path)?).map_err(at(path))?;
    if obj.parts.is_empty() {
        return Err(Error::scene("expected a model, found no faces").in_file(path));
    }
    if obj.left_out > 0 {
        let count = obj.left_out;
        contents.note(Note::at(
            whole_file(path),
            NoteKind::Omission,
            format!("{count} points and lines were left out"),
        ));
    }
    if obj.coloured > 0 && material.is_none() {
        let text = format!("the colours of {} vertices were left out", obj.coloured);
        contents.note(Note::at(whole_file(path), NoteKind::Omission, text));
    }
    let surfaces: Vec<Surface> = match material {
        Some(index) => vec![(index, None); obj.materials.len()],
        None => surfaces(path, &obj, contents)?,
    };

    let models = parse(&obj.for_parser())
        .map_err(|error| Error::scene(format!("expected a model: {error}")).in_file(path))?;
    let unnamed = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut shapes = Vec::with_capacity(models.len());
    let mut uncovered = 0;
    for (part, model) in obj.parts.iter().zip(models) {
        let (material, emission) = match (part.material, material) {
            (Some(name), _) => surfaces[name].clone(),
            (None, Some(index)) => (index, None),
            (None, None) => (contents.default_material(), None),
        };
        let group = part.group.map(|group| obj.groups[group].as_str());
        let name = group.filter(|name| !name.is_empty()).unwrap_or(&unnamed);
        let place = Place {
            file: path.to_path_buf(),
            line: Some(part.line),
        };
        let (mesh, more) = to_mesh(&model.mesh);
        uncovered += more;
        let geometry = GeometryDescription::Mesh(Arc::new(mesh));
        shapes.push(ShapeDescription {
            material,
            emission,
            // Many shapes may share a name of any length; messages need only its beginning.
            ..ShapeDescription::new(shown(name), place, geometry)
        });
    }
    if let Some(note) = note_on_uncovered(uncovered, whole_file(path)) {
        contents.note(note);
    }
    Ok(shapes)
}

/// Returns the place of what concerns a whole file.
fn whole_file(path: &Path) -> Place {
    Place {
        file: path.to_path_buf(),
        line: None,
    }
}

/// A line of a file.
fn on(path: &Path, line: usize) -> Place {
    Place {
        file: path.to_path_buf(),
        line: Some(line),
    }
}

/// Converts a complaint about a line of a file into an error.
fn at(path: &Path) -> impl Fn(Complaint) -> Error {
    move |(line, why)| Error::scene(why).in_file(path).at_line(line)
}

/// Reads the materials that the faces refer to from the file's libraries.
fn surfaces(path: &Path, obj: &ObjText, contents: &mut Contents) -> Result<Vec<Surface>> {
    if obj.libraries.is_empty() {
        let grey = contents.default_material();
        contents.note(Note::at(
            whole_file(path),
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
                contents.note(Note::at(on(path, *line), NoteKind::Omission, text));
                continue;
            }
            mtl::read(&library, &mut known, contents)
                .map_err(|error| named_in(error, path, *line))?;
        }
    }
    let mut surface = |(line, name): &(usize, String)| -> Result<Surface> {
        let Some(entry) = known.get(name) else {
            let names: Vec<&str> = known.keys().map(String::as_str).collect();
            let text = format!("{}; drawn grey", unknown_name("material", name, &names));
            contents.note(Note::at(on(path, *line), NoteKind::Omission, text));
            return Ok((contents.default_material(), None));
        };
        entry.missing_images().for_each(|note| contents.note(note));
        let here = |error| named_in(error, path, *line);
        let material = entry.material(&mut contents.textures).map_err(here)?;
        let emission = entry.emission(&mut contents.textures).map_err(here)?;
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

/// Parses the text with tobj.
fn parse(text: &str) -> std::result::Result<Vec<tobj::Model>, tobj::LoadError> {
    let options = tobj::LoadOptions {
        single_index: true,
        ..Default::default()
    };
    let no_libraries = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
    tobj::load_obj_buf(&mut text.as_bytes(), &options, no_libraries).map(|(models, _)| models)
}

/// Returns a mesh, and the number of its polygons that are not covered by their triangles.
fn to_mesh(mesh: &tobj::Mesh) -> (MeshDescription, usize) {
    let (uvs, _) = mesh.texcoords.as_chunks();
    let positions = triples(&mesh.positions);
    let (indices, uncovered) = triangles(mesh, &positions);
    let mesh = MeshDescription {
        indices,
        positions,
        normals: triples(&mesh.normals),
        uvs: uvs.iter().copied().map(DVec2::from_array).collect(),
    };
    (mesh, uncovered)
}

/// Cuts the faces of a mesh into triangles. Returns also how many are not covered by theirs.
fn triangles(mesh: &tobj::Mesh, positions: &[DVec3]) -> (Vec<[u32; 3]>, usize) {
    if mesh.face_arities.is_empty() {
        return (mesh.indices.as_chunks().0.to_vec(), 0);
    }
    let mut triangles = Vec::with_capacity(mesh.indices.len() - 2 * mesh.face_arities.len());
    let mut fans = Fans::default();
    let mut rest = mesh.indices.as_slice();
    for &arity in &mesh.face_arities {
        let (corners, after) = rest.split_at(arity as usize);
        let start = triangles.len();
        let others = corners[1..].windows(2);
        triangles.extend(others.map(|pair| [corners[0], pair[0], pair[1]]));
        if arity > 3 {
            fans.push(start..triangles.len());
        }
        rest = after;
    }
    let uncovered = fans.cut_concave(&mut triangles, positions);
    (triangles, uncovered)
}

fn triples(numbers: &[f64]) -> Vec<DVec3> {
    let (triples, _) = numbers.as_chunks();
    triples.iter().copied().map(DVec3::from_array).collect()
}
