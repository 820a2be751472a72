//! Tests of BSDFs and materials.

#[path = "../common/mod.rs"]
mod common;

mod bsdf;
mod furnace;
mod lanes;
mod materials;
mod shading_normals;
