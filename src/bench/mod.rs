//! Backends side by side: rays of real renders are recorded and traced again by each of them, ray kind by ray kind.

pub mod agreement;
pub mod closed;
mod cornell_box;
pub mod leaks;
pub mod meeting;
pub mod random;
pub mod rays;
pub mod report;
pub mod scenes;
mod staging;
pub mod target;
