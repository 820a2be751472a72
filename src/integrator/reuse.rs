//! The number of pixels that share their paths.
//!
//! Measure: pixels.
//! Range: one, or groups of 2 x 2 or 4 x 4 pixels, each two pixels from the next.
//! Source: none needed; `path/reuse.rs` has the estimator. Tested in `tests/rendering/reuse.rs`.

use crate::math::lanes::{ActiveLanes, LANES};
use serde::Serialize;

/// The width of a packet of camera rays in pixels.
const WIDTH: usize = 4;

/// The number of pixels that take light from each other's paths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub enum PathReuse {
    /// One: no path is shared.
    #[default]
    Off,
    /// Groups of 2 x 2 pixels of a packet.
    Four,
    /// All 4 x 4 pixels of a packet.
    Sixteen,
}

impl PathReuse {
    /// Every number.
    pub const ALL: &'static [Self] = &[Self::Off, Self::Four, Self::Sixteen];

    /// The name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Four => "4",
            Self::Sixteen => "16",
        }
    }

    /// Whether any path is shared.
    #[inline]
    pub fn is_on(self) -> bool {
        self != Self::Off
    }

    /// The distance of neighbouring pixels of a packet, in pixels. Packets are interleaved where paths are shared:
    /// correlated noise of adjacent pixels would be visible as blocks.
    #[inline]
    pub fn stride(self) -> u32 {
        if self.is_on() { 2 } else { 1 }
    }

    /// The lanes of a packet of 4 x 4 pixels whose pixels share with that of a lane, itself among them.
    #[inline]
    pub fn group_of(self, lane: usize) -> ActiveLanes<LANES> {
        let side = match self {
            Self::Off => 1,
            Self::Four => 2,
            Self::Sixteen => WIDTH,
        };
        let place = |lane: usize| (lane % WIDTH / side, lane / WIDTH / side);
        ActiveLanes::first(LANES).and(|other| place(other) == place(lane))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reuse_groups_partition_the_packet() {
        for (reuse, size) in [
            (PathReuse::Off, 1),
            (PathReuse::Four, 4),
            (PathReuse::Sixteen, 16),
        ] {
            for lane in 0..LANES {
                let group = reuse.group_of(lane);
                assert!(group.has(lane));
                assert_eq!(group.count(), size, "{reuse:?}");
                for other in group.each() {
                    assert_eq!(reuse.group_of(other), group, "{reuse:?}");
                }
            }
        }
        let group = PathReuse::Four.group_of(7);
        assert!(group.each().eq([2, 3, 6, 7]));
    }
}
