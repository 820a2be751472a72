//! Models and their materials, and the examples of docs/scene-format.md.

use crate::common::scene_folder::{HEAD, SceneFolder, TRIANGLE, in_repository};
use etendue::internals::image::{Image, WriteOptions, write};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DVec2, DVec3};
use etendue::internals::scene::description::{
    ColourDescription, GeometryDescription, MaterialModel, MeshDescription, SceneDescription,
};
use etendue::internals::scene::load::load;

/// Loads a model with its library `a.mtl`.
fn load_model(model: &str, library: &str) -> SceneDescription {
    SceneFolder::new([("a.obj", model), ("a.mtl", library)]).load("a.obj")
}

fn mesh(scene: &SceneDescription, index: usize) -> &MeshDescription {
    match &scene.shapes[index].geometry {
        GeometryDescription::Mesh(mesh) => mesh,
        other => panic!("{other:?} is no mesh"),
    }
}

/// Every triangle of a shape, corner by corner, in world space.
fn placed(scene: &SceneDescription, index: usize) -> Vec<[DVec3; 3]> {
    let mesh = mesh(scene, index);
    let transform = scene.shapes[index].transform;
    let corner = |i: u32| transform.transform_point3(mesh.positions[i as usize]);
    mesh.indices.iter().map(|t| t.map(corner)).collect()
}

/// Every triangle of the only shape, corner by corner.
fn triangles(scene: &SceneDescription) -> Vec<[[f64; 3]; 3]> {
    assert_eq!(scene.shapes.len(), 1);
    placed(scene, 0)
        .iter()
        .map(|t| t.map(|p| p.to_array()))
        .collect()
}

fn base(colour: &ColourDescription) -> Rgb {
    match colour {
        ColourDescription::Constant(rgb) => *rgb,
        ColourDescription::Texture(_) => panic!("a texture instead of a constant"),
    }
}

const CORNERS: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

#[test]
fn obj_syntax_variants_give_the_same_triangle() {
    for text in [
        TRIANGLE.to_owned(),
        TRIANGLE.replace('\n', "\r\n"),
        format!("\u{feff}{TRIANGLE}"),
        TRIANGLE.trim_end().to_owned(),
        TRIANGLE.replace("f 1 2 3", "f -3 -2 -1"),
        TRIANGLE
            .replace("f 1", "vt 0 0\nvn 0 0 1\ns off\ng\nf 1/1/1")
            .replace("2 3", "2/1/1 3/1/1"),
        format!("# a comment\n\n{TRIANGLE}f 1 2\nl 1 2\np 1\n"),
    ] {
        assert_eq!(triangles(&load_model(&text, "")), [CORNERS], "{text:?}");
    }
}

#[test]
fn obj_polygons_are_triangulated_as_fans() {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    let [a, b, c, d] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    assert_eq!(triangles(&load_model(square, "")), [[a, b, c], [a, c, d]]);
    let corners = 1000;
    let circle = |i: usize| {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / corners as f64).sin_cos();
        format!("v {cos} {sin} 0\n")
    };
    let vertices: String = (0..corners).map(circle).collect();
    let face: String = (1..=corners).map(|i| format!(" {i}")).collect();
    let scene = load_model(&format!("{vertices}f{face}\n"), "");
    assert_eq!(triangles(&scene).len(), corners - 2);
}

#[test]
fn obj_corners_have_their_indexed_normals_and_uvs() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nvn 0 0 2\nf 1/3/1 2/1/2 3/2/1\n";
    let scene = load_model(text, "");
    let mesh = mesh(&scene, 0);
    let order = mesh.indices[0].map(|i| i as usize);
    assert_eq!(
        order.map(|i| mesh.uvs[i]),
        [DVec2::Y, DVec2::ZERO, DVec2::X]
    );
    assert_eq!(order.map(|i| mesh.normals[i].z), [1.0, 2.0, 1.0]);
}

