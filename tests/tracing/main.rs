//! How rays meet shapes, on every backend.

#[path = "../common/mod.rs"]
mod common;

mod batches;
mod bench;
mod bench_agreement;
mod bench_scenes;
mod hard;
mod instance_rays;
mod instance_surfaces;
mod instances;
mod packets;
mod rays;
mod slivers;
