//! How random numbers become points, directions and integrals; the harness that judges it.

#[path = "../common/mod.rs"]
mod common;

mod course;
mod harness;
mod integration;
mod inversion;
mod metropolis;
mod rejection;
mod sampler;
mod stratified;
mod warps;
