//! All shapes of a scene: those that stand in the world themselves, and groups of shapes that instances place.
//!
//! Shapes are numbered as rays see them: first those that stand in the world, then, for each instance in turn, those of its
//! group. The number of a shape and that of a primitive in it identify what a ray has met.
//!
//! Measure: normalised scene units; a group has units of its own. Time goes from 0, when the shutter opens, to 1.
//! Range: groups hold no instances; each instance has a transform for at least one time step.
//! Source: Pharr, Jakob, Humphreys, section 7.1.2 for instances. Tested in `tests/tracing/instance_rays.rs`.

use super::Geometry;
pub use super::instance::Instance;
use super::placed::Placed;
use super::surface::SurfacePoint;
use crate::effects::{Effects, Switch};
use crate::math::bounds::Bounds;
use crate::math::ray::Ray;
use crate::math::vec::{Vec2, Vec3};
use std::sync::Arc;

/// One primitive of one shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PrimitiveId {
    /// Number of the shape.
    pub shape: u32,
    /// Index of the primitive within it.
    pub primitive: u32,
}

/// All shapes of a scene.
#[derive(Debug, Clone, Default)]
pub struct World {
    /// Shared, as are the groups, by worlds in which the same stands elsewhere.
    geometries: Arc<[Geometry]>,
    groups: Arc<[Vec<Geometry>]>,
    instances: Vec<Instance>,
    /// The number of the first shape of each instance.
    first_shapes: Vec<u32>,
    /// The instance of each shape beyond those that stand in the world themselves.
    owners: Vec<u32>,
}

impl World {
    /// A world of shapes and of instances of groups. One of more shapes than have numbers can be made, not traced.
    ///
    /// # Panics
    /// If an instance is of a group that does not exist.
    pub fn new(
        geometries: Vec<Geometry>,
        groups: Vec<Vec<Geometry>>,
        instances: Vec<Instance>,
    ) -> Self {
        Self::numbered(geometries.into(), groups.into(), instances)
    }

    /// The same shapes in memory, with other instances of the groups.
    ///
    /// # Panics
    /// If an instance is of a group that does not exist.
    pub fn with_instances(&self, instances: Vec<Instance>) -> Self {
        Self::numbered(self.geometries.clone(), self.groups.clone(), instances)
    }

    fn numbered(
        geometries: Arc<[Geometry]>,
        groups: Arc<[Vec<Geometry>]>,
        instances: Vec<Instance>,
    ) -> Self {
        let mut world = Self {
            geometries,
            groups,
            instances,
            ..Self::default()
        };
        if u32::try_from(world.shape_count()).is_ok() {
            world.number_shapes();
        }
        world
    }

