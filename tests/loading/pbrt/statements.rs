//! Statements of pbrt files: transforms, attributes, objects, shapes, lights and options.

use super::{emission, file, near, notes, only_light, world, world_with};
use crate::common::scene_folder::SceneFolder;
use etendue::internals::image::{Image, WriteOptions, write};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DMat3, DVec2, DVec3};
use etendue::internals::scene::description::{
    FilterKind, GeometryDescription, LightModel, MeshDescription, NoteKind, SceneDescription,
};
use std::f32::consts::PI;

fn mesh(scene: &SceneDescription) -> &MeshDescription {
    match &scene.shapes.last().expect("a shape").geometry {
        GeometryDescription::Mesh(mesh) => mesh,
        other => panic!("{other:?} is no mesh"),
    }
}

/// Where the last shape puts the point (1, 2, 3).
fn moved(text: &str) -> DVec3 {
    let scene = world(&format!("{text}\nShape \"sphere\""));
    let shape = scene.shapes.last().expect("a shape");
    let start = shape
        .motion
        .first()
        .map_or(shape.transform, |key| key.transform * shape.transform);
    start.transform_point3(DVec3::new(1.0, 2.0, 3.0))
}

#[test]
fn transform_statements_compose_the_current_transform() {
    for (text, expected) in [
        ("", [1.0, 2.0, 3.0]),
        ("Translate 1 0 0", [2.0, 2.0, 3.0]),
        ("Scale 2 2 2", [2.0, 4.0, 6.0]),
        ("Translate 1 0 0 Scale 2 2 2", [3.0, 4.0, 6.0]),
        ("Scale 2 2 2 Translate 1 0 0", [4.0, 4.0, 6.0]),
        ("Rotate 90 0 0 1", [-2.0, 1.0, 3.0]),
        ("Rotate 90 0 0 1 Identity", [1.0, 2.0, 3.0]),
        (
            "Translate 9 9 9 Transform [ 0 1 0 0  -1 0 0 0  0 0 1 0  5 0 0 1 ]",
            [3.0, 1.0, 3.0],
        ),
        (
            "Translate 9 9 9 ConcatTransform [ 0 1 0 0  -1 0 0 0  0 0 1 0  5 0 0 1 ]",
            [12.0, 10.0, 12.0],
        ),
        (
            "Translate 1 1 1 CoordinateSystem \"a\" Identity CoordSysTransform \"a\"",
            [2.0, 3.0, 4.0],
        ),
        (
            "Translate 1 1 1 CoordSysTransform \"world\"",
            [1.0, 2.0, 3.0],
        ),
        // The camera of `HEAD` is at (0, 0, 5), has x to the right and looks along -z, its own z.
        ("CoordSysTransform \"camera\"", [1.0, 2.0, 2.0]),
        (
            "AttributeBegin Translate 1 1 1 AttributeEnd",
            [1.0, 2.0, 3.0],
        ),
        (
            "TransformBegin Translate 1 1 1 TransformEnd",
            [1.0, 2.0, 3.0],
        ),
        ("LookAt 0 0 1  0 0 2  0 1 0", [1.0, 2.0, 2.0]),
        ("ActiveTransform EndTime Translate 1 0 0", [1.0, 2.0, 3.0]),
        ("ActiveTransform StartTime Translate 1 0 0", [2.0, 2.0, 3.0]),
    ] {
        assert!(
            (moved(text) - DVec3::from(expected)).length() < 1e-12,
            "{text}: {}",
            moved(text)
        );
    }
}

#[test]
fn transform_times_and_active_transform_become_motion_keys() {
    let text = "TransformTimes 2 4\nScale -1 1 1\nCamera \"perspective\" \"float shutteropen\" 2 \"float shutterclose\" 3\n\
                WorldBegin\nShape \"sphere\"\nActiveTransform EndTime\nTranslate 1 0 0\nShape \"sphere\"\n\
                ObjectBegin \"a\"\nObjectEnd\nObjectInstance \"a\"";
    let scene = file(text);
    assert!(scene.shapes[0].motion.is_empty());
    for keys in [&scene.shapes[1].motion, &scene.instances[0].motion] {
        assert_eq!([keys[0].time, keys[1].time], [2.0, 4.0]);
        let at = |i: usize| keys[i].transform.translation;
        assert_eq!([at(0), at(1)], [DVec3::ZERO, DVec3::X]);
    }
    assert_eq!(scene.camera.shutter, [2.0, 3.0]);
    assert_eq!(world("Shape \"sphere\"").camera.shutter, [0.0, 0.0]);
}

