//! The study, the battery and the lessons, from scenes to their reports.

#[path = "../../../tests/common/mod.rs"]
mod common;

mod battery;
mod lesson;
mod study;
mod study_shards;
