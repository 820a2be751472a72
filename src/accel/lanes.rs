//! Ray packets in Embree's memory layout: a structure of arrays with one lane per ray.
//!
//! Each struct of the headers has one generic type, for packets of 8 and of 16; `embree/layout.rs` asserts that every
//! field is at the offset given by the headers. Other backends also read their rays from these types.
//!
//! Measure: those of [`Ray`](crate::math::ray::Ray).
//! Range: 8 and 16 lanes; other numbers do not compile as queries.
//! Source: Embree's manual, "Ray packets"; embree4 headers. Tested in `tests/tracing/batches.rs`.

use super::{ExcludedPrimitive, Hit, PrimitiveId};
use crate::math::lanes::{ActiveLanes, LANES, Lanes, load, store, vectorised};
use crate::math::ray::Ray;
use crate::math::vec::Vector;

/// The id that Embree uses for none.
pub const NO_ID: u32 = u32::MAX;

/// The primitive that the ray of each lane starts on, see [`ExcludedPrimitive`].
#[repr(align(64))]
#[derive(Debug, Clone, Copy)]
pub struct ExcludedLanes {
    /// The shapes; [`NO_ID`] where no primitive is excluded.
    pub shape: Lanes<u32>,
    /// The primitives.
    pub primitive: Lanes<u32>,
    /// The free distances.
    pub free_distance: Lanes<f32>,
}

impl ExcludedLanes {
    /// No excluded primitives.
    pub const NONE: Self = Self {
        shape: [NO_ID; LANES],
        primitive: [0; LANES],
        free_distance: [0.0; LANES],
    };

    /// The excluded primitive of a lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Option<ExcludedPrimitive> {
        let (shape, primitive) = (self.shape[lane], self.primitive[lane]);
        (shape != NO_ID).then_some(ExcludedPrimitive {
            id: PrimitiveId { shape, primitive },
            free_distance: self.free_distance[lane],
        })
    }

    /// Sets the excluded primitive of a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, excluded: Option<ExcludedPrimitive>) {
        let none = PrimitiveId {
            shape: NO_ID,
            primitive: 0,
        };
        let id = excluded.map_or(none, |excluded| excluded.id);
        (self.shape[lane], self.primitive[lane]) = (id.shape, id.primitive);
        self.free_distance[lane] = excluded.map_or(0.0, |excluded| excluded.free_distance);
    }

    /// Whether any ray has hit the primitive that it starts on.
    #[inline]
    pub fn may_rule_out(&self, packet: &RayHitLanes<LANES>) -> bool {
        let hits = &packet.hits;
        let is_same = |lane: usize| {
            (hits.geometry[lane] == self.shape[lane])
                & (hits.primitive[lane] == self.primitive[lane])
                & (self.shape[lane] != NO_ID)
        };
        (0..LANES).fold(false, |any, lane| any | is_same(lane))
    }
}

/// The rays of a packet.
#[repr(C, align(64))]
#[derive(Debug, Clone)]
pub struct RayLanes<const N: usize> {
    /// The origins.
    pub origin: [[f32; N]; 3],
    /// Hits at or before these parameters do not count.
    pub t_min: [f32; N],
    /// The directions.
    pub dir: [[f32; N]; 3],
    /// The times of the shutter.
    pub time: [f32; N],
    /// The ends of the rays. Embree overwrites them with the parameter of the closest hit, or with minus infinity
    /// where a ray is occluded.
    pub t_max: [f32; N],
    /// The shapes that count; all of them.
    pub mask: [u32; N],
    /// Unused.
    pub id: [u32; N],
    /// Unused.
    pub flags: [u32; N],
}

/// A packet of rays that are not loaded yet, with masks that accept every shape.
impl<const N: usize> Default for RayLanes<N> {
    fn default() -> Self {
        Self {
            origin: [[0.0; N]; 3],
            t_min: [0.0; N],
            dir: [[0.0; N]; 3],
            time: [0.0; N],
            t_max: [0.0; N],
            mask: [u32::MAX; N],
            id: [0; N],
            flags: [0; N],
        }
    }
}

