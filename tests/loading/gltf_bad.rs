//! glTF files that are not valid: each is an error that says where and what was expected, and none takes much memory.

use crate::common::scene_folder::SceneFolder;
use crate::gltf_builder::{Builder, F32, U8, floats, one_mesh, refused, square};
use etendue::ErrorKind;
use etendue::internals::scene::load::load;

#[test]
fn truncated_glb_is_rejected_at_every_length() {
    let (builder, [all, _, indices]) = square();
    let keys = format!("\"attributes\":{{\"POSITION\":{all}}},\"indices\":{indices}");
    let whole = builder.glb(&one_mesh(&keys));
    let folder = SceneFolder::new([("a.glb", &whole)]);
    assert!(load(&folder.path("a.glb")).is_ok());
    for length in 0..whole.len() {
        std::fs::write(folder.path("a.glb"), &whole[..length]).expect("written");
        let error = load(&folder.path("a.glb")).expect_err("cut off");
        assert_eq!(error.kind(), ErrorKind::Scene, "{length}: {error}");
        assert_eq!(error.file(), Some(folder.path("a.glb").as_path()));
    }
}

/// A valid file with one mesh.
fn valid() -> String {
    let (builder, [all, _, indices]) = square();
    let keys = format!("\"attributes\":{{\"POSITION\":{all}}},\"indices\":{indices}");
    builder.gltf(&one_mesh(&keys))
}

#[test]
fn gltf_errors_name_the_location_and_expected_content() {
    let valid = valid();
    let cases = [
        (
            "\"version\":\"2.0\"",
            "\"version\":\"1.0\"",
            "a.gltf: asset.version: expected glTF 2.0, found version 1.0",
        ),
        (
            "\"count\":6",
            "\"count\":7",
            "a.gltf: accessors[2]: expected 7 elements of 1 bytes",
        ),
        (
            "\"count\":4",
            "\"count\":18446744073709551615",
            "a.gltf: accessors[0]: expected",
        ),
        (
            "\"byteLength\":48",
            "\"byteLength\":4800",
            "a.gltf: bufferViews[0]: expected 4800 bytes",
        ),
        (
            "\"VEC3\"",
            "\"VEC2\"",
            "a.gltf: accessors[0]: expected elements of 3 numbers, found 2",
        ),
        (
            "\"VEC3\"",
            "\"VEC9\"",
            "a.gltf: accessors[0].type: not valid",
        ),
        (
            "\"mesh\":0",
            "\"mesh\":1",
            "a.gltf: nodes[0].mesh: expected an index below 1, the number of meshes",
        ),
        (
            "\"indices\":",
            "\"material\":0,\"indices\":",
            "a.gltf: meshes[0].primitives[0].material: expected no index, as the file has no materials",
        ),
        (
            "{\"mesh\":0}",
            "{\"mesh\":0,\"children\":[0]}",
            "expected a scene, found no triangles",
        ),
        (
            "\"mesh\":0",
            "\"mesh\":0,\"scale\":[1e39,1,1]",
            "a.gltf:5: expected JSON of glTF: number out of range",
        ),
        (
            "\"POSITION\":0",
            "\"POSITION\":9",
            "a.gltf: meshes[0].primitives[0].attributes: expected one of 3 accessors, found 9",
        ),
        (
            "\"POSITION\"",
            "\"NORMAL\"",
            "a.gltf: meshes[0].primitives[0]",
        ),
        (
            "base64,",
            "base64,!",
            "a.gltf: buffers[0]: expected base 64",
        ),
        (
            "data:application/octet-stream;base64,",
            "http://a/",
            "a.gltf: buffers[0]: expected the path of a file",
        ),
        (
            "\"buffers\"",
            "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\"buffers\"",
            "a.gltf: extensionsRequired: the file requires the extension KHR_draco_mesh_compression",
        ),
        ("\"nodes\"", "\"nodes", "a.gltf:"),
    ];
    for (from, to, expected) in cases {
        assert!(valid.contains(from), "{from}");
        let message = refused(&valid.replacen(from, to, 1));
        assert!(message.contains(expected), "{to}: {message}");
    }
}