#[test]
fn names_may_contain_spaces() {
    let model = format!(
        "mtllib a.mtl\no the first one\nusemtl dark red\n{TRIANGLE}g second  one\nusemtl blue\nf 3 2 1\n"
    );
    let scene = load_model(
        &model,
        "newmtl dark red\nKd 0.5 0 0\nnewmtl blue\nKd 0 0 1\n",
    );
    let name = |i: usize| scene.materials[scene.shapes[i].material].name.as_str();
    assert_eq!([name(0), name(1)], ["dark red", "blue"]);
    let shapes: Vec<&str> = scene
        .shapes
        .iter()
        .map(|shape| shape.name.as_str())
        .collect();
    assert_eq!(shapes, ["the first one", "second  one"]);
}

#[test]
fn mtl_keys_select_the_material_model_and_parameters() {
    let read = |keys: &str| {
        let model = format!("mtllib a.mtl\nusemtl it\n{TRIANGLE}");
        let scene = load_model(&model, &format!("newmtl it\n{keys}"));
        (
            scene.materials[0].model.clone(),
            scene.shapes[0].emission.as_ref().and_then(|e| e.constant()),
            scene
                .notes
                .iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>(),
        )
    };
    let (MaterialModel::Diffuse { reflectance }, None, _) = read("") else {
        panic!()
    };
    assert_eq!(base(&reflectance), Rgb::grey(0.8));
    let (model, emission, _) = read("Kd 0.25 0.5 1\nPr 1\nKe 3 2 1\nKs 1 1 1\nillum 2");
    let MaterialModel::Diffuse { reflectance } = model else {
        panic!()
    };
    assert_eq!(
        (base(&reflectance), emission),
        (Rgb::new(0.25, 0.5, 1.0), Some(Rgb::new(3.0, 2.0, 1.0)))
    );
    let (model, ..) = read("Kd 1 1 1\nTf 1 1 1\nNi 1.25\nPr 0.5");
    let MaterialModel::Dielectric {
        ior,
        roughness,
        tint,
    } = model
    else {
        panic!()
    };
    assert_eq!((ior, roughness, base(&tint)), (1.25, 0.5, Rgb::WHITE));
    let (model, ..) = read("Pm 0.5\nTf 0.25 0.5 0.25\nPr 0.5");
    let MaterialModel::Principled {
        metallic,
        roughness,
        transmission,
        ior,
        ..
    } = model
    else {
        panic!()
    };
    assert_eq!(
        (metallic, roughness, transmission, ior),
        (0.5, 0.5, 0.5, 1.5)
    );

    let noted = |keys: &str, words: &str| {
        let (_, _, notes) = read(keys);
        assert!(
            notes.iter().any(|note| note.contains(words)),
            "{keys}: {notes:?}"
        );
    };
    noted("map_Bump -bm 1 a.png", "a.mtl:2: map_Bump: the image");
    noted(
        "Kdd 1 1 1",
        "a.mtl:2: unknown key `Kdd`; did you mean `Kd`?",
    );
}

#[test]
fn mtl_bumps_are_normal_maps_where_the_image_has_normals() {
    let read = |keys: &str, pixels: [Rgb; 2]| {
        let model = format!("mtllib a.mtl\nusemtl it\n{TRIANGLE}");
        let library = format!("newmtl it\n{keys}\n");
        let folder = SceneFolder::new([("a.obj", model.as_str()), ("a.mtl", library.as_str())]);
        let image = Image::new(2, 1, pixels.to_vec());
        write(&folder.path("it.pfm"), &image, &Default::default()).expect("it is writable");
        let mut scene = folder.load("a.obj");
        let notes = scene
            .notes
            .iter()
            .filter(|note| note.text.contains("map_Bump"));
        (notes.count(), scene.materials.remove(0))
    };
    let normals = [Rgb::new(0.5, 0.4, 0.9), Rgb::new(0.6, 0.5, 1.0)];
    let heights = [Rgb::grey(0.2), Rgb::grey(0.9)];
    for key in ["map_Bump", "map_bump", "bump"] {
        let (notes, material) = read(&format!("{key} -bm 0.5 it.pfm"), normals);
        let strength = material.normal_map.map(|map| map.strength);
        assert_eq!((notes, strength), (0, Some(0.5)), "{key}");
        let (notes, material) = read(&format!("{key} it.pfm"), heights);
        assert!(notes == 1 && material.normal_map.is_none(), "{key}");
    }
}

