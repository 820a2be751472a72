//! Ray packets, for paths that are traced as a wavefront.
//!
//! Unlike a [`RayBatch`](super::batch::RayBatch), which is split into packets of any kind, a packet is traced as it is,
//! and the hit of one ray does not depend on the other rays, unless they are flagged as coherent: it is bit-identical
//! to the hit of the ray in a packet of its own.
//!
//! Measure: those of [`Ray`].
//! Range: up to [`LANES`] rays; a ray that is not finite hits nothing.
//! Source: Embree's manual, "Ray packets". Tested in `tests/tracing/packets.rs`.

use super::lanes::RayHitLanes;
use super::{ExcludedPrimitive, Hit};
use crate::math::lanes::{ActiveLanes, LANES};
use crate::math::ray::Ray;
use crate::math::vec::Vec3;

/// Rays with their times, in the memory layout of Embree.
#[derive(Debug, Clone)]
pub struct RayPacket {
    /// The rays and their hits. Tracing overwrites `t_max`; the original ends are kept in `ends`.
    pub(super) lanes: RayHitLanes<LANES>,
    /// The mask of the rays that are finite.
    pub(super) active: ActiveLanes<LANES>,
    ends: [f32; LANES],
    /// The primitive that each ray starts on.
    excluded: [Option<ExcludedPrimitive>; LANES],
    len: usize,
}

/// The hits of the rays of a packet, in the order of the rays; entries past its end are unspecified.
pub type Hits = [Option<Hit>; LANES];

impl Default for RayPacket {
    fn default() -> Self {
        Self {
            lanes: RayHitLanes::default(),
            active: ActiveLanes::NONE,
            ends: [0.0; LANES],
            excluded: [None; LANES],
            len: 0,
        }
    }
}

impl RayPacket {
    /// The number of rays.
    #[inline]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether the packet has no rays.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Removes all rays.
    #[inline]
    pub fn clear(&mut self) {
        self.active = ActiveLanes::NONE;
        self.len = 0;
    }

    /// Adds a ray, with the primitive that it starts on.
    ///
    /// # Panics
    /// If the packet already has [`LANES`] rays.
    #[inline]
    pub fn push(&mut self, ray: &Ray, time: f32, excluded: Option<ExcludedPrimitive>) {
        let lane = self.len;
        assert!(lane < LANES, "a packet has {LANES} rays at most");
        let rays = &mut self.lanes.rays;
        for axis in 0..3 {
            rays.origin[axis][lane] = ray.origin[axis];
            rays.dir[axis][lane] = ray.dir[axis];
        }
        rays.t_min[lane] = ray.t_min;
        rays.t_max[lane] = ray.t_max;
        rays.time[lane] = time;
        self.active.0[lane] = -i32::from(ray.is_finite());
        self.ends[lane] = ray.t_max;
        self.excluded[lane] = excluded;
        self.len = lane + 1;
    }

    /// Returns one ray and its time.
    ///
    /// # Panics
    /// If `lane` is [`LANES`] or more.
    #[inline]
    pub fn get(&self, lane: usize) -> (Ray, f32) {
        let rays = &self.lanes.rays;
        let at = |field: &[[f32; LANES]; 3]| Vec3::from_array(field.each_ref().map(|x| x[lane]));
        let ray = Ray {
            origin: at(&rays.origin),
            dir: at(&rays.dir),
            t_min: rays.t_min[lane],
            t_max: self.ends[lane],
        };
        (ray, rays.time[lane])
    }

    /// The primitive that one ray starts on.
    #[inline]
    pub(super) fn excluded(&self, lane: usize) -> Option<ExcludedPrimitive> {
        self.excluded[lane]
    }

    /// Traces the rays one by one.
    pub(super) fn each<T: Default>(
        &self,
        answers: &mut [T; LANES],
        mut trace: impl FnMut(&Ray, f32) -> T,
    ) {
        for (lane, answer) in answers.iter_mut().enumerate().take(self.len) {
            let (ray, time) = self.get(lane);
            *answer = trace(&ray, time);
        }
    }
}

/// A queue of any number of rays to be traced, stored in packets of which all but the last are full.
#[derive(Debug, Default)]
pub struct RayQueue {
    packets: Vec<RayPacket>,
    len: usize,
}

impl RayQueue {
    /// The number of rays.
    #[inline]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether the queue has no rays.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Removes all rays and keeps the allocations.
    pub fn clear(&mut self) {
        for packet in self.packets_mut() {
            packet.clear();
        }
        self.len = 0;
    }

    /// Adds a ray, with the primitive that it starts on.
    #[inline]
    pub fn push(&mut self, ray: &Ray, time: f32, excluded: Option<ExcludedPrimitive>) {
        let packet = self.len / LANES;
        if packet == self.packets.len() {
            self.packets.push(RayPacket::default());
        }
        self.packets[packet].push(ray, time, excluded);
        self.len += 1;
    }

    /// The packets, in the order of their rays.
    #[inline]
    pub fn packets_mut(&mut self) -> &mut [RayPacket] {
        &mut self.packets[..self.len.div_ceil(LANES)]
    }
}
