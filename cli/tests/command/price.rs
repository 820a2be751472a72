//! `etendue price`: its answers, its table and JSON, invalid requests, and interruption.

use crate::common::scene_folder::{HEAD, SMALL, SceneFolder, in_repository};
use crate::support::{
    Finished, INPUT_OUTPUT, SCENE, USAGE, command, fails, interrupted, measured, run, succeed,
};
use serde_json::Value;

fn folder() -> SceneFolder {
    SceneFolder::new([
        ("small.toml", SMALL.to_owned()),
        ("bad.toml", format!("{HEAD}[[shape]]\n")),
        ("black.toml", format!("{HEAD}[film]\nsize = [8, 8]\n")),
        // Nothing but a sky of one colour.
        (
            "grey.toml",
            format!(
                "{HEAD}[film]\nsize = [16, 16]\n[[light]]\ntype = \"environment\"\nradiance = 0.5\n"
            ),
        ),
    ])
}

fn json(folder: &SceneFolder, arguments: &str) -> Value {
    let finished = succeed(folder, arguments);
    serde_json::from_str(&finished.stdout).expect("it is JSON")
}

/// The price, in a time that is enough for all of its parts.
fn priced(folder: &SceneFolder, arguments: &str) -> Finished {
    measured(folder, &format!("price {arguments}"), |finished| {
        let notes = ["no time for", "samples only"];
        notes.iter().any(|note| finished.stdout.contains(note))
    })
}

fn priced_as_json(folder: &SceneFolder, arguments: &str) -> Value {
    let finished = priced(folder, &format!("{arguments} --json -q"));
    serde_json::from_str(&finished.stdout).expect("it is JSON")
}

#[test]
fn invalid_price_arguments_are_rejected() {
    let folder = folder();
    for (arguments, code, words) in [
        ("small.toml --budget soon", USAGE, ["--budget", "5m"]),
        ("small.toml --budget 0s", USAGE, ["--budget", "5m"]),
        ("small.toml --integrator paht", USAGE, ["paht", "path"]),
        ("small.toml --size 0x8", USAGE, ["--size", "0x8"]),
        (
            "small.toml --size 512x512 --budget 0.01s",
            USAGE,
            ["too small", "--budget"],
        ),
        ("bad.toml", SCENE, ["bad.toml", "type"]),
        ("none.toml", INPUT_OUTPUT, ["none.toml", "cannot"]),
    ] {
        fails(&folder, &format!("price {arguments}"), code, &words);
    }
    let black = run(&folder, "price black.toml --budget 2s --integrator path -q");
    assert_eq!(black.code, 1, "{}", black.stderr);
    assert!(black.stderr.contains("black"), "{}", black.stderr);
}

#[test]
fn price_table_fits_the_terminal_and_has_every_section() {
    let folder = folder();
    let finished = priced(&folder, "small.toml --integrator path --progress none");
    for line in finished.stdout.lines() {
        assert!(line.chars().count() <= 80, "{line}");
    }
    for words in [
        "small.toml: 24 x 16 pixels, path with sobol",
        "10 %",
        "0.1 %",
        "where the error",
        "material",
        "what would make it cheaper",
        "--integrator bdpt",
        "--denoise",
        "path beyond doubt",
    ] {
        let text = &finished.stdout;
        // Which integrator is faster depends on the machine.
        let is_there = text.contains(words)
            || words.starts_with("path") && text.contains("times as fast as path");
        assert!(is_there, "no {words} in {text}");
    }
}

/// In a scene without rare paths, whose error is known early.
#[test]
fn priced_spp_matches_renders_with_that_target_error() {
    let folder = folder();
    let path = in_repository("scenes/cornell-box/cornell-box.toml");
    let scene = format!("{} --size 48x32 --integrator path", path.display());
    let report = priced_as_json(&folder, &format!("{scene} --seed 3"));
    assert_eq!(
        (&report["complete"], &report["integrator"]),
        (&true.into(), &"path".into())
    );
    assert_eq!(report["full_size"], serde_json::json!([48, 32]));
    let rows = report["answers"].as_array().expect("rows");
    assert_eq!(rows.len(), 5);
    let samples = |index: usize| rows[index]["spp"].as_f64().expect("a number");
    // Smaller errors take more samples, none less than independent ones save.
    assert!((1..5).all(|index| samples(index) > samples(index - 1)));
    let error_sources = &report["error_sources"];
    let total = |kind: &str| {
        let all = error_sources[kind].as_array().expect("a list");
        all.iter()
            .map(|it| it["variance"].as_f64().expect("a number"))
            .sum::<f64>()
    };
    // Each kind of source explains all of the error.
    assert!((total("materials") - 1.0).abs() < 1e-4 && (total("lights") - 1.0).abs() < 1e-4);
    assert!(report["advice"][0].is_string());

    // Samples, not seconds, so that no timing decides.
    let priced = samples(1);
    let spp = (11..15).map(|seed| {
        let flags = format!("render {scene} --error 3% --json -q --seed {seed} -o a.png");
        json(&folder, &flags)["spp"].as_f64().expect("a number")
    });
    let mean = spp.sum::<f64>() / 4.0;
    assert!((0.6..1.7).contains(&(mean / priced)), "{mean} for {priced}");
}

#[test]
fn price_and_plan_select_the_same_integrator() {
    let folder = folder();
    let price = priced_as_json(&folder, "small.toml");
    let plan = json(&folder, "plan small.toml --json");
    assert_eq!(price["auto"]["recommended"], price["integrator"]);
    assert_eq!(price["integrator"], plan["integrator"]["recommended"]);
}

#[test]
fn constant_scene_is_reported_as_exact() {
    let folder = folder();
    let finished = priced(&folder, "grey.toml --integrator path -q");
    assert!(
        finished.stdout.contains("exact: no noise"),
        "{}",
        finished.stdout
    );
}

#[cfg(unix)]
#[test]
fn interrupted_price_reports_the_interruption() {
    let folder = folder();
    let child = command(
        &folder,
        "price small.toml --budget 10m --integrator path --progress none",
    )
    .spawn()
    .expect("the command starts");
    std::thread::sleep(std::time::Duration::from_millis(800));
    let finished = interrupted(child);
    assert!(
        finished.stderr.contains("interrupted after"),
        "{}",
        finished.stderr
    );
}
