//! How random numbers become points, directions and integrals; the harness that judges it.

#[path = "../common/mod.rs"]
mod common;

mod harness;
mod sampler;
mod stratified;
mod warps;
