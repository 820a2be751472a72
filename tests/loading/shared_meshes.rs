//! Mesh files that several shapes of a scene refer to: these share a mesh unless they change it in different ways.
//!
//! Measure: units of the files.
//! Range: scenes of Mitsuba, pbrt and our own format that are made here.
//! Source: docs/scene-formats.md, docs/scene-format.md.

use crate::common::scene_folder::SceneFolder;
use crate::mitsuba::{mesh, scene};
use etendue::description::SceneDescription;
use std::collections::BTreeSet;

/// Two faces, one of which has only two corners, with normals or without.
fn ply(normals: bool) -> String {
    let (names, of_z) = match normals {
        true => (
            "property float nx\nproperty float ny\nproperty float nz\n",
            " 0 0 1",
        ),
        false => ("", ""),
    };
    let corners = ["0 0 0", "1 0 0", "0 1 0"].map(|corner| format!("{corner}{of_z}\n"));
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{names}\
         element face 2\nproperty list uchar int vertex_indices\nend_header\n{}3 0 1 2\n2 0 1\n",
        corners.concat()
    )
}

/// The number of meshes in memory.
fn count(scene: &SceneDescription) -> usize {
    let meshes = (0..scene.shapes.len()).map(|shape| std::ptr::from_ref(mesh(scene, shape)));
    meshes.collect::<BTreeSet<_>>().len()
}

/// The number of notes on faces that were left out.
fn omissions(scene: &SceneDescription) -> usize {
    let texts = scene.notes.iter().map(|note| &note.text);
    texts.filter(|text| text.contains("corners")).count()
}

fn mitsuba_shape(kind: &str, file: &str, content: &str, to_world: &str) -> String {
    format!(
        "<shape type=\"{kind}\"><string name=\"filename\" value=\"{file}\"/>{content}\
         <transform name=\"to_world\">{to_world}</transform></shape>"
    )
}

const TURNED: [&str; 3] = [
    "",
    "<translate x=\"3\"/>",
    "<rotate y=\"1\" angle=\"30\"/><scale value=\"2\"/>",
];

#[test]
fn mitsuba_shapes_of_one_file_share_its_mesh() {
    let named = mitsuba_shape("ply", "./b.ply", "", "");
    let shapes = TURNED.map(|to_world| mitsuba_shape("ply", "b.ply", "", to_world));
    let text = scene(&format!("{}{named}", shapes.concat()));
    let it = SceneFolder::new([("a.xml", text), ("b.ply", ply(true))]).load("a.xml");
    assert_eq!((it.shapes.len(), count(&it), omissions(&it)), (4, 1, 1));
    assert_eq!(mesh(&it, 0).indices, [[0, 1, 2]]);
}

#[test]
fn mitsuba_shapes_that_change_a_mesh_have_one_for_each_change() {
    const FACES: &str = "<boolean name=\"face_normals\" value=\"true\"/>";
    const FLIPPED: &str = "<boolean name=\"flip_normals\" value=\"true\"/>";
    const MIRROR: &str = "<scale x=\"-1\"/>";
    // Normals that the file lacks are computed in the world.
    for (content, has_normals, mirror, expected) in [
        ("", true, "", 1),
        ("", true, MIRROR, 1),
        (FACES, true, "", 1),
        (FACES, false, "", 1),
        (FACES, false, MIRROR, 2),
        ("", false, "", 2),
    ] {
        let mut shapes = TURNED.map(|to_world| mitsuba_shape("ply", "b.ply", content, to_world));
        shapes[1] = mitsuba_shape("ply", "b.ply", content, &format!("{}{mirror}", TURNED[1]));
        let flipped = mitsuba_shape("ply", "b.ply", &format!("{content}{FLIPPED}"), "");
        let text = scene(&format!("{}{flipped}", shapes.concat().repeat(2)));
        let it = SceneFolder::new([("a.xml", text), ("b.ply", ply(has_normals))]).load("a.xml");
        let case = (content, has_normals, mirror);
        assert_eq!(count(&it), expected + 1, "{case:?}");
        assert_eq!(omissions(&it), 1, "{case:?}");
        for index in 0..6 {
            let alone = scene(&shapes[index % 3]);
            let alone =
                SceneFolder::new([("a.xml", alone), ("b.ply", ply(has_normals))]).load("a.xml");
            assert_eq!(mesh(&it, index), mesh(&alone, 0), "{case:?} {index}");
        }
        assert_ne!(mesh(&it, 0), mesh(&it, 6), "{case:?}");
    }
}

