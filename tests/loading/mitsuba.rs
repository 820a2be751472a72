//! Scenes of Mitsuba 3: conventions, references, meshes, and damaged files.
//!
//! Measure: world units, radians.
//! Range: scenes that are made here, and those of Bitterli's collection.
//! Source: docs/scene-formats.md. `scripts/against-mitsuba.py` compares images with those of Mitsuba.

use crate::common::scene_folder::{SceneFolder, in_repository};
use etendue::Error;
use etendue::description::{
    GeometryDescription, LightModel, MaterialModel, MeshDescription, NoteKind, SceneDescription,
};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::DVec3;
use etendue::internals::scene::load::load;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::Write;

const SENSOR: &str = r#"<sensor type="perspective"><float name="fov" value="40"/></sensor>"#;

pub fn scene(content: &str) -> String {
    format!("<scene version=\"3.0.0\">\n{SENSOR}\n{content}\n</scene>")
}

pub fn read(text: &str) -> Result<SceneDescription, Error> {
    load(&SceneFolder::new([("a.xml", text)]).path("a.xml"))
}

pub fn valid(content: &str) -> SceneDescription {
    read(&scene(content)).unwrap_or_else(|error| panic!("{error}"))
}

pub fn complaint(content: &str) -> String {
    read(&scene(content))
        .expect_err("the scene is invalid")
        .to_string()
}

pub fn material(bsdf: &str) -> (MaterialModel, bool, SceneDescription) {
    let scene = valid(&format!("<shape type=\"sphere\">{bsdf}</shape>"));
    let it = &scene.materials[scene.shapes[0].material];
    (it.model.clone(), it.two_sided, scene.clone())
}

pub fn mesh(scene: &SceneDescription, index: usize) -> &MeshDescription {
    match &scene.shapes[index].geometry {
        GeometryDescription::Mesh(mesh) => mesh,
        other => panic!("{other:?}"),
    }
}

pub fn close(a: DVec3, b: DVec3) -> bool {
    a.distance(b) < 1e-6
}

#[test]
fn mitsuba_cornell_box_and_veach_mis_scenes_are_read() {
    let cornell = load(&in_repository("scenes/mitsuba/cornell-box/scene.xml")).expect("valid");
    assert_eq!((cornell.shapes.len(), cornell.film.size), (8, (1024, 1024)));
    assert_eq!(
        (cornell.render.spp, cornell.render.max_bounces),
        (Some(64), Some(29))
    );
    assert!(close(
        cornell.camera.to_world.translation,
        DVec3::new(0.0, 1.0, 6.8)
    ));
    assert!(close(
        cornell.camera.to_world.matrix3 * DVec3::NEG_Z,
        DVec3::NEG_Z
    ));
    assert!(close(cornell.camera.to_world.matrix3 * DVec3::X, DVec3::X));
    let light = cornell
        .shapes
        .last()
        .and_then(|shape| shape.emission.as_ref());
    assert_eq!(
        light.and_then(|light| light.constant()),
        Some(Rgb::new(17.0, 12.0, 4.0))
    );
    assert!(
        cornell.check_faithful().is_err(),
        "the integrator is unknown"
    );

    let veach = load(&in_repository("scenes/mitsuba/veach-mis/scene.xml")).expect("valid");
    assert_eq!(veach.render.max_bounces, Some(2));
    // The horizontal field of view is given.
    let fov = 2.0 * ((17.5_f64).to_radians().tan() * 720.0 / 1280.0).atan();
    assert!((veach.camera.fov - fov).abs() < 1e-12);
    let MaterialModel::Conductor {
        roughness, tint, ..
    } = veach.materials[0].model
    else {
        panic!("{:?}", veach.materials[0])
    };
    assert!((roughness - 0.1).abs() < 1e-6, "{roughness}");
    assert_eq!(tint, Rgb::grey(0.3));
}