#[test]
fn attribute_statement_sets_shape_defaults_within_its_block() {
    let scene = world(
        "AttributeBegin\nAttribute \"shape\" \"float radius\" 3\nShape \"sphere\"\n\
         Shape \"sphere\" \"float radius\" 2\nAttribute \"shape\" \"float radius\" 4\nShape \"sphere\"\nAttributeEnd\nShape \"sphere\"",
    );
    let radius = |index: usize| match &scene.shapes[index].geometry {
        GeometryDescription::Sphere { radius, .. } => *radius,
        other => panic!("{other:?}"),
    };
    assert_eq!([0, 1, 2, 3].map(radius), [3.0, 2.0, 4.0, 1.0]);
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
}

#[test]
fn objects_become_groups_and_instances() {
    let scene = world(
        "Translate 1 0 0\nObjectBegin \"a\"\nTranslate 0 1 0\nShape \"sphere\"\nObjectEnd\n\
         Translate 0 0 1\nObjectInstance \"a\"\nScale 2 2 2\nObjectInstance \"a\"\nShape \"sphere\"",
    );
    assert_eq!(scene.groups, ["a"]);
    assert_eq!(scene.shapes[0].group, Some(0));
    assert_eq!(
        scene.shapes[0].transform.translation,
        DVec3::new(1.0, 1.0, 0.0)
    );
    assert_eq!(scene.shapes[1].group, None);
    let instances: Vec<DVec3> = scene
        .instances
        .iter()
        .map(|it| it.transform.translation)
        .collect();
    assert_eq!(instances, [DVec3::new(1.0, 0.0, 1.0); 2]);
    assert_eq!(scene.instances[1].transform.matrix3, DMat3::IDENTITY * 2.0);
}

#[test]
fn include_changes_graphics_state_and_import_does_not() {
    for (statement, x) in [("Include", 1.0), ("Import", 0.0)] {
        for name in ["b.pbrt", "b.pbrt.gz"] {
            let content = b"Translate 1 0 0\n".to_vec();
            let content = if name.ends_with("gz") {
                packed(&content)
            } else {
                content
            };
            let scene = world_with(
                &format!("{statement} \"{name}\"\nShape \"sphere\""),
                [(name, content)],
            );
            assert_eq!(
                scene.shapes[0].transform.translation.x, x,
                "{statement} {name}"
            );
        }
    }
}

/// The bytes in a gzip file without compression: one stored block.
fn packed(content: &[u8]) -> Vec<u8> {
    let mut crc = u32::MAX;
    for byte in content {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
        }
    }
    let length = u16::try_from(content.len()).expect("short");
    let mut bytes = b"\x1f\x8b\x08\0\0\0\0\0\0\xff\x01".to_vec();
    bytes.extend(length.to_le_bytes());
    bytes.extend((!length).to_le_bytes());
    bytes.extend(content);
    bytes.extend((!crc).to_le_bytes());
    bytes.extend(u32::from(length).to_le_bytes());
    bytes
}

#[test]
fn triangle_and_bilinear_meshes_are_read_with_pbrt_uvs() {
    let triangle = "\"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]";
    let scene = world(&format!("Shape \"trianglemesh\" {triangle}"));
    assert_eq!(mesh(&scene).indices, [[0, 1, 2]]);
    assert!(mesh(&scene).uvs.is_empty());
    // A textured mesh without coordinates has those of pbrt's triangles.
    let texture = "Texture \"a\" \"spectrum\" \"checkerboard\" \"float uscale\" 2 \"float udelta\" 0.5\n\
                   Material \"diffuse\" \"texture reflectance\" \"a\"\n";
    let scene = world(&format!("{texture}Shape \"trianglemesh\" {triangle}"));
    let expected = [(0.5, 0.0), (2.5, 0.0), (2.5, 1.0)].map(DVec2::from);
    assert_eq!(mesh(&scene).uvs, expected);

    let quad = "Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 1 1 $ ]";
    let scene = world(&quad.replace('$', "0"));
    assert_eq!(mesh(&scene).indices, [[0, 1, 3], [0, 3, 2]]);
    assert!(scene.notes.is_empty());
    let scene = world(&quad.replace('$', "1"));
    assert_eq!(notes(&scene), [(NoteKind::Approximation, 5)]);
    for [a, b, c] in &mesh(&scene).indices {
        let [a, b, c] = [a, b, c].map(|&i| mesh(&scene).positions[i as usize]);
        // z = xy on the patch, whose normal points up.
        assert!((a.z - a.x * a.y).abs() < 1e-12 && (b - a).cross(c - a).z > 0.0);
    }
}

