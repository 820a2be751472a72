//! Models with unusual syntax of other programs, and malformed ones: read as docs/scene-format.md says, in bounded time
//! and memory.

use crate::common::scene_folder::{HEAD, SceneFolder, TRIANGLE};
use etendue::ErrorKind;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::DVec3;
use etendue::internals::scene::description::{
    ColourDescription, GeometryDescription, MaterialModel, MeshDescription, Note, NoteKind,
    SceneDescription, ShapeDescription,
};
use etendue::internals::scene::load::load;

fn load_model(model: &str, library: &str) -> SceneDescription {
    SceneFolder::new([("a.obj", model), ("a.mtl", library)]).load("a.obj")
}

/// The error of a model with its library.
fn complaint(model: &str, library: &str) -> String {
    let folder = SceneFolder::new([("a.obj", model), ("a.mtl", library)]);
    let error = load(&folder.path("a.obj")).expect_err("it is not valid");
    assert_eq!(error.kind(), ErrorKind::Scene, "{error}");
    error.to_string()
}

fn mesh(shape: &ShapeDescription) -> &MeshDescription {
    match &shape.geometry {
        GeometryDescription::Mesh(mesh) => mesh,
        other => panic!("{other:?} is not a mesh"),
    }
}

#[test]
fn faces_with_and_without_uvs_become_separate_meshes() {
    let scene = load_model(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 1 0\nf 1/1 2/1 3/1\nf 1 2 3\nf 1/1 2 3\n",
        "",
    );
    let counts = scene.shapes.iter().map(|shape| {
        let mesh = mesh(shape);
        (mesh.indices.len(), mesh.uvs.len())
    });
    assert_eq!(counts.collect::<Vec<_>>(), [(1, 3), (2, 0)]);
}

#[test]
fn obj_group_has_one_shape_per_material() {
    let again = "usemtl red\nf 1 2 3\nusemtl dark blue\nf 1 2 3\n".repeat(3);
    // The library comes last, and has a material whose texture file is missing but which no face uses.
    let model = format!("{TRIANGLE}g one\n{again}g two\nf 3 2 1\n  mtllib\ta.mtl \n");
    let library = "newmtl red\nnewmtl dark blue\nPr 0.5\nnewmtl none\nmap_Kd none.png\n";
    let scene = load_model(&model, library);
    let shapes = scene.shapes.iter().map(|shape| {
        let material = scene.materials[shape.material].name.as_str();
        let faces = mesh(shape).indices.len();
        (shape.name.as_str(), material, shape.place.line, faces)
    });
    let expected = [
        ("a", "default", Some(4), 1),
        ("one", "red", Some(7), 3),
        ("one", "dark blue", Some(9), 3),
        ("two", "dark blue", Some(19), 1),
    ];
    assert_eq!(shapes.collect::<Vec<_>>(), expected);
}

#[test]
fn obj_vertex_weights_colours_and_line_continuations_parse() {
    let text = "v 0 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 0 1 \\\n0\nvt 0.5\nf 1/1 2/1 \\\n 3/1\n# C:\\\nf 1 2 4\n";
    assert!(complaint(text, "").contains("a.obj:9: vertex 4 is out of range"));
    let scene = load_model(&text.replace("1 2 4", "1 2 3"), "");
    assert_eq!(
        mesh(&scene.shapes[0]).positions,
        [DVec3::ZERO, DVec3::X, DVec3::Y]
    );
}

#[test]
fn mtllib_accepts_several_files_and_names_with_spaces() {
    let model = format!("mtllib b.mtl c d.mtl\nusemtl m\n{TRIANGLE}");
    let files = |names: [&'static str; 3]| {
        SceneFolder::new([
            ("a.obj", model.as_str()),
            (names[0], "newmtl m\n"),
            (names[1], "newmtl k\n"),
            (names[2], "newmtl l\n"),
        ])
    };
    for names in [["b.mtl c d.mtl", "x", "y"], ["b.mtl", "c", "d.mtl"]] {
        assert_eq!(files(names).load("a.obj").materials[0].name, "m");
    }
    let folder = files(["b.mtl", "x", "y"]);
    // One that is missing is noted.
    let scene = folder.load("a.obj");
    let missing = |note: &&Note| note.text.contains("is missing");
    let notes: Vec<&Note> = scene.notes.iter().filter(missing).collect();
    assert!(
        notes
            .iter()
            .all(|it| it.kind == NoteKind::Omission && it.place.line == Some(1))
    );
    assert_eq!((notes.len(), scene.materials[0].name.as_str()), (2, "m"));
    assert!(scene.check_faithful().is_err());
    // So is a material that is in no library, as the `(null)` of older exporters.
    let scene = load_model(
        &format!("mtllib a.mtl\nusemtl (null)\n{TRIANGLE}"),
        "newmtl m\n",
    );
    assert!(
        scene
            .notes
            .iter()
            .any(|note| note.text.contains("drawn grey"))
    );
}

