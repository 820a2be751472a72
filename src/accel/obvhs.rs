//! The backend in Rust: obvhs binary BVHs, whose primitives are intersected in double precision.
//!
//! There are two levels: a tree over the primitives that stand in the world and over the instances, and one tree for each
//! group, in which rays are traced in the group's units.
//!
//! Measure: normalised scene units.
//! Range: as in `accel/mod.rs`; precision is always robust.
//! Source: obvhs (parallel locally-ordered clustering). Tested in `tests/tracing.rs` and `tests/tracing_instances.rs`.

use super::box_tree::{BoxTree, clip};
use super::primitive::{self, DRay};
use super::{AccelOptions, Hit, PrimitiveId};
use crate::geometry::Geometry;
use crate::geometry::world::World;
use crate::math::bounds::Bounds;
use crate::math::ray::Ray;
use std::sync::Arc;

/// Trees over the world and over each group.
#[derive(Debug)]
pub struct ObvhsAccel {
    world: Arc<World>,
    tree: BoxTree<Item>,
    groups: Vec<Group>,
}

/// What the world's tree holds.
#[derive(Debug, Clone, Copy)]
enum Item {
    Primitive(PrimitiveId),
    Instance(u32),
}

/// A group's tree, whose primitives have the number of their shape within the group.
#[derive(Debug)]
struct Group {
    bounds: Bounds,
    tree: BoxTree<PrimitiveId>,
}

impl ObvhsAccel {
    /// Builds the trees on rayon's current threads.
    pub fn build(world: Arc<World>, _options: AccelOptions) -> Self {
        let shapes = primitives(world.geometries()).map(|(id, b)| (Item::Primitive(id), b));
        let numbers = 0..world.instances().len();
        let instances = numbers.map(|i| (Item::Instance(i as u32), world.instance_bounds(i)));
        let occupied = instances.filter(|(_, bounds)| !bounds.is_empty());
        Self {
            tree: BoxTree::new(shapes.chain(occupied)),
            groups: world.groups().iter().map(|g| Group::new(g)).collect(),
            world,
        }
    }

    /// The closest hit.
    #[inline]
    pub fn intersect(&self, ray: &Ray, time: f32) -> Option<Hit> {
        if !is_finite(ray) {
            return None;
        }
        let closest = self.tree.closest(&ray.into(), 0.0, |item, ray| match item {
            Item::Primitive(id) => intersect_primitive(self.world.geometries(), id, ray),
            Item::Instance(instance) => self.intersect_instance(instance, ray, time),
        });
        closest.map(|(_, hit)| hit)
    }

    /// Whether anything lies on the ray; stops at the first hit found.
    #[inline]
    pub fn occluded(&self, ray: &Ray, time: f32) -> bool {
        if !is_finite(ray) {
            return false;
        }
        let ray = DRay::from(ray);
        self.tree.any(&ray, 0.0, |item| match item {
            Item::Primitive(id) => intersect_primitive(self.world.geometries(), id, &ray).is_some(),
            Item::Instance(instance) => self.instance_occludes(instance, &ray, time),
        })
    }

    /// Bytes of the trees.
    pub fn memory(&self) -> usize {
        let groups = self.groups.iter().map(|group| group.tree.memory());
        self.tree.memory() + groups.sum::<usize>()
    }

    /// Nodes of the trees.
    pub fn nodes(&self) -> usize {
        let groups = self.groups.iter().map(|group| group.tree.nodes());
        self.tree.nodes() + groups.sum::<usize>()
    }

    fn intersect_instance(&self, instance: u32, ray: &DRay, time: f32) -> Option<(f64, Hit)> {
        let (group, shapes, ray, start) = self.enter(instance, ray, time)?;
        let closest = group
            .tree
            .closest(&ray, start, |id, ray| intersect_primitive(shapes, id, ray));
        let first_shape = self.world.first_shape(instance as usize);
        closest.map(|(t, mut hit)| {
            hit.id.shape += first_shape;
            (t, hit)
        })
    }

    fn instance_occludes(&self, instance: u32, ray: &DRay, time: f32) -> bool {
        let Some((group, shapes, ray, start)) = self.enter(instance, ray, time) else {
            return false;
        };
        group.tree.any(&ray, start, |id| {
            intersect_primitive(shapes, id, &ray).is_some()
        })
    }

    /// The group of an instance, its shapes, the ray in its units, and where that comes into it.
    #[inline]
    fn enter(
        &self,
        instance: u32,
        ray: &DRay,
        time: f32,
    ) -> Option<(&Group, &[Geometry], DRay, f64)> {
        let instance = &self.world.instances()[instance as usize];
        let group = &self.groups[instance.group];
        let ray = ray.transformed(&instance.at(time).inverse());
        let start = clip(&ray, &group.bounds)?;
        Some((group, &self.world.groups()[instance.group], ray, start))
    }
}

impl Group {
    fn new(shapes: &[Geometry]) -> Self {
        let boxes = primitives(shapes).map(|(_, bounds)| bounds);
        let bounds = boxes.fold(Bounds::default(), Bounds::union);
        Self {
            tree: BoxTree::new_within(&bounds, primitives(shapes)),
            bounds,
        }
    }
}

/// Every primitive of some shapes, with its box.
fn primitives(shapes: &[Geometry]) -> impl Iterator<Item = (PrimitiveId, Bounds)> {
    (0..).zip(shapes).flat_map(|(number, shape)| {
        (0..shape.primitive_count() as u32).map(move |primitive| {
            let id = PrimitiveId {
                shape: number,
                primitive,
            };
            (id, shape.primitive_bounds(primitive))
        })
    })
}

#[inline]
fn intersect_primitive(shapes: &[Geometry], id: PrimitiveId, ray: &DRay) -> Option<(f64, Hit)> {
    let (t, uv) = primitive::intersect(&shapes[id.shape as usize], id.primitive, ray)?;
    let hit = Hit {
        id,
        t: t as f32,
        uv: uv.map(|x| x as f32),
    };
    Some((t, hit))
}

#[inline]
fn is_finite(ray: &Ray) -> bool {
    ray.origin.is_finite() && ray.dir.is_finite()
}