#[test]
fn plymesh_reads_plain_and_gzipped_ply_files() {
    let ply = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    for (name, content) in [("m.ply", ply.to_vec()), ("m.ply.gz", packed(ply))] {
        let text = format!("ReverseOrientation\nShape \"plymesh\" \"string filename\" \"{name}\"");
        let scene = world_with(&text, [(name, content)]);
        assert_eq!(mesh(&scene).indices, [[0, 2, 1]]);
        assert_eq!(mesh(&scene).positions[1], DVec3::X);
    }
}

#[test]
fn quadrics_are_analytic_or_tessellated_with_correct_area() {
    let geometry = |text: &str| world(text).shapes[0].geometry.clone();
    assert!(matches!(
        geometry("Shape \"sphere\" \"float radius\" 2"),
        GeometryDescription::Sphere { radius: 2.0, .. }
    ));
    let GeometryDescription::Disk {
        center,
        normal,
        radius,
    } = geometry("Shape \"disk\" \"float height\" 3")
    else {
        panic!("no disk");
    };
    assert_eq!((center, normal, radius), (3.0 * DVec3::Z, DVec3::Z, 1.0));
    // An ellipsoid is a sphere that an uneven transform places.
    let scene = world("Scale 1 2 3\nShape \"sphere\"");
    assert_eq!(
        scene.shapes[0].motion[0].transform.matrix3,
        DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0))
    );

    // Triangles of a part: its area and its outside.
    for (text, expected, outside) in [
        ("Shape \"sphere\" \"float zmin\" 0", 2.0 * PI, true),
        ("Shape \"sphere\" \"float phimax\" 180", 2.0 * PI, true),
        ("Shape \"disk\" \"float innerradius\" 0.5", 0.75 * PI, true),
        ("Shape \"cylinder\" \"float zmax\" 0", 2.0 * PI, true),
        (
            "AreaLightSource \"diffuse\"\nReverseOrientation\nShape \"sphere\"",
            4.0 * PI,
            false,
        ),
    ] {
        let scene = world(text);
        let shape = &scene.shapes[0];
        let mut area = 0.0;
        for t in &mesh(&scene).indices {
            let [a, b, c] = t.map(|i| {
                shape
                    .transform
                    .transform_point3(mesh(&scene).positions[i as usize])
            });
            let cross = (b - a).cross(c - a);
            area += 0.5 * cross.length() as f32;
            let outwards = if text.contains("disk") {
                DVec3::Z
            } else {
                (a + b + c) * DVec3::new(1.0, 1.0, 0.3)
            };
            assert_eq!(cross.dot(outwards) > 0.0, outside, "{text}");
        }
        assert!(
            (area - expected).abs() < 0.03 * expected,
            "{text}: {area} {expected}"
        );
        assert!(
            notes(&scene)
                .iter()
                .all(|(kind, _)| *kind == NoteKind::Approximation)
        );
    }
}

#[test]
fn area_light_radiance_follows_scale_power_and_two_sidedness() {
    let sphere = "Shape \"sphere\" \"float radius\" 2";
    for (light, shape, expected) in [
        (
            "\"rgb L\" [ 1 2 3 ] \"float scale\" 2",
            sphere,
            [2.0, 4.0, 6.0],
        ),
        ("", sphere, [1.0; 3]),
        (
            "\"rgb L\" [ 1 2 3 ] \"float power\" 16",
            sphere,
            [1.0, 2.0, 3.0].map(|l: f32| l / (PI * PI)),
        ),
        (
            "\"float power\" 16 \"bool twosided\" true",
            sphere,
            [0.5 / (PI * PI); 3],
        ),
        // Each triangle of a mesh has the power.
        (
            "\"float power\" 4",
            "Scale 2 2 2\nShape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 1 1 0 0 1 0 ] \"integer indices\" [ 0 1 2 0 2 3 ]",
            [2.0 / PI; 3],
        ),
    ] {
        let scene = world(&format!("AreaLightSource \"diffuse\" {light}\n{shape}"));
        near(emission(&scene), expected);
        assert_eq!(scene.shapes[0].two_sided_emission, light.contains("true"));
        assert_eq!(scene.shapes.len(), 1);
    }
    let uneven = "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 1 1 0 0 2 0 ] \"integer indices\" [ 0 1 2 0 2 3 ]";
    let scene = world(&format!(
        "AreaLightSource \"diffuse\" \"float power\" 1\n{uneven}"
    ));
    assert_eq!(scene.shapes.len(), 2);
    near(emission(&scene), [1.0 / PI; 3]);
}

