//! Tests of ray queries on every backend.

#[path = "../common/mod.rs"]
mod common;

mod batches;
mod hard;
mod instance_rays;
mod instance_surfaces;
mod instances;
mod packets;
mod rays;
mod slivers;
