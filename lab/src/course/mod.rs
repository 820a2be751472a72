//! Sampling and integration as the course teaches them, which no kernel of the renderer needs.

pub mod direction;
pub mod disk;
mod grid;
pub mod integrands;
pub mod metropolis;
pub mod monte_carlo;
pub mod piecewise_linear;
pub mod power;
pub mod quadrature;
pub mod rejection;
