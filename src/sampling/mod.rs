//! Sampling: warps of uniform numbers, discrete distributions, and the weights of multiple importance sampling.

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
