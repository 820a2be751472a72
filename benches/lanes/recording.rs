//! Recorded rays, traced alone: the floor.

use crate::tables::Tables;
use etendue::internals::accel::lanes::{NO_ID, RayHitLanes, RayLanes};
use etendue::internals::math::lanes::{ActiveLanes, LANES};
use std::time::Instant;

/// Rays as they were before they were traced.
#[derive(Default)]
pub struct Recording {
    pub camera: Vec<(ActiveLanes<LANES>, RayHitLanes<LANES>)>,
    pub extension: Vec<(ActiveLanes<LANES>, RayHitLanes<LANES>)>,
    pub shadow: Vec<(ActiveLanes<LANES>, RayLanes<LANES>)>,
}

impl Recording {
    /// The number of rays of each kind.
    pub fn rays(&self) -> [usize; 3] {
        let lanes = |list: &[(ActiveLanes<LANES>, RayHitLanes<LANES>)]| {
            list.iter().map(|(active, _)| active.count()).sum()
        };
        let shadow = self.shadow.iter().map(|(active, _)| active.count()).sum();
        [lanes(&self.camera), lanes(&self.extension), shadow]
    }

    /// Traces all rays, and returns the seconds for each kind.
    pub fn trace(&mut self, tables: &Tables<'_>) -> [f64; 3] {
        let kinds = [(&mut self.camera, true), (&mut self.extension, false)];
        let [camera, extension] = kinds.map(|(packets, coherent)| {
            let start = Instant::now();
            for (active, packet) in packets {
                packet.rays.t_max = [f32::INFINITY; LANES];
                packet.hits.geometry = [NO_ID; LANES];
                tables.accel.intersect_lanes(active, packet, coherent);
            }
            start.elapsed().as_secs_f64()
        });
        let start = Instant::now();
        for (active, packet) in &mut self.shadow {
            packet.t_max = [1.0; LANES];
            tables.accel.occluded_lanes(*active, packet, false);
        }
        [camera, extension, start.elapsed().as_secs_f64()]
    }
}
