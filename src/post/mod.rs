//! What is done to a finished picture.
//!
//! Measure: linear radiance.
//! Range: pictures with the layers that `etendue render --layers` writes.
//! Source: docs/accuracy.md, "Noise filtering". Tested in `tests/rendering/denoise.rs`.

pub mod denoise;
#[cfg(feature = "oidn")]
mod oidn;
