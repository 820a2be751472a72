//! How lights are sampled.

#[path = "../common/mod.rs"]
mod common;

mod delta_lights;
mod environment;
mod lamps;
mod light;
