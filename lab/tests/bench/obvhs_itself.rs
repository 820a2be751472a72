//! obvhs by its own loops hits what the renderer's exact traversal hits, so that their times are those of the same work.

use crate::common::TestRng;
use crate::common::tracing::{closed_mesh, placed_once, soup, static_world};
use etendue::internals::accel::{Accel, AccelOptions, Backend, Precision};
use etendue::internals::geometry::Geometry;
use etendue::internals::math::vec::DAffine3;
use etendue_lab::bench::obvhs_itself::ObvhsTree;
use etendue_lab::bench::rays::random_rays;
use std::sync::Arc;

#[test]
fn obvhs_tree_hits_match_ours_within_rounding() {
    let world = static_world(vec![Geometry::Mesh(closed_mesh(12, true))]);
    let options = AccelOptions {
        backend: Backend::ObvhsBvh2,
        precision: Precision::Robust,
        quality: None,
        threads: 1,
    };
    let exact = Accel::build(Arc::clone(&world), options).expect("a small scene");
    let rays = random_rays(&world, 20_000, 7);
    let trees = ObvhsTree::all(&world);
    assert_eq!(trees.len(), 4);
    for tree in &trees {
        let name = format!("{}, split: {}", tree.layout.name(), tree.is_split);
        let (mut hits, mut different) = (0, 0);
        for index in 0..rays.len() {
            let (ray, time) = rays.get(index);
            let ours = exact.intersect(&ray, time, None).map(|hit| hit.t);
            let theirs = tree.closest(&ray);
            hits += usize::from(ours.is_some());
            let is_same = match (ours, theirs) {
                (Some(ours), Some(theirs)) => (ours - theirs).abs() <= 1e-3 * ours,
                (None, None) => true,
                _ => false,
            };
            let is_consistent = tree.is_occluded(&ray) == theirs.is_some();
            different += usize::from(!(is_same && is_consistent));
        }
        // A few differ by the rounding that obvhs does not bound.
        assert!(
            hits > 2000 && different < 20,
            "{name}: {different} of {hits}"
        );
    }
}

#[test]
fn obvhs_trees_are_omitted_for_unsupported_shapes() {
    let mut rng = TestRng::new(3);
    assert!(ObvhsTree::all(&static_world(soup(&mut rng))).is_empty());
    let mesh = Geometry::Mesh(closed_mesh(2, false));
    let instance = placed_once(vec![mesh], vec![DAffine3::IDENTITY]);
    assert!(ObvhsTree::all(&instance).is_empty());
}
