//! Wavefront OBJ: one shape for each group and material of the file.
//!
//! Measure: the file's own units, in double precision; v of texture coordinates points up.
//! Range: a file of at least one face; polygons become fans of triangles.
//! Source: the OBJ format, through tobj. Tested in `tests/scene_loading.rs` and `tests/bad_input.rs`.

use super::obj_check::{self, Complaint};
use super::reader::Value;
use super::toml::Contents;
use super::{mtl, read_text};
use crate::error::{Error, Result};
use crate::math::vec::{DAffine3, DVec2, DVec3};
use crate::scene::description::{GeometryDescription, MeshDescription, Place, ShapeDescription};
use std::cell::Cell;
use std::path::Path;
use std::sync::Arc;

/// Reads a model and the materials that it names. Materials go into `contents`; shapes are returned.
///
/// # Errors
/// Whatever is wrong with the file or its material libraries, with its line.
pub fn load(path: &Path, contents: &mut Contents) -> Result<Vec<ShapeDescription>> {
    // The parser takes tabs for a part of names.
    let text = read_text(path)?.replace('\t', " ");
    let at = |(line, why): Complaint| Error::scene(why).in_file(path).at_line(line);
    let facts = obj_check::check(&text).map_err(at)?;
    if facts.faces == 0 {
        return Err(Error::scene("there are no faces in it").in_file(path));
    }

    let first_material = contents.materials.len();
    let folder = path.parent().unwrap_or(Path::new(""));
    for (line, library) in &facts.libraries {
        mtl::load(&folder.join(library), contents).map_err(|error| {
            let kind = error.kind();
            Error::scene(error.to_string())
                .of_kind(kind)
                .in_file(path)
                .at_line(*line)
        })?;
    }
    let names: Vec<String> = contents.materials[first_material..]
        .iter()
        .map(|m| m.name.clone())
        .collect();
    if facts.libraries.is_empty() {
        if !facts.materials.is_empty() {
            contents.note(format!(
                "{}: names materials but no library of them; drawn grey",
                path.display()
            ));
        }
    } else {
        let known: Vec<&str> = names.iter().map(String::as_str).collect();
        obj_check::check_materials(&facts, &known).map_err(at)?;
    }
    if facts.degenerate > 0 {
        contents.note(format!(
            "{}: {} points and lines were left out",
            path.display(),
            facts.degenerate
        ));
    }

    let models = parse(&text, &names)
        .map_err(|error| Error::scene(format!("not a model: {error}")).in_file(path))?;
    let mut shapes = Vec::new();
    for model in models {
        let material = match model.mesh.material_id {
            Some(id) => first_material + id,
            None => contents.default_material(),
        };
        shapes.push(ShapeDescription {
            name: model.name,
            place: Place {
                file: path.to_path_buf(),
                line: None,
            },
            geometry: GeometryDescription::Mesh(Arc::new(to_mesh(model.mesh, path, contents))),
            transform: DAffine3::IDENTITY,
            material,
            emission: contents.emission_of(material),
            two_sided_emission: false,
        });
    }
    Ok(shapes)
}

/// An error about a model, seen from the scene that names it: both places are told.
pub fn named_by(error: Error, value: &Value<'_>) -> Error {
    let kind = error.kind();
    value.error(error.to_string()).of_kind(kind)
}

/// Runs the parser; `names` are the materials, in the order of their ids.
fn parse(text: &str, names: &[String]) -> std::result::Result<Vec<tobj::Model>, tobj::LoadError> {
    let options = tobj::LoadOptions {
        single_index: true,
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
    };
    // All libraries are read already: the first one that the parser asks for yields all of them.
    let given = Cell::new(false);
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| {
        let first = !given.replace(true);
        let names = if first { names } else { &[] };
        let material = |name: &String| tobj::Material {
            name: name.clone(),
            ..Default::default()
        };
        let ids = names.iter().cloned().zip(0..).collect();
        Ok((names.iter().map(material).collect(), ids))
    })?;
    Ok(models
        .into_iter()
        .filter(|model| !model.mesh.indices.is_empty())
        .collect())
}

fn to_mesh(mesh: tobj::Mesh, path: &Path, contents: &mut Contents) -> MeshDescription {
    let positions: Vec<DVec3> = triples(&mesh.positions);
    let mut normals = triples(&mesh.normals);
    let mut uvs: Vec<DVec2> = mesh
        .texcoords
        .as_chunks()
        .0
        .iter()
        .map(|&[u, v]| DVec2::new(u, v))
        .collect();
    // Where only some corners have one, there is no telling which.
    for (what, there) in [
        ("normals", normals.len()),
        ("texture coordinates", uvs.len()),
    ] {
        if there != 0 && there != positions.len() {
            contents.note(format!(
                "{}: {what} of some corners only; left out where they are not complete",
                path.display()
            ));
        }
    }
    if normals.len() != positions.len() {
        normals.clear();
    }
    if uvs.len() != positions.len() {
        uvs.clear();
    }
    MeshDescription {
        positions,
        normals,
        uvs,
        indices: mesh.indices.as_chunks().0.to_vec(),
    }
}

fn triples(numbers: &[f64]) -> Vec<DVec3> {
    numbers
        .as_chunks()
        .0
        .iter()
        .map(|&xyz| DVec3::from_array(xyz))
        .collect()
}
