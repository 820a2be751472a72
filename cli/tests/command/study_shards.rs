//! `etendue study` in shards: a plan, its shards and their merge in one folder, and requests that do not fit the plan.

use crate::common::scene_folder::{SMALL, SceneFolder};
use crate::support::{INPUT_OUTPUT, SCENE, USAGE, command, fails, interrupted, measured, succeed};
use etendue_lab::study::shards::StudyPart;

const STUDY: &str = "study small.toml --size 8x6 --vary sampler=independent,sobol --progress none";

#[test]
fn shards_are_planned_rendered_and_merged_in_one_folder() {
    let folder = SceneFolder::new([("small.toml", SMALL)]);
    shards_need_a_plan(&folder);
    let planned = measured(&folder, &format!("{STUDY} --shards 2 -o out"), |_| false);
    assert!(
        planned.stderr.contains("out/plan.json: 2 shards"),
        "{}",
        planned.stderr
    );
    let written = std::fs::read_dir(folder.path("out")).expect("the folder exists");
    assert_eq!(written.count(), 1);
    other_requests_are_refused(&folder);
    shards_merge(&folder);
    all_variants_are_in_the_table(&folder);
    damaged_files_are_refused(&folder);
}

/// Requests for shards before there is a plan.
fn shards_need_a_plan(folder: &SceneFolder) {
    fails(
        folder,
        &format!("{STUDY} --shard 0/2 -o out"),
        INPUT_OUTPUT,
        &["plan.json", "--shards"],
    );
    fails(
        folder,
        &format!("{STUDY} --merge -o out"),
        INPUT_OUTPUT,
        &["plan.json", "--shards"],
    );
}

/// Requests that do not fit the plan, and merges of nothing.
fn other_requests_are_refused(folder: &SceneFolder) {
    for (arguments, code, words) in [
        (
            format!("{STUDY} --shards 2"),
            USAGE,
            ["plan.json", "already"],
        ),
        (
            format!("{STUDY} --shard 2/2"),
            USAGE,
            ["--shard", "counted from 0"],
        ),
        (
            format!("{STUDY} --shard 0/3"),
            USAGE,
            ["--shard", "2 shards, not 3"],
        ),
        (format!("{STUDY} --shard 0..4"), USAGE, ["--shard", "K/N"]),
        (
            format!("{STUDY} --shard 0/2 --seed 9"),
            USAGE,
            ["seed is 0", "9 in this command"],
        ),
        (
            format!("{STUDY} --shard 0/2 --reference bdpt"),
            USAGE,
            ["integrator", "bdpt"],
        ),
        (
            format!("{STUDY} --shard 0/2 --merge"),
            USAGE,
            ["--shard", "--merge"],
        ),
        (format!("{STUDY} --shards 1"), USAGE, ["--shards", "1"]),
        (
            format!("{STUDY} --partial"),
            USAGE,
            ["--partial", "--merge"],
        ),
        (
            format!("{STUDY} --merge"),
            USAGE,
            ["2 of 2 shards are missing", "0, 1"],
        ),
        (
            format!("{STUDY} --merge --partial"),
            USAGE,
            ["no shard", "study"],
        ),
    ] {
        fails(folder, &format!("{arguments} -o out"), code, &words);
    }
}

/// One shard, merged by itself on request, then both.
fn shards_merge(folder: &SceneFolder) {
    succeed(folder, &format!("{STUDY} --shard 1/2 -o out"));
    fails(
        folder,
        &format!("{STUDY} --merge -o out"),
        USAGE,
        &["1 of 2 shards are missing", ": 0; render", "--shard K/2"],
    );
    let partial = succeed(folder, &format!("{STUDY} --merge --partial -o out"));
    assert!(
        partial.stderr.contains("merged from 1 of 2 shards"),
        "{}",
        partial.stderr
    );
    succeed(folder, &format!("{STUDY} --shard 0/2 -o out"));
    interrupted_shard_continues(folder);
    let merged = succeed(folder, &format!("{STUDY} --merge -o out"));
    assert!(!merged.stderr.contains("merged from"), "{}", merged.stderr);
    assert!(
        merged.stdout.contains("Time to an error"),
        "{}",
        merged.stdout
    );
    for name in ["study.md", "study.html", "study.json", "study.csv"] {
        assert!(folder.path(&format!("out/{name}")).exists(), "{name}");
    }
}

/// The first shard, as if it had been interrupted after a few renders.
fn interrupted_shard_continues(folder: &SceneFolder) {
    let (part, begun) = (
        folder.path("out/part-0.exr"),
        folder.path("out/begun-0.exr"),
    );
    let whole = StudyPart::read(&part).expect("it was rendered");
    let mut first = whole.clone();
    first.renders.truncate(whole.renders.len() - 2);
    first.write(&begun).expect("written");
    std::fs::remove_file(&part).expect("it was there");
    succeed(folder, &format!("{STUDY} --shard 0/2 -o out"));
    let continued = StudyPart::read(&part).expect("it was continued");
    let seconds =
        |part: &StudyPart| -> Vec<_> { part.renders.iter().map(|it| it.seconds).collect() };
    assert_eq!(seconds(&continued)[..first.renders.len()], seconds(&first));
    assert!(!begun.exists());
}

/// Both variants have renders with seeds of their own.
fn all_variants_are_in_the_table(folder: &SceneFolder) {
    let csv = std::fs::read_to_string(folder.path("out/study.csv")).expect("a table");
    for name in ["sobol", "independent"] {
        let start = format!("\"{name}\",");
        let count = csv.lines().filter(|line| line.starts_with(&start)).count();
        assert!(count > 8, "{name}: {csv}");
    }
}

/// A part that is no image, and a plan that is none.
fn damaged_files_are_refused(folder: &SceneFolder) {
    std::fs::write(folder.path("out/part-1.exr"), "cut").expect("written");
    fails(
        folder,
        &format!("{STUDY} --merge -o out"),
        SCENE,
        &["part-1.exr"],
    );
    std::fs::write(folder.path("out/plan.json"), "{}").expect("written");
    fails(
        folder,
        &format!("{STUDY} --merge -o out"),
        SCENE,
        &["plan.json", "not the plan"],
    );
}

#[cfg(unix)]
#[test]
fn interrupted_shards_leave_no_file() {
    let folder = SceneFolder::new([("small.toml", SMALL)]);
    let study = "study small.toml --size 32x24 --progress none --quiet -o out";
    succeed(&folder, &format!("{study} --budget 3m --shards 3"));
    // A shard takes minutes.
    let child = command(&folder, &format!("{study} --shard 2/3")).spawn();
    let child = child.expect("the command starts");
    std::thread::sleep(std::time::Duration::from_millis(1500));
    interrupted(child);
    assert!(!folder.path("out/part-2.exr").exists());
}
