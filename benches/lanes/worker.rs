//! The loop over the samples of a tile: refilling lanes and calling the stages.

use crate::block::{Block, NO_SAMPLE, get, set};
use crate::random::{SAMPLE_STRIDE, advance, jump};
use crate::recording::Recording;
use crate::stages::{add_light, draw_numbers, fetch_surfaces, sample_camera, shade};
use crate::tables::Tables;
use crate::{BLOCKS, SPP, TILE};
use etendue::internals::math::lanes::LANES;
use etendue::internals::math::vec::LaneVec3 as Vec3;
use etendue::internals::sampler::hash;
use std::ops::Range;

/// The samples of tiles.
pub struct Worker<'a> {
    pub tables: &'a Tables<'a>,
    pub blocks: Vec<Block>,
    /// Samples whose camera rays have been traced, the first `used` of which are in blocks already.
    pub ready: Block,
    pub used: usize,
    /// The generator of each pixel at its next sample.
    pub pixels: Vec<(u64, u64)>,
    pub samples: Vec<Vec3>,
    pub recording: Option<Recording>,
}

impl<'a> Worker<'a> {
    pub fn new(tables: &'a Tables<'a>) -> Self {
        Self {
            tables,
            blocks: vec![Block::new(); BLOCKS],
            ready: Block::new(),
            used: LANES,
            pixels: Vec::new(),
            samples: vec![Vec3::ZERO; TILE * TILE * SPP],
            recording: None,
        }
    }

    /// Renders a tile, whose upper left pixel is given, and returns the sum of its samples.
    pub fn render(&mut self, corner: [usize; 2]) -> [f64; 3] {
        self.pixels.clear();
        for pixel in 0..TILE * TILE {
            let pixel = [corner[0] + pixel % TILE, corner[1] + pixel / TILE];
            let seed = hash::pixel_seed(1, pixel.map(|i| i as u32));
            let increment = hash::combine(seed, 0) << 1 | 1;
            let state = advance(seed.wrapping_add(increment), increment, jump(1));
            self.pixels.push((state, increment));
        }
        let mut packets = 0..TILE * TILE / LANES * SPP;
        while self.refill(corner, &mut packets) {
            self.trace();
        }
        let mut sum = [0.0; 3];
        for sample in &self.samples {
            for (sum, channel) in sum.iter_mut().zip(sample.to_array()) {
                *sum += f64::from(channel);
            }
        }
        sum
    }

    /// Stores the samples whose paths have ended, and replaces them. Returns whether any path is left.
    pub fn refill(&mut self, corner: [usize; 2], packets: &mut Range<usize>) -> bool {
        let mut any = false;
        for place in 0..self.blocks.len() {
            any |= self.blocks[place].active.any();
            for lane in self.blocks[place].active.inverse().each() {
                let block = &mut self.blocks[place];
                let sample = std::mem::replace(&mut block.sample[lane], NO_SAMPLE);
                if sample != NO_SAMPLE {
                    self.samples[sample as usize] = get(&block.radiance, lane);
                }
                if self.used == LANES {
                    let Some(packet) = packets.next() else {
                        continue;
                    };
                    self.begin(corner, packet);
                }
                self.start(place, lane);
                any = true;
            }
        }
        any
    }

    /// Traces the camera rays of one sample of 4 x 4 pixels.
    pub fn begin(&mut self, corner: [usize; 2], packet: usize) {
        const STRIDE: (u64, u64) = jump(SAMPLE_STRIDE);
        let (index, place) = (packet / LANES, packet % LANES);
        let mut film = [[0.0; LANES]; 2];
        let ready = &mut self.ready;
        for lane in 0..LANES {
            let x = place % 4 * 4 + lane % 4;
            let y = place / 4 * 4 + lane / 4;
            let pixel = y * TILE + x;
            film[0][lane] = (corner[0] + x) as f32;
            film[1][lane] = (corner[1] + y) as f32;
            let (state, increment) = &mut self.pixels[pixel];
            ready.random.state[lane] = *state;
            ready.random.increment[lane] = *increment;
            *state = advance(*state, *increment, STRIDE);
            ready.sample[lane] = (pixel * SPP + index) as u32;
        }
        sample_camera(&self.tables.camera, ready, &film);
        if let Some(recording) = &mut self.recording {
            recording
                .camera
                .push((ready.active, ready.extension.clone()));
        }
        let accel = self.tables.accel;
        accel.intersect_lanes(&ready.active, &mut ready.extension, true);
        self.used = 0;
    }

    /// Copies the next ready sample into a lane.
    pub fn start(&mut self, place: usize, lane: usize) {
        let (ready, from, block) = (&self.ready, self.used, &mut self.blocks[place]);
        self.used += 1;
        let (rays, hits) = (&mut block.extension.rays, &mut block.extension.hits);
        set(
            &mut rays.origin,
            lane,
            get(&ready.extension.rays.origin, from),
        );
        set(&mut rays.dir, lane, get(&ready.extension.rays.dir, from));
        hits.u[lane] = ready.extension.hits.u[from];
        hits.v[lane] = ready.extension.hits.v[from];
        hits.geometry[lane] = ready.extension.hits.geometry[from];
        hits.primitive[lane] = ready.extension.hits.primitive[from];
        set(&mut block.beta, lane, Vec3::ONE);
        set(&mut block.radiance, lane, Vec3::ZERO);
        block.pdf[lane] = f32::INFINITY;
        block.bounce[lane] = 0;
        block.sample[lane] = ready.sample[from];
        block.random.state[lane] = ready.random.state[from];
        block.random.increment[lane] = ready.random.increment[from];
        block.active.0[lane] = -1;
    }

    /// Traces all paths to their next surface.
    pub fn trace(&mut self) {
        let accel = self.tables.accel;
        for block in self.blocks.iter_mut().filter(|block| block.to_trace.any()) {
            if let Some(recording) = &mut self.recording {
                let packet = (block.to_trace, block.extension.clone());
                recording.extension.push(packet);
            }
            accel.intersect_lanes(&block.to_trace, &mut block.extension, false);
        }
        draw_numbers(&mut self.blocks);
        fetch_surfaces(self.tables, &mut self.blocks);
        shade(&self.tables.light, &mut self.blocks);
        for block in self
            .blocks
            .iter_mut()
            .filter(|block| block.shadow_ray_lanes.any())
        {
            if let Some(recording) = &mut self.recording {
                recording
                    .shadow
                    .push((block.shadow_ray_lanes, block.shadow.clone()));
            }
            accel.occluded_lanes(block.shadow_ray_lanes, &mut block.shadow, false);
        }
        add_light(&mut self.blocks);
    }
}
