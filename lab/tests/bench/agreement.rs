//! The comparison of backends: planted differences are classified correctly, and the backends of this build have none that
//! rounding does not explain.

use crate::common::TestRng;
use crate::common::tracing::{moving, placed_once, point, soup, static_world, transforms};
use etendue::internals::accel::batch::RayBatch;
use etendue::internals::accel::{
    Accel, AccelOptions, Backend, Precision, PrimitiveId, Quality, brute,
};
use etendue::internals::geometry::world::World;
use etendue::internals::geometry::{Geometry, mesh::Mesh};
use etendue::internals::math::ray::Ray;
use etendue::internals::math::vec::Vec3;
use etendue::internals::scene::prepare::prepare;
use etendue_lab::bench::agreement::compare;
use etendue_lab::bench::hit_interval::hit_intervals;
use etendue_lab::bench::rays::{aimed_rays, random_rays};
use etendue_lab::bench::report::AgreementReport;
use etendue_lab::bench::scenes::SCENES;
use etendue_lab::bench::target::BenchTarget;
use std::sync::Arc;

/// The backend that intersects in double precision.
const EXACT: BenchTarget = BenchTarget {
    backend: Backend::ObvhsBvh2,
    precision: Precision::Robust,
    quality: Quality::High,
};

fn every_target() -> impl Iterator<Item = BenchTarget> {
    let of = |&backend: &Backend| {
        [Precision::Robust, Precision::Fast].map(|precision| BenchTarget {
            backend,
            precision,
            ..EXACT
        })
    };
    Backend::ALL.iter().flat_map(of)
}

fn build(world: &Arc<World>, target: BenchTarget) -> Accel {
    Accel::build(Arc::clone(world), target.options(2)).expect("a small scene")
}

/// The counts of differences in `world` between two acceleration structures, which may be built over other worlds.
fn between(world: &World, sides: [&Arc<World>; 2], rays: &RayBatch, occlusion: bool) -> Counts {
    let [a, b] = sides.map(|world| build(world, EXACT));
    let mut report = AgreementReport::new(EXACT, EXACT);
    compare(
        world,
        (EXACT, &a),
        (EXACT, &b),
        rays,
        occlusion,
        &mut report,
    );
    counts(&report)
}

#[derive(Debug, PartialEq, Default, Clone, Copy)]
struct Counts {
    identical: u64,
    ties: u64,
    edges: u64,
    real: u64,
}

fn counts(report: &AgreementReport) -> Counts {
    let counts = Counts {
        identical: report.identical,
        ties: report.ties,
        edges: report.edges,
        real: report.real,
    };
    assert_eq!(report.real > 0, report.first_real.is_some());
    let sum = counts.identical + counts.ties + counts.edges + counts.real;
    assert_eq!(sum, report.rays);
    counts
}

fn batch(rays: impl IntoIterator<Item = Ray>) -> RayBatch {
    let mut batch = RayBatch::default();
    for ray in rays {
        batch.push(&ray, 0.0);
    }
    batch
}

fn triangles(triangles: &[[Vec3; 3]]) -> Arc<World> {
    let positions = triangles.concat();
    let indices = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    let mesh = Mesh::new(positions, vec![], vec![], indices.collect());
    static_world(vec![Geometry::Mesh(mesh)])
}

fn random_triangles(count: usize) -> Vec<[Vec3; 3]> {
    let mut rng = TestRng::new(7);
    let mut triangle = || [0, 1, 2].map(|_| point(&mut rng));
    (0..count).map(|_| triangle()).collect()
}

/// A triangle with its right angle at the origin, in the plane z = 0.
const CORNER: [Vec3; 3] = [
    Vec3::ZERO,
    Vec3::new(4.0, 0.0, 0.0),
    Vec3::new(0.0, 4.0, 0.0),
];

fn down(x: f32, y: f32) -> Ray {
    Ray::new(Vec3::new(x, y, 1.0), -Vec3::Z)
}

