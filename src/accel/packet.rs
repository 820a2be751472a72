//! A few rays side by side, for paths that are followed together.
//!
//! Unlike a [`RayBatch`](super::batch::RayBatch), which is cut into packets of any sort, a packet is traced as it is, and what
//! one of its rays meets does not depend on the others, unless they are said to be coherent: to the last bit, it is what
//! the ray meets in a packet of its own.
//!
//! Measure: as [`Ray`].
//! Range: up to [`LANES`] rays; a ray that is not finite hits nothing.
//! Source: Embree's manual, "Ray packets". Tested in `tests/tracing/packets.rs`.

use super::lanes::{ActiveLanes, RayHitLanes};
use super::{ExcludedPrimitive, Hit};
use crate::math::lanes::LANES;
use crate::math::ray::Ray;
use crate::math::vec::Vec3;

/// Rays with their times, laid out as Embree traces them.
#[derive(Debug, Clone)]
pub struct RayPacket {
    /// Ends that were asked for are in `ends`: tracing writes over those here.
    pub(super) lanes: RayHitLanes<LANES>,
    /// The rays that are finite.
    pub(super) active: ActiveLanes<LANES>,
    ends: [f32; LANES],
    /// What each leaves.
    departure: [Option<ExcludedPrimitive>; LANES],
    len: usize,
}

/// What the rays of a packet hit, in their order; what stands past its end is left open.
pub type Hits = [Option<Hit>; LANES];

impl Default for RayPacket {
    fn default() -> Self {
        Self {
            lanes: RayHitLanes::new(),
            active: ActiveLanes::NONE,
            ends: [0.0; LANES],
            departure: [None; LANES],
            len: 0,
        }
    }
}

impl RayPacket {
    /// How many rays there are.
    #[inline]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Takes all rays out.
    #[inline]
    pub fn clear(&mut self) {
        self.active = ActiveLanes::NONE;
        self.len = 0;
    }

    /// Adds a ray, with what it leaves.
    ///
    /// # Panics
    /// If there are [`LANES`] rays.
    #[inline]
    pub fn push(&mut self, ray: &Ray, time: f32, departure: Option<ExcludedPrimitive>) {
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
        self.departure[lane] = departure;
        self.len = lane + 1;
    }

    /// One ray and its time.
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

    /// What one ray leaves.
    #[inline]
    pub(super) fn departure(&self, lane: usize) -> Option<ExcludedPrimitive> {
        self.departure[lane]
    }

    /// Traces the rays one after the other.
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

/// Any number of rays that wait to be traced, in packets of which all but the last are whole.
#[derive(Debug, Default)]
pub struct RayQueue {
    packets: Vec<RayPacket>,
    len: usize,
}

impl RayQueue {
    /// How many rays there are.
    #[inline]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Takes all rays out and keeps the memory.
    pub fn clear(&mut self) {
        for packet in self.packets_mut() {
            packet.clear();
        }
        self.len = 0;
    }

    /// Adds a ray, with what it leaves.
    #[inline]
    pub fn push(&mut self, ray: &Ray, time: f32, departure: Option<ExcludedPrimitive>) {
        let packet = self.len / LANES;
        if packet == self.packets.len() {
            self.packets.push(RayPacket::default());
        }
        self.packets[packet].push(ray, time, departure);
        self.len += 1;
    }

    /// The packets, in the order of their rays.
    #[inline]
    pub fn packets_mut(&mut self) -> &mut [RayPacket] {
        &mut self.packets[..self.len.div_ceil(LANES)]
    }
}
