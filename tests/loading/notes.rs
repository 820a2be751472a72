//! Notes of the loader, and the strict mode that refuses scenes which cannot be rendered as they are.
//!
//! Measure: none.
//! Range: models and scenes with something to note.
//! Source: docs/scene-formats.md.

use crate::common::scene_folder::SceneFolder;
use etendue::description::NoteKind;

#[test]
fn notes_have_kind_and_source_location() {
    let folder = SceneFolder::new([
        (
            "a.obj",
            "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\np 1\n",
        ),
        ("a.mtl", "newmtl m\nmap_Bump a.png\n"),
    ]);
    let scene = folder.load("a.obj");
    let noted: Vec<(NoteKind, Option<usize>, &str)> = scene
        .notes
        .iter()
        .map(|note| (note.kind, note.place.line, note.text.as_str()))
        .collect();
    let [points, bump, camera, sky] = noted.as_slice() else {
        panic!("{noted:?}")
    };
    assert_eq!(
        *points,
        (NoteKind::Omission, None, "1 points and lines were left out")
    );
    assert_eq!((bump.0, bump.1), (NoteKind::Omission, Some(2)));
    assert_eq!((camera.0, sky.0), (NoteKind::Decision, NoteKind::Decision));
    let text = scene.notes[1].to_string();
    assert!(text.contains("a.mtl:2: map_Bump"), "{text}");
}

#[test]
fn strict_mode_rejects_omissions_but_accepts_decisions() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let points = format!("{triangle}p 1\n");
    let folder = SceneFolder::new([("decided.obj", triangle), ("left-out.obj", points.as_str())]);
    let decided = folder.load("decided.obj");
    assert!(!decided.notes.is_empty());
    decided.check_faithful().expect("only decisions");
    let error = folder
        .load("left-out.obj")
        .check_faithful()
        .expect_err("a point");
    let text = error.to_string();
    assert!(
        text.contains("left-out.obj: 1 points and lines were left out"),
        "{text}"
    );
    assert!(text.ends_with("(not allowed in strict mode)"), "{text}");
}
