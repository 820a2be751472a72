//! One level of the structure, a BVH with its leaves: the top-level shapes and the instances, or the shapes of a group.
//!
//! The vertices of triangles are stored in the order of the leaves and are all that a triangle test reads. The item of
//! a leaf slot is read only after its triangle has been hit, or if the slot holds no triangle, which is marked by NaN
//! vertices.
//!
//! Measure: normalised scene units, or the units of the group.
//! Range: as in `accel/mod.rs`.
//! Source: none needed. Tested in `tests/tracing/rays.rs` and `tests/tracing/instance_rays.rs`.

use super::box_ray::largest_coordinate;
use super::box_tree::{BoxTree, NodeLayout, widened};
use super::trace_ray::TraceRay;
use crate::accel::{Hit, PrimitiveId, Quality};
use crate::geometry::Geometry;
use crate::math::bounds::Bounds;
use crate::math::robust::gamma;
use crate::math::vec::Vec3;
use rayon::prelude::*;
use std::ops::ControlFlow;

/// The content of a leaf slot.
#[derive(Debug, Clone, Copy)]
pub enum BvhItem {
    /// A primitive of a shape of this level.
    Primitive(PrimitiveId),
    /// An instance.
    Instance(u32),
}

/// The options for building a tree.
#[derive(Debug, Clone, Copy)]
pub struct TreeOptions {
    /// The memory layout of the nodes.
    pub layout: NodeLayout,
    /// The effort spent on building.
    pub quality: Quality,
}

/// The closest hit so far: the slot of a triangle with the barycentric coordinates, or a hit on another primitive.
#[derive(Clone, Copy)]
enum ClosestHit {
    Triangle(usize, [f32; 2]),
    Other(Hit),
}

/// A tree with its leaves.
#[derive(Debug)]
pub struct Level {
    tree: BoxTree,
    /// The vertices in each leaf slot; NaN where there is no triangle.
    triangles: Vec<[Vec3; 3]>,
    /// The content of each leaf slot.
    items: Vec<BvhItem>,
}

impl Level {
    /// Builds a level for rays in world space.
    pub fn new(shapes: &[Geometry], instances: &[(u32, Bounds)], options: TreeOptions) -> Self {
        Self::padded(shapes, instances, 0.0, options)
    }

    /// Builds a level for rays that are transformed into its units and rounded at the point where they enter its
    /// bounds.
    pub fn within(bounds: &Bounds, shapes: &[Geometry], options: TreeOptions) -> Self {
        let padding = f64::from(gamma(16)) * largest_coordinate(bounds);
        Self::padded(shapes, &[], padding, options)
    }

    fn padded(
        shapes: &[Geometry],
        instances: &[(u32, Bounds)],
        padding: f64,
        options: TreeOptions,
    ) -> Self {
        let ids: Vec<_> = primitives(shapes).collect();
        let of_primitives = ids.par_iter().map(|id| {
            let bounds = shapes[id.shape as usize].primitive_bounds(id.primitive);
            widened(&bounds, padding)
        });
        let of_instances = instances.par_iter().map(|(_, b)| widened(b, padding));
        let boxes: Vec<_> = of_primitives.chain(of_instances).collect();
        let (tree, order) = BoxTree::build(&boxes, options.layout, options.quality);
        let item = |&index: &u32| match ids.get(index as usize) {
            Some(&id) => BvhItem::Primitive(id),
            None => BvhItem::Instance(instances[index as usize - ids.len()].0),
        };
        let items: Vec<_> = order.par_iter().map(item).collect();
        let triangles = items.par_iter().map(|&item| vertices(shapes, item));
        Self {
            tree,
            triangles: triangles.collect(),
            items,
        }
    }

    /// Finds the closest hit of a ray, with its parameter in double precision. Boxes are tested from the parameter
    /// `start` on; `other` intersects items that are not triangles.
    #[inline]
    pub fn closest<R: TraceRay>(
        &self,
        mut ray: R,
        start: f64,
        mut other: impl FnMut(BvhItem, &R) -> Option<(f64, Hit)>,
    ) -> Option<(f64, Hit)> {
        let (query, parameter) = ray.to_boxes(start);
        let mut closest = None;
        let _ = self.tree.traverse(query, |place, end| {
            let triangle = &self.triangles[place];
            let candidate = match ray.intersect(triangle) {
                Some((t, uv)) => Some((t, ClosestHit::Triangle(place, uv))),
                None if triangle[0].x.is_nan() => {
                    let hit = other(self.items[place], &ray);
                    hit.map(|(t, hit)| (t, ClosestHit::Other(hit)))
                }
                None => None,
            };
            if let Some((t, _)) = candidate {
                ray.end_at(t);
                *end = parameter.high(t);
                closest = candidate;
            }
            ControlFlow::Continue(())
        });
        closest.map(|(t, hit)| (t, self.resolve(t, hit)))
    }

    #[inline]
    fn resolve(&self, t: f64, hit: ClosestHit) -> Hit {
        match hit {
            ClosestHit::Other(hit) => hit,
            ClosestHit::Triangle(place, uv) => match self.items[place] {
                BvhItem::Primitive(id) => Hit {
                    id,
                    t: t as f32,
                    uv,
                },
                BvhItem::Instance(_) => unreachable!("an instance has no vertices"),
            },
        }
    }

    /// Whether the ray is occluded, with `start` and `other` as in [`Self::closest`]; stops at the first hit found.
    #[inline]
    pub fn occluded<R: TraceRay>(
        &self,
        ray: R,
        start: f64,
        mut other: impl FnMut(BvhItem, &R) -> bool,
    ) -> bool {
        let (query, _) = ray.to_boxes(start);
        let flow = self.tree.traverse(query, |place, _| {
            let triangle = &self.triangles[place];
            let is_hit = ray.intersect(triangle).is_some()
                || (triangle[0].x.is_nan() && other(self.items[place], &ray));
            if is_hit {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        flow.is_break()
    }

    /// The number of nodes of the tree.
    pub fn nodes(&self) -> usize {
        self.tree.nodes()
    }

    /// The number of bytes of the tree and its leaves.
    pub fn memory(&self) -> usize {
        self.tree.memory()
            + size_of_val(self.triangles.as_slice())
            + size_of_val(self.items.as_slice())
    }
}

/// The ids of all primitives of the shapes.
fn primitives(shapes: &[Geometry]) -> impl Iterator<Item = PrimitiveId> {
    (0..).zip(shapes).flat_map(|(shape, geometry)| {
        let primitives = 0..geometry.primitive_count() as u32;
        primitives.map(move |primitive| PrimitiveId { shape, primitive })
    })
}

/// The vertices of a triangle; NaN for other items.
fn vertices(shapes: &[Geometry], item: BvhItem) -> [Vec3; 3] {
    if let BvhItem::Primitive(id) = item
        && let Geometry::Mesh(mesh) = &shapes[id.shape as usize]
    {
        mesh.triangle(id.primitive)
    } else {
        [Vec3::NAN; 3]
    }
}