#[test]
fn missing_triangle_is_a_real_difference_where_it_is_hit_first() {
    let all = random_triangles(30);
    let missing = 4;
    let mut rest = all.clone();
    rest[missing] = [
        Vec3::splat(50.0),
        Vec3::splat(51.0),
        Vec3::new(50.0, 51.0, 52.0),
    ];
    let (world, without) = (triangles(&all), triangles(&rest));
    let rays = random_rays(&world, 4_000, 1);
    let first = |index: usize| {
        let (ray, time) = rays.get(index);
        brute::intersect(&world, &ray, time)
    };
    let expected = (0..rays.len())
        .filter(|&i| first(i).is_some_and(|hit| hit.id.primitive == missing as u32))
        .count() as u64;
    assert!(
        expected > 100,
        "only {expected} rays: the test has no power"
    );
    for sides in [[&world, &without], [&without, &world]] {
        let found = between(&world, sides, &rays, false);
        assert_eq!((found.ties, found.edges), (0, 0));
        assert_eq!(found.real, expected);
    }
    // A shadow ray differs only where no other triangle occludes it.
    let occluded = between(&world, [&world, &without], &rays, true);
    let alone = (0..rays.len()).filter(|&i| {
        let (ray, time) = rays.get(i);
        brute::occluded(&world, &ray, time) && !brute::occluded(&without, &ray, time)
    });
    let alone = alone.count() as u64;
    assert!(alone > 10, "only {alone} rays: the test has no power");
    assert_eq!((occluded.real, occluded.edges), (alone, 0));
}

#[test]
fn moved_triangle_is_real_and_its_first_ray_is_reported() {
    let all = random_triangles(30);
    let mut moved = all.clone();
    moved[3] = moved[3].map(|p| p + Vec3::splat(1e-3));
    let (world, moved) = (triangles(&all), triangles(&moved));
    let rays = random_rays(&world, 4_000, 2);
    let [a, b] = [&world, &moved].map(|world| build(world, EXACT));
    let mut report = AgreementReport::new(EXACT, EXACT);
    compare(&world, (EXACT, &b), (EXACT, &a), &rays, false, &mut report);
    assert!(report.real > 100, "{report:?}");
    // The first ray that differs is reported in numbers that parse to the same values.
    let words = report.first_real.expect("there are some");
    let differs = |&index: &usize| {
        let (ray, time) = rays.get(index);
        a.intersect(&ray, time, None) != b.intersect(&ray, time, None)
    };
    let index = (0..rays.len()).find(differs).expect("there are some");
    let (ray, time) = rays.get(index);
    let expected = format!(
        "(origin {:?}, direction {:?}, t from {:?} to {:?}, time {time:?};",
        ray.origin.to_array(),
        ray.dir.to_array(),
        ray.t_min,
        ray.t_max
    );
    assert!(words.contains(&expected), "{words}\n{expected}");
}

#[test]
fn coincident_triangles_are_a_tie() {
    let far = CORNER.map(|p| p + Vec3::splat(100.0));
    let both = triangles(&[CORNER, CORNER]);
    let (first, second) = (triangles(&[CORNER, far]), triangles(&[far, CORNER]));
    let rays = batch((1..100).map(|i| down(0.02 * i as f32, 0.01 * i as f32)));
    let found = between(&both, [&first, &second], &rays, false);
    assert_eq!(
        found,
        Counts {
            ties: 99,
            ..Counts::default()
        }
    );
    // At a distance of 0.01 they are no tie.
    let apart = triangles(&[CORNER, CORNER.map(|p| p - 0.01 * Vec3::Z)]);
    let second = triangles(&[far, CORNER.map(|p| p - 0.01 * Vec3::Z)]);
    let found = between(&apart, [&first, &second], &rays, false);
    assert_eq!(
        found,
        Counts {
            real: 99,
            ..Counts::default()
        }
    );
}

#[test]
fn hits_at_edges_or_ray_ends_are_edges_and_inner_hits_are_real() {
    let (world, empty) = (triangles(&[CORNER]), static_world(vec![]));
    // Hits on both legs, the hypotenuse and a vertex, and at the ends of rays; then hits slightly inside of all of these.
    let until = |t_max: f32| Ray {
        t_max,
        ..down(1.0, 1.0)
    };
    let from = |t_min: f32| Ray {
        t_min,
        ..down(1.0, 1.0)
    };
    let doubtful = [
        down(1.0, 0.0),
        down(0.0, 1.0),
        down(2.0, 2.0),
        down(4.0, 0.0),
        down(1.0, 2e-7),
        until(1.0),
        from(1.0_f32.next_down()),
    ];
    let certain = [
        down(1.0, 1e-4),
        down(1e-4, 1.0),
        down(1.9999, 2.0),
        down(3.999, 5e-4),
        until(1.0001),
        from(0.9999),
        // At a slope of 1e-3 the hit is still where it should be.
        Ray::new(Vec3::new(0.5, 0.5, 1e-3), Vec3::new(1.0, 0.0, -1e-3)),
    ];
    for occlusion in [false, true] {
        for sides in [[&world, &empty], [&empty, &world]] {
            let of = |rays: &[Ray]| between(&world, sides, &batch(rays.iter().copied()), occlusion);
            let edges = doubtful.len() as u64;
            assert_eq!(
                of(&doubtful),
                Counts {
                    edges,
                    ..Counts::default()
                }
            );
            let real = certain.len() as u64;
            assert_eq!(
                of(&certain),
                Counts {
                    real,
                    ..Counts::default()
                }
            );
        }
    }
}