#[test]
fn mtl_clear_coats_and_comments_behind_numbers_are_read() {
    let coat = |keys: &str| {
        let library = format!("newmtl m\n{keys}\n");
        let scene = load_model(&format!("mtllib a.mtl\nusemtl m\n{TRIANGLE}"), &library);
        let material = &scene.materials[scene.shapes[0].material];
        material.clear_coat.map(|it| (it.weight, it.roughness))
    };
    let coated = coat("Pr 0.5 # rough\nPm 1\nPc 0.75\nPcr 0.25\nillum 2 # any\nd -halo 1");
    assert_eq!(coated, Some((0.75, 0.25)));
    // A matte surface has none.
    assert_eq!(coat("Pr 1\nPc 1"), None);
}

#[test]
fn mtl_images_become_alpha_normal_and_emission_maps() {
    let grey = Image::filled(2, 2, Rgb::grey(0.5));
    let read = |keys: &str| {
        let model = format!("mtllib a.mtl\nusemtl it\n{TRIANGLE}");
        let folder = SceneFolder::new([
            ("a.obj", model.as_str()),
            ("a.mtl", &format!("newmtl it\n{keys}")),
        ]);
        write(&folder.path("grey.pfm"), &grey, &Default::default()).expect("it is writable");
        let mut scene = folder.load("a.obj");
        let emission = scene.shapes[0].emission.as_ref().map(|e| e.constant());
        (scene.materials.remove(0), emission)
    };
    let alpha = |keys: &str| read(keys).0.alpha.constant();
    assert_eq!(alpha("Pr 1"), Some(Rgb::WHITE));
    assert_eq!(alpha("d 0.25"), Some(Rgb::grey(0.25)));
    assert_eq!(alpha("map_d grey.pfm"), Some(Rgb::grey(0.5)));
    assert_eq!(alpha("Tr 0.25"), Some(Rgb::grey(0.75)));
    assert_eq!(alpha("Tr 1"), Some(Rgb::WHITE));
    assert_eq!(alpha("Tr 0.25\nd 0.5"), Some(Rgb::grey(0.5)));
    assert_eq!(alpha("d 0.25\nmap_d grey.pfm"), Some(Rgb::grey(0.125)));

    let (material, emission) = read("norm -bm 1 grey.pfm");
    let map = material.normal_map.expect("it is written");
    assert_eq!(
        (map.texture.constant(), map.strength),
        (Some(Rgb::grey(0.5)), 1.0)
    );
    assert!(emission.is_none() && read("d 1").0.normal_map.is_none());

    let emission = |keys: &str| read(keys).1;
    assert_eq!(emission("map_Ke grey.pfm"), Some(Some(Rgb::grey(0.5))));
    let times = emission("Ke 3 3 3\nmap_Ke grey.pfm");
    assert_eq!(times, Some(Some(Rgb::grey(1.5))));
    let tinted = emission("map_Ke grey.pfm\nKe 4 2 0");
    assert_eq!(tinted, Some(Some(Rgb::new(2.0, 1.0, 0.0))));
}

#[test]
fn bare_model_gets_a_framing_camera_and_white_sky() {
    let cube = "v -3 10 0\nv 5 10 0\nv 1 90 2\nv 1 50 -40\nf 1 2 3\nf 1 2 4\n";
    let scene = load_model(cube, "");
    assert_eq!(scene.constant_environment(), Rgb::WHITE);
    for words in ["camera was placed", "white sky was added"] {
        assert!(
            scene.notes.iter().any(|note| note.text.contains(words)),
            "{:?}",
            scene.notes
        );
    }
    let camera = &scene.camera;
    let (width, height) = scene.film.size;
    let top = (0.5 * camera.fov).tan();
    let right = top * f64::from(width) / f64::from(height);
    for position in &mesh(&scene, 0).positions {
        let seen: DVec3 = camera.to_world.inverse().transform_point3(*position);
        let (x, y) = (seen.x / -seen.z, seen.y / -seen.z);
        assert!(
            seen.z < 0.0 && x.abs() < right && y.abs() < top,
            "{position} is outside the image"
        );
    }
    let lamp = load_model(
        &format!("mtllib a.mtl\nusemtl it\n{TRIANGLE}"),
        "newmtl it\nKe 1 1 1\n",
    );
    assert_eq!(lamp.constant_environment(), Rgb::BLACK);
    let grey = load_model(&format!("usemtl it\n{TRIANGLE}"), "");
    assert!(
        grey.notes[0].text.contains("drawn grey"),
        "{:?}",
        grey.notes
    );
}

