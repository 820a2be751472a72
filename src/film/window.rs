//! Rectangles of pixels.
//!
//! Measure: pixels, whose coordinates are modulo 2^32: the column left of the image is 2^32 - 1.
//! Range: at least one pixel.
//! Source: none needed. Tested in `tests/rendering/determinism.rs` and `tests/rendering/filters.rs`.

use serde::{Deserialize, Serialize};

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Window {
    /// Left column.
    pub x: u32,
    /// Top row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Window {
    /// All pixels of an image of this width and height.
    pub fn whole((width, height): (u32, u32)) -> Self {
        Self {
            x: 0,
            y: 0,
            width,
            height,
        }
    }

    /// The number of pixels.
    pub fn pixel_count(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Whether a pixel is in the window.
    #[inline]
    pub fn contains(&self, [x, y]: [u32; 2]) -> bool {
        x.wrapping_sub(self.x) < self.width && y.wrapping_sub(self.y) < self.height
    }

    /// The index of a pixel of the window, row by row.
    #[inline]
    pub fn index(&self, [x, y]: [u32; 2]) -> usize {
        let [column, row] = [x.wrapping_sub(self.x), y.wrapping_sub(self.y)];
        row as usize * self.width as usize + column as usize
    }

    /// The pixels of the window, row by row.
    pub fn pixels(self) -> impl Iterator<Item = [u32; 2]> {
        let columns = (0..self.width).map(move |column| self.x.wrapping_add(column));
        let rows = (0..self.height).map(move |row| self.y.wrapping_add(row));
        rows.flat_map(move |y| columns.clone().map(move |x| [x, y]))
    }

    /// The squares of `tile_size` pixels that divide the window, row by row; those at its right and lower edges may be smaller.
    pub fn tiles(self, tile_size: u32) -> impl Iterator<Item = Self> + Send {
        let step = tile_size.max(1);
        let starts = |from: u32, length: u32| (from..from + length).step_by(step as usize);
        let columns = starts(self.x, self.width);
        starts(self.y, self.height).flat_map(move |y| {
            columns.clone().map(move |x| Self {
                x,
                y,
                width: step.min(self.x + self.width - x),
                height: step.min(self.y + self.height - y),
            })
        })
    }

    /// The window with `border_size` more pixels on each side.
    pub fn grown(self, border_size: u32) -> Self {
        Self {
            x: self.x.wrapping_sub(border_size),
            y: self.y.wrapping_sub(border_size),
            width: self.width + 2 * border_size,
            height: self.height + 2 * border_size,
        }
    }
}