/// A triangle with normals and one without, which are read as two meshes.
const OBJ: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1 2 3\nf 1//1 2//1 3//1\nusemtl none\nf 3 2 1\n";

#[test]
fn mitsuba_shapes_of_one_obj_file_share_all_its_meshes() {
    let shape = mitsuba_shape("obj", "b.obj", "", "<scale value=\"2\"/>");
    let folder = SceneFolder::new([("a.xml", scene(&shape.repeat(3))), ("b.obj", OBJ.into())]);
    let it = folder.load("a.xml");
    assert_eq!((it.shapes.len(), count(&it)), (6, 2));
}

#[test]
fn pbrt_shapes_of_one_file_share_its_mesh_and_note_what_it_lacks() {
    let shape = "Shape \"plymesh\" \"string filename\" \"b.ply\"\n";
    let text = format!(
        "Camera \"perspective\"\nWorldBegin\n{shape}Translate 1 0 0\n{shape}ReverseOrientation\n{}",
        shape.repeat(2)
    );
    let it = SceneFolder::new([("a.pbrt", text), ("b.ply", ply(false))]).load("a.pbrt");
    assert_eq!((it.shapes.len(), count(&it), omissions(&it)), (4, 2, 1));
    assert_eq!(mesh(&it, 1).indices, [[0, 1, 2]]);
    assert_eq!(mesh(&it, 2).indices, [[0, 2, 1]]);
}

#[test]
fn shapes_of_one_obj_file_share_its_meshes_and_materials() {
    let shape = "[[shape]]\ntype = \"obj\"\nfile = \"b.obj\"\n";
    let painted = format!("{shape}material = \"red\"\n");
    let text = format!(
        "version = 1\n[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nfov = 40\n[[material]]\nname = \"red\"\n\
         type = \"diffuse\"\nreflectance = [1, 0, 0]\n{}{}",
        shape.repeat(2),
        painted.repeat(2)
    );
    let mtl = "newmtl none\nKd 0.25 0.5 0.75\nKe 1 1 1\n";
    let obj = format!("mtllib b.mtl\n{OBJ}");
    let files = [("a.toml", text), ("b.obj", obj), ("b.mtl", mtl.into())];
    let it = SceneFolder::new(files).load("a.toml");
    assert_eq!((it.shapes.len(), count(&it)), (12, 6));
    // Red, grey, and that of the library.
    assert_eq!(it.materials.len(), 3);
    let shapes = it.shapes.iter();
    let seen: Vec<_> = shapes
        .map(|shape| (shape.material, shape.emission.is_some()))
        .collect();
    assert_eq!(seen[..3], seen[3..6]);
    assert_eq!(seen[..3].iter().filter(|(_, emits)| *emits).count(), 1);
    assert_eq!(seen[6..], [(0, false); 6]);
}

#[test]
fn shapes_of_one_coloured_ply_file_share_its_texture() {
    let shape = "[[shape]]\ntype = \"ply\"\nfile = \"b.ply\"\n";
    let text = format!(
        "version = 1\n[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nfov = 40\n{}",
        shape.repeat(3)
    );
    let coloured = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2\n";
    let it = SceneFolder::new([("a.toml", text), ("b.ply", coloured.into())]).load("a.toml");
    assert_eq!((it.shapes.len(), count(&it)), (3, 1));
    assert_eq!(it.materials.len(), 1);
}
