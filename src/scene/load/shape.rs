//! Reads the `[[shape]]` tables of a scene file.
//!
//! Measure: world units, radiance.
//! Range: as docs/scene-format.md says for each key.
//! Source: docs/scene-format.md. Tested in `tests/loading/scene_files.rs`.

use super::colour::{Bound, colour};
use super::contents::SceneContents;
use super::instance::group;
use super::motion::motion;
use super::obj;
use super::reader::{Table, Value};
use super::transform::transform;
use super::vertex_colours;
use super::wording::unknown_name;
use crate::error::{Error, Result};
use crate::math::vec::{DAffine3, DVec3};
use crate::scene::description::{GeometryDescription, MeshDescription, Place, ShapeDescription};
use std::path::Path;
use std::sync::Arc;

/// The types of shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ShapeType {
    Obj,
    Ply,
    Mesh,
    Sphere,
    Rectangle,
    Disk,
    Box,
}

const TYPES: &[(&str, ShapeType)] = &[
    ("obj", ShapeType::Obj),
    ("ply", ShapeType::Ply),
    ("mesh", ShapeType::Mesh),
    ("sphere", ShapeType::Sphere),
    ("rectangle", ShapeType::Rectangle),
    ("disk", ShapeType::Disk),
    ("box", ShapeType::Box),
];

/// Reads one `[[shape]]` table into `contents`; an OBJ file yields several shapes.
///
/// # Errors
/// If an entry is not as the format requires, or the file that it names is invalid.
pub fn shape(
    value: &Value<'_>,
    file: &Path,
    index: usize,
    contents: &mut SceneContents,
) -> Result<()> {
    let table = value.table()?;
    let kind = table.required("type")?;
    let shape_type = kind.one_of(TYPES)?;
    let name = match table.optional("name") {
        Some(name) => name.text()?.to_owned(),
        None => format!("{} {}", kind.text()?, index + 1),
    };
    let material = match table.optional("material") {
        Some(material) => Some(find_material(&material, contents)?),
        None => None,
    };
    let folder = file.parent().unwrap_or(Path::new(""));
    let textures = &mut contents.textures;
    let emission = table
        .optional("emission")
        .map(|emission| colour(&emission, Bound::NonNegative, folder, textures))
        .transpose()?;
    let two_sided_emission = table
        .optional("two_sided_emission")
        .map_or(Ok(false), |value| value.truth())?;
    let transform = table
        .optional("transform")
        .map_or(Ok(DAffine3::IDENTITY), |value| transform(&value, &name))?;
    let motion = motion(&table, &name)?;
    let group = group(&table, contents)?;
    let place = Place::on_line(file, value.line());

    if shape_type == ShapeType::Obj {
        let model = table.required("file")?;
        let path = folder.join(model.text()?);
        table.finish()?;
        let read = |contents: &mut SceneContents| obj::load(&path, material, contents);
        let shapes = contents.model(&path, material, read);
        let mut shapes = shapes.map_err(|error| named_by(error, &model))?;
        for shape in &mut shapes {
            shape.transform = transform;
            shape.motion.clone_from(&motion);
            shape.group = group;
            shape.two_sided_emission = two_sided_emission;
            if emission.is_some() {
                shape.emission.clone_from(&emission);
            }
        }
        contents.shapes.append(&mut shapes);
        return Ok(());
    }
    let (geometry, material) = if shape_type == ShapeType::Ply {
        let model = table.required("file")?;
        let path = folder.join(model.text()?);
        table.finish()?;
        ply(&path, material, contents).map_err(|error| named_by(error, &model))?
    } else {
        let geometry = geometry(shape_type, &table)?;
        table.finish()?;
        let material = material.unwrap_or_else(|| contents.default_material());
        (geometry, material)
    };
    contents.shapes.push(ShapeDescription {
        transform,
        motion,
        group,
        material,
        emission,
        two_sided_emission,
        ..ShapeDescription::new(name, place, geometry)
    });
    Ok(())
}

/// Reads a PLY file, and returns its material, too: the one given, or else one of its colours.
fn ply(
    path: &Path,
    material: Option<usize>,
    contents: &mut SceneContents,
) -> Result<(GeometryDescription, usize)> {
    let (mesh, colours) = contents.ply(path)?;
    if let Some(material) = material {
        return Ok((GeometryDescription::Mesh(mesh), material));
    }
    if colours.is_empty() {
        return Ok((GeometryDescription::Mesh(mesh), contents.default_material()));
    }
    // The texture of the colours is not read again, either.
    let shapes = contents.model(path, None, |contents| {
        let mut mesh = MeshDescription::clone(&mesh);
        let place = Place::of_file(path);
        let material = vertex_colours::to_material(&mut mesh, &colours, place.clone(), contents)?;
        let geometry = GeometryDescription::Mesh(Arc::new(mesh));
        Ok(vec![ShapeDescription {
            material,
            ..ShapeDescription::new("", place, geometry)
        }])
    })?;
    let shape = shapes.into_iter().next();
    let shape = shape.ok_or_else(|| Error::scene("expected a mesh").in_file(path))?;
    Ok((shape.geometry, shape.material))
}

