//! The bench: its scenes, its report, and whether backends agree.

#[path = "../../../tests/common/mod.rs"]
mod common;

mod agreement;
mod report;
mod scenes;
