//! A tree and what is in its leaves: the shapes that stand in the world and its instances, or the shapes of a group.
//!
//! The vertices of triangles lie in the order of the leaves and are all that a test reads. What a place holds is looked up
//! when a triangle has been hit; or when there is none, which vertices that are not numbers tell.
//!
//! Measure: normalised scene units, or a group's own.
//! Range: as in `accel/mod.rs`.
//! Source: none needed. Tested in `tests/tracing/rays.rs` and `tests/tracing/instance_rays.rs`.

use super::box_ray::largest_coordinate;
use super::box_tree::{BoxTree, Layout, widened};
use super::trace_ray::TraceRay;
use crate::accel::{Hit, PrimitiveId, Quality};
use crate::geometry::Geometry;
use crate::math::bounds::Bounds;
use crate::math::robust::gamma;
use crate::math::vec::Vec3;
use rayon::prelude::*;
use std::ops::ControlFlow;

/// What a place in a leaf holds.
#[derive(Debug, Clone, Copy)]
pub enum Item {
    /// A primitive of a shape of this level.
    Primitive(PrimitiveId),
    /// An instance.
    Instance(u32),
}

/// How a tree is to be built.
#[derive(Debug, Clone, Copy)]
pub struct TreeOptions {
    /// How the nodes lie.
    pub layout: Layout,
    /// How much work goes into them.
    pub quality: Quality,
}

/// What a ray has met: the place of a triangle and the point on it, or a hit on something else.
#[derive(Clone, Copy)]
enum ClosestHit {
    Triangle(usize, [f32; 2]),
    Other(Hit),
}

/// A tree with its leaves.
#[derive(Debug)]
pub struct Level {
    tree: BoxTree,
    /// The vertices in each place of a leaf, not numbers where there is no triangle.
    triangles: Vec<[Vec3; 3]>,
    /// What each place holds.
    items: Vec<Item>,
}

impl Level {
    /// A level for rays as they are.
    pub fn new(shapes: &[Geometry], instances: &[(u32, Bounds)], options: TreeOptions) -> Self {
        Self::padded(shapes, instances, 0.0, options)
    }

    /// A level for rays that are brought into its units and then rounded where they come into its bounds.
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
            Some(&id) => Item::Primitive(id),
            None => Item::Instance(instances[index as usize - ids.len()].0),
        };
        let items: Vec<_> = order.par_iter().map(item).collect();
        let triangles = items.par_iter().map(|&item| vertices(shapes, item));
        Self {
            tree,
            triangles: triangles.collect(),
            items,
        }
    }

    /// The closest hit of a ray whose boxes count from the parameter `start` on, with its parameter in full; `other` meets
    /// what is no triangle.
    #[inline]
    pub fn closest<R: TraceRay>(
        &self,
        mut ray: R,
        start: f64,
        mut other: impl FnMut(Item, &R) -> Option<(f64, Hit)>,
    ) -> Option<(f64, Hit)> {
        let (query, parameter) = ray.to_boxes(start);
        let mut closest = None;
        let _ = self.tree.traverse(query, |place, end| {
            let triangle = &self.triangles[place];
            let found = match ray.meet(triangle) {
                Some((t, uv)) => Some((t, ClosestHit::Triangle(place, uv))),
                None if triangle[0].x.is_nan() => {
                    let hit = other(self.items[place], &ray);
                    hit.map(|(t, hit)| (t, ClosestHit::Other(hit)))
                }
                None => None,
            };
            if let Some((t, _)) = found {
                ray.end_at(t);
                *end = parameter.high(t);
                closest = found;
            }
            ControlFlow::Continue(())
        });
        closest.map(|(t, found)| (t, self.resolve(t, found)))
    }

    #[inline]
    fn resolve(&self, t: f64, found: ClosestHit) -> Hit {
        match found {
            ClosestHit::Other(hit) => hit,
            ClosestHit::Triangle(place, uv) => match self.items[place] {
                Item::Primitive(id) => Hit {
                    id,
                    t: t as f32,
                    uv,
                },
                Item::Instance(_) => unreachable!("an instance has no vertices"),
            },
        }
    }

    /// Whether anything lies on a ray, with `start` and `other` as above; stops at the first hit found.
    #[inline]
    pub fn occluded<R: TraceRay>(
        &self,
        ray: R,
        start: f64,
        mut other: impl FnMut(Item, &R) -> bool,
    ) -> bool {
        let (query, _) = ray.to_boxes(start);
        let flow = self.tree.traverse(query, |place, _| {
            let triangle = &self.triangles[place];
            let met = ray.meet(triangle).is_some()
                || (triangle[0].x.is_nan() && other(self.items[place], &ray));
            if met {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        flow.is_break()
    }

    /// Nodes of the tree.
    pub fn nodes(&self) -> usize {
        self.tree.nodes()
    }

    /// Bytes of the tree and its leaves.
    pub fn memory(&self) -> usize {
        self.tree.memory()
            + size_of_val(self.triangles.as_slice())
            + size_of_val(self.items.as_slice())
    }
}

/// Every primitive of some shapes.
fn primitives(shapes: &[Geometry]) -> impl Iterator<Item = PrimitiveId> {
    (0..).zip(shapes).flat_map(|(shape, geometry)| {
        let primitives = 0..geometry.primitive_count() as u32;
        primitives.map(move |primitive| PrimitiveId { shape, primitive })
    })
}

/// The vertices of a triangle; not numbers for anything else.
fn vertices(shapes: &[Geometry], item: Item) -> [Vec3; 3] {
    if let Item::Primitive(id) = item
        && let Geometry::Mesh(mesh) = &shapes[id.shape as usize]
    {
        mesh.triangle(id.primitive)
    } else {
        [Vec3::NAN; 3]
    }
}
