//! PLY models: encodings, polygons, attributes, and damaged files.
//!
//! Measure: world units; colours are linear.
//! Range: small files that are made here, each also cut at every length.
//! Source: Turk, "The PLY Polygon File Format" (1994).

use crate::common::scene_folder::SceneFolder;
use etendue::description::{
    ColourDescription, GeometryDescription, MaterialModel, MeshDescription, NoteKind,
    SceneDescription,
};
use etendue::internals::math::vec::{DVec2, DVec3};
use etendue::internals::scene::load::load;
use etendue::{Error, ErrorKind};

/// A number of a body, in the type that the header of [`file`] declares for it.
#[derive(Clone, Copy)]
enum Number {
    Byte(u8),
    Float(f32),
    Int(i32),
}

/// A square of a triangle and a quad with all attributes, and an element of another kind between them.
const HEADER: &str = "comment by hand
element vertex 5
property float x
property float y
property float z
property float nx
property float ny
property float nz
property uchar red
property uchar green
property uchar blue
property uchar alpha
property float s
property float t
element odd 2
property list uchar int numbers
property uchar flag
element face 2
property uchar kind
property list uchar int vertex_indices
end_header
";

fn numbers() -> Vec<Vec<Number>> {
    use Number::{Byte, Float, Int};
    let corners: [(f32, f32); 5] = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let mut records: Vec<Vec<Number>> = Vec::new();
    for (x, y) in corners {
        let colour = [Byte(255), Byte((127.5 * x) as u8), Byte(0), Byte(9)];
        let place = [
            Float(x),
            Float(y),
            Float(-0.5),
            Float(0.0),
            Float(0.0),
            Float(1.0),
        ];
        let uv = [Float(0.5 * x), Float(y)];
        records.push(place.into_iter().chain(colour).chain(uv).collect());
    }
    records.push(vec![Byte(2), Int(-7), Int(7), Byte(1)]);
    records.push(vec![Byte(0), Byte(0)]);
    records.push(vec![Byte(3), Byte(4), Int(0), Int(1), Int(3), Int(4)]);
    records.push(vec![Byte(3), Byte(3), Int(1), Int(2), Int(3)]);
    records
}

/// Returns a file in this encoding.
fn file(format: &str) -> Vec<u8> {
    let mut bytes = format!("ply\nformat {format} 1.0\n{HEADER}").into_bytes();
    for record in numbers() {
        for number in &record {
            let text = match number {
                Number::Byte(byte) => byte.to_string(),
                Number::Float(float) => float.to_string(),
                Number::Int(int) => int.to_string(),
            };
            let mut binary = match number {
                Number::Byte(byte) => vec![*byte],
                Number::Float(float) => float.to_le_bytes().to_vec(),
                Number::Int(int) => int.to_le_bytes().to_vec(),
            };
            match format {
                "ascii" => bytes.extend(format!("{text} ").bytes()),
                "binary_little_endian" => bytes.append(&mut binary),
                _ => bytes.extend(binary.iter().rev()),
            }
        }
        if format == "ascii" {
            bytes.push(b'\n');
        }
    }
    bytes
}

const FORMATS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

pub fn read(bytes: impl AsRef<[u8]>) -> Result<SceneDescription, Error> {
    load(&SceneFolder::new([("a.ply", bytes)]).path("a.ply"))
}

pub fn complaint(bytes: impl AsRef<[u8]>) -> String {
    let error = read(bytes).expect_err("the file is invalid");
    assert!(matches!(error.kind(), ErrorKind::Scene), "{error}");
    assert!(error.file().is_some(), "{error}");
    error.to_string()
}

pub fn mesh(scene: &SceneDescription) -> &MeshDescription {
    match &scene.shapes[0].geometry {
        GeometryDescription::Mesh(mesh) => mesh,
        other => panic!("{other:?}"),
    }
}

