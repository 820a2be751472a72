//! A tree of boxes, of either layout, and which of the boxes a ray comes through.
//!
//! Medium quality is obvhs's preset of that name. High is the preset `very_slow_build`: parallel reinsertion of every
//! node. It is without the splitting of triangles that obvhs has for them.
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

/// How the nodes lie in memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Two children a node, each with its box in single precision.
    Binary,
    /// Eight children a node, their boxes in 8 bits a plane.
    Wide,
}

/// The nodes of a tree.
pub enum BoxTree {
    /// Two children a node.
    Binary(Vec<Bvh2Node>),
    /// Eight children a node.
    Wide(Vec<CwBvhNode>),
}

impl std::fmt::Debug for BoxTree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "BoxTree({} nodes)", self.nodes())
    }
}

impl BoxTree {
    /// Builds a tree on rayon's current threads. The numbers of the boxes come back in the order of the leaves.
    pub fn build(boxes: &[Aabb], layout: Layout, quality: Quality) -> (Self, Vec<u32>) {
        let parameters = match quality {
            Quality::Medium => BvhBuildParams::medium_build(),
            Quality::High => BvhBuildParams::very_slow_build(),
        };
        let time = &mut Duration::default();
        match layout {
            Layout::Binary => {
                let bvh = build_bvh2(boxes, parameters, time);
                (Self::Binary(bvh.nodes), bvh.primitive_indices)
            }
            Layout::Wide => {
                let bvh = build_cwbvh(boxes, parameters, time);
                (Self::Wide(bvh.nodes), bvh.primitive_indices)
            }
        }
    }

    /// Visits the places, in the order of the leaves, whose boxes the ray meets, until told to stop. A visitor may bring
    /// the end of the ray nearer.
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

    /// How many nodes there are.
    pub fn nodes(&self) -> usize {
        match self {
            Self::Binary(nodes) => nodes.len(),
            Self::Wide(nodes) => nodes.len(),
        }
    }

    /// Bytes of the nodes.
    pub fn memory(&self) -> usize {
        match self {
            Self::Binary(nodes) => size_of_val(nodes.as_slice()),
            Self::Wide(nodes) => size_of_val(nodes.as_slice()),
        }
    }
}

/// A box in single precision around another, and this much wider on every side.
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
