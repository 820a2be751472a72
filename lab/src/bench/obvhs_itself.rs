//! obvhs as its own users call it: its builders with their best preset, its traversal loops, its triangle test in single
//! precision. Our backends build with obvhs, but traverse with loops of their own, which bound rounding errors.
//!
//! Measure: none.
//! Range: scenes of triangle meshes that neither move nor are instances; obvhs has no other shapes.
//! Source: the documentation of obvhs 0.4. Tested in `lab/tests/bench/obvhs_itself.rs`.

use etendue::internals::accel::Backend;
use etendue::internals::geometry::Geometry;
use etendue::internals::geometry::world::World;
use etendue::internals::math::ray::Ray;
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::{build_bvh2, build_bvh2_from_tris};
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::{build_cwbvh, build_cwbvh_from_tris};
use obvhs::ray::{Ray as ObvhsRay, RayHit};
use obvhs::triangle::Triangle;
use std::time::Duration;

/// A tree of obvhs, with its triangles in the order of the leaves, as the crate intends.
pub struct ObvhsTree {
    /// The backend of ours that has this layout.
    pub layout: Backend,
    /// Whether the builder split triangles, as the crate's preset does and our backends do not.
    pub is_split: bool,
    nodes: Nodes,
    triangles: Vec<Triangle>,
}

enum Nodes {
    Binary(Bvh2),
    Wide(CwBvh),
}

impl ObvhsTree {
    /// Both layouts, without and with split triangles; none for a world that obvhs cannot represent.
    pub fn all(world: &World) -> Vec<Self> {
        let Some(triangles) = triangles(world).filter(|all| !all.is_empty()) else {
            return Vec::new();
        };
        let preset = BvhBuildParams::very_slow_build();
        let time = &mut Duration::default();
        let boxes: Vec<_> = triangles.iter().map(Triangle::aabb).collect();
        let binary = [
            build_bvh2(&boxes, preset, time),
            build_bvh2_from_tris(&triangles, preset, time),
        ];
        let wide = [
            build_cwbvh(&boxes, preset, time),
            build_cwbvh_from_tris(&triangles, preset, time),
        ];
        let tree = |layout, is_split, nodes: Nodes| {
            let order = match &nodes {
                Nodes::Binary(bvh) => &bvh.primitive_indices,
                Nodes::Wide(bvh) => &bvh.primitive_indices,
            };
            let ordered = order.iter().map(|&index| triangles[index as usize]);
            Self {
                layout,
                is_split,
                triangles: ordered.collect(),
                nodes,
            }
        };
        let [whole, split] = binary;
        let [wide_whole, wide_split] = wide;
        vec![
            tree(Backend::ObvhsBvh2, false, Nodes::Binary(whole)),
            tree(Backend::ObvhsBvh2, true, Nodes::Binary(split)),
            tree(Backend::ObvhsCwbvh, false, Nodes::Wide(wide_whole)),
            tree(Backend::ObvhsCwbvh, true, Nodes::Wide(wide_split)),
        ]
    }

    /// The distance of the closest hit.
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<f32> {
        let (ray, mut hit) = (converted(ray), RayHit::none());
        let of_triangle = |ray: &ObvhsRay, index: usize| self.triangles[index].intersect(ray);
        let is_hit = match &self.nodes {
            Nodes::Binary(bvh) => bvh.ray_traverse(ray, &mut hit, of_triangle),
            Nodes::Wide(bvh) => bvh.ray_traverse(ray, &mut hit, of_triangle),
        };
        is_hit.then_some(hit.t)
    }

    /// Whether anything is hit.
    #[inline]
    pub fn is_occluded(&self, ray: &Ray) -> bool {
        let ray = converted(ray);
        let of_triangle = |ray: &ObvhsRay, index: usize| self.triangles[index].intersect(ray);
        let is_missed = match &self.nodes {
            Nodes::Binary(bvh) => bvh.ray_traverse_miss(ray, of_triangle),
            Nodes::Wide(bvh) => bvh.ray_traverse_miss(ray, of_triangle),
        };
        !is_missed
    }
}

fn converted(ray: &Ray) -> ObvhsRay {
    ObvhsRay::new(ray.origin, ray.dir, ray.t_min, ray.t_max)
}

/// The triangles of a world of nothing else.
fn triangles(world: &World) -> Option<Vec<Triangle>> {
    if !world.instances().is_empty() {
        return None;
    }
    let mut all = Vec::new();
    for geometry in world.geometries() {
        let Geometry::Mesh(mesh) = geometry else {
            return None;
        };
        all.extend((0..mesh.indices().len()).map(|index| {
            let [v0, v1, v2] = mesh.triangle(index as u32);
            Triangle { v0, v1, v2 }
        }));
    }
    Some(all)
}
