//! The command, interrupted or killed at a random moment while it replaces an image file.
//!
//! Measure: pixels; exit codes.
//! Range: Unix only, for it sends signals.
//! Source: none needed.

use super::common::TestRng;
use super::common::scene_folder::{SMALL, SceneFolder};
use super::support::{command, succeed};
use etendue::internals::image::{ColourSpace, Image};
use std::process::{Child, Command};
use std::time::{Duration, Instant};

/// The exit code of an interrupted render, whose samples so far are kept.
const INTERRUPTED: i32 = 130;

/// A render of a large image, so that writing takes a good part of its time.
const RENDER: &str = "render small.toml --size 1024x512 --spp 1 -t 2 -q -o a.exr -o a.pfm";

/// A folder with an image, and counts of how its renders ended.
pub struct InterruptedRender {
    folder: SceneFolder,
    /// The duration of an undisturbed render.
    usual: Duration,
    interrupted: u64,
    killed: u64,
    finished: u64,
}

impl InterruptedRender {
    /// Creates the folder with an image already in it.
    pub fn new() -> Self {
        let folder = SceneFolder::new([("small.toml", SMALL)]);
        let start = Instant::now();
        succeed(&folder, RENDER);
        Self {
            folder,
            usual: start.elapsed(),
            interrupted: 0,
            killed: 0,
            finished: 0,
        }
    }

    /// Ends a render at a random moment; a complete image has to exist afterwards.
    pub fn kill_once(&mut self, rng: &mut TestRng) {
        let interrupt = rng.uniform() < 0.3;
        let seed = (1e6 * rng.uniform()) as u32;
        let mut child = command(&self.folder, &format!("{RENDER} --seed {seed}"))
            .spawn()
            .expect("the command starts");
        std::thread::sleep(self.usual.mul_f32(1.2 * rng.uniform()));
        if interrupt {
            signal(&child, "-INT");
        } else {
            // An error means that the process has already ended.
            child.kill().unwrap_or_default();
        }
        self.judge(&mut child, interrupt);
        for name in ["a.exr", "a.pfm"] {
            let image = Image::read(&self.folder.path(name), ColourSpace::Linear);
            let image = image.unwrap_or_else(|error| panic!("the image is damaged: {error}"));
            assert_eq!((image.width(), image.height()), (1024, 512));
        }
        self.sweep(interrupt);
    }

    /// Counts how the process ended: by the signal, or before it arrived.
    fn judge(&mut self, child: &mut Child, interrupt: bool) {
        let code = child.wait().expect("it was started here").code();
        match code {
            Some(0) => self.finished += 1,
            Some(INTERRUPTED) if interrupt => self.interrupted += 1,
            None => self.killed += 1,
            other => panic!("the command ended with {other:?}"),
        }
    }

    /// Removes temporary files: a killed process leaves one behind, an interrupted one must not.
    fn sweep(&self, interrupt: bool) {
        let ours = ["a.exr", "a.pfm", "small.toml"];
        for name in self
            .folder
            .listing()
            .iter()
            .filter(|name| !ours.contains(&name.as_str()))
        {
            assert!(!interrupt, "{name} was left behind");
            std::fs::remove_file(self.folder.path(name)).expect("it can be removed");
        }
    }
}

impl std::fmt::Display for InterruptedRender {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            interrupted,
            killed,
            finished,
            ..
        } = self;
        write!(
            f,
            "renders interrupted {interrupted}, killed {killed}, finished first {finished}"
        )
    }
}

fn signal(child: &Child, name: &str) {
    let id = child.id().to_string();
    // An error means that the process has already ended.
    let sent = Command::new("kill").args([name, &id]).output();
    sent.expect("the command kill exists");
}
