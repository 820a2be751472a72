//! Time per ray in the suzanne-room, for every kind of ray that its render traces: each backend and precision, Embree
//! also with packets; and obvhs with the traversal loops of the crate itself, compared with ours.
//!
//! An iteration traces all recorded rays of a kind on one thread. Criterion's "thrpt" is rays per second.
//! Run: `cargo bench --bench rays`.

mod common;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use etendue::internals::accel::batch::{HitBatch, RayBatch};
use etendue::internals::accel::{Accel, Backend, Precision, Quality};
use etendue::internals::geometry::world::World;
use etendue::internals::integrator::observer::RayKind;
use etendue::internals::math::ray::Ray;
use etendue_lab::bench::build::{build, pool};
use etendue_lab::bench::obvhs_itself::ObvhsTree;
use etendue_lab::bench::record::Recording;
use etendue_lab::bench::target::{BenchTarget, TracingMode};
use std::sync::Arc;
use std::time::Duration;

/// Number of recorded rays of the most frequent kind.
const RAYS: usize = 1 << 15;

/// Returns the world of the suzanne-room and the recorded rays of its render.
fn suzanne_room() -> (Arc<World>, Recording) {
    let description = common::written("suzanne-room");
    let scene = common::ready(&description);
    let recording = common::recorded(&description, &scene, RAYS);
    (Arc::clone(&scene.world), recording)
}

fn group<'a>(c: &'a mut Criterion, name: String, rays: usize) -> BenchmarkGroup<'a, WallTime> {
    let mut group = c.benchmark_group(name);
    group.throughput(Throughput::Elements(rays as u64));
    group.sample_size(20);
    group.warm_up_time(Duration::from_millis(500));
    group.measurement_time(Duration::from_secs(2));
    group
}

/// Benchmarks every backend, precision and packet width on every kind of ray.
fn kinds(c: &mut Criterion) {
    let (world, recording) = suzanne_room();
    let pool = pool(1).expect("one thread");
    let targets = BenchTarget::all(Backend::ALL).into_iter();
    let built = |target| {
        let accel = build(&world, target, &pool).expect("it was built before");
        (target, accel)
    };
    let targets = targets.filter(|target| target.quality == target.backend.default_quality());
    let targets: Vec<(BenchTarget, Accel)> = targets.map(built).collect();
    for kind in recording.kinds() {
        let rays = recording.rays(kind);
        let mut group = group(c, format!("rays/{}", kind.name()), rays.len());
        for (target, accel) in &targets {
            for variant in target.variants() {
                trace(&mut group, variant, accel, kind, rays);
            }
        }
    }
}

/// Benchmarks occlusion queries for shadow rays and closest hits for all other kinds.
fn trace(
    group: &mut BenchmarkGroup<'_, WallTime>,
    variant: TracingMode,
    accel: &Accel,
    kind: RayKind,
    rays: &RayBatch,
) {
    let packets = variant.packets;
    let way = if packets.coherent { " coherent" } else { "" };
    let width = packets.width.lanes();
    let (backend, precision) = (variant.target.backend, variant.target.precision);
    let id = format!("{}/{}/{width}{way}", backend.name(), precision.name());
    let (mut hits, mut occluded) = (HitBatch::default(), Vec::new());
    group.bench_function(id, |b| match kind {
        RayKind::Shadow => b.iter(|| accel.occluded_batch(rays, packets, &mut occluded)),
        _ => b.iter(|| accel.intersect_batch(rays, packets, &mut hits)),
    });
}

/// Benchmarks obvhs's trees of the same triangles, traversed by the crate's own loops with its own single-precision
/// triangle test, against our loops in fast precision. The crate's preset splits triangles, ours does not: the crate is
/// measured with and without splitting.
fn obvhs_itself(c: &mut Criterion) {
    let (world, recording) = suzanne_room();
    let pool = pool(1).expect("one thread");
    let accels = [Backend::ObvhsBvh2, Backend::ObvhsCwbvh].map(|backend| {
        let target = BenchTarget {
            backend,
            precision: Precision::Fast,
            quality: Quality::High,
        };
        let accel = build(&world, target, &pool).expect("it was built before");
        (backend.name(), accel)
    });
    let theirs = pool.install(|| ObvhsTree::all(&world));
    for kind in [RayKind::Camera, RayKind::Bounce1, RayKind::Bounce2] {
        let rays = recording.rays(kind);
        let rays: Vec<Ray> = (0..rays.len()).map(|i| rays.get(i).0).collect();
        let mut group = group(c, format!("rays/{}/obvhs", kind.name()), rays.len());
        for (name, accel) in &accels {
            group.bench_function(format!("{name}/ours"), |b| {
                b.iter(|| -> usize { met(&rays, |ray| accel.intersect(ray, 0.0, None)) });
            });
        }
        for tree in &theirs {
            let split = if tree.is_split { ", split" } else { "" };
            let name = format!("{}/its own{split}", tree.layout.name());
            group.bench_function(name, |b| {
                b.iter(|| -> usize { met(&rays, |ray| tree.closest(ray)) });
            });
        }
    }
}

/// Traces all rays and returns the number of hits.
fn met<T>(rays: &[Ray], closest: impl Fn(&Ray) -> Option<T>) -> usize {
    rays.iter().filter(|ray| closest(ray).is_some()).count()
}

criterion_group!(benches, kinds, obvhs_itself);
criterion_main!(benches);
