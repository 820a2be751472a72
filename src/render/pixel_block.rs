//! Blocks of 4 x 4 pixels, whose camera rays form packets.
//!
//! Measure: pixels, whose coordinates are modulo 2^32.
//! Range: blocks begin at multiples of four pixels of the film; some of their pixels may be beyond its edge.
//! Source: none needed. Tested below.

use crate::film::Window;
use crate::math::lanes::{ActiveLanes, LANES, Lanes};

/// The width and the height of a block.
const SIDE: u32 = 4;

const _: () = assert!(
    (SIDE * SIDE) as usize == LANES,
    "a block has a pixel per lane"
);

/// A block of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelBlock {
    /// The pixel of the first lane.
    corner: [u32; 2],
}

impl PixelBlock {
    /// The block of a pixel.
    pub fn of([x, y]: [u32; 2]) -> Self {
        Self {
            corner: [x - x % SIDE, y - y % SIDE],
        }
    }

    /// The blocks of the pixels of a window, row by row.
    pub fn covering(window: Window) -> impl Iterator<Item = Self> {
        let Self { corner: [x, y] } = Self::of([window.x, window.y]);
        let corners = |corner: u32, start: u32, length: u32| {
            let pixels = start.wrapping_sub(corner) + length;
            let blocks = 0..pixels.div_ceil(SIDE);
            blocks.map(move |block| corner.wrapping_add(SIDE * block))
        };
        let columns = corners(x, window.x, window.width);
        let rows = corners(y, window.y, window.height);
        rows.flat_map(move |y| columns.clone().map(move |x| Self { corner: [x, y] }))
    }

    /// The pixel of a lane.
    #[inline]
    pub fn pixel(self, lane: usize) -> [u32; 2] {
        let [x, y] = self.corner;
        let lane = lane as u32;
        [x + lane % SIDE, y + lane / SIDE]
    }

    /// The columns and the rows of all pixels.
    #[inline]
    pub fn pixels(self) -> [Lanes<u32>; 2] {
        [0, 1].map(|axis| std::array::from_fn(|lane| self.pixel(lane)[axis]))
    }

    /// The lane of a pixel of the block.
    pub fn lane(self, [x, y]: [u32; 2]) -> usize {
        ((y - self.corner[1]) * SIDE + (x - self.corner[0])) as usize
    }

    /// The lanes of the pixels in a window.
    pub fn lanes_in(self, window: Window) -> ActiveLanes<LANES> {
        let mut lanes = ActiveLanes::NONE;
        for lane in 0..LANES {
            lanes.set(lane, window.contains(self.pixel(lane)));
        }
        lanes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_of_a_window_is_in_one_lane_of_one_block() {
        let before = |n: u32| n.wrapping_neg();
        for (x, y, width, height) in [
            (0, 0, 16, 8),
            (3, 2, 7, 9),
            (5, 4, 1, 1),
            (6, 7, 3, 2),
            (before(1), 0, 6, 3),
            (4, before(5), 3, 9),
        ] {
            let window = Window {
                x,
                y,
                width,
                height,
            };
            let mut seen = std::collections::BTreeSet::new();
            for block in PixelBlock::covering(window) {
                let lanes = block.lanes_in(window);
                assert!(lanes.any());
                for lane in lanes.each() {
                    let pixel = block.pixel(lane);
                    assert_eq!((PixelBlock::of(pixel), block.lane(pixel)), (block, lane));
                    assert!(seen.insert(pixel));
                }
            }
            let pixels: std::collections::BTreeSet<[u32; 2]> = window.pixels().collect();
            assert_eq!(seen, pixels);
        }
    }
}
