//! Shapes of Mitsuba 3 whose sides and places follow from their transforms, and scenes without a sensor.
//!
//! Measure: world units.
//! Range: scenes that are made here.
//! Source: docs/scene-formats.md; sides of surfaces and texture coordinates as found by `scene.ray_intersect` of Mitsuba
//! 3.9.1.

use crate::common::scene_folder::SceneFolder;
use crate::mitsuba::{close, complaint, mesh, read, scene, valid};
use etendue::description::{GeometryDescription, NoteKind};
use etendue::internals::math::vec::{DMat3, DVec3};
use etendue::internals::scene::load::load;

#[test]
fn cylinders_are_cut_into_triangles_between_their_ends() {
    let checker =
        r#"<bsdf type="diffuse"><texture type="checkerboard" name="reflectance"/></bsdf>"#;
    let it = valid(&format!(
        r#"<shape type="cylinder"><point name="p0" x="1" y="0" z="0"/><point name="p1" x="1" y="2" z="0"/>
        <float name="radius" value="0.5"/>{checker}<transform name="to_world"><scale value="2"/></transform></shape>
        <shape type="cylinder"><boolean name="flip_normals" value="true"/></shape>
        <shape type="cylinder"><boolean name="flip_normals" value="true"/></shape>"#
    ));
    let cylinder = mesh(&it, 0);
    let placed = it.shapes[0].transform;
    let mut heights = [0; 2];
    for (position, normal) in cylinder.positions.iter().zip(&cylinder.normals) {
        let point = placed.transform_point3(*position);
        let out = point - DVec3::new(2.0, point.y, 0.0);
        assert!((out.length() - 1.0).abs() < 1e-9, "{point}");
        let normal = (placed.matrix3.inverse().transpose() * *normal).normalize();
        assert!(close(normal, out), "{normal} {out}");
        heights[usize::from(point.y > 2.0)] += 1;
        assert!(point.y.abs() < 1e-9 || (point.y - 4.0).abs() < 1e-9);
    }
    assert_eq!(heights, [65, 65]);
    // Mitsuba finds u = 0.75 where the cylinder faces z, and v = 0 at p0, where ours is 1.
    let facing = cylinder
        .positions
        .iter()
        .position(|p| close(placed.transform_point3(*p), DVec3::new(2.0, 0.0, 1.0)))
        .expect("a vertex");
    assert!(cylinder.uvs[facing].distance([0.75, 1.0].into()) < 1e-9);
    for index in [0, 1] {
        let (cylinder, inwards) = (mesh(&it, index), index == 1);
        for triangle in &cylinder.indices {
            let [a, b, c] = triangle.map(|i| cylinder.positions[i as usize]);
            let axis = DVec3::new(0.0, 0.0, a.z);
            assert_eq!((b - a).cross(c - a).dot(a - axis) < 0.0, inwards);
        }
    }
    assert!(
        std::ptr::eq(mesh(&it, 1), mesh(&it, 2)),
        "they share a mesh"
    );
    let noted = |it: &etendue::description::SceneDescription| {
        it.notes
            .iter()
            .filter(|note| note.kind == NoteKind::Approximation)
            .count()
    };
    assert_eq!(noted(&it), 3);
    let words = complaint(r#"<shape type="cylinder"><point name="p1" x="0" y="0" z="0"/></shape>"#);
    assert!(
        words.contains("a.xml:3: `p1` of shape `cylinder`: expected another point"),
        "{words}"
    );
}

/// A tetrahedron of which all triangles face outwards, without normals.
const TETRAHEDRON: &str =
    "v 1 1 1\nv 1 -1 -1\nv -1 1 -1\nv -1 -1 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n";

#[test]
fn computed_normals_of_mirrored_meshes_point_inwards_as_in_mitsuba() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        element face 4\nproperty list uchar int vertex_indices\nend_header\n1 1 1\n1 -1 -1\n-1 1 -1\n-1 -1 1\n\
        3 0 1 2\n3 0 3 1\n3 0 2 3\n3 1 3 2\n";
    for (kind, face_normals, x, flip, inwards) in [
        ("obj", false, 1, false, false),
        ("obj", false, -1, false, true),
        ("obj", false, -1, true, false),
        ("obj", true, -1, false, true),
        ("ply", false, 1, true, true),
        ("ply", false, -1, false, true),
        ("ply", false, -1, true, false),
        ("ply", true, -1, true, false),
    ] {
        let text = scene(&format!(
            r#"<shape type="{kind}"><string name="filename" value="a.{kind}"/>
            <boolean name="face_normals" value="{face_normals}"/><boolean name="flip_normals" value="{flip}"/>
            <transform name="to_world"><scale x="{x}" y="2"/></transform></shape>"#
        ));
        let files = [
            ("a.xml", text.as_str()),
            ("a.obj", TETRAHEDRON),
            ("a.ply", ply),
        ];
        let it = load(&SceneFolder::new(files).path("a.xml")).unwrap_or_else(|e| panic!("{e}"));
        let mesh = mesh(&it, 0);
        let case = format!("{kind} {face_normals} {x} {flip}");
        assert_eq!(mesh.normals.is_empty(), face_normals, "{case}");
        let to_world = it.shapes[0].transform.matrix3;
        for triangle in &mesh.indices {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            let side = (b - a).cross(c - a);
            assert_eq!(side.dot(a + b + c) < 0.0, inwards, "{case}");
        }
        for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
            assert_eq!(normal.dot(*position) < 0.0, inwards, "{case}");
        }
        if let Some(normal) = mesh.normals.first() {
            // The angles that weight the triangles are those in the world.
            let normal = (to_world.inverse().transpose() * *normal).normalize();
            let sum = weighted(
                &mesh.positions,
                &[[0, 1, 2], [0, 3, 1], [0, 2, 3]],
                to_world,
            );
            assert!(normal.cross(sum).length() < 1e-9, "{case}: {normal} {sum}");
        }
    }
}

