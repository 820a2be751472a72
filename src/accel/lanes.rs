//! Packets of rays as Embree lays them out: each field of all rays side by side, one lane a ray.
//!
//! One generic type a struct of the headers, for packets of 8 and of 16: `embree/layout.rs` asserts that every field is in
//! the place where the headers have it. Other backends read their rays from there, too.
//!
//! Measure: as [`Ray`](crate::math::ray::Ray).
//! Range: 8 and 16 lanes; other numbers do not compile as queries.
//! Source: Embree's manual, "Ray packets"; embree4 headers. Tested in `tests/tracing/batches.rs`.

/// In place of an id, where there is none: as Embree has it.
pub const NO_ID: u32 = u32::MAX;

/// Which lanes Embree is to trace: -1 for those, 0 for the others.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ActiveLanes<const N: usize>(pub [i32; N]);

impl<const N: usize> ActiveLanes<N> {
    /// Nothing to trace.
    pub const NONE: Self = Self([0; N]);
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
    pub id: [u32; N],
    pub flags: [u32; N],
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
}

/// What the rays of a packet hit.
#[repr(C)]
#[derive(Debug, Clone)]
pub struct HitLanes<const N: usize> {
    pub normal: [[f32; N]; 3],
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
            primitive: [NO_ID; N],
            geometry: [NO_ID; N],
            instance: [NO_ID; N],
            instance_primitive: [NO_ID; N],
        }
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
