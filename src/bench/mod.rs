//! Backends side by side: rays of real renders are recorded and traced again by each of them, ray kind by ray kind.

pub mod report;
pub mod target;
