//! How surfaces scatter light.

#[path = "../common/mod.rs"]
mod common;

mod bsdf;
mod furnace;
mod materials;
mod shading_normals;
