//! Sampling: warps of uniform numbers, discrete distributions, and the weights of multiple importance sampling.
//!
//! Measure: that of each density, which is in its type (`math/measure.rs`).
//! Range: uniform numbers in [0, 1).
//! Source: named in each file. Tested in `tests/sampling/warps.rs` and in each file.

pub mod clear_triangle;
pub mod cosine_power;
pub mod distribution;
pub mod linear;
pub mod mis;
pub mod piecewise;
pub mod spherical_rectangle;
pub mod spherical_triangle;
pub mod triangle;
pub mod warp;
