//! Etendue: a Monte Carlo renderer on Intel Embree 4.

pub mod accel;
pub mod battery;
pub mod bench;
pub mod bsdf;
pub mod camera;
#[cfg(feature = "cli")]
pub mod cli;
pub mod effects;
pub mod error;
pub mod film;
pub mod geometry;
pub mod image;
pub mod integrator;
pub mod lesson;
pub mod light;
pub mod math;
pub mod plan;
pub mod planted;
pub mod post;
pub mod render;
pub mod sampler;
pub mod sampling;
pub mod scene;
pub mod session;
pub mod study;

pub use error::{Error, ErrorKind, Result};
