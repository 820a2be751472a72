//! Packets of rays as Embree lays them out: each field of all rays side by side, one lane a ray.
//!
//! One generic type a struct of the headers, for packets of 8 and of 16: the assertions below hold every field in the
//! place where the headers have it.
//!
//! Measure: as [`RayBatch`](crate::accel::batch::RayBatch).
//! Range: 8 and 16 lanes; other numbers do not compile as queries.
//! Source: Embree's manual, "Ray packets"; embree4 headers. Tested in `tests/tracing/batches.rs`.

use crate::accel::batch::RayBatch;
use embree4_sys::{
    RTC_INVALID_GEOMETRY_ID, RTCHit8, RTCHit16, RTCRay8, RTCRay16, RTCRayHit8, RTCRayHit16,
};
use std::mem::offset_of;

/// Which lanes Embree is to trace: -1 for those, 0 for the others.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ActiveLanes<const N: usize>(pub [i32; N]);

impl<const N: usize> ActiveLanes<N> {
    /// Whether there is anything to trace.
    #[inline]
    pub fn any(&self) -> bool {
        self.0.iter().any(|&lane| lane != 0)
    }
}

/// The rays of a packet.
#[repr(C, align(64))]
#[derive(Debug, Clone)]
pub struct RayLanes<const N: usize> {
    pub origin: [[f32; N]; 3],
    pub t_min: [f32; N],
    pub dir: [[f32; N]; 3],
    pub time: [f32; N],
    /// Embree writes here: the closest hit's parameter, or minus infinity where a ray is occluded.
    pub t_max: [f32; N],
    pub mask: [u32; N],
    id: [u32; N],
    flags: [u32; N],
}

impl<const N: usize> RayLanes<N> {
    /// Rays that see every shape and are yet to be loaded.
    pub fn new() -> Self {
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

    /// Takes the rays of a batch from `start` on, as many as there are lanes, or as the batch has left. Tells which are
    /// to be traced: active ones that are finite.
    #[inline]
    pub fn load(&mut self, rays: &RayBatch, start: usize) -> ActiveLanes<N> {
        for axis in 0..3 {
            copy(&mut self.origin[axis], &rays.origin[axis][start..]);
            copy(&mut self.dir[axis], &rays.dir[axis][start..]);
        }
        copy(&mut self.t_min, &rays.t_min[start..]);
        copy(&mut self.t_max, &rays.t_max[start..]);
        copy(&mut self.time, &rays.time[start..]);
        // Lanes past the end of the batch keep what an earlier packet left in them.
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

/// Copies what there is, and whole packets as one piece of known size.
#[inline]
fn copy<T: Copy, const N: usize>(lanes: &mut [T; N], from: &[T]) {
    match from.first_chunk() {
        Some(whole) => *lanes = *whole,
        None => lanes[..from.len()].copy_from_slice(from),
    }
}

/// What the rays of a packet hit.
#[repr(C)]
#[derive(Debug, Clone)]
pub struct HitLanes<const N: usize> {
    normal: [[f32; N]; 3],
    pub u: [f32; N],
    pub v: [f32; N],
    pub primitive: [u32; N],
    pub geometry: [u32; N],
    pub instance: [u32; N],
    /// Known since Embree 4.3; before, room to spare.
    instance_primitive: [u32; N],
}

impl<const N: usize> HitLanes<N> {
    /// Nothing is hit.
    pub fn new() -> Self {
        Self {
            normal: [[0.0; N]; 3],
            u: [0.0; N],
            v: [0.0; N],
            primitive: [RTC_INVALID_GEOMETRY_ID; N],
            geometry: [RTC_INVALID_GEOMETRY_ID; N],
            instance: [RTC_INVALID_GEOMETRY_ID; N],
            instance_primitive: [RTC_INVALID_GEOMETRY_ID; N],
        }
    }

    /// Forgets the hits, in the fields that Embree asks to be set.
    #[inline]
    pub fn clear(&mut self) {
        self.geometry = [RTC_INVALID_GEOMETRY_ID; N];
        self.instance = [RTC_INVALID_GEOMETRY_ID; N];
    }
}

/// A packet of rays with what they hit.
#[repr(C, align(64))]
#[derive(Debug, Clone)]
pub struct RayHitLanes<const N: usize> {
    pub rays: RayLanes<N>,
    pub hits: HitLanes<N>,
}

impl<const N: usize> RayHitLanes<N> {
    /// A packet that is yet to be loaded.
    pub fn new() -> Self {
        Self {
            rays: RayLanes::new(),
            hits: HitLanes::new(),
        }
    }
}

/// Holds the types for one width against the headers.
macro_rules! assert_layout {
    ($lanes:literal, $ray:ident, $hit:ident, $ray_hit:ident) => {
        const _: () = {
            const N: usize = $lanes;
            assert!(align_of::<ActiveLanes<N>>() >= align_of::<$ray_hit>());
            assert!(size_of::<RayLanes<N>>() == size_of::<$ray>());
            assert!(align_of::<RayLanes<N>>() >= align_of::<$ray>());
            assert!(offset_of!(RayLanes<N>, origin) == offset_of!($ray, org_x));
            assert!(offset_of!(RayLanes<N>, t_min) == offset_of!($ray, tnear));
            assert!(offset_of!(RayLanes<N>, dir) == offset_of!($ray, dir_x));
            assert!(offset_of!(RayLanes<N>, time) == offset_of!($ray, time));
            assert!(offset_of!(RayLanes<N>, t_max) == offset_of!($ray, tfar));
            assert!(offset_of!(RayLanes<N>, mask) == offset_of!($ray, mask));
            assert!(offset_of!(RayLanes<N>, id) == offset_of!($ray, id));
            assert!(offset_of!(RayLanes<N>, flags) == offset_of!($ray, flags));
            // Hits grew by a field in Embree 4.3.
            assert!(size_of::<HitLanes<N>>() >= size_of::<$hit>());
            assert!(offset_of!(HitLanes<N>, normal) == offset_of!($hit, Ng_x));
            assert!(offset_of!(HitLanes<N>, u) == offset_of!($hit, u));
            assert!(offset_of!(HitLanes<N>, v) == offset_of!($hit, v));
            assert!(offset_of!(HitLanes<N>, primitive) == offset_of!($hit, primID));
            assert!(offset_of!(HitLanes<N>, geometry) == offset_of!($hit, geomID));
            assert!(offset_of!(HitLanes<N>, instance) == offset_of!($hit, instID));
            assert!(size_of::<RayHitLanes<N>>() >= size_of::<$ray_hit>());
            assert!(align_of::<RayHitLanes<N>>() >= align_of::<$ray_hit>());
            assert!(offset_of!(RayHitLanes<N>, hits) == offset_of!($ray_hit, hit));
        };
    };
}

assert_layout!(8, RTCRay8, RTCHit8, RTCRayHit8);
assert_layout!(16, RTCRay16, RTCHit16, RTCRayHit16);
