//! The backend in Rust: BVHs with two or eight children per node, built by obvhs and traversed here.
//!
//! There are two levels: a tree over the top-level primitives and the instances, and one tree per group, in which rays
//! are traced in the group's units. In robust precision triangles are intersected in double precision, and no ray
//! passes between two that share an edge or a vertex; in fast precision they are intersected in single precision.
//! Spheres, disks and the transform into an instance use double precision in both modes. Neither mode misses a box that
//! the exact ray hits.
//!
//! Measure: normalised scene units.
//! Range: as in `accel/mod.rs`, with coordinates up to 1e18 in magnitude.
//! Source: obvhs. Tested in `tests/tracing/rays.rs`, `tests/tracing/hard.rs` and `tests/tracing/instance_rays.rs`.

mod binary;
mod box_ray;
mod box_tree;
mod level;
mod stack;
mod trace_ray;
mod wide;

use super::primitive::{self, DRay};
use super::{AccelOptions, Backend, Hit, Precision, PrimitiveId};
use crate::error::{Error, Result};
use crate::geometry::Geometry;
use crate::geometry::world::World;
use crate::math::bounds::Bounds;
use crate::math::ray::Ray;
use box_ray::clip;
use box_tree::NodeLayout;
use level::{BvhItem, Level, TreeOptions};
use std::sync::Arc;
use trace_ray::{TraceRay, WatertightRay};

/// The trees over the world and over each group.
#[derive(Debug)]
pub struct ObvhsAccel {
    world: Arc<World>,
    root: Level,
    /// The trees of the groups, shared by structures over worlds with the same groups.
    groups: Arc<[GroupAccel]>,
    options: AccelOptions,
    precision: Precision,
}

/// The tree of a group.
#[derive(Debug)]
struct GroupAccel {
    bounds: Bounds,
    level: Level,
}

impl ObvhsAccel {
    /// Builds all trees.
    ///
    /// # Errors
    /// If the threads cannot be created.
    pub fn build(world: Arc<World>, options: AccelOptions) -> Result<Self> {
        on_threads(options.threads, || Self::build_here(world, options))
    }

    /// Builds the trees on rayon's current threads.
    fn build_here(world: Arc<World>, options: AccelOptions) -> Self {
        let tree_options = tree_options(options);
        let groups = world.groups().iter();
        let groups = groups.map(|g| GroupAccel::new(g, tree_options)).collect();
        Self::over(groups, world, options)
    }

    /// Builds the structure over a world that shares its shapes with the current one. The trees of groups are reused.
    ///
    /// # Errors
    /// If the threads cannot be created.
    pub fn with_instances_of(&self, world: Arc<World>) -> Result<Self> {
        let groups = Arc::clone(&self.groups);
        on_threads(self.options.threads, || {
            Self::over(groups, world, self.options)
        })
    }

    /// Builds the top-level tree.
    fn over(groups: Arc<[GroupAccel]>, world: Arc<World>, options: AccelOptions) -> Self {
        let numbers = 0..world.instances().len();
        let instances = numbers.map(|i| (i as u32, world.instance_bounds(i)));
        let occupied: Vec<_> = instances.filter(|(_, b)| !b.is_empty()).collect();
        Self {
            root: Level::new(world.geometries(), &occupied, tree_options(options)),
            groups,
            world,
            options,
            precision: options.precision,
        }
    }

    /// Finds the closest hit.
    #[inline]
    pub fn intersect(&self, ray: &Ray, time: f32) -> Option<Hit> {
        if !ray.is_finite() {
            return None;
        }
        match self.precision {
            Precision::Robust => self.closest(WatertightRay::narrow(&ray.into()), time),
            Precision::Fast => self.closest(*ray, time),
        }
    }

    /// Whether the ray is occluded; stops at the first hit found.
    #[inline]
    pub fn occluded(&self, ray: &Ray, time: f32) -> bool {
        if !ray.is_finite() {
            return false;
        }
        match self.precision {
            Precision::Robust => self.any(WatertightRay::narrow(&ray.into()), time),
            Precision::Fast => self.any(*ray, time),
        }
    }

    /// The number of bytes of the trees and their leaves.
    pub fn memory(&self) -> usize {
        let groups = self.groups.iter().map(|group| group.level.memory());
        self.root.memory() + groups.sum::<usize>()
    }

    /// The number of nodes of all trees.
    pub fn nodes(&self) -> usize {
        let groups = self.groups.iter().map(|group| group.level.nodes());
        self.root.nodes() + groups.sum::<usize>()
    }

