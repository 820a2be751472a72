//! Builds the geometries and instances that rays intersect: transformed in double precision, normalised, rounded last.
//!
//! Measure: world units in, normalised units out.
//! Range: a shape farther away than 2^48 times the scene's unit is an error, and so are a triangle with an area above 2^63
//! square units, and an instance whose transform cannot be inverted in single precision.
//! Source: docs/architecture.md. Tested through `prepare.rs` and in `tests/loading/built_scenes.rs`.

use super::description::SceneDescription;
use super::normalisation::Normalisation;
use super::placed::{NormalisedShape, TransformedAttributes, TransformedShape};
use super::placement::{Placement, SceneLayout};
use crate::error::Result;
use crate::geometry::Geometry;
use crate::geometry::mesh::MIN_PER_THREAD;
use crate::geometry::world::Instance;
use crate::math::bounds::Bounds;
use crate::math::vec::DAffine3;
use rayon::prelude::*;

/// The largest distance, in normalised units. Farther away, areas times numbers of primitives overflow single precision,
/// and obvhs builds its trees by these; beyond 2^60, Embree silently omits shapes.
const REACH: f64 = (1_u64 << 48) as f64;

/// Whether the area of a triangle exceeds single precision, in which surface interactions and Embree compute normals.
fn has_huge_triangle(geometry: &Geometry) -> bool {
    let Geometry::Mesh(mesh) = geometry else {
        return false;
    };
    let triangles = (0..mesh.indices().len()).into_par_iter();
    let triangles = triangles.with_min_len(MIN_PER_THREAD);
    triangles.any(|triangle| {
        let [a, b, c] = mesh.triangle(triangle as u32);
        !(b - a).cross(c - a).length_squared().is_finite()
    })
}

fn too_far(name: &str) -> String {
    format!(
        "`{name}` reaches farther than 2^48 times the size of what the scene mostly consists of, or leaves double precision"
    )
}

/// Builds shapes in normalised units, and the forms that their lights need.
///
/// # Errors
/// The first shape that is too far away.
pub fn build_geometry(
    shapes: &[usize],
    placed: &[TransformedShape],
    description: &SceneDescription,
    frame: &Normalisation,
) -> Result<(Vec<Geometry>, Vec<TransformedAttributes>)> {
    let trace = |(&shape, placed): (&usize, &TransformedShape)| {
        let NormalisedShape { geometry, form } = placed.build_geometry(frame);
        if geometry.primitive_count() > 0 && !geometry.bounds().is_within(REACH) {
            let shape = &description.shapes[shape];
            return Err(shape.place.error(too_far(&shape.name)));
        }
        if has_huge_triangle(&geometry) {
            let shape = &description.shapes[shape];
            let why = format!(
                "`{}` has a triangle that is more than 2^32 times as large as what the scene mostly consists of",
                shape.name
            );
            return Err(shape.place.error(why));
        }
        Ok((geometry, form))
    };
    shapes.iter().zip(placed).map(trace).collect()
}

/// Builds all placements in normalised units.
///
/// # Errors
/// The first placement that cannot be traced.
pub fn instances(
    layout: &SceneLayout,
    normalisation: &Normalisation,
    group_normalisations: &[Normalisation],
    groups: &[Vec<Geometry>],
) -> Result<Vec<Instance>> {
    let place = |placement: &Placement| {
        let instance = instance(
            placement,
            normalisation,
            &group_normalisations[placement.group],
        )?;
        let boxes = groups[placement.group].iter().map(Geometry::bounds);
        let boxes = boxes.map(|bounds| instance.bounds_of(&bounds));
        if boxes
            .fold(Bounds::default(), Bounds::union)
            .is_within(REACH)
        {
            return Ok(instance);
        }
        let (name, place) = &placement.object;
        Err(place.error(too_far(name)))
    };
    layout.placements.iter().map(place).collect()
}

/// Builds a placement from the group's normalised units to those of the world, rounded last.
fn instance(
    placement: &Placement,
    world: &Normalisation,
    group: &Normalisation,
) -> Result<Instance> {
    let from_group = group.to_affine().inverse();
    let to_world = world.to_affine();
    let round =
        |m: DAffine3| DAffine3::from_cols_array(&m.to_cols_array().map(|x| f64::from(x as f32)));
    let steps = placement.steps.iter();
    let instance = Instance {
        group: placement.group,
        steps: steps.map(|&m| round(to_world * m * from_group)).collect(),
    };
    if instance.is_invertible() {
        return Ok(instance);
    }
    let (name, place) = &placement.object;
    let message = format!(
        "the transform of {name} cannot be inverted in single precision at all times: it flattens space, is too large or too small for the scene, or turns by half a circle or more from one key to the next"
    );
    Err(place.error(message))
}
