//! Batches of rays through Embree's packets of 8 and 16.
//!
//! A packet is loaded from the batch in whole lanes, and its hits go through the same check as those of single rays; the
//! ray of a hit that is refused is traced on by itself. Which of two primitives at the same distance is reported, and the
//! last bits of where, may differ from what single rays give.
//!
//! Measure: as [`RayBatch`] and [`HitBatch`].
//! Range: any number of rays. Inactive and not finite ones are masked out, as are the lanes past the end of the batch.
//! Where the library lacks packets of the width asked for, the widest it has below that is used.
//! Source: Embree's manual, "Ray packets" and "Fast Coherent Rays". Tested in `tests/tracing/batches.rs`.

use super::EmbreeAccel;
use super::handles::PacketQuery;
use super::lanes::{HitLanes, RayHitLanes, RayLanes};
use crate::accel::batch::{HitBatch, PacketWidth, Packets, RayBatch};
use crate::accel::{Hit, Precision};

impl EmbreeAccel {
    /// The closest hit of every active ray.
    pub fn intersect_batch(&self, rays: &RayBatch, packets: Packets, hits: &mut HitBatch) {
        match self.native_width(packets.width) {
            PacketWidth::One => rays.intersect_each(hits, |ray, time| self.intersect(ray, time)),
            PacketWidth::Eight => self.intersect_packets::<8>(rays, packets.coherent, hits),
            PacketWidth::Sixteen => self.intersect_packets::<16>(rays, packets.coherent, hits),
        }
    }

    /// Whether anything lies on each active ray; `false` for the others.
    pub fn occluded_batch(&self, rays: &RayBatch, packets: Packets, occluded: &mut Vec<bool>) {
        match self.native_width(packets.width) {
            PacketWidth::One => rays.occluded_each(occluded, |ray, time| self.occluded(ray, time)),
            PacketWidth::Eight => self.occluded_packets::<8>(rays, packets.coherent, occluded),
            PacketWidth::Sixteen => self.occluded_packets::<16>(rays, packets.coherent, occluded),
        }
    }

    /// The widest packets that the library traces as such, up to the width asked for.
    fn native_width(&self, asked: PacketWidth) -> PacketWidth {
        let native = self.native_widths.iter().copied();
        native
            .filter(|&width| width <= asked)
            .max()
            .unwrap_or_default()
    }

    fn intersect_packets<const N: usize>(
        &self,
        rays: &RayBatch,
        coherent: bool,
        hits: &mut HitBatch,
    ) {
        hits.resize(rays.len());
        let mut query = PacketQuery::new(coherent);
        let mut packet = RayHitLanes::<N>::new();
        for start in (0..rays.len()).step_by(N) {
            let active = packet.rays.load(rays, start);
            packet.hits.clear();
            if active.any() {
                self.scene
                    .intersect_packet(&active, &mut packet, &mut query);
            }
            for lane in 0..N.min(rays.len() - start) {
                let index = start + lane;
                let mut hit = self.hit_of_lane(&packet, lane);
                if self.options.precision == Precision::Robust {
                    let (ray, time) = rays.get(index);
                    hit = hit.and_then(|hit| self.confirm(&ray, time, hit));
                }
                hits.set(index, hit);
            }
        }
    }

    #[inline]
    fn hit_of_lane<const N: usize>(&self, packet: &RayHitLanes<N>, lane: usize) -> Option<Hit> {
        let RayHitLanes { rays, hits } = packet;
        let HitLanes { u, v, .. } = hits;
        self.hit(
            [
                hits.geometry[lane],
                hits.primitive[lane],
                hits.instance[lane],
            ],
            rays.t_max[lane],
            [u[lane], v[lane]],
        )
    }

    fn occluded_packets<const N: usize>(
        &self,
        rays: &RayBatch,
        coherent: bool,
        occluded: &mut Vec<bool>,
    ) {
        occluded.clear();
        occluded.resize(rays.len(), false);
        let mut query = PacketQuery::new(coherent);
        let mut packet = RayLanes::<N>::new();
        for (number, answers) in occluded.chunks_mut(N).enumerate() {
            let active = packet.load(rays, number * N);
            if !active.any() {
                continue;
            }
            self.scene.occluded_packet(&active, &mut packet, &mut query);
            for (lane, answer) in answers.iter_mut().enumerate() {
                *answer = (active.0[lane] != 0) & (packet.t_max[lane] < 0.0);
            }
        }
    }
}
