//! Scenes from files: every key arrives where it belongs, and whatever is wrong is told with its place.

use etendue::geometry::texture::Texture;
use etendue::math::rgb::Rgb;
use etendue::math::vec::{DVec2, DVec3};
use etendue::scene::description::{
    ColourDescription, FilterKind, GeometryDescription, MaterialModel, MeshDescription,
    SceneDescription, ShapeDescription,
};
use etendue::scene::load::load;
use etendue::{Error, ErrorKind};
use proptest::prelude::*;
use std::path::Path;
use tempfile::TempDir;

const HEAD: &str = "version = 1\n[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n";
const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// A folder with these files.
fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).expect("the folder is writable");
    }
    folder
}

fn try_files(files: &[(&str, &str)]) -> Result<SceneDescription, Error> {
    let bytes: Vec<_> = files
        .iter()
        .map(|(name, text)| (*name, text.as_bytes()))
        .collect();
    load(&folder(&bytes).path().join(files[0].0))
}

/// Loads a scene that consists of the camera and `rest`.
fn scene(rest: &str) -> SceneDescription {
    try_files(&[("a.toml", &format!("{HEAD}{rest}"))]).expect(rest)
}

/// The error of a scene that consists of the camera, in four lines, and `rest`.
fn complaint(rest: &str) -> String {
    let error = try_files(&[("a.toml", &format!("{HEAD}{rest}"))]).expect_err(rest);
    assert_eq!(error.kind(), ErrorKind::Scene, "{error}");
    error.to_string()
}

/// The error of a model with a library.
fn model_complaint(obj: &str, mtl: &str) -> Error {
    try_files(&[("a.obj", obj), ("a.mtl", mtl)]).expect_err(obj)
}

fn mesh_of(shape: &ShapeDescription) -> &MeshDescription {
    match &shape.geometry {
        GeometryDescription::Mesh(mesh) => mesh,
        other => panic!("{other:?} is no mesh"),
    }
}

fn constant(colour: &ColourDescription) -> Rgb {
    match colour {
        ColourDescription::Constant(colour) => *colour,
        ColourDescription::Texture(texture) => panic!("{texture:?} is not constant"),
    }
}

#[test]
fn a_camera_looks_at_its_target_and_focuses_there() {
    let camera = scene("").camera;
    let at = |p: DVec3| camera.to_world.transform_point3(p);
    assert!((at(DVec3::ZERO) - DVec3::new(0.0, 0.0, 5.0)).length() < 1e-12);
    assert!(at(DVec3::new(0.0, 0.0, -5.0)).length() < 1e-12);
    assert!((at(DVec3::Y) - DVec3::new(0.0, 1.0, 5.0)).length() < 1e-12);
    assert_eq!(camera.focus_distance, 5.0);
    assert_eq!(camera.lens_radius, 0.0);
}

