//! The command, ended at a random moment while it replaces a picture.
//!
//! Measure: pixels; exit codes.
//! Range: signals, so Unix alone.
//! Source: none needed.

use super::common::TestRng;
use super::common::scene_folder::{SMALL, SceneFolder};
use super::support::{command, succeed};
use etendue::internals::image::{ColourSpace, Image};
use std::process::{Child, Command};
use std::time::{Duration, Instant};

/// The exit code of an interrupted render, whose samples so far are kept.
const INTERRUPTED: i32 = 130;

/// A render whose picture is large, so that writing it takes a good part of its time.
const RENDER: &str = "render small.toml --size 1024x512 --spp 1 -t 2 -q -o a.exr -o a.pfm";

/// A folder with a picture, and how the attempts on it went.
pub struct Victim {
    folder: SceneFolder,
    /// What an undisturbed render takes.
    usual: Duration,
    interrupted: u64,
    killed: u64,
    finished: u64,
}

impl Victim {
    /// With a picture already there.
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

    /// Ends a render at a random moment; a whole picture has to be there afterwards.
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
            // An error says that it has ended already.
            child.kill().unwrap_or_default();
        }
        self.judge(&mut child, interrupt);
        for name in ["a.exr", "a.pfm"] {
            let image = Image::read(&self.folder.path(name), ColourSpace::Linear);
            let image = image.unwrap_or_else(|error| panic!("the picture is damaged: {error}"));
            assert_eq!((image.width(), image.height()), (1024, 512));
        }
        self.sweep(interrupt);
    }

    /// How it ended: by the signal, or before it came.
    fn judge(&mut self, child: &mut Child, interrupt: bool) {
        let code = child.wait().expect("it was started here").code();
        match code {
            Some(0) => self.finished += 1,
            Some(INTERRUPTED) if interrupt => self.interrupted += 1,
            None => self.killed += 1,
            other => panic!("the command ended with {other:?}"),
        }
    }

    /// Who is killed leaves a temporary file behind; who is interrupted does not.
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

impl std::fmt::Display for Victim {
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
    // An error says that it has ended already.
    let sent = Command::new("kill").args([name, &id]).output();
    sent.expect("there is a command kill");
}
