//! Etendue: a Monte Carlo renderer on Intel Embree 4 that states how wrong its picture is.
//!
//! Programs use [`session`]: a scene that was loaded or built in code, pictures of it to a number of samples, a time or an error,
//! with their error bars and layers, and what rays meet. The command `etendue` is the module `cli`, the C library the package
//! in `capi/`. How it works inside is in `docs/architecture.md`.
//!
//! No state is kept for the process but a count of what sessions were: any number of them may live and render at once, on threads
//! of their own. Vectors and matrices in the interface are those of glam, as [`math::vec`] re-exports them, and reports can be
//! written by serde; no other dependency shows.
//!
//! # Features
//!
//! - `embree` (default): the Embree backend, through the system's library. Without it, rays are traced by obvhs, in Rust.
//! - `cli` (default): the command, with what it depends on. Libraries leave it out.
//! - `flip` (default): FLIP, how different two pictures look. Needs a C++ compiler.
//! - `oidn` (default): Intel Open Image Denoise, where it is found when running.
//!
//! # Versions
//!
//! Rust 1.89 or newer; an older one is given up with a minor version. While the major version is 0, what breaks programs comes
//! with a minor version, too. Enumerations that may grow are non-exhaustive.

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
pub mod memory;
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