    fn number_shapes(&mut self) {
        for (number, instance) in (0..).zip(&self.instances) {
            let first = self.geometries.len() + self.owners.len();
            self.first_shapes.push(first as u32);
            let until = self.owners.len() + self.groups[instance.group].len();
            self.owners.resize(until, number);
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

    /// How many shapes rays see.
    pub fn shape_count(&self) -> usize {
        let of = |instance: &Instance| self.groups[instance.group].len();
        self.geometries.len() + self.instances.iter().map(of).sum::<usize>()
    }

    /// The number of the first shape of an instance.
    #[inline]
    pub fn first_shape(&self, instance: usize) -> u32 {
        self.first_shapes[instance]
    }

    /// The form of a shape, in its own units.
    #[inline]
    pub fn geometry(&self, shape: u32) -> &Geometry {
        match self.instanced(shape) {
            Some((_, geometry)) => geometry,
            None => &self.geometries[shape as usize],
        }
    }

    /// The instance that a shape belongs to; `None` if it stands in the world itself.
    #[inline]
    pub fn placement(&self, shape: u32) -> Option<&Instance> {
        self.instanced(shape).map(|(instance, _)| instance)
    }

    /// A shape of an instance at a time; `None` if it stands in the world itself.
    #[inline]
    pub fn placed(&self, shape: u32, time: f32) -> Option<Placed<'_>> {
        let (instance, geometry) = self.instanced(shape)?;
        Some(Placed::new(geometry, instance, time))
    }

    /// The error bound of a point `p` on a primitive of an instance, which has to hold what a ray query in the group's frame
    /// loses; `None` if the shape stands in the world itself.
    #[inline]
    pub fn error_at<E: Effects>(&self, id: PrimitiveId, time: f32, p: Vec3) -> Option<Vec3> {
        if !E::Instances::ON {
            return None;
        }
        let placed = self.placed(id.shape, time)?;
        Some(placed.error_at(id.primitive, p))
    }

    /// The box around an instance over its whole motion; empty if its group is.
    pub fn instance_bounds(&self, instance: usize) -> Bounds {
        let instance = &self.instances[instance];
        let shapes = self.groups[instance.group].iter();
        let group = shapes.map(Geometry::bounds);
        instance.bounds_of(&group.fold(Bounds::default(), Bounds::union))
    }

    /// The instance that a shape belongs to, and its form; `None` if it stands in the world itself.
    #[inline]
    fn instanced(&self, shape: u32) -> Option<(&Instance, &Geometry)> {
        let beyond = (shape as usize).checked_sub(self.geometries.len())?;
        let owner = self.owners[beyond] as usize;
        let instance = &self.instances[owner];
        let geometry = (shape - self.first_shapes[owner]) as usize;
        Some((instance, &self.groups[instance.group][geometry]))
    }

    /// A shape as a kernel for the effects `E` sees it: without instances, all stand in the world themselves.
    #[inline]
    fn shape<E: Effects>(&self, shape: u32, time: f32) -> Shape<'_> {
        if E::Instances::ON
            && let Some(placed) = self.placed(shape, time)
        {
            return Shape::Placed(placed);
        }
        Shape::Standing(&self.geometries[shape as usize])
    }

    /// What the surface is like, in the world, where `ray` meets a primitive at parameter `t`.
    #[inline]
    pub fn surface_at<E: Effects>(
        &self,
        id: PrimitiveId,
        ray: &Ray,
        time: f32,
        t: f32,
        barycentric: [f32; 2],
    ) -> SurfacePoint {
        match self.shape::<E>(id.shape, time) {
            Shape::Standing(geometry) => geometry.surface_at(id.primitive, ray, t, barycentric),
            Shape::Placed(placed) => placed.surface_at(id.primitive, ray, t, barycentric),
        }
    }

    /// The texture coordinate of the point `p` of a primitive.
    #[inline]
    pub fn uv_at<E: Effects>(
        &self,
        id: PrimitiveId,
        time: f32,
        p: Vec3,
        barycentric: [f32; 2],
    ) -> Vec2 {
        match self.shape::<E>(id.shape, time) {
            Shape::Standing(geometry) => geometry.uv_at(id.primitive, p, barycentric),
            Shape::Placed(placed) => placed.uv_at(id.primitive, p, barycentric),
        }
    }

    /// The directions in which u and v grow at a point of a primitive.
    #[inline]
    pub fn tangents_at<E: Effects>(&self, id: PrimitiveId, time: f32, p: Vec3) -> [Vec3; 2] {
        match self.shape::<E>(id.shape, time) {
            Shape::Standing(geometry) => geometry.tangents_at(id.primitive, p),
            Shape::Placed(placed) => placed.tangents_at(id.primitive, p),
        }
    }

    /// Up to which parameter a ray that leaves a primitive at `from` along the unit vector `w`, to its outside or not,
    /// cannot truly meet that primitive again.
    #[inline]
    pub fn free_distance<E: Effects>(
        &self,
        id: PrimitiveId,
        time: f32,
        from: Vec3,
        w: Vec3,
        to_outside: bool,
    ) -> f32 {
        match self.shape::<E>(id.shape, time) {
            Shape::Standing(geometry) => geometry.free_distance(from, w, to_outside),
            Shape::Placed(placed) => placed.free_distance(from, w, to_outside),
        }
    }
}

/// Where a shape is.
enum Shape<'a> {
    /// In the world itself.
    Standing(&'a Geometry),
    /// In the world through an instance.
    Placed(Placed<'a>),
}