#[test]
fn defaults_references_and_transforms_are_resolved_in_order() {
    let it = valid(
        r#"<default name="x" value="2"/><default name="x" value="3"/><default name="xy" value="5"/>
        <bsdf type="diffuse" id="red"><rgb name="reflectance" value="0.5, 0.25 0"/></bsdf>
        <shape type="cube"><ref id="red"/><transform name="to_world">
            <scale value="$x"/><translate x="$xy"/><rotate z="1" angle="90"/></transform></shape>
        <shape type="sphere"><ref name="bsdf" id="red"/><point name="center" x="1" y="2" z="3"/>
            <float name="radius" value="4"/></shape>"#,
    );
    assert!(close(
        it.shapes[0].transform.transform_point3(DVec3::ONE),
        DVec3::new(-2.0, 7.0, 2.0)
    ));
    assert_eq!(it.materials.len(), 1);
    assert!(!it.materials[0].two_sided);
    assert!(close(
        it.shapes[1].transform.translation,
        DVec3::new(1.0, 2.0, 3.0)
    ));
    let [a, b] = [
        "<lookat origin=\"1, 2, 3\" target=\"1, 2, 0\" up=\"0, 1, 0\"/>",
        "<matrix value=\"-1 0 0 1 0 1 0 2 0 0 -1 3 0 0 0 1\"/>",
    ]
    .map(|step| {
        let sensor = format!(
            "<scene version=\"3.0.0\"><sensor type=\"thinlens\"><float name=\"aperture_radius\" value=\"0.5\"/>\
            <float name=\"focus_distance\" value=\"7\"/><transform name=\"to_world\">{step}</transform></sensor></scene>"
        );
        read(&sensor).unwrap_or_else(|error| panic!("{error}")).camera
    });
    assert!(close(a.to_world.translation, b.to_world.translation));
    assert!(close(
        a.to_world.matrix3 * DVec3::ONE,
        b.to_world.matrix3 * DVec3::ONE
    ));
    assert!(close(a.to_world.matrix3 * DVec3::ONE, DVec3::ONE));
    assert_eq!((a.lens_radius, a.focus_distance), (0.5, 7.0));
    assert!(!a.is_mirrored && !b.is_mirrored);
}

/// Mitsuba applies the steps in order, so that a mirror before `lookat` is one of the camera's own axes.
#[test]
fn mirrored_sensors_have_mirrored_images() {
    let camera = |steps: &str| {
        let sensor = format!(
            "<scene version=\"3.0.0\"><sensor type=\"perspective\"><transform name=\"to_world\">{steps}\
            <lookat origin=\"1, 2, 3\" target=\"1, 2, 0\" up=\"0, 1, 0\"/></transform></sensor></scene>"
        );
        read(&sensor)
            .unwrap_or_else(|error| panic!("{error}"))
            .camera
    };
    let straight = camera("");
    let mirrored = camera("<scale x=\"-1\"/>");
    assert!(
        mirrored.is_mirrored && close(mirrored.to_world.translation, straight.to_world.translation)
    );
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        assert!(close(
            mirrored.to_world.matrix3 * axis,
            straight.to_world.matrix3 * axis
        ));
    }
    // Upside down is a mirror and half a turn.
    let turned = camera("<scale y=\"-1\"/>");
    assert!(turned.is_mirrored);
    assert!(close(turned.to_world.matrix3 * DVec3::Y, DVec3::NEG_Y));
    assert!(close(turned.to_world.matrix3 * DVec3::X, DVec3::NEG_X));
    assert!(!camera("<scale x=\"-1\" y=\"-1\"/>").is_mirrored);
}

