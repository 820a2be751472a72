//! All shapes of a scene: top-level shapes in world space, and groups of shapes that are placed by instances.
//!
//! Shapes are numbered as in ray queries: first the top-level shapes, then, for each instance in turn, the shapes of
//! its group. The number of a shape and the index of a primitive in it identify the primitive that a ray has hit.
//!
//! Measure: normalised scene units; each group has its own units. Time runs from 0, when the shutter opens, to 1.
//! Range: groups hold no instances; each instance has a transform for at least one time step.
//! Source: Pharr, Jakob, Humphreys, section 7.1.2 for instances. Tested in `tests/tracing/instance_rays.rs`.

use super::Geometry;
pub use super::instance::Instance;
use super::placed::PlacedShape;
use super::surface::SurfacePoint;
use crate::effects::{Effects, Switch};
use crate::math::bounds::Bounds;
use crate::math::ray::Ray;
use crate::math::vec::{Vec2, Vec3};
use std::sync::Arc;

/// The identifier of one primitive of one shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PrimitiveId {
    /// The number of the shape.
    pub shape: u32,
    /// The index of the primitive within the shape.
    pub primitive: u32,
}

/// All shapes of a scene.
#[derive(Debug, Clone, Default)]
pub struct World {
    /// The top-level shapes. They and the groups are shared by worlds that differ only in their instances.
    geometries: Arc<[Geometry]>,
    groups: Arc<[Vec<Geometry>]>,
    instances: Vec<Instance>,
    /// The number of the first shape of each instance.
    first_shapes: Vec<u32>,
    /// The instance of each shape after the top-level shapes.
    owners: Vec<u32>,
}

impl World {
    /// Creates a world of top-level shapes and of instances of groups. A world with more shapes than 32 bits can number
    /// can be created, but not traced.
    ///
    /// # Panics
    /// If an instance refers to a group that does not exist.
    pub fn new(
        geometries: Vec<Geometry>,
        groups: Vec<Vec<Geometry>>,
        instances: Vec<Instance>,
    ) -> Self {
        Self::numbered(geometries.into(), groups.into(), instances)
    }

    /// Creates a world that shares the shapes of this one, with other instances of the groups.
    ///
    /// # Panics
    /// If an instance refers to a group that does not exist.
    pub fn with_instances(&self, instances: Vec<Instance>) -> Self {
        Self::numbered(self.geometries.clone(), self.groups.clone(), instances)
    }

    /// Whether both worlds have the same shapes in memory, and differ at most in their instances.
    pub fn shares_shapes_with(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.geometries, &other.geometries) && Arc::ptr_eq(&self.groups, &other.groups)
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

    /// The top-level shapes.
    pub fn geometries(&self) -> &[Geometry] {
        &self.geometries
    }

    /// The shapes of each group, in the units of the group.
    pub fn groups(&self) -> &[Vec<Geometry>] {
        &self.groups
    }

    /// All instances.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// The number of shapes in ray queries, with those of every instance.
    pub fn shape_count(&self) -> usize {
        let of = |instance: &Instance| self.groups[instance.group].len();
        self.geometries.len() + self.instances.iter().map(of).sum::<usize>()
    }

    /// The number of the first shape of an instance.
    #[inline]
    pub fn first_shape(&self, instance: usize) -> u32 {
        self.first_shapes[instance]
    }

    /// The geometry of a shape, in its own units.
    #[inline]
    pub fn geometry(&self, shape: u32) -> &Geometry {
        match self.instanced(shape) {
            Some((_, geometry)) => geometry,
            None => &self.geometries[shape as usize],
        }
    }

    /// The instance that a shape belongs to; `None` for a top-level shape.
    #[inline]
    pub fn placement(&self, shape: u32) -> Option<&Instance> {
        self.instanced(shape).map(|(instance, _)| instance)
    }

    /// A shape of an instance at a time; `None` for a top-level shape.
    #[inline]
    pub fn placed(&self, shape: u32, time: f32) -> Option<PlacedShape<'_>> {
        let (instance, geometry) = self.instanced(shape)?;
        Some(PlacedShape::new(geometry, instance, time))
    }

    /// The error bound of a point `p` on a primitive of an instance, including the error of a ray query in the group's
    /// frame; `None` for a top-level shape.
    #[inline]
    pub fn error_at<E: Effects>(&self, id: PrimitiveId, time: f32, p: Vec3) -> Option<Vec3> {
        if !E::Instances::ON {
            return None;
        }
        let placed = self.placed(id.shape, time)?;
        Some(placed.error_at(id.primitive, p))
    }

    /// The bounding box of an instance over its whole motion; empty if its group is.
    pub fn instance_bounds(&self, instance: usize) -> Bounds {
        let instance = &self.instances[instance];
        let shapes = self.groups[instance.group].iter();
        let group = shapes.map(Geometry::bounds);
        instance.bounds_of(&group.fold(Bounds::default(), Bounds::union))
    }

    /// The instance that a shape belongs to, and its geometry; `None` for a top-level shape.
    #[inline]
    fn instanced(&self, shape: u32) -> Option<(&Instance, &Geometry)> {
        let beyond = (shape as usize).checked_sub(self.geometries.len())?;
        let owner = self.owners[beyond] as usize;
        let instance = &self.instances[owner];
        let geometry = (shape - self.first_shapes[owner]) as usize;
        Some((instance, &self.groups[instance.group][geometry]))
    }

    /// A shape as seen by a kernel for the effects `E`: without instances, all shapes are top-level shapes.
    #[inline]
    fn shape<E: Effects>(&self, shape: u32, time: f32) -> ShapeGeometry<'_> {
        if E::Instances::ON
            && let Some(placed) = self.placed(shape, time)
        {
            return ShapeGeometry::Placed(placed);
        }
        ShapeGeometry::Static(&self.geometries[shape as usize])
    }

    /// The surface point, in world space, where `ray` hits a primitive at parameter `t`.
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
            ShapeGeometry::Static(geometry) => {
                geometry.surface_at(id.primitive, ray, t, barycentric)
            }
            ShapeGeometry::Placed(placed) => placed.surface_at(id.primitive, ray, t, barycentric),
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
            ShapeGeometry::Static(geometry) => geometry.uv_at(id.primitive, p, barycentric),
            ShapeGeometry::Placed(placed) => placed.uv_at(id.primitive, p, barycentric),
        }
    }

    /// The directions in which u and v increase at a point of a primitive.
    #[inline]
    pub fn tangents_at<E: Effects>(&self, id: PrimitiveId, time: f32, p: Vec3) -> [Vec3; 2] {
        match self.shape::<E>(id.shape, time) {
            ShapeGeometry::Static(geometry) => geometry.tangents_at(id.primitive, p),
            ShapeGeometry::Placed(placed) => placed.tangents_at(id.primitive, p),
        }
    }

    /// The parameter up to which a ray that leaves the primitive at `from` along the unit vector `w`, on its outside if
    /// `to_outside`, cannot truly hit that primitive again.
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
            ShapeGeometry::Static(geometry) => geometry.free_distance(from, w, to_outside),
            ShapeGeometry::Placed(placed) => placed.free_distance(from, w, to_outside),
        }
    }
}

/// The geometry of a shape, by its placement.
enum ShapeGeometry<'a> {
    /// A top-level shape.
    Static(&'a Geometry),
    /// A shape of an instance.
    Placed(PlacedShape<'a>),
}
