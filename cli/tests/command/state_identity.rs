//! Tests of what belongs together: states of other versions, of scenes whose files changed, and of machines whose clocks differ.

use crate::common::scene_folder::{HEAD, SMALL, SceneFolder, TRIANGLE};
use crate::support::{USAGE, fails, succeed};
use etendue::internals::state::State;
use std::fs::File;
use std::time::{Duration, SystemTime};

/// A model in front of a textured wall.
const FILES: &str = r#"
[[material]]
name = "planks"
type = "diffuse"
reflectance = { texture = "planks.pfm" }

[[shape]]
name = "wall"
type = "rectangle"
material = "planks"
corner = [-2, -2, -1]
edge_u = [4, 0, 0]
edge_v = [0, 4, 0]

[[shape]]
name = "model"
type = "obj"
file = "model.obj"
material = "planks"

[[light]]
type = "environment"
radiance = { texture = "sky.pfm" }
"#;

/// An image of one pixel.
fn pixel(value: f32) -> Vec<u8> {
    let mut file = b"PF\n1 1\n-1.0\n".to_vec();
    file.extend([value; 3].into_iter().flat_map(f32::to_le_bytes));
    file
}

#[test]
fn states_of_another_version_are_rejected_naming_both() {
    let folder = SceneFolder::new([("small.toml", SMALL)]);
    let render = "render small.toml -q --spp 8";
    succeed(&folder, &format!("{render} --shard 0/2 -o a.etd"));
    succeed(&folder, &format!("{render} --shard 1/2 -o b.etd"));
    let mut older = State::read(&folder.path("b.etd")).expect("it is whole");
    let ours = older.header.identity.program.clone();
    older.header.identity.program = "etendue 0.0.9 of the sources 0123abcd".to_owned();
    older.write(&folder.path("b.etd")).expect("it is written");
    let versions = ["etendue 0.0.9 of the sources 0123abcd", ours.as_str()];
    let both = [&["a.etd", "b.etd"][..], &versions].concat();
    fails(&folder, "merge a.etd b.etd -o it.exr", USAGE, &both);
    let resumed = format!("{render} --shard 1/2 -o c.etd --resume b.etd");
    fails(
        &folder,
        &resumed,
        USAGE,
        &[&["b.etd"][..], &versions].concat(),
    );
    // Its samples may be wanted by the version that took them.
    let aside = format!("{resumed} --checkpoint b.etd --set-damaged-aside");
    fails(&folder, &aside, USAGE, &versions);
}

#[test]
fn shards_of_a_scene_whose_files_changed_are_rejected() {
    let scene = format!("{HEAD}[film]\nsize = [8, 8]\n{FILES}");
    let folder = SceneFolder::new([
        ("scene.toml", scene.as_bytes()),
        ("model.obj", TRIANGLE.as_bytes()),
        ("planks.pfm", &pixel(0.5)),
        ("sky.pfm", &pixel(1.0)),
    ]);
    let write = |name: &str, content: &[u8]| {
        std::fs::write(folder.path(name), content).expect("it is written");
    };
    let render = "render scene.toml -q --spp 8";
    succeed(&folder, &format!("{render} --shard 0/2 -o a.etd"));
    let moved = TRIANGLE.replacen("v 1 0 0", "v 1.0000001 0 0", 1);
    for (name, changed, before, part) in [
        (
            "model.obj",
            moved.into_bytes(),
            TRIANGLE.into(),
            "the shapes, their meshes",
        ),
        (
            "planks.pfm",
            pixel(0.501),
            pixel(0.5),
            "the materials or their textures",
        ),
        (
            "sky.pfm",
            pixel(1.001),
            pixel(1.0),
            "the lights or their images",
        ),
    ] {
        write(name, &changed);
        succeed(&folder, &format!("{render} --shard 1/2 -o b.etd"));
        let words = ["a.etd", "b.etd", "the scenes differ", &format!("in {part}")];
        fails(&folder, "merge a.etd b.etd -o it.exr", USAGE, &words);
        let resumed = format!("{render} --shard 0/2 -o c.etd --resume a.etd");
        fails(&folder, &resumed, USAGE, &["a.etd", &format!("in {part}")]);
        write(name, &before);
    }
    succeed(&folder, &format!("{render} --shard 1/2 -o b.etd"));
    succeed(&folder, "merge -q a.etd b.etd -o it.exr");
}

/// Machines that share a folder may have clocks that differ, and a clock may be set back.
#[test]
fn times_of_files_change_nothing() {
    let folder = SceneFolder::new([("small.toml", SMALL)]);
    succeed(&folder, "render small.toml -q --spp 48 -o whole.pfm");
    let kept = "--checkpoint it.etd --every 0.001s";
    succeed(
        &folder,
        &format!("render small.toml -q --spp 16 {kept} -o it.pfm"),
    );
    let year = Duration::from_secs(365 * 24 * 3600);
    let now = SystemTime::now();
    for (time, spp) in [(now + year, 32), (SystemTime::UNIX_EPOCH, 48)] {
        for name in ["it.etd", "small.toml"] {
            let file = File::options().write(true).open(folder.path(name));
            let set = file.and_then(|file| file.set_modified(time));
            set.expect("the file is ours");
        }
        let resumed = format!("render small.toml -q --spp {spp} {kept} --resume it.etd -o it.pfm");
        succeed(&folder, &resumed);
        let state = State::read(&folder.path("it.etd")).expect("it is whole");
        assert_eq!(state.header.samples(), spp);
    }
    let read = |name: &str| std::fs::read(folder.path(name)).expect(name);
    assert!(read("it.pfm") == read("whole.pfm"));
}
