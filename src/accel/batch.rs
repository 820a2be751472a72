//! Batches of rays and of hits, as structures of arrays, from which a backend fills packets of the width it supports.
//!
//! Measure: those of [`Ray`] and [`Hit`].
//! Range: any number of rays; a ray that is not finite, or not active, hits nothing.
//! Source: Embree's manual, "Ray packets". Tested in `tests/tracing/batches.rs`.

use super::{Hit, PrimitiveId};
use crate::math::ray::Ray;
use crate::math::vec::Vec3;
use std::ops::Range;

/// The number of rays in a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub enum PacketWidth {
    /// One ray at a time, without packets.
    #[default]
    One,
    /// Eight rays.
    Eight,
    /// Sixteen rays.
    Sixteen,
}

impl PacketWidth {
    /// All packet widths, the narrowest first.
    pub const ALL: &'static [Self] = &[Self::One, Self::Eight, Self::Sixteen];

    /// The number of lanes.
    pub fn lanes(self) -> usize {
        match self {
            Self::One => 1,
            Self::Eight => 8,
            Self::Sixteen => 16,
        }
    }
}

/// The packets into which a batch is split. A backend without packets traces rays one by one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Packets {
    /// The width of each packet.
    pub width: PacketWidth,
    /// Whether neighbours in the batch are coherent, as camera rays are. This affects only the speed, and not at all
    /// with packets of one: finding closest hits takes half the time if the rays are coherent, and several times as
    /// long if they are not.
    pub coherent: bool,
}

/// A batch of rays with their times.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RayBatch {
    /// The coordinates of the origins.
    pub origin: [Vec<f32>; 3],
    /// The coordinates of the directions.
    pub dir: [Vec<f32>; 3],
    /// The parameters at which the rays start.
    pub t_min: Vec<f32>,
    /// The parameters at which the rays end.
    pub t_max: Vec<f32>,
    /// The times within the shutter interval, from 0 to 1.
    pub time: Vec<f32>,
    /// Whether each ray is to be traced.
    pub active: Vec<bool>,
}

impl RayBatch {
    /// The number of rays, active or not.
    pub fn len(&self) -> usize {
        self.active.len()
    }

    /// Whether the batch has no rays.
    pub fn is_empty(&self) -> bool {
        self.active.is_empty()
    }

    /// Removes all rays and keeps the allocations.
    pub fn clear(&mut self) {
        let [x, y, z] = &mut self.origin;
        let [u, v, w] = &mut self.dir;
        for list in [
            x,
            y,
            z,
            u,
            v,
            w,
            &mut self.t_min,
            &mut self.t_max,
            &mut self.time,
        ] {
            list.clear();
        }
        self.active.clear();
    }

    /// Adds an active ray.
    #[inline]
    pub fn push(&mut self, ray: &Ray, time: f32) {
        for axis in 0..3 {
            self.origin[axis].push(ray.origin[axis]);
            self.dir[axis].push(ray.dir[axis]);
        }
        self.t_min.push(ray.t_min);
        self.t_max.push(ray.t_max);
        self.time.push(time);
        self.active.push(true);
    }

    /// Appends copies of a range of another batch's rays.
    ///
    /// # Panics
    /// If the range exceeds the other batch.
    pub fn append(&mut self, other: &Self, range: Range<usize>) {
        for axis in 0..3 {
            self.origin[axis].extend_from_slice(&other.origin[axis][range.clone()]);
            self.dir[axis].extend_from_slice(&other.dir[axis][range.clone()]);
        }
        self.t_min.extend_from_slice(&other.t_min[range.clone()]);
        self.t_max.extend_from_slice(&other.t_max[range.clone()]);
        self.time.extend_from_slice(&other.time[range.clone()]);
        self.active.extend_from_slice(&other.active[range]);
    }

