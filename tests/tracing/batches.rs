//! Batches of rays, of every backend, precision, quality, packet width and coherence, against the same rays traced one by
//! one: with inactive rays, rays that are not finite, ranges and times among them.

use crate::common::TestRng;
use crate::common::tracing::{
    closed_mesh, direction, in_single, moving, point, rotation, same, soup, static_world, triangle,
};
use etendue::internals::accel::batch::{HitBatch, PacketWidth, Packets, RayBatch};
use etendue::internals::accel::{Accel, AccelOptions, Backend, Hit, Precision, Quality, brute};
use etendue::internals::geometry::Geometry;
use etendue::internals::geometry::world::{Instance, World};
use etendue::internals::math::ray::Ray;
use etendue::internals::math::vec::Vec3;
use std::sync::Arc;

/// Batch lengths around the packet widths 8 and 16, and one of many packets.
const LENGTHS: [usize; 9] = [1000, 17, 16, 15, 9, 8, 7, 1, 0];

/// The rounding error of a ray's origin in scenes of about unit size, and the relative one of its `t_min` and `t_max`.
const ROUNDING: f32 = 1e-5;

fn every_accel(world: &Arc<World>) -> Vec<(String, Accel)> {
    let mut all = Vec::new();
    for &backend in Backend::ALL {
        for precision in [Precision::Robust, Precision::Fast] {
            for quality in [Quality::Medium, Quality::High] {
                let accel = accel(world, backend, precision, quality);
                let names = [backend.name(), precision.name(), quality.name()];
                all.push((names.join(" "), accel));
            }
        }
    }
    all
}

fn accel(world: &Arc<World>, backend: Backend, precision: Precision, quality: Quality) -> Accel {
    let options = AccelOptions {
        backend,
        precision,
        quality: Some(quality),
        threads: 2,
    };
    Accel::build(Arc::clone(world), options).expect("a small scene")
}

fn every_packets() -> Vec<Packets> {
    let both = |&width| [false, true].map(|coherent| Packets { width, coherent });
    PacketWidth::ALL.iter().flat_map(both).collect()
}

fn is_finite(ray: &Ray) -> bool {
    ray.origin.is_finite() && ray.dir.is_finite()
}

/// Rays through the cube from -1 to 1: one in eight not finite, one in four inactive, half of them with a `t` range.
fn random_rays(length: usize, rng: &mut TestRng) -> RayBatch {
    let mut rays = RayBatch::default();
    for index in 0..length {
        let origin = 1.5 * point(rng);
        let mut ray = Ray::new(origin, 0.7 * point(rng) - origin);
        if rng.uniform() < 0.5 {
            ray.t_min = rng.uniform();
            ray.t_max = ray.t_min + rng.uniform();
        }
        if rng.uniform() < 0.125 {
            let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][index % 3];
            let axis = (3.0 * rng.uniform()) as usize;
            let at = if index.is_multiple_of(2) {
                &mut ray.origin
            } else {
                &mut ray.dir
            };
            at[axis] = bad;
        }
        rays.push(&ray, rng.uniform());
        rays.active[index] = rng.uniform() < 0.75;
    }
    rays
}

/// Rays of a camera at 0, 0, -3 through a square of pixels, row by row.
fn camera_rays(side: usize) -> RayBatch {
    let mut rays = RayBatch::default();
    for pixel in 0..side * side {
        let at = |i: usize| 2.0 * (i as f32 + 0.5) / side as f32 - 1.0;
        let to = Vec3::new(at(pixel % side), at(pixel / side), 0.0);
        let eye = Vec3::new(0.0, 0.0, -3.0);
        rays.push(&Ray::new(eye, (to - eye).normalize()), 0.5);
    }
    rays
}

/// Whether some ray that differs from this one by no more than rounding has this property.
fn nearly(ray: &Ray, rng: &mut TestRng, has: impl Fn(&Ray) -> bool) -> bool {
    (0..200).any(|_| {
        let near = |t: f32, u: f32| t * (1.0 + ROUNDING * (2.0 * u - 1.0));
        has(&Ray {
            origin: ray.origin + ROUNDING * point(rng),
            dir: ray.dir,
            t_min: near(ray.t_min, rng.uniform()),
            t_max: near(ray.t_max, rng.uniform()),
        })
    })
}

