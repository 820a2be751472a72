//! Running the command in a folder.
//!
//! Measure: none.
//! Range: arguments are split at spaces: names in tests have none.
//! Source: none needed.

// Each test program uses a part of this module.
#![allow(dead_code)]

use crate::common::scene_folder::{HEAD, SceneFolder};
use std::process::{Child, Command, Output, Stdio};

/// The exit code of an invalid request.
pub const USAGE: i32 = 2;
/// The exit code of an invalid scene.
pub const SCENE: i32 = 3;
/// The exit code of a file that cannot be read or written.
pub const INPUT_OUTPUT: i32 = 4;

/// The exit code and the output of the command.
#[derive(Debug)]
pub struct Finished {
    /// The exit code.
    pub code: i32,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

/// The command with these arguments, to be run in a folder.
pub fn command(folder: &SceneFolder, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_etendue"));
    command
        .current_dir(folder.root())
        .args(arguments.split_whitespace())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// Runs the command with these arguments in a folder.
pub fn run(folder: &SceneFolder, arguments: &str) -> Finished {
    let output = command(folder, arguments).output();
    output.expect("the command starts").into()
}

/// Runs the command, which has to succeed.
pub fn succeed(folder: &SceneFolder, arguments: &str) -> Finished {
    let finished = run(folder, arguments);
    assert_eq!(finished.code, 0, "{arguments}: {}", finished.stderr);
    finished
}

/// Runs a verb that measures for a given time, with twice the time whenever it was too short, so that the pace of the machine
/// decides how long a test takes and never how it ends. `left_out` tells whether a report lacks something for lack of time.
#[track_caller]
pub fn measured(
    folder: &SceneFolder,
    arguments: &str,
    left_out: impl Fn(&Finished) -> bool,
) -> Finished {
    for doublings in 0..7 {
        let budget = 2 << doublings;
        let finished = run(folder, &format!("{arguments} --budget {budget}s"));
        let too_short = finished.code == USAGE && finished.stderr.contains("too small");
        if !too_short {
            assert_eq!(finished.code, 0, "{arguments}: {}", finished.stderr);
            if !left_out(&finished) {
                return finished;
            }
        }
    }
    panic!("{arguments}: two minutes are not enough");
}

/// Sends the command what Ctrl-C sends, and waits for its end, of which its exit code has to tell.
#[cfg(unix)]
pub fn interrupted(child: Child) -> Finished {
    let id = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &id]).status();
    assert!(sent.expect("kill(1) is there").success());
    let finished: Finished = child.wait_with_output().expect("it ends").into();
    assert_eq!(finished.code, 130, "{}", finished.stderr);
    finished
}

/// Runs the command, and checks that it fails with this code, prints all of `words` on standard error, and leaves the folder
/// unchanged.
#[track_caller]
pub fn fails(folder: &SceneFolder, arguments: &str, code: i32, words: &[&str]) {
    let before = folder.listing();
    let finished = run(folder, arguments);
    let message = &finished.stderr;
    assert_eq!(finished.code, code, "{arguments}: {message}");
    for word in words {
        assert!(
            message.contains(word),
            "{arguments}: no `{word}` in: {message}"
        );
    }
    assert!(!message.contains("panicked"), "{arguments}: {message}");
    assert_eq!(finished.stdout, "", "{arguments}");
    assert_eq!(folder.listing(), before, "{arguments}");
}

/// Renders a scene that ends in `tail`, and expects an error about its `line`, counted from the tail's first.
#[track_caller]
pub fn scene_fails(tail: &str, line: usize, words: &[&str]) {
    let folder = SceneFolder::new([("a.toml", format!("{HEAD}{tail}"))]);
    let place = format!("a.toml:{}: ", HEAD.lines().count() + line);
    let words = [&[place.as_str()], words].concat();
    fails(&folder, "render a.toml", SCENE, &words);
}

impl From<Output> for Finished {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("the command prints UTF-8");
        Self {
            code: output.status.code().expect("the command was not killed"),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }
}
