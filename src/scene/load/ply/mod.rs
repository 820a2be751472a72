//! Reads PLY files: one triangle mesh with normals, texture coordinates and colours, as far as the file has them.
//!
//! Measure: the file's own units, in double precision; v of texture coordinates points up.
//! Range: at least one face; polygons are cut into triangles; other elements and properties are ignored. An error has
//! the line, or the byte of a binary body.
//! Source: Turk, "The PLY Polygon File Format" (1994). Tested in `tests/loading/ply.rs`.

mod body;
mod complaint;
mod header;
mod records;

use super::polygon::{Fans, note_on_uncovered};
use super::wording::shown;
use crate::error::{Error, Result};
use crate::image::srgb;
use crate::math::rgb::Rgb;
use crate::math::vec::{DVec2, DVec3};
use crate::memory;
use crate::scene::description::{MeshDescription, Note, NoteKind, Place};
use body::{Ascii, Binary, NumberReader};
use complaint::Complaint;
use header::{BodyEncoding, Element, PlyHeader, Scalar};
use rayon::prelude::*;
use std::path::Path;

/// The contents of a PLY file.
#[derive(Debug, Default)]
pub struct PlyModel {
    /// The mesh.
    pub mesh: MeshDescription,
    /// Linear colours, one per vertex; or empty. Bytes are read as sRGB codes, other types as linear values.
    pub colours: Vec<Rgb>,
    /// Notes on properties that were left out.
    pub notes: Vec<Note>,
    /// The image that a comment of the header names, and the line of the comment.
    pub texture_file: Option<(String, usize)>,
}

/// Reads a mesh.
///
/// # Errors
/// If the file cannot be read, or is not a PLY file with faces.
pub fn read_mesh(path: &Path) -> Result<PlyModel> {
    decode(&super::read_bytes(path)?, path)
}

/// Reads a mesh from the bytes of a file, whose path is for messages.
///
/// # Errors
/// If they are not those of a PLY file with faces.
pub fn decode(bytes: &[u8], path: &Path) -> Result<PlyModel> {
    let at = |complaint: Complaint| {
        let error = Error::scene(complaint.why).in_file(path);
        match complaint.line {
            Some(line) => error.at_line(line),
            None => error,
        }
    };
    let header = PlyHeader::parse(bytes).map_err(at)?;
    let vertices = check(&header, bytes.len()).map_err(at)?;
    let triangles = 2 * count_of(&header, "face") as u64;
    let bytes_needed = vertices as u64 * VERTEX + triangles * TRIANGLE;
    memory::check(bytes_needed, || format!("the mesh of {}", path.display()))?;
    let read = match header.encoding {
        BodyEncoding::Ascii => read_body(&header, Ascii::new(bytes, header.size, header.lines)),
        BodyEncoding::LittleEndian => read_body(&header, Binary::<false>::new(bytes, header.size)),
        BodyEncoding::BigEndian => read_body(&header, Binary::<true>::new(bytes, header.size)),
    };
    let mut body = read.map_err(at)?;
    let mesh = &mut body.mesh;
    body.uncovered = body.fans.cut_concave(&mut mesh.indices, &mesh.positions);
    if body.mesh.indices.is_empty() {
        let why =
            "expected a mesh, found no faces: point clouds and triangle strips are not supported";
        return Err(Error::scene(why).in_file(path));
    }
    Ok(PlyModel {
        notes: body.notes(&header, path),
        mesh: body.mesh,
        colours: body.colours,
        texture_file: header.texture_file,
    })
}

/// Bytes of a vertex with all attributes, and of a triangle with its share of a polygon.
const VERTEX: u64 = 76;
const TRIANGLE: u64 = 20;

fn count_of(header: &PlyHeader, name: &str) -> usize {
    let found = header.elements.iter().find(|element| element.name == name);
    found.map_or(0, |element| element.count)
}

/// Checks the elements against the size of the file, and returns the number of vertices.
fn check(header: &PlyHeader, file_size: usize) -> std::result::Result<usize, Complaint> {
    let mut left = file_size - header.size;
    for (index, element) in header.elements.iter().enumerate() {
        let name = &element.name;
        let wrong = |why: &str| Complaint::at_line(element.line, why);
        if header.elements[..index]
            .iter()
            .any(|other| other.name == *name)
        {
            return Err(wrong(&format!("there is an element `{name}` already")));
        }
        let least = element
            .count
            .checked_mul(element.least_size(header.encoding));
        left = least
            .and_then(|least| left.checked_sub(least))
            .ok_or_else(|| {
                let count = element.count;
                wrong(&format!(
                    "the file is too short for {count} records of `{name}`"
                ))
            })?;
        if name == "vertex" {
            for axis in ["x", "y", "z"] {
                let found = element.find(&[axis]).map(|i| &element.properties[i]);
                if found.is_none_or(|property| property.length.is_some()) {
                    return Err(wrong(&format!(
                        "expected a property `{axis}` of the vertices"
                    )));
                }
            }
        }
    }
    let vertices = count_of(header, "vertex");
    if u32::try_from(vertices).is_err() {
        let why = format!("expected fewer than 2^32 vertices, found {vertices}");
        return Err(Complaint::at_line(header.lines, &why));
    }
    Ok(vertices)
}