#[test]
fn point_spot_distant_and_infinite_intensities_are_converted() {
    let near_light = |text: &str, expected: [f32; 3]| {
        let scene = world(&format!("LightSource {text}"));
        let found = match only_light(&scene) {
            LightModel::Point { intensity, .. } | LightModel::Spot { intensity, .. } => *intensity,
            LightModel::Distant { irradiance, .. } => *irradiance,
            LightModel::Environment { radiance, .. } => radiance.constant().expect("constant"),
            other => panic!("{other:?}"),
        };
        near(found, expected);
    };
    near_light(
        "\"point\" \"rgb I\" [ 1 2 3 ] \"float scale\" 2",
        [2.0, 4.0, 6.0],
    );
    near_light("\"point\" \"float power\" 8", [2.0 / PI; 3]);
    let share = 2.0 * PI * (1.0 - 0.5 * (40f32.to_radians().cos() + 30f32.to_radians().cos()));
    near_light(
        "\"spot\" \"float power\" 8 \"float coneangle\" 40 \"float conedeltaangle\" 10",
        [8.0 / share; 3],
    );
    near_light("\"distant\" \"rgb L\" [ 1 2 3 ]", [1.0, 2.0, 3.0]);
    near_light("\"distant\" \"float illuminance\" 3", [3.0; 3]);
    near_light(
        "\"infinite\" \"rgb L\" [ 1 2 3 ] \"float scale\" 0.5",
        [0.5, 1.0, 1.5],
    );
    near_light("\"infinite\" \"float illuminance\" 3", [3.0 / PI; 3]);
    // The unit of a black body is its luminance.
    let scene = world("LightSource \"point\" \"blackbody I\" 3000 \"float scale\" 5");
    let LightModel::Point { intensity, .. } = only_light(&scene) else {
        panic!("no point light");
    };
    let [r, g, b] = intensity.to_array();
    assert!(
        (intensity.luminance() - 5.0).abs() < 0.01 && r > g && g > b,
        "{intensity:?}"
    );
}

#[test]
fn infinite_light_image_becomes_an_equirectangular_map() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("map.pfm");
    // The upper half of pbrt's sphere is the diamond in the middle of the square.
    let side = 32;
    let pixel = |index: u32| {
        let at = |i: u32| ((f64::from(i) + 0.5) / f64::from(side) - 0.5).abs();
        let is_up = at(index % side) + at(index / side) < 0.5;
        Rgb::grey(if is_up { 1.0 } else { 0.25 })
    };
    let map = Image::new(side, side, (0..side * side).map(pixel).collect());
    write(&path, &map, &WriteOptions::default()).expect("written");
    let bytes = std::fs::read(path).expect("read");
    let text = "Rotate -90 1 0 0\nLightSource \"infinite\" \"string filename\" \"map.pfm\" \"float scale\" 2";
    let scene = world_with(text, [("map.pfm", bytes.clone())]);
    let LightModel::Environment { radiance, to_world } = only_light(&scene) else {
        panic!("no environment");
    };
    assert_eq!(*to_world, DMat3::IDENTITY);
    let etendue::internals::scene::description::ColourDescription::Texture(texture) = radiance
    else {
        panic!("no image");
    };
    let etendue::internals::geometry::texture::Texture::Image { image, scale } = texture.as_ref()
    else {
        panic!("no image");
    };
    // z of pbrt's light is up in our world: the upper half of the panorama is the brighter one.
    let at = |x, y| scale * image.get(x, y).to_array()[0];
    assert_eq!((image.width(), image.height()), (64, 32));
    for x in [0, 20, 63] {
        assert!((at(x, 2) - 2.0).abs() < 1e-5 && (at(x, 29) - 0.5).abs() < 1e-5);
    }
    let lit =
        "LightSource \"infinite\" \"string filename\" \"map.pfm\" \"float illuminance\" 3.14159265";
    let scene = world_with(&format!("Rotate -90 1 0 0\n{lit}"), [("map.pfm", bytes)]);
    let LightModel::Environment { radiance, .. } = only_light(&scene) else {
        panic!("no environment");
    };
    let etendue::internals::scene::description::ColourDescription::Texture(texture) = radiance
    else {
        panic!("no image");
    };
    assert!((texture.brightest().to_array()[0] - 1.0).abs() < 0.02);
}

#[test]
fn film_exposure_scales_point_and_area_lights() {
    let text = "Scale -1 1 1\nFilm \"rgb\" \"float iso\" 200\nCamera \"perspective\" \"float shutterclose\" 0.25\nWorldBegin\n\
                LightSource \"point\"\nAreaLightSource \"diffuse\"\nShape \"sphere\"";
    let scene = file(text);
    near(emission(&scene), [0.5; 3]);
    let LightModel::Point { intensity, .. } = only_light(&scene) else {
        panic!("no point light");
    };
    near(*intensity, [0.5; 3]);
}

