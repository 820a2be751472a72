//! Operations on packets in Embree's layout: loading them from batches, counting active lanes, and splitting packets
//! that are wider than Embree supports.
//!
//! Measure: those of [`RayBatch`].
//! Range: 8 and 16 lanes.
//! Source: Embree's manual, "Ray packets". Tested in `tests/tracing/batches.rs` and `packets.rs`.

use crate::accel::batch::RayBatch;
use crate::accel::lanes::{HitLanes, NO_ID, RayHitLanes, RayLanes};
use crate::math::lanes::ActiveLanes;

impl<const N: usize> RayLanes<N> {
    /// Loads the rays of a batch from `start` on, up to the number of lanes or the end of the batch. Returns the mask
    /// of the rays to be traced: those that are active and finite.
    #[inline]
    pub fn load(&mut self, rays: &RayBatch, start: usize) -> ActiveLanes<N> {
        for axis in 0..3 {
            copy(&mut self.origin[axis], &rays.origin[axis][start..]);
            copy(&mut self.dir[axis], &rays.dir[axis][start..]);
        }
        copy(&mut self.t_min, &rays.t_min[start..]);
        copy(&mut self.t_max, &rays.t_max[start..]);
        copy(&mut self.time, &rays.time[start..]);
        // Lanes past the end of the batch keep the values of an earlier packet.
        let mut asked = [false; N];
        copy(&mut asked, &rays.active[start..]);
        let is_finite = |lane: usize| {
            let [x, y, z] = &self.origin;
            let [u, v, w] = &self.dir;
            [x, y, z, u, v, w]
                .iter()
                .fold(true, |all, of| all & of[lane].is_finite())
        };
        ActiveLanes(std::array::from_fn(|lane| {
            -i32::from(asked[lane] & is_finite(lane))
        }))
    }
}

impl<const N: usize> HitLanes<N> {
    /// Resets the hits, in the fields that Embree requires to be initialised.
    #[inline]
    pub fn clear(&mut self) {
        self.geometry = [NO_ID; N];
        self.instance = [NO_ID; N];
    }
}

impl<const N: usize> RayLanes<N> {
    /// A packet of the rays of `M` lanes from `start` on.
    pub fn part<const M: usize>(&self, start: usize) -> RayLanes<M> {
        let RayLanes {
            origin,
            t_min,
            dir,
            time,
            t_max,
            ..
        } = self;
        RayLanes {
            origin: origin.each_ref().map(|lanes| part(lanes, start)),
            dir: dir.each_ref().map(|lanes| part(lanes, start)),
            t_min: part(t_min, start),
            t_max: part(t_max, start),
            time: part(time, start),
            ..RayLanes::default()
        }
    }
}

impl<const N: usize> RayHitLanes<N> {
    /// A packet of the rays of `M` lanes from `start` on, with no hits.
    pub fn part<const M: usize>(&self, start: usize) -> RayHitLanes<M> {
        RayHitLanes {
            rays: self.rays.part(start),
            ..RayHitLanes::default()
        }
    }

    /// Copies the hits of a part of the lanes, from `start` on, into this packet.
    pub fn replace<const M: usize>(&mut self, start: usize, part: &RayHitLanes<M>) {
        let lanes = start..start + M;
        self.rays.t_max[lanes.clone()].copy_from_slice(&part.rays.t_max);
        let (to, from) = (&mut self.hits, &part.hits);
        to.u[lanes.clone()].copy_from_slice(&from.u);
        to.v[lanes.clone()].copy_from_slice(&from.v);
        to.primitive[lanes.clone()].copy_from_slice(&from.primitive);
        to.geometry[lanes.clone()].copy_from_slice(&from.geometry);
        to.instance[lanes].copy_from_slice(&from.instance);
    }
}

/// `M` entries of the lanes from `start` on.
#[inline]
fn part<T: Copy, const N: usize, const M: usize>(lanes: &[T; N], start: usize) -> [T; M] {
    std::array::from_fn(|lane| lanes[start + lane])
}

/// Copies up to `N` entries; a full packet is copied as one block of constant size.
#[inline]
fn copy<T: Copy, const N: usize>(lanes: &mut [T; N], from: &[T]) {
    match from.first_chunk() {
        Some(whole) => *lanes = *whole,
        None => lanes[..from.len()].copy_from_slice(from),
    }
}
