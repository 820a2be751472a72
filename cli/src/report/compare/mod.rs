//! A comparison of two images as JSON and as tables.

pub mod json;
pub mod tables;
