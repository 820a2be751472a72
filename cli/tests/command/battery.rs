//! `etendue battery`: invalid requests, printed and written output, exit codes, and the results kept after Ctrl-C.

use crate::common::scene_folder::SceneFolder;
use crate::support::{INPUT_OUTPUT, USAGE, command, fails, interrupted, run, succeed};
use etendue::internals::accel::Backend;
use serde_json::Value;

fn empty() -> SceneFolder {
    SceneFolder::new::<&str>([])
}

fn read(folder: &SceneFolder, name: &str) -> String {
    let text = std::fs::read_to_string(folder.path(name));
    text.unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("it is JSON")
}

#[test]
fn invalid_battery_arguments_are_rejected() {
    let folder = empty();
    fails(
        &folder,
        "battery 999",
        USAGE,
        &["no case of row 999", "25, 26"],
    );
    fails(&folder, "battery near", USAGE, &["ROW", "near"]);
    fails(&folder, "battery --threads 0", USAGE, &["--threads"]);
    fails(
        &folder,
        "battery --quality low",
        USAGE,
        &["--quality", "medium", "high"],
    );
    fails(
        &folder,
        "battery --precision slow",
        USAGE,
        &["--precision", "robust"],
    );
    let known = Backend::ALL[0].name();
    fails(
        &folder,
        "battery --backend embre",
        USAGE,
        &["--backend", known],
    );
    let taken = SceneFolder::new([("out", "a file")]);
    fails(&taken, "battery 29 -o out", INPUT_OUTPUT, &["out"]);
}

#[test]
fn selected_rows_are_measured_and_written() {
    let folder = empty();
    let finished = succeed(&folder, "battery 29 28 -o out --seed 7 -t 1");
    let report = json(&read(&folder, "out/battery.json"));
    assert_eq!(
        (&report["failed"], &report["complete"]),
        (&0.into(), &true.into())
    );
    assert_eq!(
        (&report["seed"], &report["effort"]),
        (&7.into(), &"quick".into())
    );
    assert_eq!(report["backend"], Backend::ALL[0].name());
    let results = report["results"].as_array().expect("a list");
    assert_eq!(report["passed"], results.len());
    assert!(
        results
            .iter()
            .all(|case| case["row"] == 28 || case["row"] == 29)
    );
    let case = &results[0];
    assert_eq!(
        (&case["verdict"], &case["relation"]),
        (&"passed".into(), &"equal".into())
    );
    for number in [
        "exact",
        "ours",
        "error",
        "standard_error",
        "power_limit",
        "seconds",
    ] {
        assert!(case[number].is_number(), "{number} of {case}");
    }
    let summary = format!("{0} of {0} cases passed", results.len());
    assert!(finished.stderr.contains(&summary), "{}", finished.stderr);
    let page = read(&folder, "out/battery.html");
    for text in [finished.stdout, page] {
        for word in [
            "passed",
            "Comparison with other renderers",
            "LuxCore",
            "cos 1e-6",
            "etendue battery 29 28",
        ] {
            assert!(text.contains(word), "{word} in {text}");
        }
    }
}

#[test]
fn printed_json_equals_the_written_file() {
    let folder = empty();
    let finished = succeed(&folder, "battery 13 --json -q -o deep/out");
    assert_eq!(finished.stderr, "");
    assert_eq!(finished.stdout, read(&folder, "deep/out/battery.json"));
    assert_eq!(json(&finished.stdout)["results"][0]["row"], 13);
}

/// With fast precision rays slip through vertices: the battery has to detect it and report it by the exit code.
#[test]
fn failed_case_sets_the_exit_code() {
    let folder = empty();
    let backend = "obvhs-bvh2";
    let finished = run(
        &folder,
        &format!("battery 37 --precision fast --backend {backend} -o out"),
    );
    let report = json(&read(&folder, "out/battery.json"));
    assert!(
        report["failed"].as_u64().is_some_and(|failed| failed > 0),
        "{report}"
    );
    assert_eq!(finished.code, 1, "{}", finished.stderr);
    assert!(finished.stderr.contains("failed"), "{}", finished.stderr);
    assert!(finished.stdout.contains("FAILED"), "{}", finished.stdout);
}

#[test]
fn full_battery_reports_its_seed_and_command() {
    let folder = empty();
    let report = json(&succeed(&folder, "battery 29 --full --json -q -o out").stdout);
    let seed = report["seed"].as_u64().expect("a seed");
    assert!(seed > 0);
    let command = report["command"].as_str().expect("a text");
    assert!(command.ends_with(&format!("--seed {seed}")), "{command}");
    assert_eq!(report["effort"], "full");
}

#[cfg(unix)]
#[test]
fn interrupted_battery_writes_an_incomplete_report() {
    let folder = empty();
    // It is interrupted long before its end; the long cases come first.
    let child = command(&folder, "battery --full -o out").spawn();
    let child = child.expect("the command starts");
    std::thread::sleep(std::time::Duration::from_secs(3));
    let finished = interrupted(child);
    assert!(
        finished.stderr.contains("interrupted"),
        "{}",
        finished.stderr
    );
    assert_eq!(json(&read(&folder, "out/battery.json"))["complete"], false);
}
