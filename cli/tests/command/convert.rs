//! Converting scenes on the command line.

use crate::common::scene_folder::{SMALL, SceneFolder, TRIANGLE};
use crate::support::{SCENE, USAGE, fails, succeed};

/// Checks that a scene and the one that it is converted to, `other.toml`, render the same bits.
pub fn assert_converts_bit_identically(folder: &SceneFolder, scene: &str) {
    succeed(folder, &format!("convert {scene} -o other.toml -q"));
    let flags = "--spp 4 --size 24x16 -q -o";
    succeed(folder, &format!("render {scene} {flags} a.pfm"));
    succeed(folder, &format!("render other.toml {flags} b.pfm"));
    let [a, b] = ["a.pfm", "b.pfm"].map(|name| std::fs::read(folder.path(name)));
    assert_eq!(a.expect("written"), b.expect("written"), "{scene}");
}

#[test]
fn converted_scene_renders_bit_identical_images() {
    let folder = SceneFolder::new([("small.toml", SMALL), ("model.obj", TRIANGLE)]);
    for scene in ["small.toml", "model.obj"] {
        assert_converts_bit_identically(&folder, scene);
    }
    assert!(folder.path("other-assets/mesh-1.ply").exists());
}

#[test]
fn convert_rejects_overwriting_and_invalid_scenes() {
    let folder = SceneFolder::new([("small.toml", SMALL), ("bad.toml", "version = 2")]);
    for (arguments, code, word) in [
        ("convert small.toml -o small.toml", USAGE, "another file"),
        ("convert small.toml -o small.xml", USAGE, ".toml"),
        ("convert bad.toml -o other.toml", SCENE, "version"),
        (
            "convert small.toml --camera front -o other.toml",
            USAGE,
            "front",
        ),
    ] {
        fails(&folder, arguments, code, &[word]);
    }
}