#[test]
fn hit_on_absent_geometry_is_real_also_for_shadow_rays() {
    let (world, empty) = (triangles(&[CORNER]), static_world(vec![]));
    let rays = batch([down(1.0, 1.0)]);
    // The triangle of the scene is not where a side reports it.
    let elsewhere = triangles(&[CORNER.map(|p| p + 0.1 * Vec3::Z)]);
    let wrong = Counts {
        real: 1,
        ..Counts::default()
    };
    assert_eq!(between(&elsewhere, [&world, &empty], &rays, false), wrong);
    let away = triangles(&[CORNER.map(|p| p + 10.0 * Vec3::X)]);
    assert_eq!(between(&away, [&world, &empty], &rays, true), wrong);
}

#[test]
fn hits_behind_a_missed_edge_must_agree() {
    // One side misses an edge, which is allowed, and then, which is not, the certain hit behind it as well.
    let behind = CORNER.map(|p| p - Vec3::new(1.0, 1.0, 1.0));
    let far = CORNER.map(|p| p + Vec3::splat(100.0));
    let world = triangles(&[CORNER, behind]);
    let (only_behind, nothing) = (triangles(&[far, behind]), triangles(&[far, far]));
    let rays = batch([down(1.0, 0.0)]);
    let edge = Counts {
        edges: 1,
        ..Counts::default()
    };
    assert_eq!(between(&world, [&world, &only_behind], &rays, false), edge);
    let wrong = Counts {
        real: 1,
        ..Counts::default()
    };
    assert_eq!(between(&world, [&world, &nothing], &rays, false), wrong);
}

#[test]
fn grazing_hit_may_replace_a_hit_at_equal_distance() {
    // The ray lies in the plane of the first triangle and certainly hits the second at t = 2.
    let grazed = [
        Vec3::new(-1.0, 0.0, -1.0),
        Vec3::new(1.0, 0.0, -1.0),
        Vec3::Z,
    ];
    let met = [
        Vec3::new(0.0, -1.0, -1.0),
        Vec3::new(0.0, 1.0, -1.0),
        Vec3::new(0.0, 0.0, 2.0),
    ];
    let far = CORNER.map(|p| p + Vec3::splat(100.0));
    let world = triangles(&[grazed, met]);
    let rays = batch([Ray::new(Vec3::new(-2.0, 0.0, 0.0), Vec3::X)]);
    let edge = Counts {
        edges: 1,
        ..Counts::default()
    };
    let wrong = Counts {
        real: 1,
        ..Counts::default()
    };
    let only_met = triangles(&[far, met]);
    // One side reports a hit on the first triangle at 2, or slightly behind.
    for (behind, expected) in [(0.0, edge), (1e-2, wrong)] {
        let instead = triangles(&[met.map(|p| p + behind * Vec3::X), far]);
        for sides in [[&only_met, &instead], [&instead, &only_met]] {
            assert_eq!(between(&world, sides, &rays, false), expected, "{behind}");
        }
    }
}

/// Triangles, spheres and disks: without instances, and instanced by transforms of every kind, still and moving.
fn worlds() -> Vec<(String, Arc<World>)> {
    let mut rng = TestRng::new(21);
    let mut worlds = vec![("soup".to_owned(), static_world(soup(&mut rng)))];
    for (name, transform) in transforms(&mut rng) {
        let still = placed_once(soup(&mut rng), vec![transform]);
        worlds.push((format!("{name}, still"), still));
        let steps = moving(&mut rng, transform, 3);
        worlds.push((
            format!("{name}, moving"),
            placed_once(soup(&mut rng), steps),
        ));
    }
    worlds
}

