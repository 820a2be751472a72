//! All shapes of a scene: those that stand in the world themselves, and groups of shapes that instances place.
//!
//! Shapes are numbered as rays see them: first those that stand in the world, then, for each instance in turn, those of its
//! group. The number of a shape and that of a primitive in it identify what a ray has met.
//!
//! Measure: normalised scene units; a group has units of its own. Time goes from 0, when the shutter opens, to 1.
//! Range: groups hold no instances; each instance has a transform for at least one time step.
//! Source: Pharr, Jakob, Humphreys, section 7.1.2 for instances. Tested in `tests/tracing.rs`.

use super::Geometry;
use super::surface::SurfacePoint;
use crate::effects::Effects;
use crate::math::ray::Ray;
use crate::math::vec::{DAffine3, Vec2, Vec3};

/// One primitive of one shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PrimitiveId {
    /// Number of the shape.
    pub shape: u32,
    /// Index of the primitive within it.
    pub primitive: u32,
}

/// A group of shapes, placed in the world.
#[derive(Debug, Clone)]
pub struct Instance {
    /// The group's index.
    pub group: usize,
    /// Group to world at equally spaced times from 0 to 1; a single one stands still. Between two, every entry of the
    /// matrix changes evenly, so that every point moves in a straight line. Its entries are single-precision numbers.
    pub steps: Vec<DAffine3>,
}

/// All shapes of a scene.
#[derive(Debug, Clone, Default)]
pub struct World {
    geometries: Vec<Geometry>,
    groups: Vec<Vec<Geometry>>,
    instances: Vec<Instance>,
}

impl World {
    /// A world of shapes and of instances of groups.
    pub fn new(
        geometries: Vec<Geometry>,
        groups: Vec<Vec<Geometry>>,
        instances: Vec<Instance>,
    ) -> Self {
        Self {
            geometries,
            groups,
            instances,
        }
    }

    /// The shapes that stand in the world themselves.
    pub fn geometries(&self) -> &[Geometry] {
        &self.geometries
    }

    /// The shapes of each group, in units of its own.
    pub fn groups(&self) -> &[Vec<Geometry>] {
        &self.groups
    }

    /// All instances.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// The form of a shape, in its own units.
    #[inline]
    pub fn geometry(&self, shape: u32) -> &Geometry {
        &self.geometries[shape as usize]
    }

    /// What the surface is like, in the world, where `ray` meets a primitive at parameter `t`.
    #[inline]
    pub fn surface_at<E: Effects>(
        &self,
        id: PrimitiveId,
        ray: &Ray,
        _time: f32,
        t: f32,
        barycentric: [f32; 2],
    ) -> SurfacePoint {
        self.geometry(id.shape)
            .surface_at(id.primitive, ray, t, barycentric)
    }

    /// The texture coordinate of the point `p` of a primitive.
    #[inline]
    pub fn uv_at<E: Effects>(
        &self,
        id: PrimitiveId,
        _time: f32,
        p: Vec3,
        barycentric: [f32; 2],
    ) -> Vec2 {
        self.geometry(id.shape).uv_at(id.primitive, p, barycentric)
    }

    /// The directions in which u and v grow at a point of a primitive.
    #[inline]
    pub fn tangents_at<E: Effects>(&self, id: PrimitiveId, _time: f32, p: Vec3) -> [Vec3; 2] {
        self.geometry(id.shape).tangents_at(id.primitive, p)
    }

    /// Up to which parameter a ray that leaves a primitive at `from` along the unit vector `w`, to its outside or not,
    /// cannot truly meet that primitive again.
    #[inline]
    pub fn free_distance<E: Effects>(
        &self,
        id: PrimitiveId,
        _time: f32,
        from: Vec3,
        w: Vec3,
        to_outside: bool,
    ) -> f32 {
        self.geometry(id.shape).free_distance(from, w, to_outside)
    }
}