#[test]
fn options_become_film_and_render_settings() {
    let scene = file("WorldBegin");
    assert_eq!(scene.film.size, (1280, 720));
    assert_eq!(
        (scene.film.filter.kind, scene.film.filter.radius),
        (FilterKind::Gaussian, 1.5)
    );
    assert_eq!(
        (scene.render.spp, scene.render.max_bounces),
        (Some(16), Some(5))
    );
    assert_eq!(scene.render.integrator, None);

    let text = "Option \"integer seed\" 9\nFilm \"gbuffer\" \"integer xresolution\" 20 \"integer yresolution\" 10\n\
                PixelFilter \"triangle\" \"float xradius\" 1 \"float yradius\" 1\nSampler \"stratified\" \"integer xsamples\" 3\n\
                Integrator \"bdpt\" \"integer maxdepth\" 7\nWorldBegin";
    let scene = file(text);
    assert_eq!(scene.film.size, (20, 10));
    assert_eq!(
        (scene.film.filter.kind, scene.film.filter.radius),
        (FilterKind::Tent, 1.0)
    );
    assert_eq!(
        (scene.render.spp, scene.render.max_bounces),
        (Some(12), Some(7))
    );
    let name = |written: &Option<etendue::internals::scene::description::WithLine<String>>| {
        written
            .as_ref()
            .map(|written| (written.value.clone(), written.line))
    };
    assert_eq!(name(&scene.render.integrator), Some(("bdpt".to_owned(), 5)));
    assert_eq!(
        name(&scene.render.sampler),
        Some(("stratified".to_owned(), 4))
    );
    assert_eq!(scene.render.seed, Some(9));
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
}

#[test]
fn approximations_and_omissions_are_noted_with_their_line() {
    use NoteKind::{Approximation, Decision, Omission};
    for (text, expected) in [
        ("LightSource \"goniometric\"", vec![(Omission, 5)]),
        ("LightSource \"projection\"", vec![(Omission, 5)]),
        (
            "\nMediumInterface \"a\" \"b\"\nMediumInterface \"a\"",
            vec![(Omission, 6)],
        ),
        (
            "MakeNamedMedium \"a\" \"string type\" \"cloud\"",
            vec![(Omission, 5)],
        ),
        ("Shape \"curve\"", vec![(Omission, 5)]),
        ("Shape \"sphere\"\n\"float colour\" 1", vec![(Decision, 6)]),
        ("CoordSysTransform \"nowhere\"", vec![(Decision, 5)]),
        (
            "Texture \"a\" \"float\" \"marble\"",
            vec![(Approximation, 5)],
        ),
        (
            "ObjectBegin \"a\"\nAreaLightSource \"diffuse\"\nShape \"disk\"\nObjectEnd",
            vec![(Decision, 7)],
        ),
    ] {
        assert_eq!(notes(&world(text)), expected, "{text}");
    }
    for (text, expected) in [
        (
            "Film \"rgb\" \"string sensor\" \"canon_eos_100d\"\nWorldBegin",
            Approximation,
        ),
        (
            "Film \"rgb\" \"float cropwindow\" [ 0 1 0 0.5 ]\nWorldBegin",
            Approximation,
        ),
        (
            "Film \"rgb\" \"float maxcomponentvalue\" 10\nWorldBegin",
            Omission,
        ),
        ("PixelFilter \"sinc\"\nWorldBegin", Approximation),
        (
            "PixelFilter \"gaussian\" \"float sigma\" 1\nWorldBegin",
            Approximation,
        ),
        ("Integrator \"sppm\"\nWorldBegin", Approximation),
        (
            "Camera \"perspective\" \"float screenwindow\" [ 0 2 -1 1 ]\nWorldBegin",
            Approximation,
        ),
        (
            "Option \"bool disablepixeljitter\" true\nWorldBegin",
            Omission,
        ),
    ] {
        let scene = file(text);
        assert!(
            notes(&scene).contains(&(expected, 1)),
            "{text}: {:?}",
            scene.notes
        );
    }
}

#[test]
fn include_file_name_may_contain_an_escaped_quote() {
    let folder = SceneFolder::new([
        ("a.pbrt", "WorldBegin\nInclude \"b\\\"c.pbrt\""),
        ("b\"c.pbrt", "Shape \"disk\""),
    ]);
    assert_eq!(folder.load("a.pbrt").shapes.len(), 1);
}
