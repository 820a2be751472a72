//! Tiling of an image: squares of pixels, smaller at the right and bottom edges.
//!
//! Measure: pixels.
//! Range: images and tiles of at least one pixel.
//! Source: none needed. Tested below.

use serde::Serialize;

/// The side in pixels of the tiles that errors are reported by.
pub const SIDE: u32 = 32;

/// One tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ImageTile {
    /// Left column.
    pub x: u32,
    /// Top row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl ImageTile {
    /// All tiles of an image, row by row from the top.
    ///
    /// # Panics
    /// If `side` is 0.
    pub fn all(width: u32, height: u32, side: u32) -> impl Iterator<Item = Self> {
        let places = move |length: u32| (0..length).step_by(side as usize);
        places(height).flat_map(move |y| {
            places(width).map(move |x| Self {
                x,
                y,
                width: side.min(width - x),
                height: side.min(height - y),
            })
        })
    }

    /// The indices of the tile's pixels in an image of this width.
    pub fn indices(self, picture_width: u32) -> impl Iterator<Item = usize> {
        let (left, width) = (self.x as usize, self.width as usize);
        (self.y..self.y + self.height).flat_map(move |row| {
            let start = row as usize * picture_width as usize + left;
            start..start + width
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn image_tiles_cover_every_pixel_exactly_once() {
        for (width, height, side) in [(13, 7, 4), (32, 32, 32), (1, 1, 32), (65, 2, 32)] {
            let mut seen: Vec<usize> = ImageTile::all(width, height, side)
                .flat_map(|tile| tile.indices(width))
                .collect();
            seen.sort_unstable();
            let all: Vec<usize> = (0..(width * height) as usize).collect();
            assert_eq!(seen, all, "{width} x {height}");
        }
        let last = ImageTile::all(13, 7, 4).last().expect("there are tiles");
        assert_eq!(
            last,
            ImageTile {
                x: 12,
                y: 4,
                width: 1,
                height: 3
            }
        );
    }
}
