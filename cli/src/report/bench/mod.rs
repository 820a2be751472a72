//! A benchmark as tables, as JSON and as a page. All three take their numbers from the same functions, so that they
//! agree.

mod compare;
pub mod html;
pub mod json;
#[cfg(test)]
mod sample;
mod scene_tables;
pub mod tables;
pub mod wording;