#[test]
fn scenes_of_versions_before_2_are_upgraded() {
    let old = read(
        r#"<scene version="0.6.0"><sensor type="thinlens"><float name="apertureRadius" value="0.5"/>
        <transform name="toWorld"><lookAt origin="1, 2, 3" target="1, 2, 0" up="0, 1, 0"/></transform></sensor>
        <shape type="sphere"><bsdf type="diffuse"><rgb name="diffuseReflectance" value="0.25"/></bsdf></shape></scene>"#,
    );
    let old = old.unwrap_or_else(|error| panic!("{error}"));
    assert!(close(
        old.camera.to_world.translation,
        DVec3::new(1.0, 2.0, 3.0)
    ));
    // Without a distance, a lens focuses at the end of the view.
    assert_eq!(
        (old.camera.lens_radius, old.camera.focus_distance),
        (0.5, 1e4)
    );
    let MaterialModel::Diffuse { reflectance } = &old.materials[0].model else {
        panic!("{:?}", old.materials[0])
    };
    assert_eq!(reflectance.constant(), Some(Rgb::grey(0.25)));
    assert!(old.check_faithful().is_ok());
}

/// The matrix is that which `mitsuba.traverse` of Mitsuba 3.9.1 reports for such a texture: rows (3, 0, 0), (0, 2, 0.5).
#[test]
fn scales_and_offsets_of_textures_before_version_2_become_to_uv() {
    let old = read(&format!(
        r#"<scene version="0.6.0">{SENSOR}<shape type="rectangle"><bsdf type="diffuse">
        <texture type="checkerboard" name="reflectance"><float name="uscale" value="3"/>
        <float name="voffset" value="0.25"/><float name="vscale" value="2"/></texture></bsdf></shape></scene>"#
    ));
    let old = old.unwrap_or_else(|error| panic!("{error}"));
    assert!(old.check_faithful().is_ok(), "{:?}", old.notes);
    let mesh = mesh(&old, 0);
    let corner = mesh
        .positions
        .iter()
        .position(|p| *p == DVec3::new(1.0, 1.0, 0.0))
        .expect("a corner");
    // Mitsuba has v down: 1 - (2 + 0.5).
    assert_eq!(mesh.uvs[corner].to_array(), [3.0, -1.5]);
    // Today these names have no meaning.
    let new = valid(
        r#"<shape type="rectangle"><bsdf type="diffuse"><texture type="checkerboard" name="reflectance">
        <float name="uscale" value="3"/></texture></bsdf></shape>"#,
    );
    assert!(new.check_faithful().is_err());
}

#[test]
fn escaped_dollar_signs_are_not_parameters() {
    let it = valid(
        r#"<default name="x" value="2"/><bsdf type="diffuse" id="\$x$x"/>
        <shape type="sphere"><ref id="\$x2"/><float name="radius" value="$x"/></shape>"#,
    );
    assert_eq!(it.materials[0].name, "$x2");
}

#[test]
fn parameters_that_insert_one_another_are_limited() {
    let mut defaults = "<default name=\"a0\" value=\"0123456789\"/>".to_owned();
    for i in 1..60 {
        let last = i - 1;
        defaults += &format!("<default name=\"a{i}\" value=\"$a{last},$a{last},\"/>");
    }
    let words = complaint(&defaults);
    assert!(words.contains("insert at most 64 times"), "{words}");
}

#[test]
fn aliases_and_capitalised_booleans_are_read() {
    let it = valid(
        r#"<bsdf type="diffuse" id="red"><rgb name="reflectance" value="0.5, 0.25 0"/></bsdf>
        <alias id="red" as="wall"/><shape type="cube"><boolean name="flip_normals" value="False"/><ref id="wall"/></shape>"#,
    );
    let MaterialModel::Diffuse { reflectance } = &it.materials[0].model else {
        panic!("{:?}", it.materials[0])
    };
    assert_eq!(reflectance.constant(), Some(Rgb::new(0.5, 0.25, 0.0)));
}

