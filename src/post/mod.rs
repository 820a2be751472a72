//! Post-processing of finished images.
//!
//! Measure: linear radiance.
//! Range: images with the layers that `etendue render --layers` writes.
//! Source: docs/accuracy.md, "Noise filtering". Tested in `tests/rendering/denoise.rs`.

pub mod denoise;
#[cfg(feature = "oidn")]
mod oidn;
