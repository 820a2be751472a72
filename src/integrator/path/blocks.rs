//! The paths of a wavefront, in blocks of sixteen.
//!
//! Measure: as in `block.rs`.
//! Range: any number of paths.
//! Source: none needed. Tested in `tests/rendering/effects.rs`.

use super::super::SampleLanes;
use super::block::PathBlock;
use crate::effects::Effects;
use crate::math::lanes::{ActiveLanes, LANES};

/// The paths of a wavefront, in as few blocks as they fit. The memory of blocks is kept.
#[derive(Debug)]
pub struct PathBlocks<E: Effects> {
    blocks: Vec<PathBlock<E>>,
    /// The number of blocks with paths.
    len: usize,
}

impl<E: Effects> Default for PathBlocks<E> {
    fn default() -> Self {
        Self {
            blocks: Vec::new(),
            len: 0,
        }
    }
}

impl<E: Effects> PathBlocks<E> {
    /// Begins a path for each sample. A full packet at the start of a block is copied as a whole.
    pub fn begin(&mut self, samples: &[SampleLanes]) {
        let mut count = 0;
        for (packet, samples) in samples.iter().enumerate() {
            let first = packet * LANES;
            if count % LANES == 0 && samples.active.all() {
                self.block(count / LANES).begin(first, samples);
                count += LANES;
                continue;
            }
            for from in samples.active.each() {
                let block = self.block(count / LANES);
                if count % LANES == 0 {
                    block.active = ActiveLanes::NONE;
                }
                block.begin_lane(count % LANES, first + from, samples, from);
                count += 1;
            }
        }
        self.len = count.div_ceil(LANES);
    }

    /// A block that has begun already, or the next one.
    #[inline]
    fn block(&mut self, index: usize) -> &mut PathBlock<E> {
        if index == self.blocks.len() {
            self.blocks.push(PathBlock::default());
        }
        &mut self.blocks[index]
    }

    /// The blocks.
    pub fn blocks_mut(&mut self) -> &mut [PathBlock<E>] {
        &mut self.blocks[..self.len]
    }

    /// Whether all paths have ended.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Moves the last paths into the lanes of those that have ended, before the rays are traced.
    pub fn compact(&mut self) {
        let mut first = 0;
        loop {
            while self.len > 0 && !self.blocks[self.len - 1].active.any() {
                self.len -= 1;
            }
            if first + 1 >= self.len {
                return;
            }
            let (front, back) = self.blocks.split_at_mut(self.len - 1);
            let (hole, last) = (&mut front[first], &mut back[0]);
            let mut paths = last.active.each();
            let ended = hole.active.inverse();
            let mut is_full = true;
            for lane in ended.each() {
                let Some(from) = paths.next() else {
                    is_full = false;
                    break;
                };
                hole.move_from(lane, last, from);
            }
            if is_full {
                first += 1;
            }
        }
    }
}
