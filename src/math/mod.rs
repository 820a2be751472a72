//! Vectors, frames, colours, densities with their measure, exact sums, statistics and rounding-error bounds.
//!
//! Measure: that of each type, which for densities is in its name (`measure.rs`).
//! Range: stated in each file.
//! Source: named in each file. Tested there.

pub mod bounds;
pub mod exact_sum;
pub mod frame;
pub mod functions;
pub mod lanes;
pub mod measure;
pub mod plane;
pub mod ray;
pub mod rgb;
pub mod robust;
pub mod stats;
pub mod transform;
pub mod triangle;
pub mod trig;
pub mod vec;
