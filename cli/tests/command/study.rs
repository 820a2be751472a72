//! `etendue study`: invalid requests, printed and written output, and the report kept after Ctrl-C.

use crate::common::scene_folder::{HEAD, SMALL, SceneFolder};
use crate::support::{
    Finished, INPUT_OUTPUT, SCENE, USAGE, command, fails, interrupted, measured, run,
};
use serde_json::Value;

fn small() -> SceneFolder {
    SceneFolder::new([("small.toml", SMALL)])
}

fn read(folder: &SceneFolder, name: &str) -> String {
    let text = std::fs::read_to_string(folder.path(name));
    text.unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("it is JSON")
}

/// The study, written to `out/`, in a time that is enough for what a test needs of its report.
fn studied(folder: &SceneFolder, arguments: &str, lacks: impl Fn(&Value) -> bool) -> Finished {
    measured(folder, &format!("study {arguments} -o out"), |_| {
        lacks(&json(&read(folder, "out/study.json")))
    })
}

/// Checks that a page has no external resources, no scripts, and no NaN or infinity.
fn assert_self_contained(page: &str) {
    assert!(page.ends_with("</html>"), "{page}");
    let mut text = String::new();
    for (index, part) in page.split("src=\"").enumerate() {
        let rest = match index {
            0 => part,
            _ => {
                let (source, rest) = part.split_once('"').expect("a quoted source");
                assert!(source.starts_with("data:image/png;base64,"), "{source:.40}");
                rest
            }
        };
        text += rest;
    }
    let outside = [
        "http:", "https:", "//", "url(", "@import", "<script", "<link", "<iframe",
    ];
    for unwanted in outside.into_iter().chain(["NaN", "inf\"", ">inf"]) {
        assert!(!text.contains(unwanted), "{unwanted} in {text}");
    }
}

#[test]
fn invalid_study_arguments_are_rejected() {
    let folder = SceneFolder::new([
        ("small.toml", SMALL.to_owned()),
        ("bad.toml", format!("{HEAD}[[shape]]\n")),
        (
            "endless.toml",
            SMALL.replace("spp = 4", "spp = 4\nroulette = \"none\""),
        ),
        ("taken", "a file".to_owned()),
    ]);
    for (arguments, code, words) in [
        (
            "small.toml --vary integrator",
            USAGE,
            ["--vary", "SETTING=A,B"],
        ),
        (
            "small.toml --vary integrater=path",
            USAGE,
            ["integrater", "integrator"],
        ),
        (
            "small.toml --vary sampler=sobol,sobel",
            USAGE,
            ["sobel", "sobol"],
        ),
        (
            "small.toml --vary max-bounces=few",
            USAGE,
            ["few", "whole number"],
        ),
        (
            "small.toml --vary integrator=bdpt light-paths=1",
            USAGE,
            ["nothing is left to study", "only path has light paths"],
        ),
        ("small.toml --vary backend=embre", USAGE, ["embre", "obvhs"]),
        ("small.toml --budget soon", USAGE, ["--budget", "5m"]),
        ("small.toml --budget 0s", USAGE, ["--budget", "5m"]),
        (
            "small.toml --size 8x8 --full-size",
            USAGE,
            ["--size", "--full-size"],
        ),
        ("small.toml --budget 50ms", USAGE, ["--budget", "5m"]),
        (
            "small.toml --size 256x256 --budget 0.02s",
            USAGE,
            ["too small", "at least"],
        ),
        (
            "endless.toml --budget 5s",
            USAGE,
            ["roulette", "--max-bounces"],
        ),
        ("bad.toml", SCENE, ["bad.toml", "type"]),
        ("none.toml", INPUT_OUTPUT, ["none.toml", "cannot"]),
        ("small.toml -o taken", INPUT_OUTPUT, ["taken", "cannot"]),
    ] {
        let arguments = match arguments.contains("-o ") {
            true => format!("study {arguments}"),
            false => format!("study {arguments} -o out"),
        };
        fails(&folder, &arguments, code, &words);
    }
}

