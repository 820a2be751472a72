//! Sampling: warps of uniform numbers, discrete choices, and the weights of combined techniques.

pub mod mis;
pub mod warp;