/// The same primitive at the same place, or another one at the same distance.
fn agree(a: Option<Hit>, b: Option<Hit>) -> bool {
    let apart = |[a, b]: [f32; 2], [c, d]: [f32; 2]| (a - c).abs().max((b - d).abs());
    match (a, b) {
        (Some(a), Some(b)) if a.id == b.id => {
            let uv = a.t == b.t || apart(a.uv, b.uv) < 1e-3;
            same(Some(a), Some(b)) && uv
        }
        _ => same(a, b),
    }
}

/// Counts of the compared rays, to check that no category is empty.
#[derive(Debug, Default)]
struct Count {
    rays: usize,
    hits: usize,
    free: usize,
    /// Inactive rays that would have hit.
    held_back: usize,
    /// Results that differ from the single ray's by rounding.
    off: usize,
}

/// Compares all ways of tracing a batch with single rays. Results may differ by rounding only, and rarely.
fn compare(
    world: &World,
    accels: &[(String, Accel)],
    rays: &RayBatch,
    rng: &mut TestRng,
    count: &mut Count,
) {
    // Larger than needed, with values that must be overwritten.
    let mut hits = HitBatch::default();
    hits.resize(rays.len() + 100);
    let mut occluded = vec![true; rays.len() + 100];
    for (name, accel) in accels {
        let singles: Vec<_> = (0..rays.len())
            .map(|index| {
                let (ray, time) = rays.get(index);
                (
                    accel.intersect(&ray, time, None),
                    accel.occluded(&ray, time),
                )
            })
            .collect();
        for packets in every_packets() {
            accel.intersect_batch(rays, packets, &mut hits);
            accel.occluded_batch(rays, packets, &mut occluded);
            assert_eq!((hits.len(), occluded.len()), (rays.len(), rays.len()));
            for (index, &single) in singles.iter().enumerate() {
                let (ray, time) = rays.get(index);
                let answer = (hits.get(index), occluded[index]);
                let place = || format!("{name} {packets:?}: ray {index}, {ray:?} at {time}");
                count.rays += 1;
                if !rays.is_active(index) || !is_finite(&ray) {
                    assert_eq!(answer, (None, false), "{}", place());
                    count.held_back += usize::from(single.0.is_some());
                    continue;
                }
                count.hits += usize::from(answer.0.is_some());
                count.free += usize::from(!answer.1);
                if !agree(answer.0, single.0) {
                    count.off += 1;
                    let is_explained = nearly(&ray, rng, |r| {
                        same(brute::intersect(world, r, time), answer.0)
                    });
                    assert!(is_explained, "{}: {answer:?}, not {single:?}", place());
                }
                if answer.1 != single.1 {
                    count.off += 1;
                    let is_explained =
                        nearly(&ray, rng, |r| brute::occluded(world, r, time) == answer.1);
                    assert!(is_explained, "{}: {answer:?}, not {single:?}", place());
                }
            }
        }
    }
}

/// Compares random batches of every length, and the rays of a camera, with single rays in a world.
fn compare_all(world: &Arc<World>, rng: &mut TestRng) {
    let accels = every_accel(world);
    let mut count = Count::default();
    for length in LENGTHS {
        let rays = random_rays(length, rng);
        compare(world, &accels, &rays, rng, &mut count);
    }
    // Whole packets without a ray to trace, between others.
    let mut rays = random_rays(100, rng);
    rays.active[24..72].fill(false);
    compare(world, &accels, &rays, rng, &mut count);
    compare(world, &accels, &camera_rays(32), rng, &mut count);
    println!("{count:?}");
    let is_over = |part: usize, percent: usize| part * 100 > percent * count.rays;
    assert!(
        is_over(count.hits, 5) && is_over(count.free, 5),
        "{count:?}"
    );
    assert!(is_over(count.held_back, 1), "{count:?}");
    assert!(count.off * 1000 <= count.rays, "{count:?}");
}

#[test]
fn batch_and_single_ray_hits_agree_on_every_shape_kind() {
    let mut rng = TestRng::new(31);
    compare_all(&static_world(soup(&mut rng)), &mut rng);
    // Each kind by itself, since Embree has a tree for each kind, and other kernels where there is only one.
    for kind in 0..3 {
        let shapes = soup(&mut rng).into_iter().skip(kind).step_by(3);
        let shapes: Vec<_> = shapes
            .chain(soup(&mut rng).into_iter().skip(kind).step_by(3))
            .collect();
        compare_all(&static_world(shapes), &mut rng);
    }
}

