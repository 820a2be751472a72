//! Tests of samplers, warps and sampling densities, and of the harness that tests them.

#[path = "../common/mod.rs"]
mod common;

mod harness;
mod sampler;
mod stratified;
mod warps;