/// The sum of the unit normals of triangles in the world, weighted by their angles at their first vertices.
fn weighted(positions: &[DVec3], triangles: &[[usize; 3]], to_world: DMat3) -> DVec3 {
    let normals = triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|i| to_world * positions[i]);
        (b - a).angle_between(c - a) * (b - a).cross(c - a).normalize()
    });
    normals.sum::<DVec3>().normalize()
}

#[test]
fn scene_without_sensor_is_framed_with_a_note() {
    let shapes = r#"<shape type="shapegroup" id="pair"><shape type="sphere"/></shape>
        <shape type="instance"><ref id="pair"/><transform name="to_world"><translate x="100"/></transform></shape>
        <shape type="disk"><transform name="to_world"><scale value="3"/></transform></shape>
        <shape type="rectangle"/><shape type="cube"/>"#;
    let it = read(&format!("<scene version=\"3.0.0\">{shapes}</scene>"));
    let it = it.unwrap_or_else(|error| panic!("{error}"));
    assert!(it.check_faithful().is_ok(), "{:?}", it.notes);
    assert!(
        it.notes
            .iter()
            .any(|note| note.text.contains("the camera was placed"))
    );
    // The box is from (-3, -3, -1) to (101, 3, 1).
    let ahead = it.camera.to_world.matrix3 * DVec3::NEG_Z;
    let centre = it.camera.to_world.translation + it.camera.focus_distance * ahead;
    assert!(close(centre, DVec3::new(49.0, 0.0, 0.0)), "{centre}");
    let error = read("<scene version=\"3.0.0\"><emitter type=\"constant\"/></scene>");
    let error = error.expect_err("there is nothing to frame").to_string();
    assert!(
        error.contains("a.xml: expected a sensor, or shapes"),
        "{error}"
    );
}

/// As `scene.ray_intersect` of Mitsuba 3.9.1 finds; our v is 1 - v of Mitsuba's.
#[test]
fn sides_of_cubes_have_the_texture_coordinates_of_mitsuba() {
    let checker =
        r#"<bsdf type="diffuse"><texture type="checkerboard" name="reflectance"/></bsdf>"#;
    let it = valid(&format!(r#"<shape type="cube">{checker}</shape>"#));
    let cube = mesh(&it, 0);
    let uv_at = |p: DVec3, n: DVec3| {
        let found = cube
            .positions
            .iter()
            .zip(&cube.normals)
            .position(|it| it == (&p, &n));
        let uv = cube.uvs[found.expect("a corner")];
        [uv.x, 1.0 - uv.y]
    };
    for (normal, corner, uv) in [
        (DVec3::X, DVec3::new(1.0, 1.0, -1.0), [1.0, 1.0]),
        (DVec3::X, DVec3::new(1.0, 1.0, 1.0), [1.0, 0.0]),
        (DVec3::NEG_X, DVec3::new(-1.0, 1.0, 1.0), [1.0, 1.0]),
        (DVec3::Y, DVec3::new(-1.0, 1.0, -1.0), [1.0, 1.0]),
        (DVec3::NEG_Y, DVec3::new(1.0, -1.0, 1.0), [1.0, 1.0]),
        (DVec3::Z, DVec3::new(1.0, 1.0, 1.0), [1.0, 1.0]),
        (DVec3::NEG_Z, DVec3::new(1.0, -1.0, -1.0), [1.0, 1.0]),
    ] {
        assert_eq!(uv_at(corner, normal), uv, "{normal} {corner}");
    }
}

#[test]
fn mirrored_or_flipped_spheres_face_inwards_and_both_do_not() {
    let sphere = |flip: bool, x: f64| {
        valid(&format!(
            r#"<shape type="sphere"><boolean name="flip_normals" value="{flip}"/>
            <transform name="to_world"><scale x="{x}"/></transform></shape>"#
        ))
    };
    for (flip, x, is_inside_out) in [
        (false, 1.0, false),
        (false, -1.0, true),
        (true, 1.0, true),
        (true, -1.0, false),
    ] {
        let it = sphere(flip, x);
        let is_mesh = matches!(it.shapes[0].geometry, GeometryDescription::Mesh(_));
        assert_eq!(is_mesh, is_inside_out, "{flip} {x}");
        if is_mesh {
            // The side of the vertices' normals is the outside, also where a transform mirrors.
            let placed = it.shapes[0].transform;
            let sphere = mesh(&it, 0);
            let normal = placed.matrix3.inverse().transpose() * sphere.normals[100];
            let point = placed.transform_point3(sphere.positions[100]);
            assert!(normal.dot(point) < 0.0, "{flip} {x}");
        }
    }
    // Numbers of few digits are a rotation.
    let matrix =
        "0.353553 0.612372 -0.707107 0 -0.866025 0.5 0 0 0.353553 0.612372 0.707107 0 0 0 0 1";
    let it = valid(&format!(
        r#"<shape type="sphere"><transform name="to_world"><matrix value="{matrix}"/></transform></shape>"#
    ));
    etendue::Session::new(
        it,
        crate::common::scene::robust(etendue::internals::accel::Backend::ALL[0]),
    )
    .expect("it is round");
}
