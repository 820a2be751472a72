//! A part of a plane with a margin about it, for processing in blocks.
//!
//! Measure: that of the values.
//! Range: beyond the border of the plane, pixels are those of the border.
//! Source: none needed. Tested in `math/plane.rs` and `means.rs`.

use crate::math::plane::Plane;

/// A part of a plane with a margin, whose pixels beyond the border are those of the border.
#[derive(Debug, Clone)]
pub struct PaddedPart {
    stride: usize,
    values: Vec<f32>,
}

impl PaddedPart {
    /// Copies `size` pixels from a corner on, and the margin about them.
    pub fn of(plane: &Plane, corner: [usize; 2], size: [usize; 2], margin: usize) -> Self {
        let stride = size[0] + 2 * margin;
        let rows = size[1] + 2 * margin;
        let start = corner.map(|at| at as isize - margin as isize);
        let values = (0..rows as isize)
            .flat_map(|y| (0..stride as isize).map(move |x| plane.at(start[0] + x, start[1] + y)));
        Self {
            stride,
            values: values.collect(),
        }
    }

    /// The `length` values of row `y` from column `x` on.
    pub fn row(&self, [x, y]: [usize; 2], length: usize) -> &[f32] {
        &self.values[y * self.stride + x..][..length]
    }
}
