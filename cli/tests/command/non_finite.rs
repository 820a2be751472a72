//! Non-finite samples: counted, left out of their own pixels only, and located by a command that replays the first. The
//! scenes produce them from valid input: lamps within the range of single precision whose sum overflows.

use crate::common::scene_folder::SceneFolder;
use crate::support::{Finished, run};
use etendue::internals::image::{ColourSpace, Image};
use std::path::Path;
use std::process::Command;

/// The exit code of too many non-finite samples.
const NON_FINITE: i32 = 6;

/// Two skies whose sum overflows single precision; a wall in front of them covers the left half of an image of 4 x 2 pixels.
const HALF: &str = r#"version = 1
[camera]
eye = [0, 0, 1]
target = [0, 0, 0]
fov = 90
[film]
size = [4, 2]
filter = "box"
[render]
max_bounces = 0
[[shape]]
type = "rectangle"
corner = [-3, -1, 0]
edge_u = [3, 0, 0]
edge_v = [0, 2, 0]
emission = 0.5
[[light]]
type = "environment"
radiance = 3e38
[[light]]
type = "environment"
radiance = 3e38
"#;

/// Runs the command printed after `the first: ` in a shell whose PATH contains the program under test.
fn replayed(folder: &SceneFolder, stderr: &str) -> Finished {
    let line = stderr
        .lines()
        .find_map(|line| line.split_once("the first: "));
    let (_, replay) = line.unwrap_or_else(|| panic!("no command in\n{stderr}"));
    let program = Path::new(env!("CARGO_BIN_EXE_etendue"));
    let here = program
        .parent()
        .expect("it is in a folder")
        .display()
        .to_string();
    let path = std::env::var("PATH").expect("there is a PATH");
    let output = Command::new("sh")
        .args(["-c", replay])
        .env("PATH", format!("{here}:{path}"))
        .current_dir(folder.root())
        .output();
    output.expect("there is a shell").into()
}

#[test]
fn non_finite_samples_are_counted_rejected_and_replayable() {
    // A name that a shell would split.
    let folder = SceneFolder::new([("it's half $HOME.toml", HALF)]);
    let scene = "it's half $HOME.toml";
    for flags in [
        &["--spp", "8", "-t", "2"][..],
        &["--spp", "5", "--seed", "7", "--sampler", "stratified"],
        &[
            "--spp",
            "3",
            "--size",
            "8x4",
            "--backend",
            "obvhs-cwbvh",
            "--precision",
            "fast",
        ],
    ] {
        let output = crate::support::command(&folder, "render")
            .arg(scene)
            .args(flags)
            .args(["-o", "a.pfm", "--stats", "a.json"])
            .output();
        let finished: Finished = output.expect("the command starts").into();
        let said = &finished.stderr;
        assert_eq!(finished.code, NON_FINITE, "{flags:?}: {said}");

        let stats = std::fs::read_to_string(folder.path("a.json")).expect("it was written");
        let stats: serde_json::Value = serde_json::from_str(&stats).expect("it is JSON");
        let image = Image::read(&folder.path("a.pfm"), ColourSpace::Linear).expect("an image");
        let (width, height) = (image.width(), image.height());
        let count = u64::from(width / 2 * height) * stats["spp"].as_u64().expect("a number");
        assert_eq!(stats["rejected"]["count"], count, "{flags:?}");
        assert!(
            said.contains(&format!("warning: {count} samples were not finite")),
            "{said}"
        );
        assert!(
            said.contains(&format!("--pixel {},0 --sample 0", width / 2)),
            "{said}"
        );
        // Rejected samples leave their pixels black; the neighbours keep all of their samples.
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let [r, ..] = image.get(x, y).to_array();
            assert_eq!(r == 0.0, x >= width / 2, "{flags:?}: pixel {x}, {y} is {r}");
        }

        let replay = replayed(&folder, said);
        assert_eq!(replay.code, 0, "{flags:?}: {}", replay.stderr);
        let path = &replay.stdout;
        assert!(
            path.starts_with(&format!("pixel {},0 sample 0\n", width / 2)),
            "{path}"
        );
        assert!(path.contains("left the scene"), "{path}");
        assert!(path.ends_with("radiance (inf, inf, inf)\n"), "{path}");
    }
}

#[test]
fn finite_images_print_no_non_finite_warning() {
    let folder = SceneFolder::new([("a.toml", HALF.replace("3e38", "1e38"))]);
    let finished = run(&folder, "render a.toml --spp 2 -o a.pfm");
    assert_eq!(finished.code, 0, "{}", finished.stderr);
    assert!(
        !finished.stderr.contains("not finite"),
        "{}",
        finished.stderr
    );
}
