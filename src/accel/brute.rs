//! Every primitive tried in turn, in double precision: the oracle that tests hold the backends against.
//!
//! Measure: normalised scene units.
//! Range: any scene, in time proportional to its primitives.
//! Source: none needed. Tested in `tests/tracing.rs`.

use super::{Hit, PrimitiveId, primitive};
use crate::geometry::Geometry;
use crate::math::ray::Ray;

/// The closest hit among all primitives; of several at the same distance the first.
pub fn intersect(geometries: &[Geometry], ray: &Ray) -> Option<Hit> {
    let mut closest: Option<(f64, Hit)> = None;
    for (geometry, shape) in (0..).zip(geometries) {
        for primitive in 0..shape.primitive_count() as u32 {
            let Some((t, uv)) = primitive::intersect(shape, primitive, ray) else {
                continue;
            };
            if closest.is_none_or(|(best, _)| t < best) {
                let id = PrimitiveId {
                    shape: geometry,
                    primitive,
                };
                closest = Some((
                    t,
                    Hit {
                        id,
                        t: t as f32,
                        uv: uv.map(|x| x as f32),
                    },
                ));
            }
        }
    }
    closest.map(|(_, hit)| hit)
}

/// Whether any primitive lies on the ray.
pub fn occluded(geometries: &[Geometry], ray: &Ray) -> bool {
    intersect(geometries, ray).is_some()
}
