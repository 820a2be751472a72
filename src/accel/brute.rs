//! Brute-force intersection of every primitive in double precision: the reference that the tests compare the backends
//! with.
//!
//! Measure: normalised scene units; time from 0 to 1.
//! Range: any scene, in time proportional to the number of its primitives.
//! Source: none needed. Tested in `tests/tracing/rays.rs`.

use super::primitive::{self, DRay};
use super::{Hit, PrimitiveId};
use crate::geometry::Geometry;
use crate::geometry::world::World;
use crate::math::ray::Ray;

/// Finds the closest hit among all primitives at a time of the shutter; of several at the same distance, the first.
pub fn intersect(world: &World, ray: &Ray, time: f32) -> Option<Hit> {
    let ray = DRay::from(ray);
    let mut closest = closest_among(world.geometries(), 0, &ray);
    for (number, instance) in world.instances().iter().enumerate() {
        let shapes = &world.groups()[instance.group];
        let local = ray.transformed(&instance.at(time).inverse());
        let hit = closest_among(shapes, world.first_shape(number), &local);
        if let Some((t, _)) = hit
            && closest.is_none_or(|(best, _)| t < best)
        {
            closest = hit;
        }
    }
    closest.map(|(_, hit)| hit)
}

/// Whether any primitive occludes the ray at a time of the shutter.
pub fn occluded(world: &World, ray: &Ray, time: f32) -> bool {
    intersect(world, ray, time).is_some()
}

/// Finds the closest hit on shapes numbered from `first_shape`, with its parameter in double precision.
fn closest_among(shapes: &[Geometry], first_shape: u32, ray: &DRay) -> Option<(f64, Hit)> {
    let mut closest: Option<(f64, Hit)> = None;
    for (number, shape) in (first_shape..).zip(shapes) {
        for primitive in 0..shape.primitive_count() as u32 {
            let Some((t, uv)) = primitive::intersect(shape, primitive, ray) else {
                continue;
            };
            if closest.is_none_or(|(best, _)| t < best) {
                let id = PrimitiveId {
                    shape: number,
                    primitive,
                };
                let hit = Hit {
                    id,
                    t: t as f32,
                    uv: uv.map(|x| x as f32),
                };
                closest = Some((t, hit));
            }
        }
    }
    closest
}
