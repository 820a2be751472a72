//! A comparison of two pictures as JSON and as tables.

pub mod json;
pub mod tables;
