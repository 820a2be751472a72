//! Lessons as JSON: all measured numbers, without the pixels of images.
//!
//! Measure: that of each number.
//! Range: any pages; non-finite numbers are `null`.
//! Source: none needed. Tested in `cli/tests/command/lesson.rs`.

use super::{Done, command};
use etendue_lab::lesson::TOPICS;
use etendue_lab::lesson::page::Page;
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
struct LessonIndexDocument<'a> {
    seed: u64,
    topics: Vec<LessonDocument<'a>>,
}

#[derive(Serialize)]
struct LessonDocument<'a> {
    name: &'a str,
    title: &'a str,
    summary: &'a str,
    command: String,
    file: &'a Path,
    #[serde(flatten)]
    page: &'a Page,
}

#[derive(Serialize)]
struct LessonContents {
    topics: Vec<LessonEntry>,
}

#[derive(Serialize)]
struct LessonEntry {
    name: &'static str,
    title: &'static str,
    summary: &'static str,
}

/// Returns the finished topics as one object.
pub fn of_pages<'a>(done: &'a [Done], seed: u64) -> String {
    let lesson = |Done { topic, page, file }: &'a Done| LessonDocument {
        name: topic.name,
        title: topic.title,
        summary: topic.summary,
        command: command(topic.name, seed),
        file,
        page,
    };
    text(&LessonIndexDocument {
        seed,
        topics: done.iter().map(lesson).collect(),
    })
}

/// Returns the table of contents as one object.
pub fn of_contents() -> String {
    let entries = TOPICS.iter().map(|topic| LessonEntry {
        name: topic.name,
        title: topic.title,
        summary: topic.summary,
    });
    text(&LessonContents {
        topics: entries.collect(),
    })
}

fn text(document: &impl Serialize) -> String {
    let text = serde_json::to_string_pretty(document).expect("plain data always serialises");
    text + "\n"
}