#[test]
fn scene_material_override_needs_no_mtl_file() {
    let scene = format!(
        "{HEAD}[[material]]\nname = \"red\"\ntype = \"diffuse\"\n[[shape]]\ntype = \"obj\"\nfile = \"a.obj\"\n\
         material = \"red\"\nemission = 2\n"
    );
    let model = format!("mtllib none.mtl\n{TRIANGLE}usemtl b\nf 1 2 3\n");
    let folder = SceneFolder::new([("a.toml", scene), ("a.obj", model)]);
    let scene = folder.load("a.toml");
    let shapes = scene
        .shapes
        .iter()
        .map(|s| (s.material, s.emission.as_ref().and_then(|e| e.constant())));
    assert_eq!(shapes.collect::<Vec<_>>(), [(0, Some(Rgb::grey(2.0))); 2]);
}

#[test]
fn opaque_3ds_max_material_is_not_read_as_glass() {
    // An opaque material as written by 3ds Max.
    let library =
        "newmtl m\nNs 10\nNi 0\nd 1\nTr 0\nTf 1 1 1\nillum 2\nKd .5 .5 .5\nmap_Bump none.png\n";
    let scene = load_model(&format!("mtllib a.mtl\nusemtl m\n{TRIANGLE}"), library);
    let model = &scene.materials[scene.shapes[0].material].model;
    let MaterialModel::Principled {
        transmission, ior, ..
    } = model
    else {
        panic!("{model:?}");
    };
    assert_eq!((*transmission, *ior), (0.0, 1.0));
    assert!(
        scene.notes[0]
            .to_string()
            .contains("a.mtl:9: map_Bump: the image"),
        "{:?}",
        scene.notes
    );
}

#[test]
fn default_camera_frames_models_at_extreme_scales_and_offsets() {
    for (scale, offset) in [(1e-6, 0.0), (1e6, 1e9), (1e100, 0.0), (0.0, 1e10)] {
        let vertex = |x: f64, y: f64| format!("v {} {} 0\n", offset + scale * x, scale * y);
        let text = vertex(0.0, 0.0) + &vertex(3.0, 0.0) + &vertex(0.0, 1.0) + "f 1 2 3\n";
        let scene = load_model(&text, "");
        let camera = scene.camera;
        assert!(camera.to_world.is_finite() && camera.focus_distance > 0.0);
        for &p in &mesh(&scene.shapes[0]).positions {
            let p = camera.to_world.inverse().transform_point3(p);
            assert!(
                p.z < 0.0 && p.y.abs() <= -p.z * (0.5 * camera.fov).tan(),
                "{p}"
            );
        }
    }
    let huge = "v -1e308 0 0\nv 1e308 0 0\nv 0 1e308 0\nf 1 2 3\n";
    assert!(complaint(huge, "").contains("too large"));
}

#[test]
fn folder_as_material_library_is_an_io_error() {
    let folder = SceneFolder::new([("a.obj", format!("mtllib b.mtl\nusemtl m\n{TRIANGLE}"))]);
    std::fs::create_dir(folder.path("b.mtl")).expect("the folder is writable");
    let error = load(&folder.path("a.obj")).expect_err("a library cannot be a folder");
    assert_eq!(error.kind(), ErrorKind::Io, "{error}");
}

#[test]
fn error_message_length_and_note_count_are_bounded() {
    let long = "x".repeat(1 << 20);
    for message in [
        complaint(&format!("f {long}"), ""),
        complaint(
            &format!("mtllib a.mtl\n{TRIANGLE}"),
            &format!("newmtl a\nKd {long}"),
        ),
        complaint(&format!("mtllib a.mtl\n{TRIANGLE}"), &format!("{long} 1")),
    ] {
        assert!(message.len() < 1000, "{} bytes", message.len());
    }
    let library = format!("newmtl m\n{}", "x 1\n".repeat(100_000));
    let notes = load_model(&format!("mtllib a.mtl\nusemtl m\n{TRIANGLE}"), &library).notes;
    assert!(notes.len() < 30, "{} notes", notes.len());
}

#[test]
fn adversarial_obj_loads_with_expected_shapes_and_short_names() {
    // Each of these costs gigabytes or hours where work or memory grows with the square of the file.
    let mut model = TRIANGLE.to_owned();
    model += &format!("f{}\n", " 1 2 3".repeat(33_334));
    model += &format!("g {0}\nusemtl {0}\n", "n".repeat(1 << 20));
    for i in 0..20_000 {
        model += &format!("usemtl m{i}\nf 1 2 3\nusemtl m0\nf 1 2 3\n");
    }
    for i in 0..20_000 {
        model += &format!("g g{}\nf 1 2 3\n", i % 2);
    }
    let scene = load_model(&model, "");
    assert_eq!(mesh(&scene.shapes[0]).indices.len(), 1 + 3 * 33_334 - 2);
    assert_eq!(scene.shapes.len(), 1 + 20_000 + 2);
    assert!(scene.shapes.iter().all(|shape| shape.name.len() < 100));
}