/// The contents of the body.
#[derive(Debug, Default)]
struct Body {
    mesh: MeshDescription,
    colours: Vec<Rgb>,
    /// The faces with more than three corners.
    fans: Fans,
    /// Number of polygons that are not covered by their triangles.
    uncovered: usize,
    /// Number of faces with fewer than three corners.
    left_out: usize,
}

impl Body {
    fn notes(&self, header: &PlyHeader, path: &Path) -> Vec<Note> {
        let note = |line: Option<usize>, text: String| {
            let file = path.to_path_buf();
            Note::at(Place { file, line }, NoteKind::Omission, text)
        };
        let count = self.left_out;
        let lines = format!("{count} faces of fewer than three corners were left out");
        let lines = (count > 0).then(|| note(None, lines));
        let faces = header
            .elements
            .iter()
            .find(|element| element.name == "face");
        let by_corner = faces.and_then(|faces| {
            let property = &faces.properties[faces.find(&["texcoord"])?];
            let text = format!(
                "the texture coordinates of corners, `{}`, were left out",
                property.name
            );
            Some(note(Some(faces.line), text))
        });
        let place = Place::of_file(path);
        let uncovered = note_on_uncovered(self.uncovered, place);
        let notes = [lines, by_corner, uncovered];
        notes.into_iter().flatten().collect()
    }
}

fn read_body(
    header: &PlyHeader,
    mut numbers: impl NumberReader,
) -> std::result::Result<Body, Complaint> {
    let mut body = Body::default();
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => read_vertices(element, &mut numbers, &mut body)?,
            "face" => read_faces(element, count_of(header, "vertex"), &mut numbers, &mut body)?,
            _ if element.properties.is_empty() => {}
            _ => {
                for _ in 0..element.count {
                    for property in &element.properties {
                        numbers.skip(property)?;
                    }
                }
            }
        }
    }
    Ok(body)
}

/// The properties of vertices: position, normal, texture coordinates, colour.
const COLUMNS: [&[&str]; 11] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["u", "s", "texture_u", "texture_s"],
    &["v", "t", "texture_v", "texture_t"],
    &["red", "r", "diffuse_red"],
    &["green", "g", "diffuse_green"],
    &["blue", "b", "diffuse_blue"],
];

fn read_vertices(
    element: &Element,
    numbers: &mut impl NumberReader,
    body: &mut Body,
) -> std::result::Result<(), Complaint> {
    // The column of each property.
    let mut columns = vec![None; element.properties.len()];
    let mut found = [None; COLUMNS.len()];
    for (column, names) in COLUMNS.iter().enumerate() {
        let index = element.find(names);
        if let Some(index) = index.filter(|&i| element.properties[i].length.is_none()) {
            columns[index] = Some(column);
            found[column] = Some(element.properties[index].scalar);
        }
    }
    let has = |range: std::ops::Range<usize>| found[range].iter().all(Option::is_some);
    let count = element.count;
    let (normals, uvs, colours) = (has(3..6), has(6..8), has(8..11));
    if vertices_of_records(element, &columns, [normals, uvs, colours], numbers, body).is_some() {
        return Ok(());
    }
    let reserved = |has: bool| if has { count } else { 0 };
    body.mesh.positions.reserve_exact(count);
    body.mesh.normals.reserve_exact(reserved(normals));
    body.mesh.uvs.reserve_exact(reserved(uvs));
    body.colours.reserve_exact(reserved(colours));
    for _ in 0..count {
        let mut row = [0.0; COLUMNS.len()];
        for (property, column) in element.properties.iter().zip(&columns) {
            let Some(column) = *column else {
                numbers.skip(property)?;
                continue;
            };
            row[column] = numbers.next(property.scalar)?;
            if !(row[column] as f32).is_finite() {
                let what = shown(&property.name);
                let value = row[column];
                let why = format!(
                    "expected a number within single precision for `{what}`, found {value}"
                );
                return Err(numbers.wrong(&why));
            }
        }
        let vec3 = |i: usize| DVec3::new(row[i], row[i + 1], row[i + 2]);
        body.mesh.positions.push(vec3(0));
        if normals {
            body.mesh.normals.push(vec3(3));
        }
        if uvs {
            body.mesh.uvs.push(DVec2::new(row[6], row[7]));
        }
        if colours {
            let channel = |i: usize| linear(row[i], found[i].unwrap_or(Scalar::F64));
            body.colours
                .push(Rgb::new(channel(8), channel(9), channel(10)));
        }
    }
    Ok(())
}

