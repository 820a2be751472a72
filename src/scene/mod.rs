//! Scenes: as written, and as rendered.

pub mod description;
