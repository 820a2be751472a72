//! Blocks of 4 x 4 pixels, whose camera rays form packets.
//!
//! Measure: pixels, whose coordinates are modulo 2^32.
//! Range: the blocks of all pixels lie in squares that begin at multiples of four strides of the film; some of their pixels
//! may be beyond its edge.
//! Source: none needed. Tested below.

use crate::film::Window;
use crate::math::lanes::{ActiveLanes, LANES, Lanes};

/// The number of pixels in a row and in a column of a block.
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
    /// The distance of neighbouring pixels of the block: a power of two. Blocks are interleaved where it is above 1.
    stride: u32,
}

impl PixelBlock {
    /// The block of a pixel, of adjacent pixels.
    pub fn of(pixel: [u32; 2]) -> Self {
        Self::with_stride(pixel, 1)
    }

    /// The block of a pixel, of pixels at this distance from each other.
    fn with_stride(pixel: [u32; 2], stride: u32) -> Self {
        let corner = pixel.map(|x| x - x % (SIDE * stride) + x % stride);
        Self { corner, stride }
    }

    /// The blocks of the pixels of a window, row by row; neighbouring pixels of a block are this many pixels apart.
    pub fn covering(window: Window, stride: u32) -> impl Iterator<Item = Self> {
        let corners = move |start: u32, length: u32| {
            let edge = SIDE * stride;
            let first = start - start % edge;
            let squares = (start.wrapping_sub(first) + length).div_ceil(edge);
            let corners = (0..squares).flat_map(move |square| {
                (0..stride).map(move |shift| first.wrapping_add(square * edge + shift))
            });
            // The first and the last square may have no pixel of a shift in the window.
            corners.filter(move |corner| {
                let mut pixels = (0..SIDE).map(|k| corner.wrapping_add(k * stride));
                pixels.any(|pixel| pixel.wrapping_sub(start) < length)
            })
        };
        let columns = corners(window.x, window.width);
        let rows = corners(window.y, window.height);
        rows.flat_map(move |y| {
            let corner = move |x| Self {
                corner: [x, y],
                stride,
            };
            columns.clone().map(corner)
        })
    }

    /// The pixel of a lane.
    #[inline]
    pub fn pixel(self, lane: usize) -> [u32; 2] {
        let [x, y] = self.corner;
        let lane = lane as u32;
        [x + lane % SIDE * self.stride, y + lane / SIDE * self.stride]
    }

    /// The columns and the rows of all pixels.
    #[inline]
    pub fn pixels(self) -> [Lanes<u32>; 2] {
        [0, 1].map(|axis| std::array::from_fn(|lane| self.pixel(lane)[axis]))
    }

    /// The lane of a pixel of the block.
    pub fn lane(self, [x, y]: [u32; 2]) -> usize {
        let [column, row] = [x - self.corner[0], y - self.corner[1]].map(|it| it / self.stride);
        (row * SIDE + column) as usize
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
    fn pixel_blocks_cover_each_window_pixel_once() {
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
            for stride in [1, 2, 4] {
                let mut seen = std::collections::BTreeSet::new();
                for block in PixelBlock::covering(window, stride) {
                    let lanes = block.lanes_in(window);
                    assert!(lanes.any());
                    for lane in lanes.each() {
                        let pixel = block.pixel(lane);
                        let of_pixel = PixelBlock::with_stride(pixel, stride);
                        assert_eq!((of_pixel, block.lane(pixel)), (block, lane));
                        assert!(seen.insert(pixel));
                    }
                }
                let pixels: std::collections::BTreeSet<[u32; 2]> = window.pixels().collect();
                assert_eq!(seen, pixels);
            }
        }
    }
}