fn omissions(scene: &SceneDescription) -> Vec<(Option<usize>, &str)> {
    let is_omission = |note: &&Note| note.kind == NoteKind::Omission;
    let notes = scene.notes.iter().filter(is_omission);
    notes
        .map(|note| (note.place.line, note.text.as_str()))
        .collect()
}

#[test]
fn missing_images_of_used_materials_are_noted_and_left_out() {
    let model = format!("mtllib a.mtl\nusemtl a\n{TRIANGLE}");
    let library =
        "newmtl a\nKd .5 0 0\nmap_Kd C:\\lost\\wood.png\nmap_Ke\nnewmtl b\nmap_Kd none.png\n";
    let scene = load_model(&model, library);
    let notes = omissions(&scene);
    assert_eq!(notes[0], (Some(4), "an image without a file; left out"));
    assert_eq!((notes.len(), notes[1].0), (2, Some(3)), "{notes:?}");
    assert!(notes[1].1.contains("wood.png is missing"), "{notes:?}");
    let material = &scene.materials[scene.shapes[0].material].model;
    let MaterialModel::Diffuse { reflectance } = material else {
        panic!("{material:?}")
    };
    assert_eq!(reflectance.constant(), Some(Rgb::new(0.5, 0.0, 0.0)));
}

#[test]
fn images_of_other_formats_are_noted_and_damaged_ones_refused() {
    let load_with = |image: &'static str| {
        let library = format!("newmtl a\nKd .5 0 0\nmap_Kd {image}\n");
        let model = format!("mtllib a.mtl\nusemtl a\n{TRIANGLE}");
        let folder = SceneFolder::new([
            ("a.obj", model.as_str()),
            ("a.mtl", library.as_str()),
            (image, "DDS ..."),
        ]);
        load(&folder.path("a.obj"))
    };
    let scene = load_with("wood.DDS").expect("its image is left out");
    let notes = omissions(&scene);
    assert_eq!((notes.len(), notes[0].0), (1, Some(3)), "{notes:?}");
    assert!(
        notes[0].1.contains("of a format that is not read"),
        "{notes:?}"
    );
    assert!(load_with("wood.png").is_err());
}

#[test]
fn models_of_other_encodings_are_read() {
    let model = [b"mtllib a.mtl\nusemtl r\xf6t\n", TRIANGLE.as_bytes()].concat();
    let folder = SceneFolder::new([
        ("a.obj", model.as_slice()),
        ("a.mtl", b"# gr\xfc\xdfe\nnewmtl r\xf6t\nKd 1 0 0\n"),
    ]);
    let scene = folder.load("a.obj");
    assert_eq!(scene.materials[scene.shapes[0].material].name, "r\u{f6}t");
    assert_eq!(omissions(&scene), []);
}

#[test]
fn colours_of_obj_vertices_are_those_of_faces_without_a_material() {
    let model = "v 0 0 0 1 0 0\nv 1 0 0 0 .5 0\nv 0 1 0 1\nf 1 2 3\n";
    let scene = load_model(model, "");
    assert_eq!(omissions(&scene), []);
    assert!(!scene.notes.iter().any(|note| note.text.contains("grey")));
    let shape = &scene.shapes[0];
    let MaterialModel::Diffuse {
        reflectance: ColourDescription::Texture(texture),
    } = &scene.materials[shape.material].model
    else {
        panic!("{:?}", scene.materials)
    };
    // The third vertex has a weight, and is white; half of the sRGB scale is 0.214.
    let expected = [[1.0, 0.0, 0.0], [0.0, 0.214, 0.0], [1.0; 3]];
    for (uv, expected) in mesh(shape).uvs.iter().zip(expected) {
        let found = texture.lookup(uv.as_vec2()).to_array();
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-3, "{found} for {expected}");
        }
    }
}

#[test]
fn colours_of_obj_vertices_out_of_range_or_beside_a_material_are_noted() {
    let bytes = load_model("v 0 0 0 255 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "");
    let text = "the colours of 1 vertices were left out: expected numbers from 0 to 1";
    assert_eq!(omissions(&bytes), [(None, text)]);
    let model = "mtllib a.mtl\nv 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\n\
                 f 1 2 3\nusemtl a\nf 1 2 3\n";
    let both = load_model(model, "newmtl a\nKd 0 1 0\n");
    let text = "the colours of vertices of faces with a material were left out";
    assert_eq!(omissions(&both), [(None, text)]);
    let names = both
        .shapes
        .iter()
        .map(|shape| both.materials[shape.material].name.as_str());
    assert_eq!(names.collect::<Vec<_>>(), ["colours", "a"]);
}

#[test]
fn concave_faces_are_covered_once() {
    let arrow = "v 2 1 0\nv 0 0 0\nv 2 -1 0\nv 0.5 0 0\nf 1 2 3 4\n";
    let scene = load_model(arrow, "");
    let mesh = mesh(&scene.shapes[0]);
    let areas = mesh.indices.iter().map(|t| {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
        (b - a).cross(c - a).z / 2.0
    });
    assert_eq!(areas.collect::<Vec<f64>>(), [0.25; 2]);
}
