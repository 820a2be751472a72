//! Tests of the scripts in `scripts/slurm/`, as far as they need no Slurm; `scripts/slurm/try.sh` tests them with one.

use crate::common::scene_folder::{SMALL, SceneFolder, in_repository};
use crate::support::{Finished, succeed};
use std::os::unix::fs::PermissionsExt;
use std::process::Command;

/// Runs a task of an array, which renders the first range of a folder.
fn task(folder: &SceneFolder) -> Finished {
    let task = Command::new("sh")
        .arg(in_repository("scripts/slurm/shard.sh"))
        .arg(folder.root())
        .env("SLURM_ARRAY_TASK_ID", "0")
        .env("ETENDUE", env!("CARGO_BIN_EXE_etendue"))
        .output();
    task.expect("sh runs").into()
}

#[test]
fn damaged_checkpoint_does_not_block_its_shard() {
    let folder = SceneFolder::new([("small.toml", SMALL), ("round", "0..8\n"), ("spp", "8\n")]);
    let scene = folder.path("small.toml").display().to_string();
    std::fs::write(folder.path("command"), format!("{scene}\n")).expect("it is written");
    let checkpoint = folder.path("checkpoint-0..8.etd");
    std::fs::write(&checkpoint, "ETDSTATE and noise").expect("it is written");
    let ended = task(&folder);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    // The log is the task's standard error.
    let words = ["damaged state file", "checkpoint-0..8.etd.damaged"];
    assert!(
        words.iter().all(|word| ended.stderr.contains(word)),
        "{}",
        ended.stderr
    );
    let kept = std::fs::read(folder.path("checkpoint-0..8.etd.damaged"));
    assert_eq!(kept.expect("it is kept"), b"ETDSTATE and noise");
    succeed(&folder, "merge -q part-0..8.etd -o merged.pfm");
    succeed(&folder, "render small.toml -q --spp 8 -o whole.pfm");
    let read = |name: &str| std::fs::read(folder.path(name)).expect(name);
    assert!(read("merged.pfm") == read("whole.pfm"));
}

/// The exit code of an image with many samples that are not finite, after the image is written.
#[test]
fn slurm_script_reports_an_image_with_samples_that_are_not_finite() {
    let folder = SceneFolder::new([
        ("round", "0..4\n"),
        ("spp", "4\n"),
        ("part-0..4.etd", ""),
        ("merge", "#!/bin/sh\nexit 6\n"),
    ]);
    let program = folder.path("merge");
    let permissions = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(&program, permissions).expect("it is ours");
    let ended = Command::new("sh")
        .arg(in_repository("scripts/slurm/render.sh"))
        .arg("--next")
        .arg(folder.root())
        .env("ETENDUE", &program)
        .output();
    assert!(!ended.expect("sh runs").status.success());
    let reason = std::fs::read_to_string(folder.path("failed")).expect("a reason");
    assert!(reason.contains("the image is written"), "{reason}");
}
