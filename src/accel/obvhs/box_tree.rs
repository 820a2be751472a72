//! A BVH over boxes, of either node layout, and its traversal by a ray.
//!
//! Medium quality is obvhs's preset of that name. High is the preset `very_slow_build`: parallel reinsertion of every
//! node. obvhs's splitting of triangles is not used.
//!
//! Measure: any unit of length.
//! Range: boxes that are not empty, with coordinates up to 1e18 in magnitude.
//! Source: obvhs: parallel locally-ordered clustering (Meister and Bittner 2018) and reinsertion (the same, 2018). Tested in
//! `tests/tracing/rays.rs`, `tests/tracing/hard.rs` and `tests/tracing/instance_rays.rs`.

use super::box_ray::BoxRay;
use super::{binary, wide};
use crate::accel::Quality;
use crate::math::bounds::Bounds;
use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::cwbvh::node::CwBvhNode;
use std::ops::ControlFlow;
use std::time::Duration;

/// The memory layout of the nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NodeLayout {
    /// Two children per node, each with its box in single precision.
    Binary,
    /// Eight children per node, with boxes of 8 bits per plane.
    Wide,
}

/// The nodes of a tree.
pub enum BoxTree {
    /// Two children per node.
    Binary(Vec<Bvh2Node>),
    /// Eight children per node.
    Wide(Vec<CwBvhNode>),
}

impl std::fmt::Debug for BoxTree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "BoxTree({} nodes)", self.nodes())
    }
}

impl BoxTree {
    /// Builds a tree on rayon's current threads. Also returns the indices of the boxes in the order of the leaves.
    pub fn build(boxes: &[Aabb], layout: NodeLayout, quality: Quality) -> (Self, Vec<u32>) {
        let parameters = match quality {
            Quality::Medium => BvhBuildParams::medium_build(),
            Quality::High => BvhBuildParams::very_slow_build(),
        };
        let time = &mut Duration::default();
        match layout {
            NodeLayout::Binary => {
                let bvh = build_bvh2(boxes, parameters, time);
                (Self::Binary(bvh.nodes), bvh.primitive_indices)
            }
            NodeLayout::Wide => {
                let bvh = build_cwbvh(boxes, parameters, time);
                (Self::Wide(bvh.nodes), bvh.primitive_indices)
            }
        }
    }

    /// Visits the leaf slots, numbered in the order of the leaves, whose boxes the ray hits, until the visitor breaks.
    /// The visitor may shorten the ray.
    #[inline(always)]
    pub fn traverse(
        &self,
        mut ray: BoxRay,
        visit: impl FnMut(usize, &mut f32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        match self {
            Self::Binary(nodes) => binary::traverse(nodes, &mut ray, visit),
            Self::Wide(nodes) => wide::traverse(nodes, &mut ray, visit),
        }
    }

    /// The number of nodes.
    pub fn nodes(&self) -> usize {
        match self {
            Self::Binary(nodes) => nodes.len(),
            Self::Wide(nodes) => nodes.len(),
        }
    }

    /// The number of bytes of the nodes.
    pub fn memory(&self) -> usize {
        match self {
            Self::Binary(nodes) => size_of_val(nodes.as_slice()),
            Self::Wide(nodes) => size_of_val(nodes.as_slice()),
        }
    }
}

/// The single-precision box that encloses another box widened by `padding` on every side.
pub fn widened(bounds: &Bounds, padding: f64) -> Aabb {
    let down = |x: f64| {
        let rounded = x as f32;
        if f64::from(rounded) > x {
            rounded.next_down()
        } else {
            rounded
        }
    };
    let (min, max) = (bounds.min - padding, bounds.max + padding);
    Aabb::new(
        Vec3A::from_array(min.to_array().map(down)),
        Vec3A::from_array(max.to_array().map(|x| -down(-x))),
    )
}