#[test]
fn study_is_printed_and_written_in_every_format() {
    let folder = small();
    let finished = studied(
        &folder,
        "small.toml --size 8x6 --vary integrator=path,direct-directional sampler=independent --reference bdpt --seed 3 --progress none",
        |report| report["derived"][0]["slope"].is_null(),
    );
    for expected in [
        "# Study of small.toml",
        "## Time to an error",
        "## Bias and error bars",
        "direct-directional, independent",
        "--seed 3",
    ] {
        let tables = read(&folder, "out/study.md");
        assert!(tables.contains(expected), "no {expected} in {tables}");
    }
    // The terminal gets the answers, in lines that fit.
    for expected in [
        "small.toml\n",
        "Time to an error",
        "An error of 1 % takes",
        "never",
    ] {
        let text = &finished.stdout;
        assert!(text.contains(expected), "no {expected} in {text}");
    }
    for line in finished.stdout.lines() {
        assert!(line.chars().count() <= 80, "{line}");
    }
    assert!(
        finished.stderr.contains("out/study.html: done"),
        "{}",
        finished.stderr
    );

    let report = json(&read(&folder, "out/study.json"));
    assert_eq!(
        (&report["complete"], &report["seed"]),
        (&true.into(), &3.into())
    );
    let variants = report["variants"].as_array().expect("a list");
    assert_eq!(variants.len(), 2);
    assert_eq!(variants[0]["variant"]["sampler"], "independent");
    assert_eq!(report["reference"]["integrator"], "bdpt");
    let runs: usize = variants
        .iter()
        .flat_map(|variant| variant["levels"].as_array().expect("levels"))
        .map(|level| {
            let runs = level["runs"].as_array().expect("runs").len();
            assert_eq!(level["gram"]["rows"].as_array().expect("rows").len(), runs);
            runs
        })
        .sum();
    assert!(report["derived"][0]["slope"]["b"]["value"].is_number());
    let answers = report["derived"][0]["answers"].as_array().expect("answers");
    assert_eq!(answers.len(), 5);
    assert!(report["seconds"].as_f64().expect("a number") > 0.0);

    let csv = read(&folder, "out/study.csv");
    assert_eq!(csv.lines().count(), runs + 1);
    let page = read(&folder, "out/study.html");
    assert_self_contained(&page);
    for expected in [
        "<svg",
        "What accuracy costs",
        "Error against time",
        "data:image/png",
        "--seed 3",
        "What errors look like",
    ] {
        assert!(page.contains(expected), "no {expected}");
    }
}

#[test]
fn json_is_the_only_output_when_requested() {
    let folder = small();
    let finished = studied(&folder, "small.toml --size 8x6 --json -q", |_| false);
    assert_eq!(finished.stderr, "");
    let report = json(&finished.stdout);
    assert_eq!(report["size"], json("[8, 6]"));
    // By default, the study compares the independent with the Sobol' sampler.
    let names = ["independent", "sobol"];
    for (variant, name) in report["variants"]
        .as_array()
        .expect("two")
        .iter()
        .zip(names)
    {
        assert_eq!(variant["variant"]["name"], name);
    }
    assert_eq!(finished.stdout, read(&folder, "out/study.json"));
}

#[cfg(unix)]
#[test]
fn interrupted_study_writes_an_incomplete_report() {
    let folder = small();
    let child = command(
        &folder,
        "study small.toml --budget 10m --size 8x6 -o out --progress none",
    )
    .spawn()
    .expect("the command starts");
    // Results are written during the study.
    let begun = std::time::Instant::now();
    while begun.elapsed().as_millis() < 1500 {
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    interrupted(child);
    let report = json(&read(&folder, "out/study.json"));
    assert_eq!(report["complete"], false);
    let page = read(&folder, "out/study.html");
    assert_self_contained(&page);
    assert!(page.contains("was interrupted"));
    // No file is left partially written.
    let names = std::fs::read_dir(folder.path("out")).expect("a folder");
    for name in names.map(|entry| entry.expect("an entry").file_name()) {
        assert!(name.to_string_lossy().starts_with("study."), "{name:?}");
    }
}

#[test]
fn help_lists_the_variable_settings() {
    let finished = run(&small(), "study --help");
    assert_eq!(finished.code, 0);
    for word in ["integrator", "max-bounces", "--budget", "study.html"] {
        assert!(finished.stdout.contains(word), "no {word}");
    }
}

#[test]
fn times_are_predicted_for_another_thread_count() {
    let folder = small();
    fails(
        &folder,
        "study small.toml --for-threads 0",
        USAGE,
        &["--for-threads", "0"],
    );
    studied(
        &folder,
        "small.toml --vary sampler=sobol --size 8x6 --threads 2 --for-threads 64 -q",
        |report| report["scaling"].is_null() || report["derived"][0]["slope"].is_null(),
    );
    let report = json(&read(&folder, "out/study.json"));
    let scaling = &report["scaling"];
    assert_eq!(
        (&scaling["measured"], &scaling["threads"]),
        (&2.into(), &64.into())
    );
    let tables = read(&folder, "out/study.md");
    assert!(
        tables.contains("Time to an error on 64 threads"),
        "{tables}"
    );
}

#[test]
fn constant_scene_is_reported_as_noise_free() {
    let grey =
        format!("{HEAD}[film]\nsize = [8, 8]\n[[light]]\ntype = \"environment\"\nradiance = 0.5\n");
    let folder = SceneFolder::new([("grey.toml", grey)]);
    let finished = studied(&folder, "grey.toml -q", |report| {
        report["derived"][0].is_null()
    });
    assert!(
        finished.stdout.contains("has no noise in this scene"),
        "{}",
        finished.stdout
    );
    assert_self_contained(&read(&folder, "out/study.html"));
}
