//! Binary PLY records that several threads read, as opposed to ascii ones, which are read in order.
//!
//! Measure: bytes from the start of the file; world units.
//! Range: files of 10 000 vertices that are made here, whole and with wrong numbers.
//! Source: Turk, "The PLY Polygon File Format" (1994).

use crate::ply::{complaint, mesh, read};

/// The number of vertices of [`strip`], which several threads read.
const STRIP: usize = 10_000;

/// Returns a strip of triangles with normals and texture coordinates, little-endian or as ascii, and the byte where the faces begin.
fn strip(is_binary: bool) -> (Vec<u8>, usize) {
    let format = if is_binary {
        "binary_little_endian"
    } else {
        "ascii"
    };
    let faces = STRIP - 2;
    let header = format!(
        "ply\nformat {format} 1.0\nelement vertex {STRIP}\nproperty double x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n\
         element face {faces}\nproperty uchar kind\nproperty list ushort uint vertex_indices\nend_header\n"
    );
    let mut bytes = header.into_bytes();
    for i in 0..STRIP as u16 {
        let x = f64::from(i) / 3.0;
        let others = [i % 2, 0, 0, 0, 1, i % 7, i % 5].map(f32::from);
        if is_binary {
            bytes.extend(x.to_le_bytes());
            bytes.extend(others.iter().flat_map(|y| y.to_le_bytes()));
        } else {
            bytes.extend(format!("{x}").bytes());
            bytes.extend(others.iter().flat_map(|y| format!(" {y}").into_bytes()));
            bytes.push(b'\n');
        }
    }
    let start = bytes.len();
    for i in 0..faces as u32 {
        let corners = [i, i + 1, i + 2];
        if is_binary {
            bytes.extend([7, 3, 0]);
            bytes.extend(corners.iter().flat_map(|corner| corner.to_le_bytes()));
        } else {
            let [a, b, c] = corners;
            bytes.extend(format!("7 3 {a} {b} {c}\n").bytes());
        }
    }
    (bytes, start)
}

#[test]
fn binary_records_read_by_several_threads_equal_ascii_ones() {
    let [binary, ascii] = [true, false].map(|is_binary| {
        let scene = read(strip(is_binary).0).unwrap_or_else(|error| panic!("{error}"));
        mesh(&scene).clone()
    });
    assert_eq!(binary.positions, ascii.positions);
    assert_eq!(binary.normals, ascii.normals);
    assert_eq!(binary.uvs, ascii.uvs);
    assert_eq!(binary.indices, ascii.indices);
    assert_eq!(binary.positions.len(), STRIP);
}

#[test]
fn first_wrong_binary_record_is_named_by_its_byte() {
    let (bytes, faces) = strip(true);
    let first_vertex = faces - STRIP * (8 + 7 * 4);
    let coordinate = first_vertex + 8000 * (8 + 7 * 4) + 8;
    let normal = first_vertex + 7000 * (8 + 7 * 4) + 8 + 2 * 4;
    let index = faces + 5000 * 15 + 3 + 4;
    let length = faces + 4000 * 15 + 1;
    let infinite = f32::INFINITY.to_le_bytes();
    let ten_thousand = (STRIP as u32).to_le_bytes();
    for (wrong, at, expected) in [
        (
            &[(coordinate, infinite)][..],
            coordinate,
            "expected a number within single precision",
        ),
        (
            &[(coordinate, infinite), (normal, infinite)],
            normal,
            "expected a number within single precision",
        ),
        (
            &[(index, ten_thousand)],
            index,
            "expected the index of one of 10000 vertices",
        ),
        // A quadrangle whose last index has bytes of the next face.
        (
            &[(length, [4, 0, 160, 15])],
            length + 14,
            "expected the index of one of 10000 vertices",
        ),
    ] {
        let mut bytes = bytes.clone();
        for (at, value) in wrong {
            bytes[*at..*at + 4].copy_from_slice(value);
        }
        let words = complaint(&bytes);
        assert!(
            words.contains(&format!("at byte {at}: {expected}")),
            "{words}"
        );
    }
}
