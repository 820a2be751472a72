//! Seconds to build each backend's acceleration structure in each quality, on all threads.
//!
//! The precision is fast: Embree builds robust scenes in only one quality, and for obvhs precision makes no difference.
//! Run: `cargo bench --bench build`.

mod common;

use criterion::{Criterion, criterion_group, criterion_main};
use etendue::internals::accel::{Accel, Backend, Precision};
use etendue::internals::render::settings::available_threads;
use etendue::internals::scene::description::SceneDescription;
use etendue_lab::bench::build::{build, pool};
use etendue_lab::bench::scenes::SCENES;
use etendue_lab::bench::target::BenchTarget;

/// Triangles of the terrain.
const TRIANGLES: usize = 200_000;

fn scenes() -> [(&'static str, SceneDescription); 2] {
    let mut made = SCENES.iter();
    let terrain = made.find(|scene| scene.name == "terrain");
    let terrain = terrain.expect("the bench has a terrain");
    [
        ("suzanne-room", common::written("suzanne-room")),
        ("terrain", terrain.describe(TRIANGLES)),
    ]
}

fn builds(c: &mut Criterion) {
    let pool = pool(available_threads()).expect("as many threads as the machine has");
    for (name, description) in scenes() {
        let world = common::ready(&description).world;
        let mut group = c.benchmark_group(format!("build/{name}"));
        group.sample_size(10);
        let targets = BenchTarget::all(Backend::ALL).into_iter();
        for target in targets.filter(|target| target.precision == Precision::Fast) {
            let id = [target.backend.name(), target.quality.name()].join("/");
            let build = || -> Accel { build(&world, target, &pool).expect("it was built before") };
            group.bench_function(id, |b| {
                b.iter_with_large_drop(build);
            });
        }
    }
}

criterion_group!(benches, builds);
criterion_main!(benches);