#[test]
fn ascii_and_both_binary_ply_encodings_give_the_same_mesh() {
    for format in FORMATS {
        let scene = read(file(format)).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scene.shapes.len(), 1);
        let mesh = mesh(&scene);
        // The quad is two triangles; colours give each triangle vertices of its own.
        assert_eq!(mesh.indices, [[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
        let expected = [
            (0, 0),
            (1, 0),
            (1, 1),
            (0, 0),
            (1, 1),
            (0, 1),
            (1, 0),
            (2, 0),
            (1, 1),
        ];
        let expected = expected.map(|(x, y)| DVec3::new(f64::from(x), f64::from(y), -0.5));
        assert_eq!(mesh.positions, expected, "{format}");
        assert_eq!(mesh.normals, [DVec3::Z; 9], "{format}");
        let MaterialModel::Diffuse { reflectance } = &scene.materials[0].model else {
            panic!("{:?}", scene.materials[0].model)
        };
        let ColourDescription::Texture(texture) = reflectance else {
            panic!("{reflectance:?}")
        };
        for (position, uv) in mesh.positions.iter().zip(&mesh.uvs) {
            let colour = texture.lookup(uv.as_vec2()).to_array();
            let code = (127.5 * position.x).floor() / 255.0;
            let green = if code <= 0.04045 {
                code / 12.92
            } else {
                ((code + 0.055) / 1.055).powf(2.4)
            };
            assert!((colour[0] - 1.0).abs() < 1e-5, "{colour:?}");
            assert!((f64::from(colour[1]) - green).abs() < 1e-5, "{colour:?}");
            assert_eq!(colour[2], 0.0);
        }
        assert!(
            scene
                .notes
                .iter()
                .all(|note| note.kind == NoteKind::Decision)
        );
    }
}

#[test]
fn ply_without_colours_keeps_uvs_and_shared_vertices() {
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\n\
        property double z\nproperty float texture_u\nproperty float texture_v\nelement face 1\n\
        property list uchar uint vertex_index\nend_header\n\
        0 0 0 0 0\n1e-3 0 0 1 0\n1e-3 1 0 1 1\n0 1 0 0 1\n4 0 1 2 3\n";
    let scene = read(text).unwrap_or_else(|error| panic!("{error}"));
    let mesh = mesh(&scene);
    assert_eq!(mesh.indices, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.positions[1], DVec3::new(1e-3, 0.0, 0.0));
    assert_eq!(
        mesh.uvs,
        [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(u, v)| DVec2::new(u.into(), v.into()))
    );
    assert!(mesh.normals.is_empty());
    let crlf = text.replace('\n', "\r\n");
    assert_eq!(self::mesh(&read(crlf).expect("CRLF")).indices, mesh.indices);
}

#[test]
fn two_vertex_faces_and_per_corner_texcoords_are_noted() {
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 2\nproperty list uchar int vertex_indices\n\
        property list uchar float texcoord\nend_header\n\
        0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0 0 1 0 1 1\n2 0 1 0\n";
    let scene = read(text).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(mesh(&scene).indices, [[0, 1, 2]]);
    let omissions = scene
        .notes
        .iter()
        .filter(|note| note.kind == NoteKind::Omission);
    let text: Vec<&str> = omissions.map(|note| note.text.as_str()).collect();
    assert!(
        text[0].starts_with("1 faces of fewer than three corners"),
        "{text:?}"
    );
    assert!(text[1].contains("`texcoord`"), "{text:?}");
}

#[test]
fn concave_polygons_are_covered_once() {
    // An arrow head, whose first corner does not see the last but one; vertices may follow the faces.
    let vertices = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
    let faces = "element face 1\nproperty list uchar int vertex_indices\n";
    let (points, face) = ("2 1 0\n0 0 0\n2 -1 0\n0.5 0 0\n", "4 0 1 2 3\n");
    for (elements, body) in [
        (vertices.to_owned() + faces, points.to_owned() + face),
        (faces.to_owned() + vertices, face.to_owned() + points),
    ] {
        let text = format!("ply\nformat ascii 1.0\n{elements}end_header\n{body}");
        let scene = read(text).unwrap_or_else(|error| panic!("{error}"));
        let mesh = mesh(&scene);
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            (b - a).cross(c - a).z / 2.0
        };
        let areas: Vec<f64> = mesh.indices.iter().map(area).collect();
        assert_eq!(areas, [0.25; 2], "{:?}", mesh.indices);
    }
}

#[test]
fn texture_of_a_comment_is_noted_and_comments_may_have_any_encoding() {
    let text = b"ply\nformat ascii 1.0\ncomment TextureFile my wood.png\ncomment K\xf6rper\n\
        element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let scene = read(text).unwrap_or_else(|error| panic!("{error}"));
    let noted = scene
        .notes
        .iter()
        .map(|note| (note.place.line, note.text.as_str()));
    assert!(
        noted
            .into_iter()
            .any(|note| note == (Some(3), "the image my wood.png was left out")),
        "{:?}",
        scene.notes
    );
}

#[test]
fn truncated_ply_is_rejected_at_every_length() {
    for format in FORMATS {
        let whole = file(format);
        // Only white space follows the last number of the ascii file.
        let end = whole.trim_ascii_end().len();
        let end = if format == "ascii" { end } else { whole.len() };
        for length in 0..end {
            let words = complaint(&whole[..length]);
            assert!(words.contains("a.ply"), "{format}, {length} bytes: {words}");
        }
    }
}

#[test]
fn corrupt_ply_bytes_give_a_mesh_or_an_error_naming_the_file() {
    for format in FORMATS {
        let whole = file(format);
        for index in 0..whole.len() {
            for byte in [b'-', 255] {
                let mut bytes = whole.clone();
                bytes[index] = byte;
                if let Err(error) = read(&bytes) {
                    assert!(error.to_string().contains("a.ply"), "{error}");
                }
            }
        }
    }
}

#[test]
fn ply_errors_name_the_line_and_expected_content() {
    let ascii = String::from_utf8(file("ascii")).expect("text");
    let change = |from: &str, to: &str| {
        assert!(ascii.contains(from), "{from}");
        ascii.replacen(from, to, 1)
    };
    for (text, expected) in [
        (change("ply", "plx"), "a.ply:1: expected a PLY file"),
        (
            change("ascii", "asci"),
            "a.ply:2: unknown format `asci`; did you mean `ascii`?",
        ),
        (
            change("float x", "flot x"),
            "a.ply:5: unknown type `flot`; did you mean `float`?",
        ),
        (
            change("float x", "float X"),
            "a.ply:4: expected a property `x`",
        ),
        (
            change("vertex 5", "vertex -5"),
            "a.ply:4: expected a number of records, found -5",
        ),
        (
            change("vertex 5", "vertex 99999999999999999999"),
            "a.ply:4: expected a number of records",
        ),
        (
            change("vertex 5", "vertex 99999999999999"),
            "a.ply:4: the file is too short",
        ),
        (
            change("element odd", "element face"),
            "a.ply:20: there is an element `face` already",
        ),
        (
            change("vertex_indices", "corners"),
            "a.ply:20: expected a list `vertex_indices`",
        ),
        (
            change("3 4 0 1", "3 4 0 5"),
            "a.ply:31: expected the index of one of 5 vertices",
        ),
        (
            change("3 4 0 1", "3 4 0 -1"),
            "a.ply:31: expected the index of one of 5 vertices",
        ),
        (
            change("3 4 0 1", "3 -4 0 1"),
            "a.ply:31: expected the length of the list",
        ),
        (
            change("1 0 -0.5", "1 nan -0.5"),
            "a.ply:25: expected a number within single precision for `y`",
        ),
        (
            change("1 0 -0.5", "1 1e99 -0.5"),
            "a.ply:25: expected a number within single precision for `y`",
        ),
        (
            change("1 0 -0.5", "1 O -0.5"),
            "a.ply:25: expected a number, found O",
        ),
        (
            change("element face 2", "element face 0"),
            "a.ply: expected a mesh, found no faces",
        ),
    ] {
        let words = complaint(&text);
        assert!(words.contains(expected), "{expected}: {words}");
    }
}

#[test]
fn wrong_index_in_a_binary_ply_file_is_named_by_its_byte() {
    let mut binary = file("binary_little_endian");
    let last = binary.len() - 4;
    binary[last..].copy_from_slice(&5_i32.to_le_bytes());
    let words = complaint(&binary);
    assert!(
        words.contains(&format!("a.ply: at byte {last}: expected the index")),
        "{words}"
    );
}

#[test]
fn missing_ply_file_is_an_io_error() {
    let folder = SceneFolder::new::<&str>([]);
    let error = load(&folder.path("none.ply")).expect_err("there is no file");
    assert_eq!(error.kind(), ErrorKind::Io);
}
