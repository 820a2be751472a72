//! A tree of boxes with items in them, and which of them a ray has to be tried against.
//!
//! The boxes are tested in single precision with a ray in double precision. What that loses is made up for by wider
//! boxes, by beginning where the ray comes into the tree, and by a direction whose largest entry is about one.
//!
//! Measure: any unit of length; parameters in multiples of the direction's length.
//! Range: finite rays; boxes that are not empty.
//! Source: obvhs; error of the box test as in Pharr, Jakob, Humphreys, section 6.8.2. Tested in `tests/tracing.rs` and
//! `tests/tracing_instances.rs`.

use super::primitive::DRay;
use crate::math::bounds::Bounds;
use crate::math::robust::gamma;
use crate::math::vec::DVec3;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use obvhs::ray::RayHit;
use std::time::Duration;

/// A binary BVH and its items in the order of its leaves.
pub struct BoxTree<T> {
    bvh: Bvh2,
    items: Vec<T>,
}

impl<T> std::fmt::Debug for BoxTree<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "BoxTree({} items)", self.items.len())
    }
}

impl<T: Copy> BoxTree<T> {
    /// A tree for rays whose origin is a single-precision number.
    pub fn new(items: impl Iterator<Item = (T, Bounds)>) -> Self {
        Self::padded(items, |bounds| {
            f64::from(gamma(8)) * largest_coordinate(bounds)
        })
    }

    /// A tree for rays that are clipped to these bounds, which hold all items.
    pub fn new_within(bounds: &Bounds, items: impl Iterator<Item = (T, Bounds)>) -> Self {
        let padding = f64::from(gamma(16)) * largest_coordinate(bounds);
        Self::padded(items, |_| padding)
    }

    fn padded(items: impl Iterator<Item = (T, Bounds)>, padding: impl Fn(&Bounds) -> f64) -> Self {
        let (items, boxes): (Vec<T>, Vec<Aabb>) = items
            .map(|(item, bounds)| {
                let padding = DVec3::splat(padding(&bounds) + f64::from(f32::MIN_POSITIVE));
                let (min, max) = (bounds.min - padding, bounds.max + padding);
                let widened = Aabb::new(min.as_vec3a().into(), max.as_vec3a().into());
                (item, widened)
            })
            .unzip();
        let parameters = BvhBuildParams::medium_build();
        let bvh = build_bvh2(&boxes, parameters, &mut Duration::default());
        let order = bvh.primitive_indices.iter();
        let items = order.map(|&i| items[i as usize]).collect();
        Self { bvh, items }
    }

    /// The closest of the hits that `meet` finds on an item with a ray that ends at the closest so far. Boxes before
    /// `start` along the ray do not count.
    #[inline]
    pub fn closest<H: Copy>(
        &self,
        ray: &DRay,
        start: f64,
        mut meet: impl FnMut(T, &DRay) -> Option<(f64, H)>,
    ) -> Option<(f64, H)> {
        let (query, unit) = single(ray, start);
        let mut ray = *ray;
        let mut closest: Option<(f64, H)> = None;
        self.bvh
            .ray_traverse(query, &mut RayHit::none(), |_, index| {
                match meet(self.items[index], &ray) {
                    Some((t, hit)) if closest.is_none_or(|(best, _)| t < best) => {
                        closest = Some((t, hit));
                        ray.t_max = t;
                        ((t - start) * unit) as f32
                    }
                    _ => f32::INFINITY,
                }
            });
        closest
    }

    /// Whether any item satisfies `meets`, of those whose boxes the ray meets after `start`.
    #[inline]
    pub fn any(&self, ray: &DRay, start: f64, mut meets: impl FnMut(T) -> bool) -> bool {
        let (query, _) = single(ray, start);
        !self.bvh.ray_traverse_miss(query, |_, index| {
            if meets(self.items[index]) {
                f32::NEG_INFINITY
            } else {
                f32::INFINITY
            }
        })
    }

    /// Nodes of the BVH.
    pub fn nodes(&self) -> usize {
        self.bvh.nodes.len()
    }

    /// Bytes of the BVH and of the list of items.
    pub fn memory(&self) -> usize {
        size_of_val(self.bvh.nodes.as_slice())
            + size_of_val(self.bvh.primitive_indices.as_slice())
            + size_of_val(self.items.as_slice())
    }
}

/// Where a ray comes into a box, or its own beginning within; `None` if it passes.
pub fn clip(ray: &DRay, bounds: &Bounds) -> Option<f64> {
    // Rounding in double precision is far below this.
    let padding = DVec3::splat(f64::from(gamma(1)) * largest_coordinate(bounds));
    let near = (bounds.min - padding - ray.origin) / ray.dir;
    let far = (bounds.max + padding - ray.origin) / ray.dir;
    let (mut from, mut to) = (ray.t_min, ray.t_max);
    for axis in 0..3 {
        // Along an axis without direction a quotient is infinite, or no number, which min and max leave aside.
        from = from.max(near[axis].min(far[axis]));
        to = to.min(near[axis].max(far[axis]));
    }
    (from <= to && from.is_finite()).then_some(from)
}

fn largest_coordinate(bounds: &Bounds) -> f64 {
    bounds.min.abs().max(bounds.max.abs()).max_element()
}

/// The ray from `start` in single precision, and what its parameter grows by for one of ours: a power of two, so that
/// the numbers of a ray that is in single precision already stay as they are. obvhs takes entries of the direction below
/// 2^-23 for 0. It looks for hits before the end of the ray, we also at the end.
#[inline]
fn single(ray: &DRay, start: f64) -> (obvhs::ray::Ray, f64) {
    let exponent_bits = f64::INFINITY.to_bits();
    let unit = f64::from_bits(ray.dir.abs().max_element().to_bits() & exponent_bits);
    let unit = if unit > 0.0 { unit } else { 1.0 };
    let origin = ray.origin + start * ray.dir;
    let query = obvhs::ray::Ray::new(
        origin.as_vec3a().into(),
        (ray.dir / unit).as_vec3a().into(),
        (((ray.t_min - start) * unit) as f32).next_down(),
        (((ray.t_max - start) * unit) as f32).next_up(),
    );
    (query, unit)
}
