//! Tests of `render --checkpoint` and `--resume`: renders that are killed, interrupted, or run out of disk.

use crate::common::scene_folder::{SMALL, SceneFolder};
use crate::support::{INPUT_OUTPUT, USAGE, command, fails, run, succeed};
use etendue::internals::image::{ColourSpace, Image};
use etendue::internals::state::{State, read_header};
use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

fn small() -> SceneFolder {
    SceneFolder::new([("small.toml", SMALL)])
}

fn read(folder: &SceneFolder, name: &str) -> Image {
    let read = Image::read(&folder.path(name), ColourSpace::Srgb);
    read.unwrap_or_else(|error| panic!("{error}"))
}

/// Waits until the checkpoint has more samples than `least`, or the render has ended.
fn wait_for(checkpoint: &Path, least: u64, child: &mut Child) {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(60) {
        let samples = read_header(checkpoint).map_or(0, |header| header.samples());
        if samples > least || child.try_wait().expect("it can be waited for").is_some() {
            return;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("no checkpoint after a minute");
}

#[test]
fn a_killed_render_goes_on_to_the_bits_of_one_that_was_not() {
    for (integrator, spp) in [("path", 2000), ("bdpt", 1000), ("mlt", 400)] {
        let folder = small();
        let flags = format!(
            "small.toml -q --spp {spp} --integrator {integrator} --checkpoint it.etd --every 0.01s"
        );
        let mut resume = String::new();
        for kill in 0..3 {
            let checkpoint = folder.path("it.etd");
            let before = read_header(&checkpoint).map_or(0, |header| header.samples());
            let threads = 1 + kill % 2;
            let flags = format!("render {flags} -t {threads} {resume} -o it.exr");
            let mut child = command(&folder, &flags).spawn().expect("it starts");
            wait_for(&checkpoint, before, &mut child);
            // SIGKILL: nothing can be tidied up.
            child.kill().expect("it can be killed");
            child.wait().expect("it ends");
            resume = "--resume it.etd".to_owned();
        }
        succeed(&folder, &format!("render {flags} {resume} -o it.exr"));
        succeed(
            &folder,
            &format!("render small.toml -q --spp {spp} --integrator {integrator} -o whole.exr"),
        );
        assert!(
            read(&folder, "it.exr") == read(&folder, "whole.exr"),
            "{integrator}"
        );
    }
}

#[cfg(unix)]
#[test]
fn a_render_that_is_asked_to_end_keeps_all_its_samples() {
    let folder = small();
    let flags =
        "render small.toml --spp 1000000 --shard 1/2 --checkpoint it.etd --every 0.01s -o part.etd";
    let mut child = command(&folder, flags).spawn().expect("it starts");
    wait_for(&folder.path("it.etd"), 0, &mut child);
    let pid = child.id().to_string();
    let asked = Command::new("kill").args(["-TERM", &pid]).status();
    assert!(asked.expect("kill runs").success());
    let ended = child.wait().expect("it ends");
    assert_eq!(ended.code(), Some(130));
    assert!(
        !folder.path("part.etd").exists(),
        "a part is not a whole shard"
    );
    let header = read_header(&folder.path("it.etd")).expect("it is whole");
    assert_eq!(header.shard, Some([500_000, 1_000_000]));
    assert_eq!(header.done[0][0], 500_000);
}

#[test]
fn only_its_own_state_continues_a_render() {
    let folder = small();
    succeed(&folder, "render small.toml -q --spp 8 -o it.etd");
    for (flags, code, word) in [
        (
            "--seed 7 --resume it.etd",
            USAGE,
            "seed is 7 in this render, 0 in the state",
        ),
        ("--integrator bdpt --resume it.etd", USAGE, "integrator is"),
        ("--crop 0,0,8,8 --resume it.etd", USAGE, "window is"),
        ("--size 12x8 --resume it.etd", USAGE, "the scenes differ"),
        (
            "--spp 16 --shard 0/2 --resume it.etd -o part.etd",
            USAGE,
            "a whole render",
        ),
        ("--resume none.etd", INPUT_OUTPUT, "none.etd"),
        ("--resume small.toml", INPUT_OUTPUT, "not a state file"),
    ] {
        fails(
            &folder,
            &format!("render small.toml {flags}"),
            code,
            &[word],
        );
    }
    // What a render has already is not rendered again.
    let again = succeed(
        &folder,
        "render small.toml --spp 8 --resume it.etd -o it.exr --json",
    );
    assert!(again.stdout.contains("\"spp\": 8"), "{}", again.stdout);
}

/// A small file system in memory, which is full soon. Only root may mount one.
#[cfg(target_os = "linux")]
struct SmallDisk(std::path::PathBuf);

#[cfg(target_os = "linux")]
impl SmallDisk {
    fn mount(at: std::path::PathBuf) -> Option<Self> {
        std::fs::create_dir(&at).expect("a new folder");
        let mut mount = Command::new("mount");
        mount
            .args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"])
            .arg(&at);
        let is_mounted = mount.output().is_ok_and(|output| output.status.success());
        is_mounted.then_some(Self(at))
    }
}

#[cfg(target_os = "linux")]
impl Drop for SmallDisk {
    fn drop(&mut self) {
        let mut unmount = Command::new("umount");
        let ended = unmount.arg(&self.0).status().expect("umount runs");
        assert!(ended.success(), "{} is still mounted", self.0.display());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_costs_nothing_that_was_whole() {
    let folder = small();
    let Some(disk) = SmallDisk::mount(folder.path("disk")) else {
        eprintln!("not tested: only root may mount a small disk");
        return;
    };
    // With a box filter 24 x 16 pixels take some 40 kB: there is room for one file, but not for a second one beside it.
    succeed(
        &folder,
        "render small.toml --filter box -q --spp 4 -o disk/it.etd",
    );
    let before = std::fs::read(folder.path("disk/it.etd")).expect("it is there");
    let full = run(
        &folder,
        "render small.toml --filter box -q --spp 8 -o disk/it.etd",
    );
    assert_eq!(full.code, INPUT_OUTPUT, "{}", full.stderr);
    assert!(full.stderr.contains("disk/it.etd"), "{}", full.stderr);
    let after = std::fs::read(folder.path("disk/it.etd")).expect("it is there");
    assert!(before == after);
    // A checkpoint that cannot be written is a warning, while the render goes on.
    let flags = "render small.toml --filter box --spp 2000 --checkpoint disk/it.etd --every 0.001s -o it.exr";
    let full = run(&folder, flags);
    assert!(full.stderr.contains("no checkpoint"), "{}", full.stderr);
    let names = std::fs::read_dir(&disk.0).expect("it is there");
    assert_eq!(names.count(), 1, "a temporary file was left");
}

#[test]
fn of_two_writers_of_one_name_one_file_is_left_whole() {
    let folder = small();
    let flags = |seed| {
        format!(
            "render small.toml -q --spp 400 --seed {seed} -o it.etd --checkpoint it.etd --every 0.001s"
        )
    };
    let mut children =
        [1, 2].map(|seed| command(&folder, &flags(seed)).spawn().expect("it starts"));
    while children[0]
        .try_wait()
        .expect("it can be waited for")
        .is_none()
    {
        // At any time, there is no file or a whole one.
        if folder.path("it.etd").exists() {
            State::read(&folder.path("it.etd")).unwrap_or_else(|error| panic!("{error}"));
        }
    }
    for mut child in children {
        assert!(child.wait().expect("it ends").success());
    }
    succeed(&folder, "merge -q it.etd -o it.exr");
}
