//! Lessons as pages, as text for the terminal and as JSON.

pub mod html;
pub mod json;
pub mod text;
pub mod wording;

pub use wording::significant;

use etendue_lab::lesson::page::Page;
use etendue_lab::lesson::topic::Topic;
use std::path::PathBuf;

/// A finished topic.
pub struct Done {
    pub topic: Topic,
    pub page: Page,
    pub file: PathBuf,
}

/// Returns the command that reproduces a page.
pub fn command(what: &str, seed: u64) -> String {
    format!("etendue lesson {what} --seed {seed}")
}
