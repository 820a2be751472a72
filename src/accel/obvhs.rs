//! The backend in Rust: an obvhs binary BVH over all primitives, which are intersected in double precision.
//!
//! Measure: normalised scene units.
//! Range: as in `accel/mod.rs`; precision is always robust.
//! Source: obvhs (parallel locally-ordered clustering). Tested in `tests/tracing.rs`.

use super::{Hit, PrimitiveId, primitive};
use crate::geometry::Geometry;
use crate::geometry::world::World;
use crate::math::ray::Ray;
use crate::math::robust::gamma;
use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use obvhs::ray::RayHit;
use std::sync::Arc;
use std::time::Duration;

/// A binary BVH and the primitives in the order of its leaves.
pub struct ObvhsAccel {
    world: Arc<World>,
    bvh: Bvh2,
    primitives: Vec<PrimitiveId>,
}

impl std::fmt::Debug for ObvhsAccel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ObvhsAccel({} primitives)", self.primitives.len())
    }
}

impl ObvhsAccel {
    /// Builds the BVH on rayon's current threads.
    pub fn build(world: Arc<World>) -> Self {
        let mut primitives = Vec::new();
        let mut boxes = Vec::new();
        for (geometry, shape) in (0..).zip(world.geometries()) {
            for primitive in 0..shape.primitive_count() as u32 {
                primitives.push(PrimitiveId {
                    shape: geometry,
                    primitive,
                });
                boxes.push(padded_box(shape, primitive));
            }
        }
        let bvh = build_bvh2(
            &boxes,
            BvhBuildParams::medium_build(),
            &mut Duration::default(),
        );
        let in_leaf_order = bvh
            .primitive_indices
            .iter()
            .map(|&i| primitives[i as usize]);
        let primitives = in_leaf_order.collect();
        Self {
            world,
            bvh,
            primitives,
        }
    }

    /// The closest hit.
    #[inline]
    pub fn intersect(&self, ray: &Ray, _time: f32) -> Option<Hit> {
        if !is_finite(ray) {
            return None;
        }
        let mut closest: Option<Hit> = None;
        self.bvh
            .ray_traverse(to_obvhs(ray), &mut RayHit::none(), |_, index| {
                let id = self.primitives[index];
                let t_max = closest.map_or(ray.t_max, |hit| hit.t);
                match self.intersect_primitive(id, &Ray { t_max, ..*ray }) {
                    Some(hit) if closest.is_none_or(|best| hit.t < best.t) => {
                        closest = Some(hit);
                        hit.t
                    }
                    _ => f32::INFINITY,
                }
            });
        closest
    }

    /// Whether anything lies on the ray; stops at the first hit found.
    #[inline]
    pub fn occluded(&self, ray: &Ray, _time: f32) -> bool {
        is_finite(ray)
            && !self.bvh.ray_traverse_miss(to_obvhs(ray), |_, index| {
                self.intersect_primitive(self.primitives[index], ray)
                    .map_or(f32::INFINITY, |_| 0.0)
            })
    }

    /// Bytes of the BVH and of the list of primitives.
    pub fn memory(&self) -> usize {
        size_of_val(self.bvh.nodes.as_slice())
            + size_of_val(self.bvh.primitive_indices.as_slice())
            + size_of_val(self.primitives.as_slice())
    }

    #[inline]
    fn intersect_primitive(&self, id: PrimitiveId, ray: &Ray) -> Option<Hit> {
        let shape = self.world.geometry(id.shape);
        let (t, uv) = primitive::intersect(shape, id.primitive, ray)?;
        Some(Hit {
            id,
            t: t as f32,
            uv: uv.map(|x| x as f32),
        })
    }
}

/// The primitive's box, widened by what rounding can take away from it in a box test.
fn padded_box(shape: &Geometry, primitive: u32) -> Aabb {
    let bounds = shape.primitive_bounds(primitive);
    let (min, max) = (bounds.min.as_vec3a(), bounds.max.as_vec3a());
    let padding = gamma(8) * min.abs().max(max.abs()).max_element() + f32::MIN_POSITIVE;
    Aabb::new(min - Vec3A::splat(padding), max + Vec3A::splat(padding))
}

#[inline]
fn is_finite(ray: &Ray) -> bool {
    ray.origin.is_finite() && ray.dir.is_finite()
}

/// obvhs looks for hits before the end of the ray, we also at the end.
#[inline]
fn to_obvhs(ray: &Ray) -> obvhs::ray::Ray {
    obvhs::ray::Ray::new(
        ray.origin.into(),
        ray.dir.into(),
        ray.t_min,
        ray.t_max.next_up(),
    )
}