    /// Finds the closest hit. Not inlined, so that the code of each precision is allocated registers on its own.
    #[inline(never)]
    fn closest<R: TraceRay>(&self, ray: R, time: f32) -> Option<Hit> {
        let closest = self.root.closest(ray, 0.0, |item, ray| match item {
            BvhItem::Primitive(id) => {
                intersect_primitive(self.world.geometries(), id, &ray.widen())
            }
            BvhItem::Instance(instance) => self.closest_in(instance, ray, time),
        });
        closest.map(|(_, hit)| hit)
    }

    #[inline(never)]
    fn any<R: TraceRay>(&self, ray: R, time: f32) -> bool {
        self.root.occluded(ray, 0.0, |item, ray| match item {
            BvhItem::Primitive(id) => {
                intersect_primitive(self.world.geometries(), id, &ray.widen()).is_some()
            }
            BvhItem::Instance(instance) => self.any_in(instance, ray, time),
        })
    }

    /// Finds the closest hit on an instance, with its parameter in double precision. Not inlined, to keep the top-level
    /// traversal loop small.
    #[inline(never)]
    fn closest_in<R: TraceRay>(&self, instance: u32, ray: &R, time: f32) -> Option<(f64, Hit)> {
        let (group, shapes, ray, start) = self.enter(instance, ray, time)?;
        let closest = group.level.closest(ray, start, |item, ray| match item {
            BvhItem::Primitive(id) => intersect_primitive(shapes, id, &ray.widen()),
            BvhItem::Instance(_) => None,
        });
        let first_shape = self.world.first_shape(instance as usize);
        closest.map(|(t, mut hit)| {
            hit.id.shape += first_shape;
            (t, hit)
        })
    }

    /// Whether an instance occludes the ray.
    #[inline(never)]
    fn any_in<R: TraceRay>(&self, instance: u32, ray: &R, time: f32) -> bool {
        let Some((group, shapes, ray, start)) = self.enter(instance, ray, time) else {
            return false;
        };
        group.level.occluded(ray, start, |item, ray| match item {
            BvhItem::Primitive(id) => intersect_primitive(shapes, id, &ray.widen()).is_some(),
            BvhItem::Instance(_) => false,
        })
    }

    /// The group of an instance, its shapes, the ray in its units, and the parameter at which the ray enters its
    /// bounds.
    #[inline]
    fn enter<R: TraceRay>(
        &self,
        instance: u32,
        ray: &R,
        time: f32,
    ) -> Option<(&GroupAccel, &[Geometry], R, f64)> {
        let instance = &self.world.instances()[instance as usize];
        let group = &self.groups[instance.group];
        let ray = ray.widen().transformed(&instance.at(time).inverse());
        let start = clip(&ray, &group.bounds)?;
        let shapes = &self.world.groups()[instance.group];
        Some((group, shapes, R::narrow(&ray), start))
    }
}

impl GroupAccel {
    fn new(shapes: &[Geometry], options: TreeOptions) -> Self {
        let boxes = shapes.iter().map(Geometry::bounds);
        let bounds = boxes.fold(Bounds::default(), Bounds::union);
        Self {
            level: Level::within(&bounds, shapes, options),
            bounds,
        }
    }
}

fn tree_options(options: AccelOptions) -> TreeOptions {
    TreeOptions {
        layout: match options.backend {
            Backend::ObvhsCwbvh => NodeLayout::Wide,
            _ => NodeLayout::Binary,
        },
        quality: options.quality(),
    }
}

/// Runs work on this many threads: on rayon's current threads if their number matches, else on new ones.
fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> Result<T> {
    if rayon::current_thread_index().is_some() && rayon::current_num_threads() == threads {
        return Ok(work());
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Error::render(format!("no threads to build on: {error}")))?;
    Ok(pool.install(work))
}

/// Intersects any primitive in double precision. Not inlined, to keep the loop over triangles small.
#[inline(never)]
fn intersect_primitive(shapes: &[Geometry], id: PrimitiveId, ray: &DRay) -> Option<(f64, Hit)> {
    let (t, uv) = primitive::intersect(&shapes[id.shape as usize], id.primitive, ray)?;
    let hit = Hit {
        id,
        t: t as f32,
        uv: uv.map(|x| x as f32),
    };
    Some((t, hit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn on_threads_uses_requested_count_and_reuses_a_nested_pool() {
        for threads in [1, 3] {
            let used = on_threads(threads, rayon::current_num_threads).expect("a few threads");
            assert_eq!(used, threads);
            let within = on_threads(threads, || {
                let outer = rayon::current_thread_index();
                on_threads(threads, || (outer, rayon::current_thread_index()))
            });
            let (outer, inner) = within.and_then(|inner| inner).expect("a few threads");
            assert!(
                outer.is_some() && outer == inner,
                "a pool within a pool of its size"
            );
        }
    }
}
