//! Traversal of a compressed BVH with eight children per node by a ray, roughly front to back.
//!
//! The boxes of a node's children are stored with 8 bits per plane, as multiples of a power of two from the lowest
//! corner of the node. obvhs's own box test starts at the parameter 10^-4, regardless of the unit of length, and treats
//! -0 in a direction as positive in one place and as negative in another. This test does neither, and bounds its
//! rounding error.
//!
//! Measure: the unit of the boxes; ray parameters as in `BoxRay`.
//! Range: any tree with coordinates up to 1e18 in magnitude.
//! Source: Ylitie, Karras and Laine 2017 for the layout and the order; obvhs for the nodes. Tested in `tests/tracing/rays.rs`
//! and `tests/tracing/hard.rs`.

use super::box_ray::BoxRay;
use super::stack::Stack;
use crate::math::robust::gamma;
use glam::{Vec3A, Vec4};
use obvhs::cwbvh::node::CwBvhNode;
use std::ops::ControlFlow;

/// The bits of a hit mask for children that are inner nodes; the lower bits are for primitives.
const INNER: u32 = 0xff00_0000;

/// The children of one node that are still to be visited.
#[derive(Debug, Clone, Copy, Default)]
struct PendingChildren {
    /// The index of the node's first child.
    base: u32,
    /// One bit for each child that is an inner node, by child slot.
    places: u8,
    /// One bit for each child to be visited; the highest bit is visited first.
    waiting: u32,
}

/// Visits the primitives of every leaf whose box the ray hits, until the visitor breaks.
#[inline(always)]
pub fn traverse(
    nodes: &[CwBvhNode],
    ray: &mut BoxRay,
    mut visit: impl FnMut(usize, &mut f32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let Some(mut node) = nodes.first() else {
        return ControlFlow::Continue(());
    };
    let octant = octant(ray);
    let mut stack = Stack::<_, 12>::new();
    loop {
        let hits = hits(node, ray, octant);
        let mut primitives = hits & !INNER;
        while primitives != 0 {
            let offset = primitives.trailing_zeros();
            primitives &= primitives - 1;
            visit((node.primitive_base_idx + offset) as usize, &mut ray.t_max)?;
        }
        let mut group = PendingChildren {
            base: node.child_base_idx,
            places: node.imask,
            waiting: hits & INNER,
        };
        if group.waiting == 0 {
            group = match stack.pop() {
                Some(earlier) => earlier,
                None => return ControlFlow::Continue(()),
            };
        }
        let first = u32::BITS - 1 - group.waiting.leading_zeros();
        group.waiting ^= 1 << first;
        if group.waiting != 0 {
            stack.push(group);
        }
        let place = (first - 24) ^ octant;
        let before = (u32::from(group.places) & ((1 << place) - 1)).count_ones();
        node = &nodes[(group.base + before) as usize];
    }
}

/// The mask that is XORed with child slots so that the child to be visited first has the highest slot.
#[inline(always)]
fn octant(ray: &BoxRay) -> u32 {
    let positive = ray.inverse.cmpge(Vec3A::ZERO).bitmask();
    // The x axis has the highest bit.
    (positive & 1) << 2 | (positive & 2) | (positive & 4) >> 2
}

/// The children that the ray hits: one bit for each primitive of a leaf, and one for each inner node.
#[inline(always)]
fn hits(node: &CwBvhNode, ray: &BoxRay, octant: u32) -> u32 {
    let (bits, shifts) = node.get_child_and_index_bits(octant * 0x0101_0101);
    let child_hits = children_hit(node, ray);
    // All children, hit or not: a loop over the hit children costs more in mispredicted branches.
    let of_child = |child: u32| {
        let mask = 0u32.wrapping_sub(child_hits >> child & 1);
        let bits = (bits >> (8 * child)) as u32 & 0xff;
        (bits & mask) << (shifts >> (8 * child) & 0x1f)
    };
    (0..8).fold(0, |hits, child| hits | of_child(child))
}

/// One bit for each child whose box the ray hits.
#[inline(always)]
fn children_hit(node: &CwBvhNode, ray: &BoxRay) -> u32 {
    let unit = node.compute_extent();
    let offset = Vec3A::from(node.p) - ray.origin;
    // Up to ten roundings in the planes and in their parameters. The power of two is chosen by a logarithm, whose
    // rounding can make it too small by the equivalent of another 22.
    let relative = gamma(32) * ray.inverse.abs();
    let slack = offset.abs() * relative + (unit * (255.0 * relative) + ray.slack);
    let scale = unit * ray.inverse;
    let shift = offset * ray.inverse;
    let (near, far) = (shift - slack, shift + slack);
    let backwards = ray.inverse.cmplt(Vec3A::ZERO);
    let order = |axis, low, high| match backwards.test(axis) {
        true => (high, low),
        false => (low, high),
    };
    let (near_x, far_x) = order(0, &node.child_min_x, &node.child_max_x);
    let (near_y, far_y) = order(1, &node.child_min_y, &node.child_max_y);
    let (near_z, far_z) = order(2, &node.child_min_z, &node.child_max_z);
    let half = |half: usize| {
        let at = |planes: &[u8; 8], scale: f32, shift: f32| {
            let four: [f32; 4] = std::array::from_fn(|i| f32::from(planes[4 * half + i]));
            Vec4::from_array(four) * scale + shift
        };
        let from = at(near_x, scale.x, near.x)
            .max(at(near_y, scale.y, near.y))
            .max(at(near_z, scale.z, near.z))
            .max(Vec4::splat(ray.t_min));
        let to = at(far_x, scale.x, far.x)
            .min(at(far_y, scale.y, far.y))
            .min(at(far_z, scale.z, far.z))
            .min(Vec4::splat(ray.t_max));
        from.cmple(to).bitmask()
    };
    half(0) | half(1) << 4
}