#[test]
fn mitsuba_conductors_are_converted_to_conductors_or_mirrors() {
    let (model, two_sided, _) = material(
        r#"<bsdf type="twosided"><bsdf type="roughconductor">
        <string name="material" value="Au"/><float name="alpha" value="0.25"/>
        <string name="distribution" value="ggx"/></bsdf></bsdf>"#,
    );
    let MaterialModel::Conductor { eta, roughness, .. } = model else {
        panic!("{model:?}")
    };
    assert!(two_sided);
    assert_eq!((eta, roughness), (Rgb::new(0.143, 0.3753, 1.442), 0.5));
    let (model, _, _) =
        material(r#"<bsdf type="conductor"><string name="material" value="none"/></bsdf>"#);
    assert!(matches!(model, MaterialModel::Mirror { .. }));
    // Without a metal's name, too, a conductor reflects all light.
    let (model, _, _) = material(r#"<bsdf type="conductor"/>"#);
    assert!(matches!(model, MaterialModel::Mirror { .. }));
    for indices in [
        "",
        r#"<rgb name="eta" value="0"/><rgb name="k" value="1"/>"#,
    ] {
        let (model, _, _) = material(&format!(
            r#"<bsdf type="roughconductor"><string name="material" value="none"/>
            <string name="distribution" value="ggx"/>{indices}</bsdf>"#
        ));
        let MaterialModel::Conductor { eta, k, .. } = model else {
            panic!("{model:?}")
        };
        assert_eq!((eta, k), (Rgb::grey(1e-4), Rgb::WHITE));
    }
}

#[test]
fn mitsuba_dielectrics_blends_and_masks_are_converted_to_materials() {
    let (model, two_sided, _) = material(
        r#"<bsdf type="dielectric"><string name="int_ior" value="water"/>
        <float name="ext_ior" value="1"/></bsdf>"#,
    );
    let MaterialModel::Dielectric { ior, roughness, .. } = model else {
        panic!("{model:?}")
    };
    assert!(two_sided);
    assert_eq!((ior, roughness), (1.333, 0.0));
    let (pane, two_sided, scene) = material(r#"<bsdf type="thindielectric"/>"#);
    assert!(two_sided && scene.check_faithful().is_ok());
    assert!(matches!(pane, MaterialModel::ThinDielectric { .. }));
    let (model, ..) = material(
        r#"<bsdf type="blendbsdf"><float name="weight" value="0.25"/>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.8"/></bsdf>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.4"/></bsdf></bsdf>"#,
    );
    let MaterialModel::Diffuse { reflectance } = model else {
        panic!("{model:?}")
    };
    let grey = reflectance.constant().expect("a constant").luminance();
    assert!((grey - 0.7).abs() < 1e-6);
    let masked = material(
        r#"<bsdf type="mask"><float name="opacity" value="0.25"/><bsdf type="diffuse"/></bsdf>"#,
    )
    .2;
    assert_eq!(masked.materials[0].alpha.constant(), Some(Rgb::grey(0.25)));
}

#[test]
fn mitsuba_bsdfs_without_an_equal_are_noted() {
    for (bsdf, kind) in [
        ("<bsdf type=\"plastic\"/>", NoteKind::Approximation),
        ("<bsdf type=\"principled\"/>", NoteKind::Approximation),
        ("<bsdf type=\"hair\"/>", NoteKind::Approximation),
        ("<bsdf type=\"roughconductor\"/>", NoteKind::Approximation),
        (
            "<bsdf type=\"diffuse\"><float name=\"shine\" value=\"1\"/></bsdf>",
            NoteKind::Omission,
        ),
    ] {
        let (_, _, scene) = material(bsdf);
        let found = scene
            .notes
            .iter()
            .any(|note| note.kind == kind && note.place.line == Some(3));
        assert!(found, "{bsdf}: {:?}", scene.notes);
        let error = scene.check_faithful().expect_err(bsdf);
        assert!(error.to_string().contains("a.xml:3: bsdf"), "{error}");
    }
}

#[test]
fn mitsuba_emitters_are_converted_or_noted_as_omitted() {
    let it = valid(
        r#"<emitter type="constant"><rgb name="radiance" value="0.5"/></emitter>
        <emitter type="point"><point name="position" x="1" y="2" z="3"/><rgb name="intensity" value="4"/></emitter>
        <emitter type="spot"><transform name="to_world"><lookat origin="0 5 0" target="0 0 0" up="0 0 1"/></transform>
            <float name="cutoff_angle" value="30"/><float name="beam_width" value="30"/></emitter>
        <emitter type="directional"><vector name="direction" x="0" y="-1" z="0"/></emitter>
        <emitter type="sunsky"/>
        <shape type="rectangle"><emitter type="area"><rgb name="radiance" value="7"/></emitter></shape>"#,
    );
    assert_eq!(it.lights.len(), 4);
    assert!(
        matches!(it.lights[1].model, LightModel::Point { position, .. } if position == DVec3::new(1.0, 2.0, 3.0))
    );
    let LightModel::Spot {
        position,
        target,
        penumbra,
        ..
    } = it.lights[2].model
    else {
        panic!("{:?}", it.lights[2])
    };
    assert!(close(position, DVec3::new(0.0, 5.0, 0.0)) && close(target - position, DVec3::NEG_Y));
    assert_eq!(penumbra, 0.0);
    assert!(
        it.notes
            .iter()
            .any(|note| note.kind == NoteKind::Omission && note.text.contains("sunsky"))
    );
    assert!(it.shapes[0].emission.is_some());
    // An emitter without a bsdf reflects nothing.
    let MaterialModel::Diffuse { reflectance } = &it.materials[0].model else {
        panic!("{:?}", it.materials[0])
    };
    assert!(reflectance.is_black());
}

#[test]
fn shapegroups_become_groups_placed_by_instances() {
    let it = valid(
        r#"<shape type="shapegroup" id="pair"><shape type="sphere"/><shape type="cube"/></shape>
        <shape type="instance"><ref id="pair"/><transform name="to_world"><translate y="3"/></transform></shape>
        <shape type="instance"><ref id="pair"/></shape>
        <shape type="merge"><shape type="cube"/><shape type="disk"/></shape>"#,
    );
    assert_eq!(
        (it.groups.len(), it.instances.len(), it.shapes.len()),
        (1, 2, 4)
    );
    assert_eq!(
        it.shapes
            .iter()
            .filter(|shape| shape.group == Some(0))
            .count(),
        2
    );
    assert_eq!(
        it.instances[0].transform.translation,
        DVec3::new(0.0, 3.0, 0.0)
    );
}

#[test]
fn normals_and_uvs_follow_mitsuba_conventions() {
    let checker = r#"<bsdf type="diffuse"><texture type="checkerboard" name="reflectance">
        <transform name="to_uv"><scale x="3" y="2"/></transform></texture></bsdf>"#;
    let it = valid(&format!(
        "<shape type=\"rectangle\">{checker}</shape><shape type=\"rectangle\">{checker}\
        <boolean name=\"flip_normals\" value=\"true\"/></shape>"
    ));
    for (index, facing) in [1.0, -1.0].into_iter().enumerate() {
        let mesh = mesh(&it, index);
        for triangle in &mesh.indices {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            assert_eq!((b - a).cross(c - a).z.signum(), facing);
            assert_eq!(mesh.normals[triangle[0] as usize].z.signum(), facing);
        }
        // Mitsuba has v down, and ours is mirrored: the corner (1, 1) is at (3, 1 - 2).
        let corner = mesh
            .positions
            .iter()
            .position(|p| *p == DVec3::new(1.0, 1.0, 0.0))
            .expect("a corner");
        assert_eq!(mesh.uvs[corner].to_array(), [3.0, -1.0]);
    }
    let cube = valid(
        "<shape type=\"cube\"><boolean name=\"face_normals\" value=\"true\"/>\
        <transform name=\"to_world\"><scale x=\"-1\"/></transform></shape>",
    );
    let cube = mesh(&cube, 0);
    assert!(cube.normals.is_empty());
    for triangle in &cube.indices {
        let [a, b, c] = triangle.map(|i| cube.positions[i as usize]);
        assert!(
            (b - a).cross(c - a).dot(a + b + c) < 0.0,
            "mirrored without normals: inside out"
        );
    }
}

#[test]
fn second_to_uv_of_a_material_is_noted_for_normal_maps_as_for_colours() {
    let checker = |place: &str, scale: f32| {
        format!(
            r#"<texture type="checkerboard" {place}><transform name="to_uv"><scale x="{scale}"/></transform></texture>"#
        )
    };
    let notes = |scale: f32| {
        let (map, colour) = (checker("", scale), checker("name=\"reflectance\"", 3.0));
        let it = valid(&format!(
            r#"<shape type="rectangle"><bsdf type="normalmap">{map}<bsdf type="diffuse">{colour}</bsdf></bsdf></shape>"#
        ));
        assert!(it.materials[0].normal_map.is_some());
        let is_of_to_uv = |text: &str| text.contains("gets the `to_uv` of the material's first");
        let notes = it.notes.iter().filter(|note| is_of_to_uv(&note.text));
        notes.map(|note| note.kind).collect::<Vec<_>>()
    };
    assert_eq!(notes(2.0), [NoteKind::Approximation]);
    assert!(notes(3.0).is_empty());
}

/// A mesh of two triangles in the format `serialized`.
fn serialized(version: u16) -> Vec<u8> {
    let mut stream = Vec::new();
    stream.extend(0x1002_u32.to_le_bytes());
    if version == 4 {
        stream.extend(b"a\0");
    }
    stream.extend(4_u64.to_le_bytes());
    stream.extend(2_u64.to_le_bytes());
    let positions = [
        0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0_f32,
    ];
    let uvs = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0_f32];
    stream.extend(positions.iter().chain(&uvs).flat_map(|x| x.to_le_bytes()));
    stream.extend([0, 1, 2, 0, 2, 3_u32].iter().flat_map(|i| i.to_le_bytes()));
    let mut file = Vec::new();
    file.extend(0x041c_u16.to_le_bytes());
    file.extend(version.to_le_bytes());
    let mut encoder = ZlibEncoder::new(&mut file, Compression::default());
    encoder.write_all(&stream).expect("memory");
    encoder.finish().expect("memory");
    if version == 4 {
        file.extend(0_u64.to_le_bytes());
    } else {
        file.extend(0_u32.to_le_bytes());
    }
    file.extend(1_u32.to_le_bytes());
    file
}

fn load_serialized(bytes: &[u8], index: usize) -> Result<SceneDescription, Error> {
    let text = scene(&format!(
        "<shape type=\"serialized\"><string name=\"filename\" value=\"a.serialized\"/>\
        <integer name=\"shape_index\" value=\"{index}\"/></shape>"
    ));
    load(&SceneFolder::new([("a.xml", text.as_bytes()), ("a.serialized", bytes)]).path("a.xml"))
}

#[test]
fn serialized_meshes_are_read_and_truncated_ones_rejected() {
    for version in [3, 4] {
        let whole = serialized(version);
        let it = load_serialized(&whole, 0).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(mesh(&it, 0).indices, [[0, 1, 2], [0, 2, 3]]);
        assert!(mesh(&it, 0).normals.iter().all(|n| close(*n, DVec3::Z)));
        for length in 0..whole.len() {
            let error = load_serialized(&whole[..length], 0).expect_err("the file is cut");
            assert!(error.to_string().contains("a.serialized"), "{error}");
        }
        let error = load_serialized(&whole, 1)
            .expect_err("there is one mesh")
            .to_string();
        assert!(error.contains("there are 1 meshes"), "{error}");
    }
}

#[test]
fn mitsuba_errors_name_the_file_and_what_is_wrong() {
    for (content, expected) in [
        (
            "<shap type=\"cube\"/>",
            "a.xml:3: unknown element `shap`; did you mean `shape`?",
        ),
        (
            "<shape type=\"cub\"/>",
            "unknown shape `cub`; did you mean `cube`?",
        ),
        ("<shape/>", "a.xml:3: expected an attribute `type`"),
        (
            "<shape type=\"cube\"><ref id=\"m\"/></shape>",
            "a.xml:3: unknown id `m`",
        ),
        (
            "<bsdf id=\"a\" type=\"diffuse\"/><bsdf id=\"a\" type=\"diffuse\"/>",
            "an object of the id `a` already",
        ),
        (
            "<bsdf id=\"a\" type=\"twosided\"><ref id=\"a\"/></bsdf>",
            "a.xml:3: expected an object that does not contain itself",
        ),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"$r\"/></shape>",
            "unknown parameter `r`",
        ),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"1e999\"/></shape>",
            "expected a finite number, found 1e999",
        ),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"-1\"/></shape>",
            "expected a number above 0, found -1",
        ),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"1 2\"/></shape>",
            "expected 1 numbers, found 2",
        ),
        (
            "<shape type=\"obj\"><string name=\"filename\" value=\"none.obj\"/></shape>",
            "none.obj",
        ),
        ("<shape type=\"ply\"/>", "expected a `filename`"),
        (
            "<shape type=\"instance\"/>",
            "expected a reference to a shape of type shapegroup",
        ),
        (
            "<include filename=\"a.xml\"/>",
            "does a.xml include itself?",
        ),
        ("<include filename=\"none.xml\"/>", "a.xml:3: "),
        (
            "<emitter type=\"envmap\"><string name=\"filename\" value=\"none.exr\"/></emitter>",
            "a.xml:3: emitter `envmap`",
        ),
        ("<emitter type=\"lamp\"/>", "unknown emitter `lamp`"),
        (
            "<shape type=\"sphere\"><bsdf type=\"difuse\"/></shape>",
            "unknown bsdf `difuse`; did you mean `diffuse`?",
        ),
        (
            "<shape type=\"cube\"><transform name=\"to_world\"><scale value=\"0\"/></transform></shape>",
            "not singular",
        ),
        (
            "<shape type=\"cube\"><transform name=\"to_world\"><matrix value=\"1 2\"/></transform></shape>",
            "16 or 9",
        ),
        (
            "<integrator type=\"path\"><integer name=\"max_depth\" value=\"-2\"/></integrator>",
            "expected -1, or",
        ),
        ("<", "a.xml:"),
    ] {
        let words = complaint(content);
        assert!(words.contains("a.xml"), "{words}");
        assert!(words.contains(expected), "{expected}: {words}");
    }
}

