//! Extents: the boxes that determine a scene's normalisation, and its bounding sphere.
//!
//! Measure: world units in double precision, or normalised units as stated at each item.
//! Range: any shapes; without shapes, the radius is 1.
//! Source: none needed. Tested through `prepare.rs` and `normalisation.rs`.

use super::medians::PrimitiveBoxes;
use super::normalisation::Normalisation;
use super::placed::TransformedShape;
use super::placement::SceneLayout;
use crate::geometry::Geometry;
use crate::geometry::mesh::MIN_PER_THREAD;
use crate::geometry::world::World;
use crate::light::types::BoundingSphere;
use crate::math::bounds::Bounds;
use crate::math::vec::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// The boxes of all primitives, which are computed again for each use, as they would take much memory; for an instance, one box
/// per shape.
pub struct SceneBoxes<'a> {
    shapes: &'a [TransformedShape],
    instances: Vec<Bounds>,
}

impl<'a> SceneBoxes<'a> {
    /// Returns the boxes of a scene.
    pub fn new(
        roots: &'a [TransformedShape],
        groups: &[Vec<TransformedShape>],
        layout: &SceneLayout,
    ) -> Self {
        let of_group = |group: &Vec<TransformedShape>| -> Vec<Bounds> {
            let boxes = group.iter().map(TransformedShape::bounds);
            boxes.filter(|bounds| !bounds.is_empty()).collect()
        };
        let of_groups: Vec<Vec<Bounds>> = groups.iter().map(of_group).collect();
        let of_instances = layout.placements.iter().flat_map(|placement| {
            let shapes = &of_groups[placement.group];
            shapes.iter().map(|bounds| {
                let moved = placement.steps.iter().map(|step| bounds.transformed(step));
                moved.fold(Bounds::default(), Bounds::union)
            })
        });
        Self {
            shapes: roots,
            instances: of_instances.collect(),
        }
    }
}

impl PrimitiveBoxes for SceneBoxes<'_> {
    fn count(&self) -> usize {
        let counts = self.shapes.iter().map(TransformedShape::primitive_count);
        counts.sum::<usize>() + self.instances.len()
    }

    fn sample(&self, every: usize) -> Vec<Bounds> {
        let of_shape = |shape: &TransformedShape| {
            let primitives = (0..shape.primitive_count()).step_by(every);
            let boxes = primitives.map(|primitive| shape.primitive_bounds(primitive));
            boxes.collect::<Vec<_>>()
        };
        let of_shapes = self.shapes.iter().flat_map(of_shape);
        let all = of_shapes.chain(self.instances.iter().step_by(every).copied());
        all.filter(|bounds| !bounds.is_empty()).collect()
    }

    fn fold<T: Send>(
        &self,
        new: impl Fn() -> T + Sync,
        add: impl Fn(&mut T, &Bounds) + Sync,
        merge: impl Fn(&mut T, T),
    ) -> T {
        let mut all = new();
        self.instances
            .iter()
            .for_each(|bounds| add(&mut all, bounds));
        for shape in self.shapes {
            let add_part = |sum: &mut T, primitives: Range<usize>| {
                for primitive in primitives {
                    let bounds = shape.primitive_bounds(primitive);
                    if !bounds.is_empty() {
                        add(sum, &bounds);
                    }
                }
            };
            let count = shape.primitive_count();
            if count < MIN_PER_THREAD {
                add_part(&mut all, 0..count);
                continue;
            }
            let parts = (0..count.div_ceil(MIN_PER_THREAD)).into_par_iter();
            let of_part = |part: usize| {
                let start = part * MIN_PER_THREAD;
                let mut sum = new();
                add_part(&mut sum, start..count.min(start + MIN_PER_THREAD));
                sum
            };
            let sums: Vec<T> = parts.map(of_part).collect();
            sums.into_iter().for_each(|sum| merge(&mut all, sum));
        }
        all
    }
}

/// Returns the sphere through the corners of the bounding box of everything that rays can hit.
pub fn bounding_sphere(world: &World) -> BoundingSphere {
    let bounds_of = |shapes: &[Geometry]| -> Vec<Bounds> {
        let not_empty = shapes.iter().filter(|shape| shape.primitive_count() > 0);
        not_empty.map(Geometry::bounds).collect()
    };
    let mut boxes = bounds_of(world.geometries());
    for instance in world.instances() {
        let shapes = bounds_of(&world.groups()[instance.group]);
        boxes.extend(shapes.iter().map(|bounds| instance.bounds_of(bounds)));
    }
    let whole = boxes.iter().fold(Bounds::default(), |all, b| all.union(*b));
    if whole.is_empty() {
        return BoundingSphere {
            center: Vec3::ZERO,
            radius: 1.0,
        };
    }
    BoundingSphere {
        center: whole.centre().as_vec3a(),
        radius: (0.5 * whole.extent().length()) as f32,
    }
}

/// Returns half the diagonal of the box around everything, in normalised units; 1 if it is empty.
pub fn radius(whole: &Bounds, normalisation: &Normalisation) -> f64 {
    if whole.is_empty() {
        return 1.0;
    }
    f64::from(normalisation.length(0.5 * whole.extent().length()))
}

/// Returns the normalisation of a group.
pub fn frame_of(group: &[TransformedShape]) -> Normalisation {
    let boxes = SceneBoxes {
        shapes: group,
        instances: vec![],
    };
    Normalisation::of(&boxes).0
}
