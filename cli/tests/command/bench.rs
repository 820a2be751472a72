//! `etendue bench`: invalid arguments, its output and files, and what it keeps after Ctrl-C.

use crate::common::scene_folder::{HEAD, SMALL, SceneFolder};
use crate::support::{INPUT_OUTPUT, SCENE, USAGE, command, fails, interrupted, succeed};
use etendue::internals::accel::Backend;
use serde_json::Value;

/// The options of a minimal bench.
const LITTLE: &str = "--rays 256 --compare 1000 --segments 1000 --render-time 0.01s -o out";

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

fn list<'a>(value: &'a Value, name: &str) -> &'a [Value] {
    let list = value[name].as_array();
    list.unwrap_or_else(|| panic!("no list {name} in {value}"))
}

fn texts<'a>(values: &'a [Value], name: &str) -> Vec<&'a str> {
    let text = |value: &'a Value| value[name].as_str().expect("a text");
    let mut texts: Vec<_> = values.iter().map(text).collect();
    texts.sort_unstable();
    texts.dedup();
    texts
}

fn backends() -> Vec<&'static str> {
    let mut names: Vec<_> = Backend::ALL.iter().map(|backend| backend.name()).collect();
    names.sort_unstable();
    names
}

#[test]
fn invalid_bench_arguments_are_rejected() {
    let folder = SceneFolder::new([
        ("small.toml", SMALL.to_owned()),
        ("bad.toml", format!("{HEAD}[[shape]]\n")),
    ]);
    for flag in [
        "--rounds=8",
        "--rays=0",
        "--threads=0",
        "--compare=-1",
        "--segments=x",
    ] {
        let name = flag.split('=').next().expect("split yields one part");
        fails(&folder, &format!("bench small.toml {flag}"), USAGE, &[name]);
    }
    fails(
        &folder,
        "bench small.toml --render-time soon",
        USAGE,
        &["--render-time"],
    );
    fails(
        &folder,
        "bench small.toml --precision slow",
        USAGE,
        &["--precision", "robust"],
    );
    fails(
        &folder,
        "bench small.toml --backend embre",
        USAGE,
        &["--backend", Backend::ALL[0].name()],
    );
    if !cfg!(feature = "embree") {
        let words = ["--backend", "this build is without Embree"];
        fails(&folder, "bench small.toml --backend embree", USAGE, &words);
    }
    fails(
        &folder,
        "bench small.toml none.toml",
        INPUT_OUTPUT,
        &["none.toml"],
    );
    fails(
        &folder,
        "bench terain",
        INPUT_OUTPUT,
        &["terain", "terrain", "suzanne-room"],
    );
    fails(&folder, "bench small.toml bad.toml", SCENE, &["bad.toml:5"]);
    fails(
        &folder,
        "bench small.toml -o small.toml",
        INPUT_OUTPUT,
        &["small.toml", "folder"],
    );
}

#[test]
fn printed_and_written_bench_reports_agree() {
    let folder = small();
    let finished = succeed(&folder, &format!("bench small.toml {LITTLE}"));
    let report = json(&read(&folder, "out/bench.json"));
    assert_eq!(
        (&report["complete"], &report["rounds"]),
        (&true.into(), &9.into())
    );
    let scene = &list(&report, "scenes")[0];
    assert_eq!(scene["name"], "small.toml");
    assert_eq!(texts(list(scene, "traces"), "backend"), backends());
    assert_eq!(texts(list(scene, "builds"), "backend"), backends());
    let kinds = texts(list(scene, "rays"), "kind");
    assert_eq!(texts(list(scene, "traces"), "kind"), kinds);
    assert!(
        kinds.contains(&"camera") && kinds.contains(&"shadow"),
        "{kinds:?}"
    );

    let printed = &finished.stdout;
    assert!(
        printed.starts_with("# The bench\n\nMeasured by `etendue bench small.toml --rays 256"),
        "{printed}"
    );
    let fastest = list(&report["derived"]["scenes"][0], "fastest");
    // Embree is compared twice, with its packets and without.
    let embree = usize::from(cfg!(feature = "embree"));
    assert_eq!(fastest.len(), kinds.len() * (backends().len() + embree));
    for fastest in fastest {
        let [kind, contender] =
            ["kind", "contender"].map(|name| fastest[name].as_str().expect("a text"));
        let time = fastest["nanoseconds"]["median"].as_f64().expect("a number");
        let row = printed.lines().find(|line| {
            let mut cells = line.split('|').map(str::trim).skip(1);
            cells.next() == Some(kind) && cells.next() == Some(contender)
        });
        let row = row.unwrap_or_else(|| panic!("no {kind} by {contender} in\n{printed}"));
        // Three digits are printed; the last one may be rounded either way.
        let shown = row
            .split('|')
            .map(str::trim)
            .find_map(|cell| cell.split_once(" ("));
        let shown: f64 = shown.map_or(f64::NAN, |(median, _)| median.parse().expect("a number"));
        assert!((shown / time - 1.0).abs() < 0.0051, "no {time} in {row}");
    }
    let page = read(&folder, "out/bench.html");
    for expected in backends().into_iter().chain(["small.toml", "</html>"]) {
        assert!(page.contains(expected), "no {expected} in {page}");
    }
    for outside in [
        "http:", "https:", "src=", "url(", "@import", "<script", "<link",
    ] {
        assert!(!page.contains(outside), "{outside} in {page}");
    }
    assert!(
        finished.stderr.contains("out/bench.html"),
        "{}",
        finished.stderr
    );
}

#[test]
fn single_backend_bench_prints_its_json() {
    let folder = small();
    let name = Backend::ALL[1].name();
    let arguments = format!("bench small.toml --json -q --backend {name} {LITTLE}");
    let finished = succeed(&folder, &arguments);
    assert_eq!(finished.stderr, "");
    assert_eq!(finished.stdout, read(&folder, "out/bench.json"));
    let report = json(&finished.stdout);
    assert_eq!(report["derived"]["reference"], name);
    assert_eq!(
        texts(list(&report["scenes"][0], "traces"), "backend"),
        [name]
    );
    assert_eq!(folder.listing(), ["out", "small.toml"]);
}

#[cfg(unix)]
#[test]
fn interrupted_bench_writes_an_incomplete_report() {
    let folder = small();
    // More rounds than can finish before the interrupt.
    let arguments = "bench small.toml --rounds 1000 --render-time 1h -o out";
    let child = command(&folder, arguments)
        .spawn()
        .expect("the command starts");
    // The first part is done once the file exists.
    let begun = std::time::Instant::now();
    while !folder.path("out/bench.json").exists() && begun.elapsed().as_secs() < 300 {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let finished = interrupted(child);
    let report = json(&read(&folder, "out/bench.json"));
    assert_eq!(report["complete"], false);
    assert_eq!(report["scenes"][0]["name"], "small.toml");
    for text in [finished.stdout, read(&folder, "out/bench.html")] {
        assert!(
            text.contains("interrupted") && text.contains("small.toml"),
            "{text}"
        );
    }
}
