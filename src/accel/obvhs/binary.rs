//! The leaves of a binary tree that a ray comes through, the nearer child first.
//!
//! Measure: as of the boxes; parameters as of `BoxRay`.
//! Range: any tree.
//! Source: obvhs for the nodes; Pharr, Jakob, Humphreys, section 6.8.2 for the rounding of the test. Tested in
//! `tests/tracing.rs` and `tests/tracing_hard.rs`.

use super::box_ray::BoxRay;
use super::stack::Stack;
use crate::math::robust::gamma;
use obvhs::bvh2::node::Bvh2Node;
use std::ops::ControlFlow;

/// Visits the primitives of every leaf whose box the ray meets, until told to stop.
#[inline]
pub fn traverse(
    nodes: &[Bvh2Node],
    ray: &mut BoxRay,
    mut visit: impl FnMut(usize, &mut f32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let Some(mut node) = nodes.first().filter(|root| enters(root, ray).is_some()) else {
        return ControlFlow::Continue(());
    };
    let mut stack = Stack::<_, 32>::new();
    loop {
        if node.is_leaf() {
            for index in node.first_index..node.first_index + node.prim_count {
                visit(index as usize, &mut ray.t_max)?;
            }
        } else {
            let first = node.first_index;
            let children = &nodes[first as usize..][..2];
            match (enters(&children[0], ray), enters(&children[1], ray)) {
                (Some(left), Some(right)) => {
                    let right_first = usize::from(right < left);
                    let later = [(first + 1, right), (first, left)][right_first];
                    stack.push(later);
                    node = &children[right_first];
                    continue;
                }
                (Some(_), None) => {
                    node = &children[0];
                    continue;
                }
                (None, Some(_)) => {
                    node = &children[1];
                    continue;
                }
                (None, None) => {}
            }
        }
        node = loop {
            let Some((index, near)) = stack.pop() else {
                return ControlFlow::Continue(());
            };
            if near <= ray.t_max {
                break &nodes[index as usize];
            }
        };
    }
}

/// Where the ray comes into a node's box, if it does.
#[inline]
fn enters(node: &Bvh2Node, ray: &BoxRay) -> Option<f32> {
    // Three roundings each for where the ray comes in and where it goes out.
    const SLACK: f32 = 1.0 + 2.0 * gamma(3);
    let bounds = node.aabb();
    let a = (bounds.min - ray.origin) * ray.inverse;
    let b = (bounds.max - ray.origin) * ray.inverse;
    let (mut near, mut far) = (a.min(b), a.max(b));
    if ray.is_parallel {
        (near, far) = (near - ray.slack, far + ray.slack);
    }
    let (near, far) = (near.max_element(), far.min_element() * SLACK);
    // One instruction each, as `f32::max` is not: that has to tell what is not a number.
    let near = if near > ray.t_min { near } else { ray.t_min };
    let far = if far < ray.t_max { far } else { ray.t_max };
    (near <= far).then_some(near)
}
