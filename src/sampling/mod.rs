//! Sampling: warps of uniform numbers, discrete choices, and the weights of combined techniques.

pub mod clear_triangle;
pub mod distribution;
pub mod linear;
pub mod mis;
pub mod piecewise;
pub mod spherical_rectangle;
pub mod spherical_triangle;
pub mod warp;
