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

impl<const N: usize> Default for RayLanes<N> {
    /// Creates a packet of rays that are not loaded yet, with masks that accept every shape.
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
    /// Embree's ids of geometries.
    pub geometry: [u32; N],
    /// Embree's ids of instances.
    pub instance: [u32; N],
    /// Present since Embree 4.3; unused padding in earlier versions.
    instance_primitive: [u32; N],
}

impl<const N: usize> Default for HitLanes<N> {
    /// Creates lanes that all miss.
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

impl<const N: usize> Default for RayHitLanes<N> {
    /// Creates a packet that is not loaded yet.
    fn default() -> Self {
        Self {
            rays: RayLanes::default(),
            hits: HitLanes::default(),
        }
    }
}