fn model<'a>(scene: &'a SceneDescription, name: &str) -> &'a MaterialModel {
    let found = scene
        .materials
        .iter()
        .find(|material| material.name == name);
    &found.unwrap_or_else(|| panic!("no material {name}")).model
}

#[test]
fn suzanne_room_has_expected_triangles_materials_and_emitter() {
    let scene = load(&in_repository("scenes/suzanne-room/suzanne-room.toml")).expect("it is valid");
    assert_eq!(scene.materials.len(), 10);
    let count: usize = (0..scene.shapes.len())
        .map(|i| placed(&scene, i).len())
        .sum();
    assert_eq!(count, 73_840);
    let lamps: Vec<usize> = (0..scene.shapes.len())
        .filter(|&i| scene.shapes[i].emission.is_some())
        .collect();
    assert_eq!(lamps.len(), 1);
    let lamp = &scene.shapes[lamps[0]];
    let emission = lamp.emission.as_ref().and_then(|e| e.constant());
    assert_eq!(emission, Some(Rgb::new(12.0, 11.16, 9.96)));
    assert!(!lamp.two_sided_emission);
    for [a, b, c] in placed(&scene, lamps[0]) {
        assert!(
            (b - a).cross(c - a).normalize().distance(DVec3::NEG_Y) < 1e-6,
            "{a} {b} {c}"
        );
    }
    let MaterialModel::Dielectric {
        ior,
        roughness,
        tint,
    } = model(&scene, "glass")
    else {
        panic!()
    };
    assert_eq!((*ior, *roughness, base(tint)), (1.5, 0.0, Rgb::WHITE));
    let MaterialModel::Principled {
        metallic,
        roughness,
        base_color,
        ..
    } = model(&scene, "gold")
    else {
        panic!()
    };
    assert_eq!((*metallic, *roughness), (1.0, 0.2));
    assert_eq!(base(base_color), Rgb::new(1.0, 0.77, 0.34));
    let walls = scene
        .materials
        .iter()
        .filter(|material| material.name.contains("wall"));
    assert!(walls.clone().count() > 0);
    for wall in walls {
        assert!(
            matches!(wall.model, MaterialModel::Diffuse { .. }),
            "{wall:?}"
        );
    }
}

#[test]
fn scene_format_documentation_examples_load() {
    let page = include_str!("../../docs/scene-format.md");
    let examples: Vec<&str> = page
        .split("```toml\n")
        .skip(1)
        .map(|rest| {
            rest.split("```")
                .next()
                .expect("split yields at least one part")
        })
        .collect();
    assert!(examples.len() >= 9, "{} examples", examples.len());
    let folder = SceneFolder::new([("model.obj", TRIANGLE)]);
    std::fs::copy(
        in_repository("scenes/suzanne-room/planks.png"),
        folder.path("planks.png"),
    )
    .expect("the folder is writable");
    let sky = Image::filled(2, 1, Rgb::WHITE);
    write(&folder.path("sky.hdr"), &sky, &WriteOptions::default()).expect("writable");
    for example in examples {
        // An example shows one table; the rest of the scene is added here.
        let head = match (example.contains("version ="), example.contains("[camera]")) {
            (true, _) => "",
            (false, true) => "version = 1\n",
            (false, false) => HEAD,
        };
        std::fs::write(folder.path("a.toml"), format!("{head}{example}")).expect("writable");
        folder.load("a.toml");
    }
}
