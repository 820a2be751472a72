//! The leaves of a binary tree that a ray comes through, the nearer child first.
//!
//! Measure: as of the boxes; parameters as of `BoxRay`.
//! Range: any tree.
//! Source: obvhs for the nodes; Pharr, Jakob, Humphreys, section 6.8.2 for the rounding of the test. Tested in
//! `tests/tracing/rays.rs` and `tests/tracing/hard.rs`.

use super::box_ray::BoxRay;
use super::stack::Stack;
use crate::math::robust::gamma;
use crate::planted::planted;
use obvhs::bvh2::node::Bvh2Node;
use std::ops::ControlFlow;

/// Visits the primitives of every leaf whose box the ray meets, until told to stop.
#[inline(always)]
pub fn traverse(
    nodes: &[Bvh2Node],
    ray: &mut BoxRay,
    mut visit: impl FnMut(usize, &mut f32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    // Whether there is more to do in a node that the ray comes into here: what is in a leaf is visited at once.
    let mut descends = |(node, near): (&Bvh2Node, f32), ray: &mut BoxRay| {
        if near > ray.t_max {
            return ControlFlow::Continue(false);
        }
        for place in node.first_index..node.first_index + node.prim_count {
            visit(place as usize, &mut ray.t_max)?;
        }
        ControlFlow::Continue(!node.is_leaf())
    };
    let Some(root) = nodes.first() else {
        return ControlFlow::Continue(());
    };
    if !descends((root, enters(root, ray)), ray)? {
        return ControlFlow::Continue(());
    }
    let mut first = root.first_index;
    let mut stack = Stack::<_, 24>::new();
    loop {
        let children = &nodes[first as usize..][..2];
        let mut nearer = (&children[0], enters(&children[0], ray));
        let mut farther = (&children[1], enters(&children[1], ray));
        if farther.1 < nearer.1 {
            (nearer, farther) = (farther, nearer);
        }
        let (into_nearer, into_farther) = (descends(nearer, ray)?, descends(farther, ray)?);
        first = match (into_nearer, into_farther) {
            (true, true) => {
                stack.push((farther.0.first_index, farther.1));
                nearer.0.first_index
            }
            (true, false) => nearer.0.first_index,
            (false, true) => farther.0.first_index,
            (false, false) => loop {
                let Some((first, near)) = stack.pop() else {
                    return ControlFlow::Continue(());
                };
                if near <= ray.t_max {
                    break first;
                }
            },
        };
    }
}

/// Where the ray comes into a node's box, or infinity, which is beyond its end, if it passes.
#[inline(always)]
fn enters(node: &Bvh2Node, ray: &BoxRay) -> f32 {
    // Three roundings for where the ray comes in; one more, that of the slack, for where it goes out.
    const SLACK: f32 = 1.0 + 2.0 * gamma(4);
    let bounds = node.aabb();
    let (to_min, to_max) = (bounds.min - ray.origin, bounds.max - ray.origin);
    let outward = ray.inverse * planted!("box-without-slack", 1.0, SLACK);
    let mut near = (to_min * ray.inverse).min(to_max * ray.inverse);
    let mut far = (to_min * outward).max(to_max * outward);
    if ray.is_parallel {
        (near, far) = (near - ray.slack, far + ray.slack);
    }
    let (near, far) = (near.max_element(), far.min_element());
    // Both at once: a branch on either would often be guessed wrongly.
    if (near <= far) & (ray.t_min <= far) {
        near
    } else {
        f32::INFINITY
    }
}
