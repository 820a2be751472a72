//! Tests of `render --checkpoint` and `--resume`: renders that are killed, interrupted, or run out of disk.

use crate::common::scene_folder::{SMALL, SceneFolder};
use crate::support::{INPUT_OUTPUT, USAGE, command, fails, run, succeed};
use etendue::internals::image::{ColourSpace, Image};
use etendue::internals::state::{State, read_header, with_checksum};
use std::path::Path;
use std::process::{Child, Command, Stdio};
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
fn killed_and_resumed_render_is_bit_identical() {
    for (integrator, spp) in [
        ("path", 2000),
        ("path --adaptive", 2000),
        ("path --layers", 2000),
        ("bdpt", 1000),
        ("mlt", 400),
    ] {
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
fn terminated_shard_leaves_a_checkpoint_but_no_output() {
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
    // Without --shard, it is not taken for the whole image.
    fails(
        &folder,
        "render small.toml --spp 1000000 --resume it.etd -o it.exr",
        USAGE,
        &["samples 500000..1000000", "-o part.etd"],
    );
    // Nor without an output, whose default is an image.
    fails(
        &folder,
        "render small.toml --spp 1000000 --resume it.etd",
        USAGE,
        &["samples 500000..1000000", "-o part.etd"],
    );
    assert_eq!(header.shard, Some([500_000, 1_000_000]));
    assert_eq!(header.done[0][0], 500_000);
}

/// Pilots that are cut choose otherwise than whole ones.
#[cfg(unix)]
#[test]
fn render_terminated_while_it_resumes_does_not_report_another_render() {
    let folder = small();
    let flags = "small.toml -q -t 1 --size 192x128 --integrator auto --checkpoint it.etd";
    succeed(&folder, &format!("render {flags} --spp 4 -o it.exr"));
    // The time of the signal decides what the test shows, not how it ends: before the pilots and after them, a render ends
    // in the same way.
    for delay in [50, 100, 200, 400, 800] {
        let flags = format!("render {flags} --spp 10000000 --resume it.etd -o it.exr");
        let child = command(&folder, &flags).spawn().expect("it starts");
        std::thread::sleep(Duration::from_millis(delay));
        let pid = child.id().to_string();
        let asked = Command::new("kill").args(["-TERM", &pid]).status();
        assert!(asked.expect("kill runs").success());
        let ended = child.wait_with_output().expect("it ends");
        let message = String::from_utf8_lossy(&ended.stderr);
        // Without a code, the signal came before the command was ready for it.
        let code = ended.status.code();
        assert!(code.is_none_or(|code| code == 130), "{code:?}: {message}");
    }
}

#[test]
fn checkpoint_of_a_complete_render_has_no_layers() {
    let folder = small();
    let flags = "render small.toml -q --spp 8 --layers --checkpoint it.etd -o all.etd -o it.exr";
    succeed(&folder, flags);
    let layers = |name: &str| read_header(&folder.path(name)).expect("it is whole").layers;
    assert!(layers("it.etd").is_empty() && !layers("all.etd").is_empty());
    succeed(&folder, "merge -q all.etd --denoise -o filtered.exr");
    fails(
        &folder,
        "merge it.etd --denoise -o filtered.exr",
        USAGE,
        &["--denoise needs the layers"],
    );
    // The headers tell it, before the sums are read.
    let mut damaged = std::fs::read(folder.path("it.etd")).expect("it is there");
    let last = damaged.len() - 1;
    damaged[last] ^= 1;
    std::fs::write(folder.path("it.etd"), damaged).expect("it is written");
    fails(
        &folder,
        "merge it.etd --denoise -o filtered.exr",
        USAGE,
        &["--denoise needs the layers"],
    );
}

#[test]
fn mismatched_state_files_are_rejected_on_resume() {
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
    // A checkpoint with samples is not replaced by a render that begins.
    fails(
        &folder,
        "render small.toml --spp 16 --checkpoint it.etd -o it.exr",
        USAGE,
        &["it.etd", "--resume it.etd"],
    );
    // Neither is a file that is no checkpoint, or may be one of another version.
    let scene = std::fs::read(folder.path("small.toml")).expect("it is there");
    for name in ["small.toml", "damaged.etd"] {
        std::fs::write(folder.path("damaged.etd"), &scene).expect("it is written");
        fails(
            &folder,
            &format!("render small.toml --spp 4 --checkpoint {name} -o it.exr"),
            INPUT_OUTPUT,
            &[name, "not a state file"],
        );
        let kept = std::fs::read(folder.path(name)).expect("it is there");
        assert!(kept == scene, "{name}");
    }
    // What a render has already is not rendered again.
    let again = succeed(
        &folder,
        "render small.toml --spp 8 --resume it.etd -o it.exr --json",
    );
    assert!(again.stdout.contains("\"spp\": 8"), "{}", again.stdout);
}

#[test]
fn damaged_checkpoint_is_set_aside_on_request_and_a_whole_one_is_not() {
    let folder = small();
    let flags = "-q --spp 8 --checkpoint it.etd -o it.pfm";
    succeed(&folder, &format!("render small.toml {flags}"));
    let read = |name: &str| std::fs::read(folder.path(name)).expect(name);
    let write = |name: &str, bytes: &[u8]| {
        std::fs::write(folder.path(name), bytes).expect("it is written");
    };
    let (whole, image) = (read("it.etd"), read("it.pfm"));
    let resume = format!("render small.toml {flags} --resume it.etd");
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    let cut = &whole[..whole.len() / 2];
    let names = ["it.etd.damaged", "it.etd.damaged-2", "it.etd.damaged-3"];
    for (damaged, name) in [&flipped[..], cut, &[]].into_iter().zip(names) {
        write("it.etd", damaged);
        fails(&folder, &resume, INPUT_OUTPUT, &["it.etd", "damaged"]);
        write("it.pfm", b"");
        let anew = succeed(&folder, &format!("{resume} --set-damaged-aside"));
        for word in ["it.etd: is a damaged state file", name, "begins anew"] {
            assert!(anew.stderr.contains(word), "{}", anew.stderr);
        }
        assert!(read(name) == damaged, "{name}");
        assert!(read("it.pfm") == image);
    }
    // A state of another render, or of a format to come, has samples that somebody may want.
    let aside = format!("{resume} --set-damaged-aside");
    fails(&folder, &format!("{aside} --seed 7"), USAGE, &["seed is 7"]);
    let mut other = whole[..whole.len() - 32].to_vec();
    other[8] += 1;
    let other = with_checksum(other);
    write("it.etd", &other);
    fails(&folder, &aside, INPUT_OUTPUT, &["it.etd", "of format 3"]);
    // Nor is a file that is no checkpoint.
    let elsewhere = aside.replace("--resume it.etd", "--resume it.etd.damaged");
    fails(
        &folder,
        &elsewhere,
        USAGE,
        &["it.etd.damaged", "--resume names another file"],
    );
}

#[test]
fn checkpoint_of_an_unfinished_first_pass_is_not_replaced() {
    let folder = small();
    succeed(&folder, "render small.toml -q --spp 4 -o it.etd");
    let mut state = State::read(&folder.path("it.etd")).expect("it is whole");
    state.header.done.clear();
    state.header.is_uneven = true;
    state.write(&folder.path("it.etd")).expect("it is written");
    fails(
        &folder,
        "render small.toml --spp 16 --checkpoint it.etd -o it.exr",
        USAGE,
        &["has samples already", "--resume it.etd"],
    );
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
fn full_disk_preserves_the_existing_file() {
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
    let flags = "render small.toml --filter box -q --spp 2000 --resume disk/it.etd --checkpoint disk/it.etd --every 0.001s -o it.exr";
    let full = run(&folder, flags);
    assert!(full.stderr.contains("no checkpoint"), "{}", full.stderr);
    // The last checkpoint cannot be written either, which costs the image nothing.
    assert_eq!(full.code, INPUT_OUTPUT, "{}", full.stderr);
    assert_eq!(read(&folder, "it.exr").width(), 24);
    let names = std::fs::read_dir(&disk.0).expect("it is there");
    assert_eq!(names.count(), 1, "a temporary file was left");
}

/// Both begin while there is no checkpoint. Whoever comes second keeps its hands off.
#[test]
fn checkpoint_of_another_render_is_kept() {
    let folder = small();
    let begin = |seed: u64, spp: u64| {
        let flags = format!(
            "render small.toml --spp {spp} --seed {seed} --checkpoint it.etd --every 0.01s -o it-{seed}.exr"
        );
        command(&folder, &flags)
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts")
    };
    let mut children = [begin(1, 3000), begin(2, 3000)];
    for child in &mut children {
        wait_for(&folder.path("it.etd"), 0, child);
    }
    let first = read_header(&folder.path("it.etd")).expect("it is whole");
    let ended = children.map(|child| child.wait_with_output().expect("it ends"));
    let last = read_header(&folder.path("it.etd")).expect("it is whole");
    assert_eq!(first.identity, last.identity);
    assert_eq!(last.samples(), 3000);
    let refused: Vec<_> = ended.iter().filter(|it| !it.status.success()).collect();
    let [refused] = refused[..] else {
        panic!("{ended:?}");
    };
    let reason = String::from_utf8_lossy(&refused.stderr);
    // One that began later, when there was a checkpoint already, is refused before its first sample.
    let is_late = reason.contains("has samples already");
    assert!(is_late || reason.contains("by another process"), "{reason}");
    let outputs = ["it-1.exr", "it-2.exr"].map(|name| folder.path(name).exists());
    assert_ne!(is_late, outputs == [true, true]);
}

#[test]
fn concurrent_writers_leave_a_valid_file() {
    let folder = small();
    let write = |seed| {
        for _ in 0..20 {
            let flags = format!("render small.toml -q --spp 4 --seed {seed} -o it.etd");
            succeed(&folder, &flags);
        }
    };
    std::thread::scope(|scope| {
        let writers = [1, 2].map(|seed| scope.spawn(move || write(seed)));
        while !writers
            .iter()
            .all(std::thread::ScopedJoinHandle::is_finished)
        {
            // At any time, there is no file or a whole one.
            if folder.path("it.etd").exists() {
                State::read(&folder.path("it.etd")).unwrap_or_else(|error| panic!("{error}"));
            }
        }
    });
    succeed(&folder, "merge -q it.etd -o it.exr");
}