#[test]
fn hit_intervals_contain_oracle_hits_and_certain_ones_are_real() {
    let (mut hits, mut certain) = (0, 0);
    for (name, world) in worlds() {
        for rays in [random_rays(&world, 600, 3), aimed_rays(&world, 200, 3)] {
            for index in 0..rays.len() {
                let (ray, time) = rays.get(index);
                let hit = brute::intersect(&world, &ray, time);
                let intervals = |id: PrimitiveId| hit_intervals(&world, id, &ray, time);
                if let Some(hit) = hit {
                    let interval = intervals(hit.id)
                        .into_iter()
                        .flatten()
                        .find(|m| m.holds(hit.t));
                    let interval = interval.unwrap_or_else(|| panic!("{name}: {hit:?} on {ray:?}"));
                    hits += 1;
                    certain += usize::from(interval.certain);
                }
                for shape in 0..world.shape_count() as u32 {
                    let id = PrimitiveId {
                        shape,
                        primitive: 0,
                    };
                    for interval in intervals(id).into_iter().flatten().filter(|m| m.certain) {
                        let first = hit.unwrap_or_else(|| panic!("{name}: {id:?} on {ray:?}"));
                        assert!(
                            f64::from(first.t) <= interval.to,
                            "{name}: {id:?} on {ray:?}"
                        );
                    }
                }
            }
        }
    }
    assert!(hits > 3_000, "only {hits} hits: the test has no power");
    // Most hits are far from any edge.
    assert!(certain * 2 > hits, "{certain} of {hits}");
}

/// Compares every target with [`EXACT`], on random and on aimed rays.
fn agree(name: &str, world: &Arc<World>, count: usize) -> Counts {
    let reference = build(world, EXACT);
    let mut sum = Counts::default();
    for target in every_target() {
        let accel = build(world, target);
        let sets = [random_rays(world, count, 4), aimed_rays(world, count, 4)];
        for (rays, kind) in sets.iter().zip(["random", "aimed"]) {
            for occlusion in [false, true] {
                let mut report = AgreementReport::new(target, EXACT);
                let sides = ((target, &accel), (EXACT, &reference));
                compare(world, sides.0, sides.1, rays, occlusion, &mut report);
                let found = counts(&report);
                println!(
                    "{name}, {kind}, occlusion {occlusion}, {}: {found:?}",
                    target.name()
                );
                assert_eq!(report.first_real, None, "{name}, {kind}, {}", target.name());
                sum.identical += found.identical;
                sum.ties += found.ties;
                sum.edges += found.edges;
                if kind == "random" {
                    let others = found.ties + found.edges;
                    assert!(
                        others * 100 <= report.rays,
                        "{name}, {}: {found:?}",
                        target.name()
                    );
                }
            }
        }
    }
    sum
}

#[test]
fn backends_agree_on_every_shape_type() {
    for (name, world) in worlds() {
        agree(&name, &world, 500);
    }
}

#[test]
fn backends_agree_on_every_bench_scene() {
    let options = AccelOptions {
        backend: Backend::ObvhsBvh2,
        precision: Precision::Robust,
        quality: Some(Quality::Medium),
        threads: 2,
    };
    for scene in SCENES {
        let prepared = prepare(&scene.describe(3_000), options).expect("it can be traced");
        let found = agree(scene.name, &prepared.scene.world, 2_000);
        assert!(found.identical > 10_000, "{}: {found:?}", scene.name);
    }
}

#[test]
fn report_is_independent_of_threads_and_ray_batching() {
    let all = random_triangles(30);
    let mut moved = all.clone();
    moved[3] = moved[3].map(|p| p + Vec3::splat(1e-3));
    let (world, moved) = (triangles(&all), triangles(&moved));
    let rays = random_rays(&world, 5_000, 5);
    let [a, b] = [&world, &moved].map(|world| build(world, EXACT));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let mut report = AgreementReport::new(EXACT, EXACT);
        pool.expect("threads").install(|| {
            compare(&world, (EXACT, &a), (EXACT, &b), &rays, false, &mut report);
        });
        report
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(counts(&one), counts(&three));
    assert_eq!(one.first_real, three.first_real);
    let mut parts = AgreementReport::new(EXACT, EXACT);
    for part in [0..1_000, 1_000..5_000] {
        let mut some = RayBatch::default();
        for index in part {
            let (ray, time) = rays.get(index);
            some.push(&ray, time);
        }
        compare(&world, (EXACT, &a), (EXACT, &b), &some, false, &mut parts);
    }
    assert_eq!(counts(&one), counts(&parts));
    assert_eq!(one.first_real, parts.first_real);
}
