//! `etendue lesson`: the table of contents, the topics as pages, and their numbers in the terminal.
//!
//! Measure: that of each topic.
//! Range: topics of the course. A page is written as soon as its topic is done, so that finished pages survive Ctrl-C.
//! Source: docs/lessons.md. Tested in `cli/tests/command/lesson.rs`.

use super::args::{LessonArguments, ProgressMode};
use super::durations::format_duration;
use super::output::{ConsoleObserver, time_left};
use super::report::lesson::{Done, command, html, json, text};
use super::{Outcome, print};
use etendue::internals::image::atomic::{check_creatable, make_folder, write_text};
use etendue::internals::render::RenderObserver;
use etendue::internals::render::settings::available_threads;
use etendue::{Error, Result};
use etendue_lab::lesson::page::Page;
use etendue_lab::lesson::topic::{LessonObserver, LessonSettings, Topic};
use etendue_lab::lesson::{self, TOPICS};
use etendue_lab::verdict::Verdict;
use std::path::PathBuf;
use std::time::Instant;

pub fn run(arguments: &LessonArguments) -> Result<Outcome> {
    let topics = if arguments.all {
        TOPICS
    } else {
        &arguments.topics
    };
    if topics.is_empty() {
        return print(contents(arguments.json).as_bytes());
    }
    let mode = match arguments.quiet {
        true => ProgressMode::None,
        false => arguments.progress,
    };
    let console = ConsoleObserver::new(mode)?;
    let site = Site::new(arguments, topics)?;
    let start = Instant::now();
    let done = site.run(&console);
    console.finish();
    let done = done?;
    if arguments.json {
        print(json::of_pages(&done, arguments.seed).as_bytes())?;
    }
    let whole = done.len() == topics.len();
    if !arguments.quiet {
        let end = if whole { "done" } else { "interrupted" };
        let place = match done.as_slice() {
            [only] => only.file.display().to_string(),
            _ if arguments.all => site.index().display().to_string(),
            _ => format!("{} pages in {}", done.len(), site.arguments.out.display()),
        };
        say!("{place}: {end} after {}", format_duration(start.elapsed()));
    }
    judge(&done)?;
    Ok(match whole {
        true => Outcome::Done,
        false => Outcome::Interrupted,
    })
}

fn contents(as_json: bool) -> String {
    if as_json {
        json::of_contents()
    } else {
        text::contents()
    }
}

/// Returns an error if a number failed its test.
fn judge(done: &[Done]) -> Result<()> {
    let numbers = done
        .iter()
        .flat_map(|done| done.page.numbers().map(move |n| (done, n)));
    let mut wrong = numbers.filter(|(_, number)| number.verdict != Verdict::Passed);
    match wrong.next() {
        None => Ok(()),
        Some((done, number)) => Err(Error::render(format!(
            "{}: `{}` {}: {} instead of {}, standard error {:.1e}",
            done.topic.name,
            number.name,
            number.verdict.name(),
            number.ours,
            number.exact,
            number.standard_error
        ))),
    }
}

/// The pages to write.
struct Site<'a> {
    arguments: &'a LessonArguments,
    topics: &'a [Topic],
}

impl<'a> Site<'a> {
    /// Creates the folder, and checks that every page can be written before anything is measured.
    fn new(arguments: &'a LessonArguments, topics: &'a [Topic]) -> Result<Self> {
        let folder = &arguments.out;
        make_folder(folder)?;
        let site = Self { arguments, topics };
        for topic in topics {
            check_creatable(&site.file(topic))?;
        }
        if arguments.all {
            check_creatable(&site.index())?;
        }
        Ok(site)
    }

    fn file(&self, topic: &Topic) -> PathBuf {
        self.arguments.out.join(format!("{}.html", topic.name))
    }

    fn index(&self) -> PathBuf {
        self.arguments.out.join("index.html")
    }

    /// Runs all topics, or those before an interruption.
    fn run(&self, console: &ConsoleObserver) -> Result<Vec<Done>> {
        let settings = LessonSettings {
            seed: self.arguments.seed,
            threads: self
                .arguments
                .threads
                .map_or_else(available_threads, usize::from),
            ..LessonSettings::default()
        };
        let whole: f64 = self.topics.iter().map(|topic| topic.weight).sum();
        let start = Instant::now();
        let mut before = 0.0;
        let mut done = Vec::new();
        for topic in self.topics {
            let teller = LessonProgress {
                console,
                topic,
                start,
                part: [before / whole, topic.weight / whole],
            };
            teller.progress(0.0);
            let Some(page) = lesson::run(topic, &settings, &teller)? else {
                break;
            };
            self.write(topic, &page)?;
            done.push(Done {
                topic: *topic,
                page,
                file: self.file(topic),
            });
            if self.arguments.all {
                write_text(
                    &self.index(),
                    &html::index(&done, self.topics, settings.seed),
                )?;
            }
            before += topic.weight;
        }
        Ok(done)
    }

    fn write(&self, topic: &Topic, page: &Page) -> Result<()> {
        let neighbours = if self.arguments.all { self.topics } else { &[] };
        let command = command(topic.name, self.arguments.seed);
        write_text(
            &self.file(topic),
            &html::of_page(topic, page, neighbours, &command),
        )?;
        match self.arguments.json {
            true => Ok(()),
            false => print(text::of_page(topic, page).as_bytes()).map(|_| ()),
        }
    }
}

/// Shows progress and forwards Ctrl-C.
struct LessonProgress<'a> {
    console: &'a ConsoleObserver,
    topic: &'a Topic,
    start: Instant,
    /// The start of this topic in the whole run, and its share, as fractions.
    part: [f64; 2],
}

impl LessonObserver for LessonProgress<'_> {
    fn progress(&self, fraction: f64) {
        let fraction = self.part[0] + fraction * self.part[1];
        self.console.show(fraction, || {
            let left = time_left(fraction, self.start.elapsed());
            let name = self.topic.name;
            left.map_or(name.to_owned(), |left| format!("{name}, {left} left"))
        });
    }

    fn is_cancelled(&self) -> bool {
        self.console.is_cancelled()
    }
}
