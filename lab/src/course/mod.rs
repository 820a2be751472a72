//! Sampling and integration methods of the course that the renderer itself does not use.

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
