//! Extents: the boxes that determine a scene's normalisation, and its bounding sphere.
//!
//! Measure: world units in double precision, or normalised units as stated at each item.
//! Range: any shapes; without shapes, the radius is 1.
//! Source: none needed. Tested through `prepare.rs` and `normalisation.rs`.

use super::normalisation::Normalisation;
use super::placed::TransformedShape;
use super::placement::SceneLayout;
use crate::geometry::Geometry;
use crate::geometry::world::World;
use crate::light::types::BoundingSphere;
use crate::math::bounds::Bounds;
use crate::math::vec::Vec3;

/// Returns the boxes of all primitives; for an instance, one box per shape.
pub fn boxes(
    roots: &[TransformedShape],
    groups: &[Vec<TransformedShape>],
    layout: &SceneLayout,
) -> Vec<Bounds> {
    let whole = |placed: &TransformedShape| {
        let boxes = placed.boxes().into_iter();
        boxes.fold(Bounds::default(), Bounds::union)
    };
    let of_groups: Vec<Vec<Bounds>> = groups
        .iter()
        .map(|group| group.iter().map(whole).filter(|b| !b.is_empty()).collect())
        .collect();
    let of_instances = layout.placements.iter().flat_map(|placement| {
        let shapes = &of_groups[placement.group];
        shapes.iter().map(|bounds| {
            let moved = placement.steps.iter().map(|step| bounds.transformed(step));
            moved.fold(Bounds::default(), Bounds::union)
        })
    });
    roots
        .iter()
        .flat_map(TransformedShape::boxes)
        .chain(of_instances)
        .collect()
}

/// Returns half the diagonal of the bounding box of everything, in normalised units.
pub fn scene_radius(boxes: &[Bounds], normalisation: &Normalisation) -> f64 {
    let whole = boxes.iter().fold(Bounds::default(), |all, b| all.union(*b));
    if whole.is_empty() {
        return 1.0;
    }
    f64::from(normalisation.length(0.5 * whole.extent().length()))
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

/// Returns the normalisation of a group.
pub fn frame_of(group: &[TransformedShape]) -> Normalisation {
    let boxes: Vec<Bounds> = group.iter().flat_map(TransformedShape::boxes).collect();
    Normalisation::of(&boxes)
}
