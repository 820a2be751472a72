//! Wavefront OBJ files against an independent reader, the crate tobj: the same meshes, vertex by vertex.

use crate::common::scene_folder::SceneFolder;
use etendue::internals::math::vec::{DVec2, DVec3};
use etendue::internals::scene::description::{GeometryDescription, MeshDescription};
use rand_core::Rng;
use rand_pcg::Pcg32;
use std::fmt::Write;

/// Vertices, then groups of triangles whose corners name some of them, all groups with the same attributes.
fn random_model(random: &mut Pcg32, vertices: usize, faces: usize) -> String {
    let mut text = String::new();
    for _ in 0..vertices {
        for keyword in ["v", "vt", "vn"] {
            text.push_str(keyword);
            let count = if keyword == "vt" { 2 } else { 3 };
            for _ in 0..count {
                let number = f64::from(random.next_u32()) / 1e9 - 2.0;
                // As programs write them: with all digits, few digits, or an exponent.
                match random.next_u32() % 3 {
                    0 => write!(text, " {number}"),
                    1 => write!(text, " {number:.3}"),
                    _ => write!(text, " {number:e}"),
                }
                .expect("strings take all");
            }
            text.push('\n');
        }
    }
    let separators = [["", ""], ["/", ""], ["//", ""], ["/", "/"]];
    for group in 0..4 {
        writeln!(text, "g group{group}").expect("strings take all");
        let [first, second] = separators[random.next_u32() as usize % 4];
        for _ in 0..faces {
            text.push('f');
            for _ in 0..3 {
                let mut index = || {
                    let index = (random.next_u32() as usize % vertices) as i64;
                    // Those from the end have negative numbers.
                    if random.next_u32().is_multiple_of(2) {
                        index + 1
                    } else {
                        index - vertices as i64
                    }
                };
                write!(text, " {}", index()).expect("strings take all");
                for separator in [first, second].iter().filter(|text| !text.is_empty()) {
                    write!(text, "{separator}{}", index()).expect("strings take all");
                }
            }
            text.push('\n');
        }
    }
    text
}

/// Reads a model with tobj.
fn by_tobj(text: &str) -> Vec<MeshDescription> {
    let options = tobj::LoadOptions {
        single_index: true,
        ..Default::default()
    };
    let no_libraries = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let parsed = tobj::load_obj_buf(&mut text.as_bytes(), &options, no_libraries);
    let triples = |numbers: &[f64]| -> Vec<DVec3> {
        numbers
            .as_chunks()
            .0
            .iter()
            .copied()
            .map(DVec3::from_array)
            .collect()
    };
    let (models, _) = parsed.expect("the model is valid");
    let meshes = models.iter().map(|model| MeshDescription {
        indices: model.mesh.indices.as_chunks().0.to_vec(),
        positions: triples(&model.mesh.positions),
        normals: triples(&model.mesh.normals),
        uvs: model
            .mesh
            .texcoords
            .as_chunks()
            .0
            .iter()
            .copied()
            .map(DVec2::from_array)
            .collect(),
    });
    meshes.collect()
}

#[test]
fn random_models_are_the_meshes_that_another_reader_finds() {
    let mut random = Pcg32::new(5, 1);
    for (vertices, faces) in [(3, 1), (3, 200), (40, 10), (500, 500), (5000, 20_000)] {
        for _ in 0..4 {
            let text = random_model(&mut random, vertices, faces);
            let expected = by_tobj(&text);
            let scene = SceneFolder::new([("a.obj", text.as_str())]).load("a.obj");
            assert_eq!(scene.shapes.len(), expected.len());
            for (shape, expected) in scene.shapes.iter().zip(&expected) {
                let GeometryDescription::Mesh(mesh) = &shape.geometry else {
                    panic!("{:?} is not a mesh", shape.geometry);
                };
                assert!(
                    **mesh == *expected,
                    "{vertices} vertices, {faces} faces: {}",
                    shape.name
                );
            }
        }
    }
}