/// Reads binary vertices on all threads; `None` if they have to be read in order. `columns` has the column of each property, and
/// `has` whether the vertices have normals, texture coordinates and colours.
fn vertices_of_records(
    element: &Element,
    columns: &[Option<usize>],
    has: [bool; 3],
    numbers: &mut impl NumberReader,
    body: &mut Body,
) -> Option<()> {
    let [normals, uvs, colours] = has.map(usize::from);
    // Columns that are not used are checked, too, which is done in order.
    if columns.iter().flatten().count() != 3 + 3 * normals + 2 * uvs + 3 * colours {
        return None;
    }
    let (fields, size) = records::fields(element)?;
    let records = numbers.records(size, element.count)?;
    let field = |column: usize| {
        let property = columns.iter().position(|of| *of == Some(column))?;
        Some(fields[property])
    };
    let triples = |first: usize| {
        let fields = [field(first)?, field(first + 1)?, field(first + 2)?];
        records::numbers(&records, fields)
    };
    let vectors = |triples: Vec<[f64; 3]>| triples.into_iter().map(DVec3::from_array).collect();
    let positions = vectors(triples(0)?);
    let normals = if has[0] { vectors(triples(3)?) } else { vec![] };
    let uvs = match has[1] {
        true => {
            let pairs = records::numbers(&records, [field(6)?, field(7)?])?;
            pairs.into_iter().map(DVec2::from_array).collect()
        }
        false => vec![],
    };
    let colours: Vec<Rgb> = if has[2] {
        let scalars = [field(8)?, field(9)?, field(10)?].map(|(_, scalar)| scalar);
        let colour = |values: [f64; 3]| {
            Rgb::from([0, 1, 2].map(|channel| linear(values[channel], scalars[channel])))
        };
        triples(8)?.into_par_iter().map(colour).collect()
    } else {
        vec![]
    };
    numbers.advance(size * element.count);
    body.mesh.positions = positions;
    body.mesh.normals = normals;
    body.mesh.uvs = uvs;
    body.colours = colours;
    Some(())
}

/// Returns the linear value, in [0, 1], of a channel.
fn linear(value: f64, scalar: Scalar) -> f32 {
    let share = (value / scalar.full()).clamp(0.0, 1.0);
    let is_code = matches!(scalar, Scalar::I8 | Scalar::U8);
    (if is_code {
        srgb::to_linear(share)
    } else {
        share
    }) as f32
}

fn read_faces(
    element: &Element,
    vertices: usize,
    numbers: &mut impl NumberReader,
    body: &mut Body,
) -> std::result::Result<(), Complaint> {
    let list = element.find(&["vertex_indices", "vertex_index"]);
    let list = list.and_then(|index| Some((index, element.properties[index].length?)));
    let Some((list, length)) = list else {
        let why = "expected a list `vertex_indices` of the faces";
        return Err(Complaint::at_line(element.line, why));
    };
    if let Some(triangles) = records::triangles(element, list, vertices, numbers) {
        body.mesh.indices = triangles;
        return Ok(());
    }
    body.mesh.indices.reserve(element.count);
    for _ in 0..element.count {
        for (index, property) in element.properties.iter().enumerate() {
            if index != list {
                numbers.skip(property)?;
                continue;
            }
            let corners = numbers.length(property, length)?;
            body.left_out += usize::from(corners < 3);
            let start = body.mesh.indices.len();
            let (mut first, mut previous) = (0, 0);
            for corner in 0..corners {
                let vertex = numbers.next_index(property.scalar)?;
                let vertex = vertex
                    .filter(|&vertex| (vertex as usize) < vertices)
                    .ok_or_else(|| {
                        numbers.wrong(&format!("expected the index of one of {vertices} vertices"))
                    })?;
                match corner {
                    0 => first = vertex,
                    1 => {}
                    _ => body.mesh.indices.push([first, previous, vertex]),
                }
                previous = vertex;
            }
            if corners > 3 {
                body.fans.push(start..body.mesh.indices.len());
            }
        }
    }
    Ok(())
}