/// Wraps an error about a model in one about the scene that refers to it; both places are reported.
fn named_by(error: Error, value: &Value<'_>) -> Error {
    let kind = error.kind();
    value.error(error.to_string()).of_kind(kind)
}

fn find_material(value: &Value<'_>, contents: &SceneContents) -> Result<usize> {
    let name = value.text()?;
    contents
        .material_named(name)
        .ok_or_else(|| value.error(unknown_name("material", name, &contents.material_names())))
}

fn geometry(shape_type: ShapeType, table: &Table<'_>) -> Result<GeometryDescription> {
    let point = |key| table.required(key).and_then(|value| value.vec3());
    let length = |key| {
        table
            .required(key)
            .and_then(|value| value.number_where("a number above 0", |x| x > 0.0))
    };
    let direction = |key| {
        let value = table.required(key)?;
        let direction = value.vec3()?;
        match direction.try_normalize() {
            Some(_) => Ok(direction),
            None => Err(value.expected("a direction that is not zero")),
        }
    };
    Ok(match shape_type {
        ShapeType::Sphere => GeometryDescription::Sphere {
            center: point("center")?,
            radius: length("radius")?,
        },
        ShapeType::Disk => GeometryDescription::Disk {
            center: point("center")?,
            normal: direction("normal")?,
            radius: length("radius")?,
        },
        ShapeType::Rectangle => {
            let corner = point("corner")?;
            let (edge_u, edge_v) = (direction("edge_u")?, direction("edge_v")?);
            if edge_u.cross(edge_v) == DVec3::ZERO {
                return Err(
                    table.error("edge_u and edge_v are parallel: the rectangle has no area")
                );
            }
            GeometryDescription::Rectangle {
                corner,
                edge_u,
                edge_v,
            }
        }
        ShapeType::Box => {
            let (min, max) = (point("min")?, point("max")?);
            if !min.cmplt(max).all() {
                return Err(table.error("expected every coordinate of min below that of max"));
            }
            GeometryDescription::Box { min, max }
        }
        ShapeType::Mesh => GeometryDescription::Mesh(Arc::new(mesh(table)?)),
        ShapeType::Obj | ShapeType::Ply => unreachable!("read by its caller"),
    })
}

/// Reads a mesh whose vertices are listed in the scene file.
fn mesh(table: &Table<'_>) -> Result<MeshDescription> {
    let positions = table.required("positions")?;
    let positions: Vec<DVec3> = vectors(&positions, |entry| entry.vec3())?;
    let per_vertex = |value: &Value<'_>, length: usize| {
        let what = format!("one entry for each of the {} positions", positions.len());
        if length == positions.len() {
            Ok(())
        } else {
            Err(value.expected(&what))
        }
    };
    let normals = match table.optional("normals") {
        Some(value) => {
            let normals = vectors(&value, |entry| entry.vec3())?;
            per_vertex(&value, normals.len())?;
            normals
        }
        None => Vec::new(),
    };
    let uvs = match table.optional("uvs") {
        Some(value) => {
            let uvs = vectors(&value, |entry| entry.vec2())?;
            per_vertex(&value, uvs.len())?;
            uvs
        }
        None => Vec::new(),
    };
    let indices = table.required("indices")?;
    let most = (positions.len() as u64).checked_sub(1);
    let indices = vectors(&indices, |entry| {
        let corners = entry.list()?;
        let [a, b, c] = corners.as_slice() else {
            return Err(entry.expected("a list of three vertices"));
        };
        let most = most.ok_or_else(|| entry.error("there are no positions to refer to"))?;
        let index = |value: &Value<'_>| value.whole(0, most).map(|index| index as u32);
        Ok([index(a)?, index(b)?, index(c)?])
    })?;
    Ok(MeshDescription {
        positions,
        normals,
        uvs,
        indices,
    })
}

fn vectors<'a, T>(value: &Value<'a>, read: impl Fn(&Value<'a>) -> Result<T>) -> Result<Vec<T>> {
    value.list()?.iter().map(read).collect()
}
