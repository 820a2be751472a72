//! Lessons as pages, as text for the terminal and as JSON.

pub mod html;
pub mod json;
pub mod text;
pub mod wording;

pub use wording::significant;

use etendue_lab::lesson::page::Page;
use etendue_lab::lesson::topic::Topic;
use std::path::PathBuf;

/// A topic that is done.
pub struct Done {
    pub topic: Topic,
    pub page: Page,
    pub file: PathBuf,
}

/// The command that makes a page again.
pub fn command(what: &str, seed: u64) -> String {
    format!("etendue lesson {what} --seed {seed}")
}
