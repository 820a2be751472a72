//! Scattering at a surface.

pub mod types;
