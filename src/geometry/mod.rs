//! Shapes and textures.

pub mod texture;
