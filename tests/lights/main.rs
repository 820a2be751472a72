//! Tests of lights and their sampling.

#[path = "../common/mod.rs"]
mod common;

mod choice;
mod delta_lights;
mod emission;
mod environment;
mod lamps;
mod lanes;
mod light;
