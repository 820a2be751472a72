//! Sampling: warps of uniform numbers, discrete choices, the weights of combined techniques, and integration, by rules
//! and by chance.

pub mod clear_triangle;
pub mod cosine_power;
pub mod direction;
pub mod disk;
pub mod distribution;
mod grid;
pub mod integrands;
pub mod linear;
pub mod metropolis;
pub mod mis;
pub mod monte_carlo;
pub mod piecewise;
pub mod piecewise_linear;
pub mod power;
pub mod quadrature;
pub mod rejection;
pub mod spherical_rectangle;
pub mod spherical_triangle;
pub mod triangle;
pub mod warp;
