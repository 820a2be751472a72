//! Ray packets in Embree's memory layout: a structure of arrays with one lane per ray.
//!
//! Each struct of the headers has one generic type, for packets of 8 and of 16; `embree/layout.rs` asserts that every
//! field is at the offset given by the headers. Other backends also read their rays from these types.
//!
//! Measure: those of [`Ray`](crate::math::ray::Ray).
//! Range: 8 and 16 lanes; other numbers do not compile as queries.
//! Source: Embree's manual, "Ray packets"; embree4 headers. Tested in `tests/tracing/batches.rs`.

/// The id that Embree uses for none.
pub const NO_ID: u32 = u32::MAX;

/// The mask of lanes that Embree traces: -1 for active lanes, 0 for the others.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ActiveLanes<const N: usize>(pub [i32; N]);

impl<const N: usize> ActiveLanes<N> {
    /// The mask with no active lane.
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
    /// The ends of the rays. Embree overwrites them with the parameter of the closest hit, or with minus infinity
    /// where a ray is occluded.
    pub t_max: [f32; N],
    pub mask: [u32; N],
    pub id: [u32; N],
    pub flags: [u32; N],
}

impl<const N: usize> RayLanes<N> {
    /// Creates a packet of rays that are not loaded yet, with masks that accept every shape.
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

/// The hits of the rays of a packet.
#[repr(C)]
#[derive(Debug, Clone)]
pub struct HitLanes<const N: usize> {
    pub normal: [[f32; N]; 3],
    pub u: [f32; N],
    pub v: [f32; N],
    pub primitive: [u32; N],
    pub geometry: [u32; N],
    pub instance: [u32; N],
    /// Present since Embree 4.3; unused padding in earlier versions.
    instance_primitive: [u32; N],
}

impl<const N: usize> HitLanes<N> {
    /// Creates lanes that all miss.
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

/// A packet of rays with their hits.
#[repr(C, align(64))]
#[derive(Debug, Clone)]
pub struct RayHitLanes<const N: usize> {
    pub rays: RayLanes<N>,
    pub hits: HitLanes<N>,
}

impl<const N: usize> RayHitLanes<N> {
    /// Creates a packet that is not loaded yet.
    pub fn new() -> Self {
        Self {
            rays: RayLanes::new(),
            hits: HitLanes::new(),
        }
    }
}
