//! Tests that Embree builds with the requested number of threads and quality. This is the only test of its process,
//! because the threads of others would be counted, too.
#![cfg(all(feature = "embree", target_os = "linux"))]

mod common;

use common::TestRng;
use common::tracing::{direction, point, static_world};
use etendue::internals::accel::{Accel, AccelOptions, Backend, Precision, Quality};
use etendue::internals::geometry::{Geometry, mesh::Mesh};

const NEEDLES: u32 = 20_000;

/// Long thin triangles in every direction: their boxes overlap, so spatial splits pay off.
fn needles() -> Mesh {
    let mut rng = TestRng::new(36);
    let needles = (0..NEEDLES).map(|_| {
        let from = point(&mut rng);
        let to = from + direction(&mut rng);
        [from, to, to + 0.001 * point(&mut rng)]
    });
    let positions = needles.flatten().collect();
    let indices = (0..NEEDLES).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    Mesh::new(positions, vec![], vec![], indices.collect())
}

fn threads() -> usize {
    let tasks = std::fs::read_dir("/proc/self/task").expect("Linux lists the threads");
    tasks.count()
}

#[test]
fn embree_build_respects_single_thread_and_quality_options() {
    let world = static_world(vec![Geometry::Mesh(needles())]);
    let build = |precision, quality| {
        let options = AccelOptions {
            backend: Backend::Embree,
            precision,
            quality: Some(quality),
            threads: 1,
        };
        Accel::build(world.clone(), options).expect("memory for 20,000 triangles")
    };
    let before = threads();
    let first = build(Precision::Fast, Quality::Medium);
    assert_eq!(
        threads(),
        before,
        "the build runs on the calling thread only"
    );
    // A triangle takes nine coordinates and two integers in a leaf, and its share of the nodes. Temporary memory of the
    // build has been freed.
    let bytes_each = first.memory() / NEEDLES as usize;
    println!("{bytes_each} bytes a triangle");
    assert!((44..100).contains(&bytes_each), "{bytes_each}");
    drop(first);

    // Split triangles need more memory. Robust scenes are built without splits.
    for (precision, splits) in [(Precision::Fast, true), (Precision::Robust, false)] {
        let [medium, high] = [Quality::Medium, Quality::High].map(|q| build(precision, q).memory());
        println!("{precision:?}: {medium} and {high} bytes");
        assert_eq!(high > medium, splits, "{precision:?}");
    }
}
