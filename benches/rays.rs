//! Time per ray in the suzanne-room, for every kind of ray that its render traces: each backend and precision, Embree
//! also with packets; and obvhs with the traversal loops of the crate itself, compared with ours.
//!
//! An iteration traces all recorded rays of a kind on one thread. Criterion's "thrpt" is rays per second.
//! Run: `cargo bench --bench rays`.

mod common;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use etendue::internals::accel::batch::{HitBatch, RayBatch};
use etendue::internals::accel::{Accel, Backend, Hit, Precision, Quality};
use etendue::internals::geometry::Geometry;
use etendue::internals::geometry::world::World;
use etendue::internals::integrator::observer::RayKind;
use etendue::internals::math::ray::Ray;
use etendue_lab::bench::build::{build, pool};
use etendue_lab::bench::record::Recording;
use etendue_lab::bench::target::{Target, Variant};
use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::{build_bvh2, build_bvh2_from_tris};
use obvhs::cwbvh::builder::{build_cwbvh, build_cwbvh_from_tris};
use obvhs::ray::{Ray as TheirRay, RayHit};
use obvhs::triangle::Triangle;
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
    let targets = Target::all(Backend::ALL).into_iter();
    let built = |target| {
        let accel = build(&world, target, &pool).expect("it was built before");
        (target, accel)
    };
    let targets = targets.filter(|target| target.quality == target.backend.default_quality());
    let targets: Vec<(Target, Accel)> = targets.map(built).collect();
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
    variant: Variant,
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
    let triangles = triangles(&world);
    let pool = pool(1).expect("one thread");
    let accels = [Backend::ObvhsBvh2, Backend::ObvhsCwbvh].map(|backend| {
        let target = Target {
            backend,
            precision: Precision::Fast,
            quality: Quality::High,
        };
        let accel = build(&world, target, &pool).expect("it was built before");
        (backend.name(), accel)
    });
    let theirs = pool.install(|| Theirs::all(&triangles));
    for kind in [RayKind::Camera, RayKind::Bounce1, RayKind::Bounce2] {
        let rays = recording.rays(kind);
        let rays: Vec<Ray> = (0..rays.len()).map(|i| rays.get(i).0).collect();
        let mut group = group(c, format!("rays/{}/obvhs", kind.name()), rays.len());
        for (name, accel) in &accels {
            group.bench_function(format!("{name}/ours"), |b| {
                b.iter(|| -> usize { met(&rays, |ray| accel.intersect(ray, 0.0, None)) });
            });
        }
        for (name, their) in &theirs {
            agree(name, &rays, &accels[0].1, their);
            group.bench_function(*name, |b| {
                b.iter(|| -> usize { met(&rays, |ray| their.closest(ray)) });
            });
        }
    }
}

/// Traces all rays and returns the number of hits.
fn met<T>(rays: &[Ray], closest: impl Fn(&Ray) -> Option<T>) -> usize {
    rays.iter().filter(|ray| closest(ray).is_some()).count()
}

/// Returns the triangles of a world that contains nothing else.
fn triangles(world: &World) -> Vec<Triangle> {
    assert!(world.instances().is_empty(), "the scene has no instances");
    let of = |geometry: &Geometry| -> Vec<Triangle> {
        let Geometry::Mesh(mesh) = geometry else {
            panic!("every shape is a mesh");
        };
        let triangle = |i: usize| {
            let [v0, v1, v2] = mesh.triangle(i as u32);
            Triangle { v0, v1, v2 }
        };
        (0..mesh.indices().len()).map(triangle).collect()
    };
    world.geometries().iter().flat_map(of).collect()
}

/// A tree of the crate with its triangles in the order of the leaves, as the crate intends.
enum Theirs {
    Binary(obvhs::bvh2::Bvh2, Vec<Triangle>),
    Wide(obvhs::cwbvh::CwBvh, Vec<Triangle>),
}

impl Theirs {
    /// Builds both layouts, without and with split triangles, with names.
    fn all(triangles: &[Triangle]) -> [(&'static str, Self); 4] {
        let parameters = BvhBuildParams::very_slow_build();
        let time = &mut Duration::default();
        let boxes: Vec<_> = triangles.iter().map(Triangle::aabb).collect();
        [
            (
                "obvhs-bvh2/its own",
                Self::binary(build_bvh2(&boxes, parameters, time), triangles),
            ),
            (
                "obvhs-bvh2/its own, split",
                Self::binary(build_bvh2_from_tris(triangles, parameters, time), triangles),
            ),
            (
                "obvhs-cwbvh/its own",
                Self::wide(build_cwbvh(&boxes, parameters, time), triangles),
            ),
            (
                "obvhs-cwbvh/its own, split",
                Self::wide(
                    build_cwbvh_from_tris(triangles, parameters, time),
                    triangles,
                ),
            ),
        ]
    }

    fn binary(bvh: obvhs::bvh2::Bvh2, triangles: &[Triangle]) -> Self {
        let order = bvh.primitive_indices.iter();
        let ordered = order.map(|&i| triangles[i as usize]).collect();
        Self::Binary(bvh, ordered)
    }

    fn wide(bvh: obvhs::cwbvh::CwBvh, triangles: &[Triangle]) -> Self {
        let order = bvh.primitive_indices.iter();
        let ordered = order.map(|&i| triangles[i as usize]).collect();
        Self::Wide(bvh, ordered)
    }

    #[inline]
    fn closest(&self, ray: &Ray) -> Option<RayHit> {
        let ray = TheirRay::new(ray.origin, ray.dir, ray.t_min, ray.t_max);
        let mut hit = RayHit::none();
        let found = match self {
            Self::Binary(bvh, triangles) => {
                bvh.ray_traverse(ray, &mut hit, |ray, i| triangles[i].intersect(ray))
            }
            Self::Wide(bvh, triangles) => {
                bvh.ray_traverse(ray, &mut hit, |ray, i| triangles[i].intersect(ray))
            }
        };
        found.then_some(hit)
    }
}

/// Asserts that both find the same hits, except for a few because of rounding, so that the work compared is the same.
fn agree(name: &str, rays: &[Ray], ours: &Accel, theirs: &Theirs) {
    let differs = |ray: &&Ray| {
        let ours: Option<Hit> = ours.intersect(ray, 0.0, None);
        match (ours, theirs.closest(ray)) {
            (None, None) => false,
            (Some(a), Some(b)) => (a.t - b.t).abs() > 1e-3 * a.t,
            _ => true,
        }
    };
    let count = rays.iter().filter(differs).count();
    assert!(count * 100 <= rays.len(), "{name}: {count} hits differ");
}

criterion_group!(benches, kinds, obvhs_itself);
criterion_main!(benches);