#[test]
fn batch_and_single_ray_hits_agree_on_meshes() {
    let mut rng = TestRng::new(32);
    let mesh = |n, round| Geometry::Mesh(closed_mesh(n, round));
    compare_all(&static_world(vec![mesh(8, true)]), &mut rng);
    let triangles = (0..300).map(|_| {
        let center = point(&mut rng);
        triangle([0, 1, 2].map(|_| center + 0.3 * point(&mut rng)))
    });
    let shapes = triangles.chain([mesh(3, true)]).collect();
    compare_all(&static_world(shapes), &mut rng);
}

#[test]
fn batch_and_single_ray_hits_agree_on_moving_instances() {
    let mut rng = TestRng::new(33);
    let groups = vec![
        soup(&mut rng),
        vec![Geometry::Mesh(closed_mesh(4, true))],
        vec![],
    ];
    for steps in [1, 2, 5] {
        let instances = (0..9).map(|i| {
            let mut start =
                rotation(&mut rng) * glam::DAffine3::from_scale(glam::DVec3::splat(0.4));
            start.translation = 0.7 * point(&mut rng).as_dvec3();
            let steps = match steps {
                1 => vec![in_single(start)],
                _ => moving(&mut rng, start, steps),
            };
            let group = i % 3;
            Instance { group, steps }
        });
        let instances: Vec<_> = instances.collect();
        for roots in [vec![], soup(&mut rng)] {
            let world = World::new(roots, groups.clone(), instances.clone());
            compare_all(&Arc::new(world), &mut rng);
        }
    }
}

#[test]
fn batches_in_empty_space_hit_nothing() {
    let mut rng = TestRng::new(34);
    for (name, accel) in every_accel(&static_world(vec![])) {
        for packets in every_packets() {
            let rays = random_rays(20, &mut rng);
            let (mut hits, mut occluded) = (HitBatch::default(), vec![]);
            accel.intersect_batch(&rays, packets, &mut hits);
            accel.occluded_batch(&rays, packets, &mut occluded);
            assert!((0..20).all(|i| hits.get(i).is_none()), "{name} {packets:?}");
            assert_eq!(occluded, [false; 20], "{name} {packets:?}");
        }
    }
}

/// Rays in batches do not escape a closed mesh; for single rays see `tests/tracing/rays.rs`.
#[test]
fn robust_batches_are_watertight_at_closed_mesh_edges() {
    const RAYS: usize = 20_000;
    let mut rng = TestRng::new(35);
    let mesh = closed_mesh(6, true);
    let world = static_world(vec![Geometry::Mesh(mesh.clone())]);
    let mut batches = [(); 3].map(|()| RayBatch::default());
    for index in 0..RAYS {
        let from = 0.5 * point(&mut rng);
        let corners = mesh.indices()[index % mesh.indices().len()];
        let [a, b, _] = corners.map(|i| mesh.vertices()[i as usize].position());
        let targets = [a, a + rng.uniform() * (b - a), from + direction(&mut rng)];
        for (rays, target) in batches.iter_mut().zip(targets) {
            rays.push(&Ray::new(from, (target - from).normalize()), 0.0);
        }
    }
    let (mut hits, mut occluded) = (HitBatch::default(), vec![]);
    for &backend in Backend::ALL {
        let accel = accel(&world, backend, Precision::Robust, Quality::High);
        for packets in every_packets() {
            let escaped = batches.each_ref().map(|rays| {
                accel.intersect_batch(rays, packets, &mut hits);
                accel.occluded_batch(rays, packets, &mut occluded);
                let is_out = |&i: &usize| hits.get(i).is_none() || !occluded[i];
                (0..RAYS).filter(is_out).count()
            });
            println!("{backend:?} {packets:?}: {escaped:?} of {RAYS} escaped");
            assert_eq!(escaped[1..], [0, 0], "{backend:?} {packets:?}");
            assert!(escaped[0] * 1_000 <= RAYS, "{backend:?} {packets:?}");
        }
    }
}