#[test]
fn camera_film_and_render_tables_arrive() {
    let scene = try_files(&[(
        "a.toml",
        "version = 1\n[camera]\ntransform = [{ rotate = { axis = [0, 2, 0], angle = 90 } }, { translate = [1, 2, 3] }]\n\
         fov = 90\nlens_radius = 0.5\nfocus_distance = 3\nshutter = [0.5, 0.5]\n\
         [film]\nsize = [10, 20]\nfilter = { type = \"tent\", radius = 2.5 }\n\
         [render]\nintegrator = \"path\"\nspp = 9\nsampler = \"sobol\"\nmax_bounces = 0\nseed = 18446744073709551615\n",
    )])
    .expect("all of it is valid");
    let camera = scene.camera;
    let forward = camera.to_world.transform_vector3(DVec3::NEG_Z);
    assert!((forward - DVec3::NEG_X).length() < 1e-12);
    assert_eq!(camera.to_world.translation, DVec3::new(1.0, 2.0, 3.0));
    assert!((camera.fov - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!((camera.lens_radius, camera.focus_distance), (0.5, 3.0));
    assert_eq!(scene.film.size, (10, 20));
    assert_eq!(
        (scene.film.filter.kind, scene.film.filter.radius),
        (FilterKind::Tent, 2.5)
    );
    let render = scene.render;
    let name = |written: Option<etendue::scene::description::Written<String>>| {
        written.map(|w| (w.value, w.line))
    };
    assert_eq!(name(render.integrator), Some(("path".to_owned(), 12)));
    assert_eq!(name(render.sampler), Some(("sobol".to_owned(), 14)));
    assert_eq!(
        (render.spp, render.max_bounces, render.seed),
        (Some(9), Some(0), Some(u64::MAX))
    );
}

#[test]
fn materials_arrive() {
    let scene = scene(
        "[[material]]\nname = 'a'\ntype = 'diffuse'\nreflectance = [0.1, 0.2, 0.3]\n\
         [[material]]\nname = 'b'\ntype = 'mirror'\nreflectance = '#ff8000'\n\
         [[material]]\nname = 'c'\ntype = 'conductor'\npreset = 'gold'\nroughness = 0.25\n\
         [[material]]\nname = 'd'\ntype = 'dielectric'\nior = 0.75\nroughness = 1\ntint = 0.5\n\
         [[material]]\nname = 'e'\ntype = 'principled'\nbase_color = 0.25\nmetallic = 0.5\nroughness = 0.125\nior = 2\ntransmission = 0.75\n\
         [[material]]\nname = 'f'\ntype = 'diffuse'\nreflectance = { checker = [0, 1], repeat = [2, 3] }\n",
    );
    let names: Vec<_> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["a", "b", "c", "d", "e", "f"]);
    assert_eq!(scene.materials[1].place.line, Some(9));
    let models: Vec<_> = scene.materials.iter().map(|m| &m.model).collect();
    let [
        MaterialModel::Diffuse { reflectance },
        MaterialModel::Mirror { reflectance: hex },
        MaterialModel::Conductor { roughness, k, .. },
        MaterialModel::Dielectric {
            ior: 0.75,
            roughness: 1.0,
            tint,
        },
        MaterialModel::Principled {
            base_color,
            metallic: 0.5,
            roughness: 0.125,
            ior: 2.0,
            transmission: 0.75,
        },
        MaterialModel::Diffuse {
            reflectance: ColourDescription::Texture(texture),
        },
    ] = models.as_slice()
    else {
        panic!("{models:?}");
    };
    assert_eq!(constant(reflectance), Rgb::new(0.1, 0.2, 0.3));
    let [r, g, b] = constant(hex).to_array();
    assert!((r - 1.0).abs() < 1e-6 && (g - 0.21586).abs() < 1e-4 && b == 0.0);
    assert_eq!(*roughness, 0.25);
    assert!(k.to_array().iter().all(|k| *k > 0.0));
    assert_eq!(constant(tint), Rgb::grey(0.5));
    assert_eq!(constant(base_color), Rgb::grey(0.25));
    let Texture::Checker { colours, repeat } = texture.as_ref() else {
        panic!("{texture:?}");
    };
    assert_eq!(*colours, [Rgb::BLACK, Rgb::WHITE]);
    assert_eq!(repeat.to_array(), [2.0, 3.0]);
}

#[test]
fn shapes_arrive() {
    let scene = scene(
        "[[material]]\nname = 'red'\ntype = 'diffuse'\n\
         [[shape]]\ntype = 'sphere'\ncenter = [1, 2, 3]\nradius = 4\nmaterial = 'red'\n\
         [[shape]]\ntype = 'disk'\nname = 'plate'\ncenter = [0, 0, 0]\nnormal = [0, 2, 0]\nradius = 0.5\n\
         [[shape]]\ntype = 'rectangle'\ncorner = [0, 0, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nemission = [1, 2, 3]\ntwo_sided_emission = true\n\
         [[shape]]\ntype = 'box'\nmin = [0, 0, 0]\nmax = [1, 2, 3]\n\
         [[shape]]\ntype = 'mesh'\npositions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\nindices = [[0, 1, 2]]\nuvs = [[0, 0], [1, 0], [0, 1]]\nnormals = [[0, 0, 1], [0, 0, 1], [0, 0, 1]]\n\
         [[light]]\ntype = 'environment'\nradiance = 0.25\n\
         [[light]]\ntype = 'environment'\nradiance = [0, 1, 0]\n",
    );
    let [sphere, disk, rectangle, cuboid, mesh] = scene.shapes.as_slice() else {
        panic!("{:?}", scene.shapes);
    };
    assert_eq!((sphere.name.as_str(), sphere.material), ("sphere 1", 0));
    assert_eq!(sphere.place.line, Some(8));
    assert!(
        matches!(sphere.geometry, GeometryDescription::Sphere { center, radius: 4.0 } if center == DVec3::new(1.0, 2.0, 3.0))
    );
    assert_eq!((disk.name.as_str(), disk.material), ("plate", 1));
    assert_eq!(scene.materials[1].name, "default");
    assert!(
        matches!(disk.geometry, GeometryDescription::Disk { normal, radius: 0.5, .. } if normal == 2.0 * DVec3::Y)
    );
    assert_eq!(rectangle.emission, Some(Rgb::new(1.0, 2.0, 3.0)));
    assert!(rectangle.two_sided_emission && !disk.two_sided_emission);
    assert!(
        matches!(rectangle.geometry, GeometryDescription::Rectangle { edge_u, edge_v, .. } if edge_u == DVec3::X && edge_v == DVec3::Z)
    );
    assert!(
        matches!(cuboid.geometry, GeometryDescription::Box { max, .. } if max == DVec3::new(1.0, 2.0, 3.0))
    );
    let expected = MeshDescription {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        normals: vec![DVec3::Z; 3],
        uvs: vec![DVec2::ZERO, DVec2::X, DVec2::Y],
        indices: vec![[0, 1, 2]],
    };
    assert_eq!(mesh_of(mesh), &expected);
    assert_eq!(scene.environment, Rgb::new(0.25, 1.25, 0.25));
}

#[test]
fn a_transform_applies_its_steps_in_order() {
    let scene = scene(
        "[[shape]]\ntype = 'sphere'\ncenter = [0, 0, 0]\nradius = 1\ntransform = [\n\
         { scale = [2, 3, 4] },\n{ rotate = { axis = [0, 0, 5], angle = 90 } },\n{ translate = [1, 0, 0] },\n\
         { scale = 2 },\n{ matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 7, 0, 0, 0, 1] }]\n",
    );
    let transform = scene.shapes[0].transform;
    // (1, 0, 0) -> (2, 0, 0) -> (0, 2, 0) -> (1, 2, 0) -> (2, 4, 0) -> (2, 4, 7).
    let image = transform.transform_point3(DVec3::X);
    assert!((image - DVec3::new(2.0, 4.0, 7.0)).length() < 1e-12);
}

#[test]
fn what_is_wrong_in_a_scene_is_told_with_line_and_field() {
    let sphere = "[[shape]]\ntype = 'sphere'\ncenter = [0, 0, 0]\n";
    let material = "[[material]]\nname = 'a'\n";
    let cases = [
        (format!("{sphere}radius = -1"), "a.toml:8: shape[0].radius: expected a number above 0, found -1"),
        (format!("{sphere}radius = nan"), "a.toml:8: shape[0].radius: expected a number above 0, found nan"),
        (format!("{sphere}radius = inf"), "found inf"),
        (format!("{sphere}radius = 1e999"), "found 1e999"),
        (format!("{sphere}radius = '1'"), "expected a number above 0, found '1'"),
        (sphere.to_owned(), "a.toml:5: shape[0]: `radius` is missing"),
        (format!("{sphere}raduis = 1\nradius = 1"), "a.toml:8: shape[0]: unknown key `raduis`; did you mean `radius`?"),
        (format!("{sphere}radius = 1\nmotion = []"), "`motion` is not supported by this version"),
        (format!("{sphere}radius = 1\nmaterial = 'b'"), "a.toml:9: shape[0].material: unknown material `b`; there are none"),
        (format!("{sphere}radius = 1\nemission = -1"), "shape[0].emission: expected a colour of at least 0"),
        (format!("{sphere}radius = 1\nemission = 1e39"), "shape[0].emission: "),
        (format!("{sphere}radius = 1\ntransform = [{{ scale = 0 }}]"), "the transform of sphere 1 is singular"),
        (format!("{sphere}radius = 1\ntransform = [{{ scale = 1e200 }}]"), "the transform of sphere 1 is singular"),
        (format!("{sphere}radius = 1\ntransform = [{{ scael = 0 }}]"), "shape[0].transform[0]: unknown key `scael`; did you mean `scale`?"),
        (format!("{sphere}radius = 1\ntransform = [{{ rotate = {{ axis = [0, 0, 0], angle = 1 }} }}]"), "rotate.axis: expected an axis"),
        (format!("{sphere}radius = 1\ntransform = [{{ matrix = [1, 2] }}]"), "expected a list of 16 numbers, found a list of 2"),
        ("[[shape]]\ntype = 'shpere'".to_owned(), "a.toml:6: shape[0].type: unknown name `shpere`; did you mean `sphere`?"),
        ("[[shape]]\ntype = 'mesh'\npositions = [[0, 0, 0]]\nindices = [[0, 0, 1]]".to_owned(), "shape[0].indices[0][2]: expected a whole number from 0 to 0, found 1"),
        ("[[shape]]\ntype = 'mesh'\npositions = []\nindices = [[0, 0, 0]]".to_owned(), "there are no positions"),
        ("[[shape]]\ntype = 'rectangle'\ncorner = [0, 0, 0]\nedge_u = [1, 0, 0]\nedge_v = [2, 0, 0]".to_owned(), "parallel"),
        ("[[shape]]\ntype = 'box'\nmin = [0, 0, 0]\nmax = [1, 0, 1]".to_owned(), "below that of max"),
        (format!("{material}type = 'diffuse'\nreflectance = 1.5"), "a.toml:8: material[0].reflectance: expected a reflectance"),
        (format!("{material}type = 'diffuse'\nreflectance = '#+f+f+f'"), "a colour such as"),
        (format!("{material}type = 'diffuse'\nalpha = 0.5"), "`alpha` is not supported by this version"),
        (format!("{material}type = 'diffuse'\nreflectance = {{ texture = 'a.toml' }}"), "a.toml:8: material[0].reflectance.texture: "),
        (format!("{material}type = 'diffuse'\nreflectance = {{ checker = [1, 0], repeat = [1e39, 1] }}"), "repeat: "),
        (format!("{material}type = 'plastic'"), "`plastic` is not supported by this version"),
        (format!("{material}type = 'dielectric'\nior = 1e-60"), "ior: expected a number above 0"),
        (format!("{material}type = 'dielectric'\nior = 1e300"), "ior: expected a number above 0"),
        (format!("{material}type = 'conductor'\npreset = 'glod'"), "did you mean `gold`?"),
        (format!("{material}type = 'conductor'"), "a conductor needs either"),
        (format!("{material}type = 'diffuse'\n{material}type = 'mirror'"), "there is a material `a` already"),
        ("fov = 180".to_owned(), "a.toml:5: camera.fov: expected an angle"),
        ("up = [0, 0, 1]".to_owned(), "camera.target: "),
        ("shutter = [0, 1]".to_owned(), "motion is not supported"),
        ("focus_distance = 0".to_owned(), "camera.focus_distance: "),
        ("[film]\nsize = [0, 512]".to_owned(), "a.toml:6: film.size[0]: expected a whole number from 1 to 65536, found 0"),
        ("[film]\nsize = [1, 65537]".to_owned(), "film.size[1]: "),
        ("[film]\nfilter = 'gausian'".to_owned(), "did you mean `gaussian`?"),
        ("[render]\nspp = 0".to_owned(), "render.spp: expected a whole number of at least 1, found 0"),
        ("[render]\nspp = -4".to_owned(), "found -4"),
        ("[[light]]\ntype = 'spot'".to_owned(), "`spot` is not supported by this version"),
        ("[[light]]\ntype = 'environment'\nradiance = { texture = 'sky.hdr' }".to_owned(), "not supported by this version"),
        ("[camera]".to_owned(), "a.toml:5: "),
        ("camera = = 1".to_owned(), "a.toml:5: "),
        ("[scenery]".to_owned(), "a.toml:5: unknown key `scenery`"),
    ];
    for (rest, expected) in cases {
        let message = complaint(&rest);
        assert!(
            message.contains(expected),
            "{rest}\n  gives {message}\n  not {expected}"
        );
        let line = message.split_once(": ").map_or("", |(place, _)| place);
        assert!(line.contains("a.toml:"), "{message}");
    }
}

#[test]
fn the_version_has_to_be_there_and_to_be_1() {
    for (text, expected) in [
        ("[camera]", "a.toml:1: `version` is missing"),
        ("version = 2", "a.toml:1: version: expected 1"),
        ("version = 'x'", "a.toml:1: version: "),
        ("version = 1", "`camera` is missing"),
    ] {
        let message = try_files(&[("a.toml", text)]).expect_err(text).to_string();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn files_that_are_no_text_are_told() {
    let utf8 = folder(&[
        ("a.toml", b"version = 1\n\xff"),
        ("a.obj", b"v 0 0 0\n\n\xc3\x28"),
    ]);
    let message = |name: &str| load(&utf8.path().join(name)).expect_err(name).to_string();
    assert!(message("a.toml").contains("a.toml:2: expected UTF-8"));
    assert!(message("a.obj").contains("a.obj:3: expected UTF-8"));
    let missing = load(&utf8.path().join("b.toml")).expect_err("it is missing");
    assert_eq!(missing.kind(), ErrorKind::Io);
    let kind = load(&utf8.path().join("a.png"))
        .expect_err("no scene")
        .kind();
    assert_eq!(kind, ErrorKind::Usage);
    let folder = folder(&[]);
    std::fs::create_dir(folder.path().join("d.obj")).expect("writable");
    assert_eq!(
        load(&folder.path().join("d.obj"))
            .expect_err("a folder")
            .kind(),
        ErrorKind::Io
    );
    assert!(try_files(&[("a.toml", &format!("{HEAD}name = \"\0\""))]).is_err());
}

#[test]
fn byte_order_marks_and_windows_line_ends_are_fine() {
    let toml =
        format!("\u{feff}{HEAD}[[shape]]\ntype = 'obj'\nfile = 'a.obj'\n").replace('\n', "\r\n");
    let obj = format!("\u{feff}mtllib a.mtl\nusemtl m\n{TRIANGLE}").replace('\n', "\r\n");
    let mtl = "\u{feff}newmtl m\r\nKd 1 0 0\r\n";
    let scene = try_files(&[("a.toml", &toml), ("a.obj", &obj), ("a.mtl", mtl)]).expect("valid");
    assert_eq!(scene.materials[scene.shapes[0].material].name, "m");
}

#[test]
fn long_texts_are_not_repeated_in_full() {
    let long = "x".repeat(1 << 20);
    for message in [
        complaint(&format!("{long} = 1")),
        complaint(&format!("up = '{long}'")),
        complaint(&format!("[[material]]\nname = 'a'\ntype = '{long}'")),
        model_complaint(&format!("f {long}"), "").to_string(),
        model_complaint(
            &format!("mtllib a.mtl\nusemtl {long}\n{TRIANGLE}"),
            &format!("newmtl {long}y"),
        )
        .to_string(),
        model_complaint(
            &format!("mtllib a.mtl\n{TRIANGLE}"),
            &format!("newmtl a\nKd {long}"),
        )
        .to_string(),
    ] {
        assert!(message.len() < 1000, "{} bytes", message.len());
    }
}

#[test]
fn a_bare_model_is_framed_and_lit_unless_it_emits() {
    for (scale, offset) in [(1.0, 0.0), (1e-6, 0.0), (1e6, 1e9), (0.0, 1e10)] {
        let vertex = |x: f64, y: f64, z: f64| {
            format!("v {} {} {}\n", offset + scale * x, scale * y, scale * z)
        };
        let obj =
            vertex(0.0, 0.0, 0.0) + &vertex(3.0, 0.0, 0.0) + &vertex(0.0, 1.0, -2.0) + "f 1 2 3";
        let scene = try_files(&[("a.obj", &obj)]).expect("valid");
        assert_eq!(scene.film.size, (768, 512));
        assert_eq!(scene.environment, Rgb::WHITE);
        assert!(
            scene.notes.iter().any(|note| note.contains("sky")),
            "{:?}",
            scene.notes
        );
        let camera = &scene.camera;
        assert!(camera.to_world.is_finite() && camera.focus_distance > 0.0);
        let to_camera = camera.to_world.inverse();
        for &p in &mesh_of(&scene.shapes[0]).positions {
            let p = to_camera.transform_point3(p);
            assert!(p.z < 0.0, "{p} is behind the camera");
            assert!(
                p.y.abs() <= -p.z * (0.5 * camera.fov).tan(),
                "{p} is outside"
            );
        }
    }
    let emitting = format!("mtllib a.mtl\nusemtl lamp\n{TRIANGLE}");
    let scene = try_files(&[
        ("a.obj", &emitting),
        ("a.mtl", "newmtl lamp\nKd 0 0 0\nKe 1 2 3\n"),
    ])
    .expect("valid");
    assert_eq!(scene.environment, Rgb::BLACK);
    assert_eq!(scene.shapes[0].emission, Some(Rgb::new(1.0, 2.0, 3.0)));
    let huge = "v -1e308 0 0\nv 1e308 0 0\nv 0 1e308 0\nf 1 2 3\n";
    assert!(
        try_files(&[("a.obj", huge)])
            .expect_err("huge")
            .to_string()
            .contains("too large")
    );
}

#[test]
fn groups_and_materials_become_shapes() {
    let obj = "mtllib some materials.mtl\n\
               v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 1\nvn 0 0 1\n\
               o first\nusemtl red\nf 1 2 3 4\nusemtl blue stone\nf 1 2 3\n\
               g second\nf -4/1/1 -3/2/1 -2/1/1\nf 1 2\n";
    let mtl = "newmtl red\nKd 1 0 0\nPr 1\nnewmtl blue stone\nKd 0 0 1\nPr 0.5\nPm 1\nnewmtl unused\nmap_Kd none.png\n";
    let scene = try_files(&[("a.obj", obj), ("some materials.mtl", mtl)]).expect("valid");
    let shapes: Vec<_> = scene
        .shapes
        .iter()
        .map(|s| {
            (
                s.name.as_str(),
                scene.materials[s.material].name.as_str(),
                s.place.line,
            )
        })
        .collect();
    let expected = [
        ("first", "red", Some(11)),
        ("first", "blue stone", Some(13)),
        ("second", "blue stone", Some(15)),
    ];
    assert_eq!(shapes, expected);
    assert_eq!(mesh_of(&scene.shapes[0]).indices, [[0, 1, 2], [0, 2, 3]]);
    let last = mesh_of(&scene.shapes[2]);
    assert_eq!(last.normals, [DVec3::Z; 3]);
    assert_eq!(last.uvs, [DVec2::ZERO, DVec2::ONE, DVec2::ZERO]);
    assert!(
        scene
            .notes
            .iter()
            .any(|note| note.contains("1 points and lines were left out"))
    );
}

#[test]
fn corners_with_and_without_texture_coordinates_stay_apart() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 1 0\nf 1/1 2/1 3/1\nf 1 2 3\nf 1/1 2 3\n";
    let scene = try_files(&[("a.obj", obj)]).expect("valid");
    let counts: Vec<_> = scene
        .shapes
        .iter()
        .map(|s| (mesh_of(s).indices.len(), mesh_of(s).uvs.len()))
        .collect();
    assert_eq!(counts, [(1, 3), (2, 0)]);
}

#[test]
fn what_is_wrong_in_a_model_is_told_with_its_line() {
    let cases: &[(&str, &str, &str)] = &[
        ("", "", "a.obj: expected a model, found no faces"),
        ("v 0 0 0\ng a\ng b\n", "", "found no faces"),
        ("v 0 0 0\nf 1\nf 1 1\nl 1 1\n", "", "found no faces"),
        ("v 0 0 0\nf 1 1 2", "", "a.obj:2: vertex 2 is out of range"),
        (
            "f -1 -1 -1\nv 0 0 0",
            "",
            "a.obj:1: vertex -1 is out of range",
        ),
        (
            "v 0 0 nan",
            "",
            "a.obj:1: expected a finite number, found `nan`",
        ),
        ("v 0 0 0\0", "", "a.obj:1: expected a finite number"),
        (
            "mtllib a.mtl\nv 0 0 0\nusemtl glas\nf 1 1 1",
            "newmtl glass",
            "a.obj:3: unknown material `glas`; did you mean `glass`?",
        ),
        (
            "mtllib a.mtl\nv 0 0 0\nf 1 1 1",
            "newmtl a\nKd 1 0",
            "a.mtl:2: Kd: expected three numbers from 0 to 1, found 1 0",
        ),
        (
            "mtllib a.mtl\nv 0 0 0\nf 1 1 1",
            "Kd 1 0 0",
            "a.mtl:1: Kd: expected newmtl first",
        ),
        (
            "mtllib a.mtl\nv 0 0 0\nusemtl a\nf 1 1 1",
            "newmtl a\nmap_Kd a.obj",
            "a.mtl:2: map_Kd: ",
        ),
    ];
    for (obj, mtl, expected) in cases {
        let error = model_complaint(obj, mtl);
        assert_eq!(error.kind(), ErrorKind::Scene, "{error}");
        assert!(
            error.to_string().contains(expected),
            "{error}\n  not {expected}"
        );
    }
    let missing =
        try_files(&[("a.obj", &format!("\nmtllib none.mtl\n{TRIANGLE}"))]).expect_err("missing");
    assert_eq!(missing.kind(), ErrorKind::Io);
    assert!(missing.to_string().contains("a.obj:2: "), "{missing}");
    assert!(
        missing.to_string().contains("none.mtl: cannot read"),
        "{missing}"
    );
}

#[test]
fn a_model_without_a_library_is_grey_and_one_with_unknown_keys_is_drawn() {
    let scene = try_files(&[("a.obj", &format!("usemtl a\n{TRIANGLE}"))]).expect("valid");
    assert_eq!(scene.materials[scene.shapes[0].material].name, "default");
    assert!(
        scene
            .notes
            .iter()
            .any(|note| note.contains("no material library"))
    );
    let obj = format!("usemtl a\nmtllib a.mtl\n{TRIANGLE}");
    let mtl = "newmtl a\nKb 1 0 0\nmap_Bump none.png\nKs 1 1 1\nd 0.5\n";
    let scene = try_files(&[("a.obj", &obj), ("a.mtl", mtl)]).expect("valid");
    assert_eq!(scene.materials[scene.shapes[0].material].name, "a");
    for expected in [
        "a.mtl:2: a: unknown key `Kb`; did you mean `Kd`?",
        "map_Bump",
        "drawn opaque",
    ] {
        assert!(
            scene.notes.iter().any(|note| note.contains(expected)),
            "{:?}",
            scene.notes
        );
    }
    assert!(!scene.notes.iter().any(|note| note.contains("Ks is")));
}

#[test]
fn a_scene_overrides_what_its_model_says() {
    let toml = format!(
        "{HEAD}[[material]]\nname = 'red'\ntype = 'diffuse'\n[[shape]]\ntype = 'obj'\nfile = 'a.obj'\nmaterial = 'red'\n\
         emission = 2\ntransform = [{{ scale = 3 }}]\n"
    );
    // The library is missing, which does not matter.
    let obj = format!("mtllib none.mtl\nusemtl a\n{TRIANGLE}usemtl b\nf 1 2 3\n");
    let scene = try_files(&[("a.toml", &toml), ("a.obj", &obj)]).expect("valid");
    assert_eq!(scene.shapes.len(), 2);
    for shape in &scene.shapes {
        assert_eq!((shape.material, shape.emission), (0, Some(Rgb::grey(2.0))));
        assert_eq!(shape.transform.transform_point3(DVec3::X), 3.0 * DVec3::X);
    }
    let toml = format!("{HEAD}[[shape]]\ntype = 'obj'\nfile = 'a.obj'\n");
    let error = try_files(&[("a.toml", &toml), ("a.obj", "f 1 2 3")]).expect_err("no vertices");
    let message = error.to_string();
    assert!(message.contains("a.toml:7: shape[0].file: "), "{message}");
    assert!(
        message.contains("a.obj:1: vertex 1 is out of range"),
        "{message}"
    );
}

#[test]
fn many_faces_names_and_corners_take_little_time() {
    let mut obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned();
    obj.push_str(&format!("f{}\n", " 1 2 3".repeat(33_334)));
    obj.push_str(&format!("g {}\n", "n".repeat(1 << 20)));
    for i in 0..20_000 {
        obj.push_str(&format!("usemtl m{}\nf 1 2 3\n", i % 2));
    }
    for i in 0..20_000 {
        obj.push_str(&format!("usemtl n{i}\nf 1 2 3\n"));
    }
    let start = std::time::Instant::now();
    let scene = try_files(&[("a.obj", &obj)]).expect("valid");
    assert_eq!(mesh_of(&scene.shapes[0]).indices.len(), 3 * 33_334 - 2);
    assert_eq!(scene.shapes.len(), 1 + 2 + 20_000);
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

#[test]
fn suzanne_room_loads() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let scene = load(&root.join("scenes/suzanne-room/suzanne-room.toml")).expect("our own scene");
    assert_eq!(scene.notes, Vec::<String>::new());
    assert_eq!(scene.materials.len(), 10);
    assert_eq!(scene.shapes.len(), 55);
    let triangles: usize = scene.shapes.iter().map(|s| mesh_of(s).indices.len()).sum();
    assert_eq!(triangles, 73_840);
    for shape in &scene.shapes {
        let mesh = mesh_of(shape);
        assert_eq!(mesh.normals.len(), mesh.positions.len(), "{}", shape.name);
    }

    let lamps: Vec<_> = scene
        .shapes
        .iter()
        .filter(|s| s.emission.is_some())
        .collect();
    let [lamp] = lamps.as_slice() else {
        panic!("{lamps:?}");
    };
    assert_eq!(lamp.emission, Some(Rgb::new(12.0, 11.16, 9.96)));
    let mesh = mesh_of(lamp);
    for [a, b, c] in mesh
        .indices
        .iter()
        .map(|t| t.map(|i| mesh.positions[i as usize]))
    {
        let normal = (b - a).cross(c - a).normalize();
        assert!(normal.y < -0.999, "the lamp shines along {normal}");
    }

    let model = |name: &str| {
        let material = scene.materials.iter().find(|m| m.name == name);
        &material.expect(name).model
    };
    assert!(matches!(
        model("glass"),
        MaterialModel::Dielectric {
            ior: 1.5,
            roughness: 0.0,
            ..
        }
    ));
    assert!(matches!(model("wall"), MaterialModel::Diffuse { .. }));
    assert!(matches!(
        model("gold"),
        MaterialModel::Principled {
            metallic: 1.0,
            roughness: 0.2,
            ..
        }
    ));
    assert!(matches!(
        model("ceramic"),
        MaterialModel::Principled {
            metallic: 0.0,
            roughness: 0.25,
            ..
        }
    ));
    assert!(matches!(
        model("planks"),
        MaterialModel::Principled {
            base_color: ColourDescription::Texture(_),
            ..
        }
    ));
}

#[test]
fn the_examples_of_the_documentation_load() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/scene-format.md");
    let text = std::fs::read_to_string(path).expect("the documentation is there");
    let examples: Vec<&str> = text
        .split("```toml\n")
        .skip(1)
        .map(|rest| rest.split("```").next().expect("split yields one part"))
        .collect();
    assert!(examples.len() >= 4);
    for example in examples {
        let scene = try_files(&[("a.toml", example)]).expect(example);
        assert_eq!(scene.notes, Vec::<String>::new());
    }
    for (metal, _, _) in etendue::bsdf::conductor::PRESETS {
        assert!(
            text.contains(&format!("`{metal}`")),
            "{metal} is not documented"
        );
    }
}

/// A small valid scene of every kind of file.
const SMALL: [(&str, &[u8]); 3] = [
    (
        "a.toml",
        b"version = 1\n[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nfov = 40\n[film]\nsize = [8, 8]\nfilter = { type = 'box', radius = 1 }\n\
          [[material]]\nname = 'a'\ntype = 'diffuse'\nreflectance = { checker = ['#ff0000', 0.5], repeat = [2, 2] }\n\
          [[shape]]\ntype = 'obj'\nfile = 'a.obj'\ntransform = [{ scale = 2 }, { rotate = { axis = [0, 1, 0], angle = 3 } }]\n\
          [[shape]]\ntype = 'mesh'\npositions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\nindices = [[0, 1, 2]]\nemission = 1e1\n",
    ),
    (
        "a.obj",
        b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1e0\nvt 0 0\nvn 0 0 1\ng b\nusemtl m\nf 1/1/1 2/1/1 3/1/1 4/1/1\nusemtl n\nf -1//-1 -2//1 -3//1\nf 1 2 3\nl 1 2\n",
    ),
    (
        "a.mtl",
        b"newmtl m\nKd 0.5 0.5 0.5\nKe 0 0 0\nNi 1.5\nd 1\nillum 2\nPr 0.5\nPm 0\nnewmtl n\nTf 1 1 1\nPr 0\nNs 10\n",
    ),
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever happens to the bytes of a file: a scene or an error, never a panic.
    #[test]
    fn damaged_files_never_panic(
        which in 0..SMALL.len(),
        damages in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..4_u8), 1..8),
    ) {
        let mut bytes = SMALL[which].1.to_vec();
        for (place, byte, kind) in damages {
            let place = place.index(bytes.len().max(1));
            // Mostly bytes that mean something to the formats.
            let byte = if byte < 160 { b"0123456789-+./e#[]{}='\" \n\\\tnvtf"[usize::from(byte) % 30] } else { byte };
            match kind {
                0 => bytes.truncate(place.max(1)),
                1 => bytes.insert(place, byte),
                2 => { bytes.remove(place); bytes.push(byte); }
                _ => bytes[place] = byte,
            }
        }
        let mut files = SMALL;
        files[which].1 = &bytes;
        let folder = folder(&files);
        for name in ["a.toml", "a.obj"] {
            let _ = load(&folder.path().join(name));
        }
    }
}
