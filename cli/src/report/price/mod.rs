//! A price as text for a terminal and as JSON.

pub mod json;
pub mod text;