    /// Returns one ray and its time.
    ///
    /// # Panics
    /// If the index is out of range.
    #[inline]
    pub fn get(&self, index: usize) -> (Ray, f32) {
        let [x, y, z] = &self.origin;
        let [u, v, w] = &self.dir;
        let ray = Ray {
            origin: Vec3::new(x[index], y[index], z[index]),
            dir: Vec3::new(u[index], v[index], w[index]),
            t_min: self.t_min[index],
            t_max: self.t_max[index],
        };
        (ray, self.time[index])
    }

    /// Whether a ray is to be traced.
    ///
    /// # Panics
    /// If the index is out of range.
    pub fn is_active(&self, index: usize) -> bool {
        self.active[index]
    }

    /// Traces the active rays one by one and stores their closest hits.
    pub(super) fn intersect_each(
        &self,
        hits: &mut HitBatch,
        intersect: impl Fn(&Ray, f32) -> Option<Hit>,
    ) {
        hits.resize(self.len());
        for index in 0..self.len() {
            let (ray, time) = self.get(index);
            let hit = self.active[index].then(|| intersect(&ray, time)).flatten();
            hits.set(index, hit);
        }
    }

    /// Tests the active rays for occlusion one by one; inactive rays are not occluded.
    pub(super) fn occluded_each(
        &self,
        occluded: &mut Vec<bool>,
        is_occluded: impl Fn(&Ray, f32) -> bool,
    ) {
        occluded.clear();
        occluded.extend((0..self.len()).map(|index| {
            let (ray, time) = self.get(index);
            self.active[index] && is_occluded(&ray, time)
        }));
    }
}

/// The hits of the rays of a batch, in the order of the rays.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HitBatch {
    /// The parameters along the rays.
    pub t: Vec<f32>,
    /// The first barycentric coordinates.
    pub u: Vec<f32>,
    /// The second barycentric coordinates.
    pub v: Vec<f32>,
    /// The shape numbers; [`HitBatch::MISS`] where there is no hit.
    pub shape: Vec<u32>,
    /// The indices of the primitives within their shapes.
    pub primitive: Vec<u32>,
}

impl HitBatch {
    /// The shape number that marks a miss; the other entries of that ray are then meaningless.
    pub const MISS: u32 = u32::MAX;

    /// The number of rays traced.
    pub fn len(&self) -> usize {
        self.shape.len()
    }

    /// Whether the batch has no entries.
    pub fn is_empty(&self) -> bool {
        self.shape.is_empty()
    }

    /// Resizes the batch to this number of rays; the contents of the entries are unspecified.
    pub fn resize(&mut self, rays: usize) {
        self.t.resize(rays, f32::INFINITY);
        self.u.resize(rays, 0.0);
        self.v.resize(rays, 0.0);
        self.shape.resize(rays, Self::MISS);
        self.primitive.resize(rays, Self::MISS);
    }

    /// Sets the hit of one ray.
    ///
    /// # Panics
    /// If the index is out of range.
    #[inline]
    pub fn set(&mut self, index: usize, hit: Option<Hit>) {
        let nothing = Hit {
            id: PrimitiveId {
                shape: Self::MISS,
                primitive: Self::MISS,
            },
            t: f32::INFINITY,
            uv: [0.0; 2],
        };
        let Hit { id, t, uv } = hit.unwrap_or(nothing);
        self.t[index] = t;
        [self.u[index], self.v[index]] = uv;
        self.shape[index] = id.shape;
        self.primitive[index] = id.primitive;
    }

    /// Returns the hit of one ray.
    ///
    /// # Panics
    /// If the index is out of range.
    #[inline]
    pub fn get(&self, index: usize) -> Option<Hit> {
        let shape = self.shape[index];
        (shape != Self::MISS).then(|| Hit {
            id: PrimitiveId {
                shape,
                primitive: self.primitive[index],
            },
            t: self.t[index],
            uv: [self.u[index], self.v[index]],
        })
    }
}
