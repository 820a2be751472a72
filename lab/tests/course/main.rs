//! Sampling and integration as the course teaches them.

#[path = "../../../tests/common/mod.rs"]
mod common;

mod integration;
mod inversion;
mod metropolis;
mod rejection;
mod warps;