/// The hits of the rays of a packet.
#[repr(C)]
#[derive(Debug, Clone)]
pub struct HitLanes<const N: usize> {
    /// The normals of triangles, not of unit length.
    pub normal: [[f32; N]; 3],
    /// The first barycentric coordinates on triangles.
    pub u: [f32; N],
    /// The second barycentric coordinates.
    pub v: [f32; N],
    /// The primitives.
    pub primitive: [u32; N],
    /// Embree's ids, or, after [`Accel::intersect_lanes`](super::Accel::intersect_lanes), the world's shapes.
    pub geometry: [u32; N],
    /// Embree's ids of instances.
    pub instance: [u32; N],
    /// Present since Embree 4.3; unused padding in earlier versions.
    instance_primitive: [u32; N],
}

/// Lanes that all miss.
impl<const N: usize> Default for HitLanes<N> {
    fn default() -> Self {
        Self {
            normal: [[0.0; N]; 3],
            u: [0.0; N],
            v: [0.0; N],
            primitive: [NO_ID; N],
            geometry: [NO_ID; N],
            instance: [NO_ID; N],
            instance_primitive: [NO_ID; N],
        }
    }
}

/// A packet of rays with their hits.
#[repr(C, align(64))]
#[derive(Debug, Clone)]
pub struct RayHitLanes<const N: usize> {
    /// The rays.
    pub rays: RayLanes<N>,
    /// Their hits.
    pub hits: HitLanes<N>,
}

/// A packet that is not loaded yet.
impl<const N: usize> Default for RayHitLanes<N> {
    fn default() -> Self {
        Self {
            rays: RayLanes::default(),
            hits: HitLanes::default(),
        }
    }
}

impl RayLanes<LANES> {
    /// The ray of a lane and its time. A query overwrites the end of the ray.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> (Ray, f32) {
        let ray = Ray {
            origin: load(&self.origin, lane),
            dir: load(&self.dir, lane),
            t_min: self.t_min[lane],
            t_max: self.t_max[lane],
        };
        (ray, self.time[lane])
    }

    /// Sets the ray of a lane.
    #[inline(always)]
    pub fn set<V: Vector>(&mut self, lane: usize, ray: &Ray<V>) {
        store(&mut self.origin, lane, ray.origin);
        store(&mut self.dir, lane, ray.dir);
        self.t_min[lane] = ray.t_min;
        self.t_max[lane] = ray.t_max;
    }

    /// The active lanes whose rays are finite.
    #[inline]
    pub fn finite(&self, active: &ActiveLanes<LANES>) -> ActiveLanes<LANES> {
        let mut finite = *active;
        are_finite(self, &mut finite);
        finite
    }
}

vectorised! {
    /// Deactivates the lanes whose rays are not finite.
    fn are_finite(rays: &RayLanes<LANES>, active: &mut ActiveLanes<LANES>) {
        for lane in 0..LANES {
            let origin = [rays.origin[0][lane], rays.origin[1][lane], rays.origin[2][lane]];
            let dir = [rays.dir[0][lane], rays.dir[1][lane], rays.dir[2][lane]];
            let is_finite = |[x, y, z]: [f32; 3]| {
                (x.abs() < f32::INFINITY) & (y.abs() < f32::INFINITY) & (z.abs() < f32::INFINITY)
            };
            let mask = if is_finite(origin) & is_finite(dir) { -1 } else { 0 };
            active.0[lane] &= mask;
        }
    }
}

impl RayHitLanes<LANES> {
    /// The ray of a lane, as infinitely long since a query overwrites its end, and its time.
    #[inline(always)]
    pub fn ray(&self, lane: usize) -> (Ray, f32) {
        let (ray, time) = self.rays.get(lane);
        let t_max = f32::INFINITY;
        (Ray { t_max, ..ray }, time)
    }

    /// The hit of a lane, after [`Accel::intersect_lanes`](super::Accel::intersect_lanes).
    #[inline(always)]
    pub fn hit(&self, lane: usize) -> Option<Hit> {
        let id = PrimitiveId {
            shape: self.hits.geometry[lane],
            primitive: self.hits.primitive[lane],
        };
        (id.shape != NO_ID).then_some(Hit {
            id,
            t: self.rays.t_max[lane],
            uv: [self.hits.u[lane], self.hits.v[lane]],
        })
    }

    /// Sets the hit of a lane.
    #[inline(always)]
    pub fn set_hit(&mut self, lane: usize, hit: Option<Hit>) {
        let Some(Hit { id, t, uv: [u, v] }) = hit else {
            self.hits.geometry[lane] = NO_ID;
            return;
        };
        (self.hits.geometry[lane], self.hits.primitive[lane]) = (id.shape, id.primitive);
        self.rays.t_max[lane] = t;
        (self.hits.u[lane], self.hits.v[lane]) = (u, v);
    }
}
