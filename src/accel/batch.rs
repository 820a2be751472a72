//! Rays and hits in batches: structures of arrays, from which a backend fills packets of the width it likes.
//!
//! Measure: as [`Ray`] and [`Hit`].
//! Range: any number of rays; a ray that is not finite, or not active, hits nothing.
//! Source: Embree's manual, "Ray packets". Tested in `tests/tracing/batches.rs`.

use super::{Hit, PrimitiveId};
use crate::math::ray::Ray;
use crate::math::vec::Vec3;
use std::ops::Range;

/// How many rays are traced at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub enum PacketWidth {
    /// One after the other.
    #[default]
    One,
    /// Eight.
    Eight,
    /// Sixteen.
    Sixteen,
}

impl PacketWidth {
    /// Every width.
    pub const ALL: &'static [Self] = &[Self::One, Self::Eight, Self::Sixteen];

    /// Rays in a packet.
    pub fn lanes(self) -> usize {
        match self {
            Self::One => 1,
            Self::Eight => 8,
            Self::Sixteen => 16,
        }
    }
}

/// How a batch is cut into packets. A backend without packets traces one ray after the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Packets {
    /// Rays in each.
    pub width: PacketWidth,
    /// Whether neighbours in the batch go much the same way, as camera rays do. It changes nothing but the speed, and
    /// nothing at all for packets of one: closest hits take half the time if they do, and several times as long if not.
    pub coherent: bool,
}

/// Rays with their times.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RayBatch {
    /// Coordinates of the origins.
    pub origin: [Vec<f32>; 3],
    /// Coordinates of the directions.
    pub dir: [Vec<f32>; 3],
    /// Where each begins.
    pub t_min: Vec<f32>,
    /// Where each ends.
    pub t_max: Vec<f32>,
    /// Times of the shutter, from 0 to 1.
    pub time: Vec<f32>,
    /// Which are to be traced.
    pub active: Vec<bool>,
}

impl RayBatch {
    /// How many rays there are, active or not.
    pub fn len(&self) -> usize {
        self.active.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.active.is_empty()
    }

    /// Takes all rays out and keeps the memory.
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

    /// Adds copies of a range of another batch's rays.
    ///
    /// # Panics
    /// If there are not that many.
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

    /// One ray and its time.
    ///
    /// # Panics
    /// If there is none with this index.
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
    /// If there is none with this index.
    pub fn is_active(&self, index: usize) -> bool {
        self.active[index]
    }

    /// Traces the active rays one after the other.
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

    /// The same for whether anything lies on them.
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

/// What the rays of a batch hit, in their order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HitBatch {
    /// Parameters along the rays.
    pub t: Vec<f32>,
    /// First barycentric coordinates.
    pub u: Vec<f32>,
    /// Second ones.
    pub v: Vec<f32>,
    /// Numbers of the shapes; [`HitBatch::MISS`] where there is no hit.
    pub shape: Vec<u32>,
    /// Primitives within them.
    pub primitive: Vec<u32>,
}

impl HitBatch {
    /// In place of a shape, for a ray that hits nothing; the other entries then say nothing.
    pub const MISS: u32 = u32::MAX;

    /// How many rays were traced.
    pub fn len(&self) -> usize {
        self.shape.len()
    }

    /// Whether there were none.
    pub fn is_empty(&self) -> bool {
        self.shape.is_empty()
    }

    /// Makes room for the hits of so many rays; what stands there is left open.
    pub fn resize(&mut self, rays: usize) {
        self.t.resize(rays, f32::INFINITY);
        self.u.resize(rays, 0.0);
        self.v.resize(rays, 0.0);
        self.shape.resize(rays, Self::MISS);
        self.primitive.resize(rays, Self::MISS);
    }

    /// Says what one ray hits.
    ///
    /// # Panics
    /// If there is none with this index.
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

    /// What one ray hits.
    ///
    /// # Panics
    /// If there is none with this index.
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
