//! `etendue lesson`: the contents, self-contained pages, JSON, and errors.

use crate::common::scene_folder::SceneFolder;
use crate::support::{INPUT_OUTPUT, USAGE, fails, interrupted, run, succeed};
use etendue_lab::lesson::TOPICS;

fn folder() -> SceneFolder {
    SceneFolder::new([] as [(&str, String); 0])
}

fn read(folder: &SceneFolder, name: &str) -> String {
    std::fs::read_to_string(folder.path(name)).expect("it was written")
}

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).expect("valid JSON")
}

/// Asserts that a page has no external resources, no scripts and no formula that failed to render.
fn assert_self_contained(page: &str) {
    assert!(page.ends_with("</html>"), "{page}");
    // Image data is left out: its base64 letters may spell anything.
    let mut text = String::new();
    for (index, part) in page.split("src=\"").enumerate() {
        if index == 0 {
            text += part;
        } else {
            let (source, rest) = part.split_once('"').expect("a quoted source");
            assert!(source.starts_with("data:image/png;base64,"), "{source:.40}");
            text += rest;
        }
    }
    let outside = [
        "http:", "https:", "//", "url(", "@import", "<script", "<link", "<iframe",
    ];
    // `merror` marks a malformed formula.
    for unwanted in outside.into_iter().chain(["merror", "NaN"]) {
        assert!(!text.contains(unwanted), "{unwanted} in {text}");
    }
}

#[test]
fn lesson_without_a_topic_lists_all_topics() {
    let folder = folder();
    let printed = succeed(&folder, "lesson").stdout;
    for topic in TOPICS {
        assert!(
            printed.contains(topic.name) && printed.contains(topic.summary),
            "{printed}"
        );
    }
    let contents = json(&succeed(&folder, "lesson --json").stdout);
    let topics = contents["topics"].as_array().expect("a list");
    assert_eq!(topics.len(), TOPICS.len());
    assert_eq!(topics[0]["name"], "dice");
    assert!(folder.listing().is_empty());
}

#[test]
fn unknown_topic_is_rejected_with_the_nearest_name() {
    fails(
        &folder(),
        "lesson stratifyed",
        USAGE,
        &["stratifyed", "stratified"],
    );
    fails(&folder(), "lesson --all dice", USAGE, &["--all"]);
}

#[test]
fn unwritable_output_folder_is_rejected() {
    let folder = SceneFolder::new([("taken", "a file".to_owned())]);
    fails(&folder, "lesson dice -o taken", INPUT_OUTPUT, &["taken"]);
    fails(
        &folder,
        "lesson dice -o taken/below",
        INPUT_OUTPUT,
        &["taken"],
    );
    // A folder has the name of the page.
    std::fs::create_dir_all(folder.path("out/lesson/dice.html")).expect("a folder");
    fails(&folder, "lesson dice", INPUT_OUTPUT, &["dice.html"]);
}

#[test]
fn topic_prints_results_and_writes_a_self_contained_page() {
    let folder = folder();
    let finished = succeed(&folder, "lesson power-function --seed 5 --progress none");
    for expected in ["# The power function", "exact", "passed", "efficiency"] {
        assert!(finished.stdout.contains(expected), "{}", finished.stdout);
    }
    assert!(
        finished.stderr.contains("out/lesson/power-function.html"),
        "{}",
        finished.stderr
    );
    let page = read(&folder, "out/lesson/power-function.html");
    assert_self_contained(&page);
    for expected in [
        "etendue lesson power-function --seed 5",
        "<math",
        "<svg",
        "The claim",
    ] {
        assert!(page.contains(expected), "no {expected}");
    }
}

#[test]
fn json_contains_results_and_is_the_only_output() {
    let folder = folder();
    let finished = succeed(&folder, "lesson dice roulette --json -q -o pages");
    assert_eq!(finished.stderr, "");
    let report = json(&finished.stdout);
    let topics = report["topics"].as_array().expect("a list");
    assert_eq!(topics.len(), 2);
    assert_eq!(topics[0]["file"], "pages/dice.html");
    assert_eq!(topics[1]["command"], "etendue lesson roulette --seed 0");
    let numbers = &topics[0]["findings"][0]["numbers"]["numbers"];
    assert_eq!(numbers[0]["exact"], 3.5);
    assert_eq!(numbers[0]["verdict"], "passed");
    for name in ["dice", "roulette"] {
        assert_self_contained(&read(&folder, &format!("pages/{name}.html")));
    }
}

#[cfg(unix)]
#[test]
fn interrupted_site_keeps_completed_pages() {
    let folder = folder();
    let child = crate::support::command(&folder, "lesson --all -t 1")
        .spawn()
        .expect("the command starts");
    let begun = std::time::Instant::now();
    while !folder.path("out/lesson/index.html").exists() && begun.elapsed().as_secs() < 300 {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    interrupted(child);
    let (dice, index) = (
        read(&folder, "out/lesson/dice.html"),
        read(&folder, "out/lesson/index.html"),
    );
    assert_self_contained(&dice);
    assert_self_contained(&index);
    assert!(index.contains("href=\"dice.html\"") && !index.contains("href=\"ladder.html\""));
    assert!(!folder.path("out/lesson/ladder.html").exists());
    // No partly written file is left.
    let names = std::fs::read_dir(folder.path("out/lesson")).expect("a folder");
    for name in names.map(|entry| entry.expect("an entry").file_name()) {
        assert!(name.to_string_lossy().ends_with(".html"), "{name:?}");
    }
}

#[test]
fn non_numeric_seed_is_a_usage_error() {
    let finished = run(&folder(), "lesson dice --seed many");
    assert_eq!(finished.code, USAGE);
}
