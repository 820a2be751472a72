//! Tests of the scripts in `scripts/slurm/`, as far as they need no Slurm; `scripts/slurm/try.sh` tests them with one.

use crate::common::scene_folder::{SMALL, SceneFolder, in_repository};
use crate::support::{Finished, succeed};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
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

/// An `sbatch` that runs the tasks of a job one after the other, before it returns.
const SBATCH: &str = r#"#!/bin/sh
tasks=
while :; do
    case $1 in
    --array=*) tasks=${1#--array=} ;;
    --*) ;;
    *) break ;;
    esac
    shift
done
if [ -z "$tasks" ]; then
    sh "$@" >/dev/null
fi
for range in $(echo "$tasks" | tr , ' '); do
    task=${range%-*}
    while [ "$task" -le "${range#*-}" ]; do
        SLURM_ARRAY_TASK_ID=$task sh "$@" >/dev/null
        task=$((task + 1))
    done
done
echo 1
"#;

/// A folder with a scene and a program `sbatch` that runs jobs.
fn with_sbatch(scene: &str) -> SceneFolder {
    let folder = SceneFolder::new([("small.toml", scene), ("sbatch", SBATCH)]);
    let permissions = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(folder.path("sbatch"), permissions).expect("it is ours");
    folder
}

/// Renders to `render` by jobs of the folder's `sbatch`, with these arguments and this error to reach, if there is one; the image is
/// `shards.pfm` of the folder.
fn submit(folder: &SceneFolder, render: &Path, arguments: &str, error: &str) -> Finished {
    let path = std::env::var("PATH").expect("there are programs");
    let submitted = Command::new("sh")
        .arg(in_repository("scripts/slurm/render.sh"))
        .arg(render)
        .args(arguments.split_whitespace())
        .current_dir(folder.root())
        .env("PATH", format!("{}:{path}", folder.root().display()))
        .env("ETENDUE", env!("CARGO_BIN_EXE_etendue"))
        .env("IMAGE", folder.path("shards.pfm"))
        .env("ERROR", error)
        .output();
    submitted.expect("sh runs").into()
}

/// A disk may damage a shard after its task has ended, or the pilot, which is missed when another shard is lost.
#[test]
fn damaged_shard_is_rendered_again() {
    for (flags, damaged, lost) in [
        ("", "part-0..16.etd", None),
        ("--adaptive", "part-0..4.etd", None),
        ("--adaptive", "part-8..20.etd", None),
        ("--adaptive", "pilot.etd", Some("part-8..20.etd")),
    ] {
        let folder = with_sbatch(SMALL);
        let render = folder.path("render");
        let read = |name: &str| std::fs::read(folder.path(name)).expect(name);
        let done = |arguments: &str| {
            let submitted = submit(&folder, &render, arguments, "");
            let problem = std::fs::read_to_string(render.join("failed"));
            assert_eq!(submitted.code, 0, "{}{problem:?}", submitted.stderr);
            assert!(render.join("done").exists(), "{problem:?}");
            read("shards.pfm")
        };
        let image = done(&format!("2 32 small.toml {flags}"));
        let shard = std::fs::read(render.join(damaged)).expect("a state file");
        let mut bytes = shard.clone();
        bytes[shard.len() / 2] ^= 1;
        std::fs::write(render.join(damaged), &bytes).expect("it is written");
        std::fs::write(folder.path("shards.pfm"), "").expect("it is written");
        if let Some(lost) = lost {
            std::fs::remove_file(render.join(lost)).expect("it was there");
        }
        assert!(done("") == image, "{flags} {damaged}");
        if lost.is_some() {
            let merged = std::fs::read(render.join(damaged)).expect("a state file");
            assert!(merged == shard, "{flags} {damaged}");
        } else {
            let aside = std::fs::read(render.join(format!("{damaged}.damaged")));
            assert!(aside.expect("it is kept") == bytes, "{flags} {damaged}");
        }
    }
}

#[test]
fn adaptive_render_to_an_error_has_the_bits_of_a_continued_one() {
    let matte = "type = \"diffuse\"\nreflectance = 0.5";
    let scene = SMALL
        .replace("type = \"dielectric\"", matte)
        .replace("emission = [12, 11, 10]", "");
    let folder = with_sbatch(&scene);
    let settings = "--adaptive --sampler independent";
    // With four samples, the pilot is all of the first round.
    for (first, error) in [(64, "1%"), (4, "5%")] {
        let render = folder.path(&format!("render-{first}"));
        let arguments = format!("3 {first} small.toml {settings}");
        let submitted = submit(&folder, &render, &arguments, error);
        let read = |name: &str| std::fs::read_to_string(render.join(name)).unwrap_or_default();
        let problem = format!("{}{}", submitted.stderr, read("failed"));
        assert_eq!(submitted.code, 0, "{problem}");
        assert!(read("done").contains("samples per pixel"), "{problem}");
        let all: u64 = read("spp").trim().parse().expect("a number of samples");
        assert!(
            all > first,
            "the first round was enough: {}",
            read("report.json")
        );
        let flags = format!("render small.toml -q {settings}");
        succeed(&folder, &format!("{flags} --spp {first} -o begun.etd"));
        let continued = format!("{flags} --spp {all} --resume begun.etd -o whole.pfm");
        succeed(&folder, &continued);
        let image = |name: &str| std::fs::read(folder.path(name)).expect(name);
        assert!(image("shards.pfm") == image("whole.pfm"), "{first}");
    }
}
