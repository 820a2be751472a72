//! Traversal of a binary BVH by a ray, the nearer child first.
//!
//! Measure: the unit of the boxes; ray parameters as in `BoxRay`.
//! Range: any tree.
//! Source: obvhs for the nodes; Pharr, Jakob, Humphreys, section 6.8.2 for the rounding of the test. Tested in
//! `tests/tracing/rays.rs` and `tests/tracing/hard.rs`.

use super::box_ray::BoxRay;
use super::stack::Stack;
use crate::math::robust::gamma;
use crate::planted::planted;
use obvhs::bvh2::node::Bvh2Node;
use std::ops::ControlFlow;

/// Visits the primitives of every leaf whose box the ray hits, until the visitor breaks.
#[inline(always)]
pub fn traverse(
    nodes: &[Bvh2Node],
    ray: &mut BoxRay,
    mut visit: impl FnMut(usize, &mut f32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    // Whether to descend into a node that the ray enters at `near`; the primitives of a leaf are visited immediately.
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

/// The parameter at which the ray enters a node's box; infinity, which is beyond the end of the ray, for a miss.
#[inline(always)]
fn enters(node: &Bvh2Node, ray: &BoxRay) -> f32 {
    // Three roundings in the entry parameter; a fourth, of the factor for the slack, in the exit parameter.
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
    // Evaluated without short-circuiting: a branch on either would often be mispredicted.
    if (near <= far) & (ray.t_min <= far) {
        near
    } else {
        f32::INFINITY
    }
}
