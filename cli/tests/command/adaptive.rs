//! `--adaptive` on the command line: what it reports, and that the scene's setting applies where the flag is absent.

use crate::common::scene_folder::{SMALL, SceneFolder};
use crate::support::{USAGE, fails, scene_fails, succeed};
use serde_json::Value;

fn stats(folder: &SceneFolder) -> Value {
    let text = std::fs::read_to_string(folder.path("a.json")).expect("it was written");
    serde_json::from_str(&text).expect("it is JSON")
}

/// Whether the bytes of the EXR contain this text.
fn exr_says(folder: &SceneFolder, words: &str) -> bool {
    let bytes = std::fs::read(folder.path("a.exr")).expect("it was written");
    bytes
        .windows(words.len())
        .any(|window| window == words.as_bytes())
}

#[test]
fn greedy_adaptive_is_labelled_biased_and_two_phase_is_not() {
    let folder = SceneFolder::new([("a.toml", SMALL)]);
    let flags = "-o a.exr --stats a.json --progress none";
    let greedy = succeed(
        &folder,
        &format!("render a.toml --adaptive=greedy --error 50% --spp 512 {flags}"),
    );
    assert!(
        greedy.stderr.contains("biased by greedy"),
        "{}",
        greedy.stderr
    );
    assert!(
        stats(&folder)["bias"][0]
            .as_str()
            .is_some_and(|it| it.contains("greedy"))
    );
    assert!(exr_says(&folder, "greedy adaptive sampling"));

    let ours = succeed(
        &folder,
        &format!("render a.toml --adaptive --spp 128 {flags}"),
    );
    assert!(!ours.stderr.contains("biased"), "{}", ours.stderr);
    assert!(
        ours.stderr.contains("128 spp in the mean (32 to "),
        "{}",
        ours.stderr
    );
    let stats = stats(&folder);
    assert_eq!(stats["adaptive"], "two-phase");
    assert_eq!(stats["bias"], Value::Array(vec![]));
    assert_eq!(stats["spp_range"][0], 32);
    let samples = stats["samples"].as_u64().expect("a number");
    // Five standard deviations of the sum of fractions of rounds, which each pixel rounds by itself.
    assert!(samples.abs_diff(24 * 16 * 128) <= 160, "{samples}");
    assert!(exr_says(&folder, "two-phase"));
}

#[test]
fn adaptive_flag_overrides_the_scene_setting() {
    let text = SMALL.replace("spp = 4", "spp = 64\nadaptive = \"two-phase\"");
    let folder = SceneFolder::new([("a.toml", text)]);
    let flags = "-o a.pfm --stats a.json -q";
    for (flag, expected) in [("", "two-phase"), ("--adaptive=off", "off")] {
        succeed(&folder, &format!("render a.toml {flag} {flags}"));
        assert_eq!(stats(&folder)["adaptive"], expected);
    }
    scene_fails(
        "[render]\nadaptive = \"greed\"",
        2,
        &["render.adaptive", "`greedy`"],
    );
}

#[test]
fn invalid_adaptive_flags_are_usage_errors() {
    let folder = SceneFolder::new([("a.toml", SMALL)]);
    for (flags, words) in [
        ("--adaptive=greedy", ["--error", "greedy"]),
        ("--adaptive=gredy --error 1%", ["--adaptive", "greedy"]),
    ] {
        fails(&folder, &format!("render a.toml {flags}"), USAGE, &words);
    }
}
