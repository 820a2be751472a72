//! Tests that `--integrator auto` reports its choice and the reason before the render, on the last line, in the
//! statistics and in the image, and that `etendue plan` reports it without rendering.

use crate::common::scene_folder::{SMALL, SceneFolder};
use crate::support::{USAGE, fails, succeed};
use serde_json::Value;

/// The small scene, alone and with a point light, for which the glass ball casts a caustic.
fn folder() -> SceneFolder {
    let point = "\n[[light]]\ntype = \"point\"\nposition = [-1, 3, 0]\nintensity = 5\n";
    let auto = SMALL.replace("spp = 4", "spp = 4\nintegrator = \"auto\"");
    SceneFolder::new([
        ("small.toml", SMALL.to_owned()),
        ("point.toml", format!("{SMALL}{point}")),
        ("auto.toml", format!("{auto}{point}")),
    ])
}

#[test]
fn auto_choice_and_reason_are_reported_in_every_output() {
    let folder = folder();
    for arguments in [
        "render point.toml --integrator auto --light-paths off --stats it.json -o it.exr",
        "render auto.toml --light-paths off --stats it.json -o it.exr",
    ] {
        let said = succeed(&folder, arguments).stderr;
        let stats = std::fs::read_to_string(folder.path("it.json")).expect("the file was written");
        let stats: Value = serde_json::from_str(&stats).expect("a JSON object");
        let chosen = stats["integrator"].as_str().expect("a name");
        assert!(["bdpt", "mlt"].contains(&chosen), "{chosen}");
        let why = stats["auto"].as_str().expect("a reason");
        assert!(why.contains("smooth surfaces"), "{why}");
        let first = format!("auto: {chosen}, as {why}");
        assert!(
            said.lines().any(|line| line == first),
            "no `{first}` in {said}"
        );
        let last = said.lines().last().expect("a last line");
        let words = format!("spp by {chosen}, chosen by auto in ");
        assert!(last.contains(&words), "no `{words}` in {last}");
        let image = std::fs::read(folder.path("it.exr")).expect("the file was written");
        for words in ["etendue.auto", why] {
            let holds = image.windows(words.len()).any(|it| it == words.as_bytes());
            assert!(holds, "no `{words}` in the image");
        }
    }
}

#[test]
fn auto_is_not_reported_for_a_named_integrator() {
    let finished = succeed(&folder(), "render small.toml --json -o it.png");
    let stats: Value = serde_json::from_str(&finished.stdout).expect("a JSON object");
    assert_eq!(
        (&stats["integrator"], &stats["auto"]),
        (&"path".into(), &Value::Null)
    );
    assert!(!finished.stderr.contains("auto"), "{}", finished.stderr);
}

#[test]
fn plan_reports_selected_integrator_and_alternatives() {
    let folder = folder();
    let table = succeed(&folder, "plan point.toml").stdout;
    for words in [
        "integrator: --integrator auto selects path: ",
        "light paths beside path: 1 for each camera path (camera paths alone miss light)",
        "squared error at equal work in a pilot, relative to path: path 1.00, bdpt ",
        "roulette of path: window=1/",
        "filter: gaussian:1.5, splatting (where light varies little, 2.97 times",
    ] {
        assert!(table.contains(words), "no `{words}` in\n{table}");
    }
    let printed = succeed(&folder, "plan small.toml --json").stdout;
    let report: Value = serde_json::from_str(&printed).expect("a JSON object");
    let integrator = &report["integrator"];
    let held = integrator["held_against"].as_array().expect("a list");
    let names: Vec<&str> = held
        .iter()
        .filter_map(|it| it["integrator"].as_str())
        .collect();
    assert_eq!(names, ["path", "bdpt", "mlt"]);
    assert_eq!(held[0]["inefficiency"], 1.0);
    assert!(integrator["recommended"].is_string() && integrator["why"].is_string());
    assert!(integrator["option"].is_null());
}

#[test]
fn study_rejects_integrator_auto() {
    let words = ["auto selects one of several", "--vary integrator=path,bdpt"];
    fails(
        &folder(),
        "study auto.toml -o study --budget 1s",
        USAGE,
        &words,
    );
}
