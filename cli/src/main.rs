//! The command-line program: typed arguments, one file per verb, and the output streams.
//!
//! Data goes to standard output, everything else to standard error. Exit codes: 0 done, 1 failed, 2 usage error, 3
//! invalid scene, 4 input or output error, 5 requested error not reached (image written), 6 too many non-finite samples
//! (image written), 130 interrupted (image written).

#[macro_use]
mod output;

mod args;
mod battery;
mod bench;
mod compare;
mod convert;
mod damaged;
mod denoise;
mod durations;
mod info;
mod lesson;
mod merge;
mod plan;
mod price;
mod recommendation;
mod render;
mod report;
mod shard_plan;
mod study;

use args::{Arguments, Verb};
use clap::{CommandFactory, Parser};
use etendue::{Error, ErrorKind};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The outcome of the command if no error was returned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Outcome {
    Done,
    ErrorNotReached,
    Failed,
    TooManyNonFinite,
    Interrupted,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let result = match &arguments.verb {
        Verb::Render(render) => render::run(render),
        Verb::Merge(merge) => merge::run(merge),
        Verb::Plan(plan) => plan::run(plan),
        Verb::Price(price) => price::run(price),
        Verb::Study(study) => study::run(study),
        Verb::Convert(convert) => convert::run(convert),
        Verb::Compare(compare) => compare::run(compare),
        Verb::Denoise(denoise) => denoise::run(denoise),
        Verb::Bench(bench) => bench::run(bench),
        Verb::Lesson(lesson) => lesson::run(lesson),
        Verb::Battery(battery) => battery::run(battery),
        Verb::Info(info) => info::run(info),
        Verb::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(*shell, &mut Arguments::command(), "etendue", &mut script);
            print(&script)
        }
        Verb::Man { verb } => manual(verb.as_deref()),
    };
    match result {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::ErrorNotReached) => ExitCode::from(5),
        Ok(Outcome::Failed) => ExitCode::FAILURE,
        Ok(Outcome::TooManyNonFinite) => ExitCode::from(6),
        Ok(Outcome::Interrupted) => ExitCode::from(130),
        Err(error) => {
            say!("etendue: {error}");
            ExitCode::from(match error.kind() {
                ErrorKind::Usage => 2,
                ErrorKind::Scene => 3,
                ErrorKind::Io => 4,
                _ => 1,
            })
        }
    }
}

/// Prints the manual page of the command or of one verb.
fn manual(verb: Option<&str>) -> etendue::Result<Outcome> {
    let mut command = Arguments::command();
    command.build();
    let page = match verb {
        None => command,
        Some(name) => match command.find_subcommand(name) {
            Some(found) => found.clone(),
            None => return Err(Error::usage(format!("there is no verb `{name}`"))),
        },
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page)
        .render(&mut text)
        .map_err(|error| Error::new(ErrorKind::Io, "cannot make the manual page").because(error))?;
    print(&text)
}

/// Returns the command line, beginning with `etendue`, as a shell reads it.
fn command_line() -> String {
    let words = std::env::args_os().skip(1);
    let words = words.map(|word| quoted(&word.to_string_lossy()));
    let words: Vec<String> = ["etendue".to_owned()].into_iter().chain(words).collect();
    words.join(" ")
}

/// Quotes a text as one word of a shell command.
fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./+,:@=%".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

/// Returns the name of a file in the current folder: that of a scene with another extension.
fn named_after(scene: &Path, extension: &str) -> PathBuf {
    // `with_extension` would take `.5` of `room.5` for an extension.
    let mut name = scene.file_stem().unwrap_or("scene".as_ref()).to_owned();
    name.push(".");
    name.push(extension);
    PathBuf::from(name)
}

/// Writes to standard output. A closed pipe, as with `| head`, is not an error.
fn print(text: &[u8]) -> etendue::Result<Outcome> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::io(
            "cannot write",
            Path::new("standard output"),
            error,
        )),
        _ => Ok(Outcome::Done),
    }
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn words_of_a_command_are_quoted_as_a_shell_reads_them() {
        for (word, text) in [
            ("scenes/box.toml", "scenes/box.toml"),
            ("1%", "1%"),
            ("my scene.toml", "'my scene.toml'"),
            ("it's", r"'it'\''s'"),
            ("", "''"),
        ] {
            assert_eq!(quoted(word), text);
        }
    }
}