#[test]
fn deep_mitsuba_files_and_those_without_scene_or_sensor_are_rejected() {
    let deep = "<shape type=\"merge\">".repeat(500) + &"</shape>".repeat(500);
    assert!(complaint(&deep).contains("nested at most 64 deep"));
    assert!(
        read("<scene version=\"3.0.0\"/>")
            .expect_err("no sensor")
            .to_string()
            .contains("expected a sensor")
    );
    assert!(
        read("<bsdf/>")
            .expect_err("no scene")
            .to_string()
            .contains("expected an element `scene`")
    );
}

#[test]
fn truncated_mitsuba_scene_is_rejected_at_every_length() {
    let whole =
        scene("<bsdf type=\"diffuse\" id=\"é\"/><shape type=\"cube\"><ref id=\"é\"/></shape>");
    for length in 0..whole.len() {
        let error = load(&SceneFolder::new([("a.xml", &whole.as_bytes()[..length])]).path("a.xml"));
        assert!(error.expect_err("it is cut").to_string().contains("a.xml"));
    }
}

#[test]
fn maps_of_normals_and_heights_are_read_and_the_outer_one_counts() {
    let checker = r#"<texture type="checkerboard"/>"#;
    let bumps = |inner: &str| {
        format!(
            r#"<bsdf type="bumpmap">{checker}<float name="scale" value="0.25"/>
            <boolean name="use_shadowing_function" value="false"/>{inner}</bsdf>"#
        )
    };
    let (_, _, it) = material(&bumps(r#"<bsdf type="diffuse"/>"#));
    let height = it.materials[0].bump_map.as_ref().map(|map| map.height);
    assert_eq!(height, Some(0.25));
    it.check_faithful().expect("it is as the file says");
    let normals = format!(r#"<bsdf type="normalmap">{checker}<bsdf type="diffuse"/></bsdf>"#);
    let (_, _, it) = material(&normals);
    let map = it.materials[0].normal_map.as_ref().expect("a map");
    assert!(map.is_right_handed && it.notes.iter().any(|it| it.text.contains("shadowing")));
    let (_, _, it) = material(&bumps(&normals));
    let outer = &it.materials[0];
    assert!(outer.normal_map.is_none() && outer.bump_map.is_some());
    assert!(
        it.notes
            .iter()
            .any(|it| it.text.contains("replaces the map"))
    );
    let error = complaint(
        r#"<shape type="sphere"><bsdf type="bumpmap"><bsdf type="diffuse"/></bsdf></shape>"#,
    );
    assert!(error.contains("a nested texture"), "{error}");
}

#[test]
fn bsdfs_of_versions_before_2_are_read() {
    let (phong, _, it) =
        material(r#"<bsdf type="phong"><float name="exponent" value="50"/></bsdf>"#);
    assert!(
        matches!(phong, MaterialModel::Phong { exponent: 50.0, .. }),
        "{phong:?}"
    );
    it.check_faithful().expect("it is as the file says");
    let coat = r#"<bsdf type="coating"><bsdf type="roughconductor"><string name="material" value="Au"/>
        <string name="distribution" value="ggx"/></bsdf></bsdf>"#;
    let (gold, _, it) = material(coat);
    let coat = it.materials[0].clear_coat.expect("a coat");
    assert!(matches!(gold, MaterialModel::Conductor { .. }));
    assert!(
        (coat.ior - 1.5046 / 1.000_277).abs() < 1e-3 && coat.roughness == 0.0,
        "{coat:?}"
    );
    let (model, _, it) = material(r#"<bsdf type="coating"><bsdf type="diffuse"/></bsdf>"#);
    assert!(matches!(model, MaterialModel::Diffuse { .. }));
    assert!(it.check_faithful().is_err());
}

#[test]
fn transforms_of_textures_of_which_the_mean_counts_do_not_hold_for_others() {
    let texture = |name: &str, scale: f32| {
        format!(
            r#"<texture type="checkerboard" name="{name}"><transform name="to_uv"><scale value="{scale}"/></transform></texture>"#
        )
    };
    let it = valid(&format!(
        r#"<shape type="rectangle"><bsdf type="principled">{}{}</bsdf></shape>"#,
        texture("roughness", 1.0),
        texture("base_color", 8.0),
    ));
    let uvs = &mesh(&it, 0).uvs;
    let largest = uvs.iter().map(|uv| uv.x).fold(0.0, f64::max);
    assert_eq!(largest, 8.0);
}

#[test]
fn properties_of_value_0_are_no_omission() {
    let sensor = SENSOR.replace(
        "</sensor>",
        r#"<float name="principal_point_offset_x" value="0"/></sensor>"#,
    );
    let sphere = r#"<shape type="sphere"/>"#;
    let it = read(&format!(
        "<scene version=\"3.0.0\">{sensor}{sphere}</scene>"
    ));
    it.and_then(|it| it.check_faithful())
        .expect("it is as the file says");
}