#[test]
fn cyclic_gltf_nodes_are_rejected_where_a_scene_reaches_them() {
    let (builder, _) = square();
    let cyclic = builder
        .gltf("\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"children\":[1]},{\"children\":[0]}]");
    assert!(refused(&cyclic).contains("nodes[0]: expected a tree of nodes"));
    let mesh = "\"mesh\":0}";
    let unreached = format!("{mesh},{{\"children\":[2]}},{{\"children\":[1]}}");
    let valid = valid();
    assert!(valid.contains(mesh));
    let folder = SceneFolder::new([("a.gltf", valid.replacen(mesh, &unreached, 1))]);
    assert!(load(&folder.path("a.gltf")).is_ok());
}

#[test]
fn gltf_accessors_with_wrong_numbers_per_element_are_rejected() {
    let (builder, [all, uvs, indices]) = square();
    let position = format!("\"attributes\":{{\"POSITION\":{all}}}");
    let message = refused(&builder.gltf(&one_mesh(&format!(
        "\"attributes\":{{\"POSITION\":{all},\"TEXCOORD_0\":{indices}}}"
    ))));
    assert!(
        message.contains("accessors[2]: expected elements of 2 numbers"),
        "{message}"
    );
    let message = refused(&builder.gltf(&one_mesh(&format!("{position},\"indices\":{uvs}"))));
    assert!(
        message.contains("accessors[1]: expected elements of 1 numbers"),
        "{message}"
    );
}

#[test]
fn out_of_range_indices_and_infinite_positions_are_rejected() {
    let (mut builder, [all, ..]) = square();
    let wrong = builder.add("SCALAR", U8, 3, &[0, 1, 4]);
    let message = refused(&builder.gltf(&one_mesh(&format!(
        "\"attributes\":{{\"POSITION\":{all}}},\"indices\":{wrong}"
    ))));
    assert!(
        message.contains("accessors[3]: expected indices of 4 vertices, found 4"),
        "{message}"
    );
    let endless = builder.add(
        "VEC3",
        F32,
        3,
        &floats(&[0., 0., f32::INFINITY, 1., 0., 0., 0., 1., 0.]),
    );
    let message = refused(&builder.gltf(&one_mesh(&format!(
        "\"attributes\":{{\"POSITION\":{endless}}}"
    ))));
    assert!(
        message.contains("POSITION: expected finite numbers"),
        "{message}"
    );
    assert!(message.contains("element 0"), "{message}");
}

#[test]
fn missing_buffer_file_is_an_io_error_naming_buffer_and_file() {
    let (builder, [all, ..]) = square();
    let keys = one_mesh(&format!("\"attributes\":{{\"POSITION\":{all}}}"));
    let folder = SceneFolder::new([("a.gltf", builder.gltf_beside(&keys, "none.bin"))]);
    let error = load(&folder.path("a.gltf")).expect_err("there is none");
    assert_eq!(error.kind(), ErrorKind::Io);
    let message = error.to_string();
    assert!(
        message.contains("buffers[0]") && message.contains("none.bin"),
        "{message}"
    );
}

#[test]
fn accessors_expanding_far_beyond_the_file_are_rejected() {
    let mut builder = Builder::default();
    let positions = floats(&[0.5; 3 * 300]);
    let view = builder.view(&positions, "");
    // Each primitive has all vertices, from another one on.
    let primitives: Vec<String> = (0..200)
        .map(|i| {
            let more = format!(",\"bufferView\":{view},\"byteOffset\":{}", 12 * i);
            let accessor = builder.accessor("VEC3", F32, 99, &more);
            format!("{{\"attributes\":{{\"POSITION\":{accessor}}}}}")
        })
        .collect();
    let message = refused(&builder.gltf(&format!(
        "\"nodes\":[{{\"mesh\":0}}],\"meshes\":[{{\"primitives\":[{}]}}]",
        primitives.join(",")
    )));
    assert!(
        message.contains("refer to the same data too often"),
        "{message}"
    );
    // Zeros without a view are limited by the file, too.
    let zeros = builder.accessor(
        "VEC3",
        F32,
        1 << 40,
        ",\"sparse\":{\"count\":1,\"indices\":\
        {\"bufferView\":0,\"componentType\":5121},\"values\":{\"bufferView\":0}}",
    );
    let message = refused(&builder.gltf(&one_mesh(&format!(
        "\"attributes\":{{\"POSITION\":{zeros}}}"
    ))));
    assert!(message.contains("expected a buffer view"), "{message}");
}
