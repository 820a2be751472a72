//! The scenes that the bench generates, and the closed meshes that it tests for leaks.

use crate::common::scene_folder::in_repository;
use crate::common::tracing::every_accel;
use etendue::internals::accel::{Accel, AccelOptions, Backend, Precision, Quality, brute};
use etendue::internals::geometry::world::World;
use etendue::internals::geometry::{Geometry, mesh::Mesh};
use etendue::internals::image::metrics;
use etendue::internals::math::vec::DVec3;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::render::{NullRenderObserver, render};
use etendue::internals::scene::description::{GeometryDescription, SceneDescription};
use etendue::internals::scene::prepare::prepare;
use etendue_lab::bench::closed::{Aim, ClosedForm, ClosedMesh};
use etendue_lab::bench::leaks::leaks;
use etendue_lab::bench::scenes::{SCENES, suzanne_room};
use etendue_lab::bench::target::BenchTarget;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

const TARGET: BenchTarget = BenchTarget {
    backend: Backend::ALL[0],
    precision: Precision::Robust,
    quality: Quality::High,
};

fn build(world: &Arc<World>) -> Accel {
    Accel::build(Arc::clone(world), TARGET.options(2)).expect("a small mesh")
}

fn never() -> bool {
    false
}

fn triangles(scene: &SceneDescription) -> usize {
    let of = |geometry: &GeometryDescription| match geometry {
        GeometryDescription::Mesh(mesh) => mesh.indices.len(),
        _ => 2,
    };
    scene.shapes.iter().map(|shape| of(&shape.geometry)).sum()
}

#[test]
fn scenes_have_requested_size_and_render_a_lit_image() {
    for scene in SCENES {
        let mut described = scene.describe(4_000);
        if scene.name != "cornell-box" {
            let (found, asked) = (triangles(&described), 4_000);
            assert!(found.abs_diff(asked) < 1_400, "{}: {found}", scene.name);
        }
        described.film.size = (48, 32);
        let options: AccelOptions = TARGET.options(2);
        let prepared = prepare(&described, options).expect("it can be rendered");
        assert_eq!(prepared.notes, Vec::<String>::new(), "{}", scene.name);
        let settings = RenderSettings::new(described.film.size, 4);
        let filter = etendue::internals::film::filter::Filter::new(&described.film.filter);
        let rendered = render(
            &prepared.scene,
            &filter,
            described.film.size,
            &settings,
            &NullRenderObserver,
        )
        .expect("the settings are valid");
        let rays = rendered.rays;
        // Paths continue from hits: the camera sees geometry.
        assert!(
            (rays.shadow + rays.closest) * 3 > rays.camera,
            "{}: {rays:?}",
            scene.name
        );
        let image = rendered.film.develop();
        let mean = image.mean()[1];
        assert!((0.05..2.0).contains(&mean), "{}: mean {mean}", scene.name);
        // The image is not constant.
        let flat = etendue::internals::image::Image::filled(48, 32, [mean as f32; 3].into());
        let mse = metrics::mse(&image, &flat).expect("the same size");
        let contrast = mse.sqrt() / mean;
        assert!(contrast > 0.2, "{}: contrast {contrast}", scene.name);
    }
}

#[test]
fn scene_generation_is_deterministic() {
    for scene in SCENES {
        let positions = |scene: SceneDescription| -> Vec<DVec3> {
            let of = |geometry: &GeometryDescription| match geometry {
                GeometryDescription::Mesh(mesh) => mesh.positions.clone(),
                _ => vec![],
            };
            scene
                .shapes
                .iter()
                .flat_map(|shape| of(&shape.geometry))
                .collect()
        };
        let (a, b) = (scene.describe(1_000), scene.describe(1_000));
        assert_eq!(positions(a), positions(b), "{}", scene.name);
    }
}

#[test]
fn cornell_box_matches_its_scene_file() {
    let path = in_repository("scenes/cornell-box/cornell-box.toml");
    let file = etendue::internals::scene::load::load(&path).expect("it is in the sources");
    let made = SCENES[0].describe(0);
    assert_eq!(made.film, file.film);
    assert!((made.camera.fov - file.camera.fov).abs() < 1e-12);
    assert_eq!(made.camera.to_world, file.camera.to_world);
    assert_eq!(made.shapes.len(), file.shapes.len());
    let sorted = |geometry: &GeometryDescription| match geometry {
        GeometryDescription::Mesh(mesh) => {
            let mut triangles = mesh.indices.clone();
            // Triangles compare equal whichever vertex is first.
            for t in &mut triangles {
                let first = (0..3).min_by_key(|&k| t[k]).expect("three");
                t.rotate_left(first);
            }
            triangles.sort_unstable();
            format!("{:?} {triangles:?}", mesh.positions)
        }
        other => format!("{other:?}"),
    };
    for (made_shape, shape) in made.shapes.iter().zip(&file.shapes) {
        assert_eq!(made_shape.name, shape.name);
        assert_eq!(sorted(&made_shape.geometry), sorted(&shape.geometry));
        let colour =
            |scene: &SceneDescription, index: usize| format!("{:?}", scene.materials[index].model);
        assert_eq!(
            colour(&made, made_shape.material),
            colour(&file, shape.material)
        );
        assert_eq!(
            format!("{:?}", made_shape.emission),
            format!("{:?}", shape.emission)
        );
    }
}

#[test]
fn suzanne_room_is_found_in_the_source_tree() {
    let room = suzanne_room().expect("tests run in the sources");
    assert!(room.ends_with("scenes/suzanne-room/suzanne-room.toml"));
}

#[test]
fn every_segment_intersects_its_closed_mesh() {
    // The counts of leaks rely on this; tested in double precision by brute force.
    for mesh in ClosedMesh::all(4) {
        let world = mesh.world();
        let mut random = etendue_lab::bench::random::Random::new(1, 0);
        for &aim in Aim::ALL {
            let mut missed = 0;
            for _ in 0..300 {
                let segment = mesh.segment(aim, &mut random);
                missed += usize::from(!brute::occluded(world, &segment, 0.0));
            }
            assert_eq!(missed, 0, "{}, {}", mesh.name(), aim.name());
        }
    }
}

/// Embree's robust mode leaks some segments at vertices (Embree issue 181): 1 to 5 of 20,000 here, and 1.4 % of them with a
/// bumpy sphere as fine as that of `etendue bench`.
#[test]
fn closed_mesh_leaks_stay_within_the_limits_per_backend() {
    const SEGMENTS: u64 = 20_000;
    for mesh in ClosedMesh::all(6) {
        for (name, accel) in every_accel(mesh.world()) {
            for &aim in Aim::ALL {
                let report = leaks(&mesh, aim, (TARGET, &accel), SEGMENTS, 3, &never);
                let counted = (report.segments, report.aim.as_str());
                assert_eq!(counted, (SEGMENTS, aim.name()));
                println!("{name}, {}, {}: {}", report.mesh, report.aim, report.leaks);
                // Where fast mode is known to leak, its leaks are counted without a limit.
                let allowed = match aim {
                    Aim::Edge | Aim::Vertex if name.ends_with("fast") => SEGMENTS,
                    Aim::Vertex if name.starts_with("embree") => SEGMENTS / 100,
                    _ => 0,
                };
                assert!(
                    report.leaks <= allowed,
                    "{name}, {}, {}: {}",
                    report.mesh,
                    report.aim,
                    report.leaks
                );
            }
        }
    }
}

/// The room without the triangles on one of its six sides.
fn without_a_side(room: &ClosedMesh) -> Arc<World> {
    let [Geometry::Mesh(mesh)] = room.world().geometries() else {
        panic!("a closed mesh is one mesh");
    };
    let on_side = |t: &[u32; 3]| {
        t.iter()
            .all(|&i| mesh.vertices()[i as usize].position().y >= 1.0)
    };
    let kept = mesh.indices().iter().copied().filter(|t| !on_side(t));
    let open = Mesh::new(mesh.positions().collect(), vec![], vec![], kept.collect());
    Arc::new(World::new(vec![Geometry::Mesh(open)], vec![], vec![]))
}

#[test]
fn open_room_leaks_one_sixth_of_segments() {
    // The origins of segments are distributed as symmetrically as the room: each side fills a sixth of the sphere on average.
    let room = ClosedMesh::new(ClosedForm::Room, 5, 1.0, 0.0);
    let open = build(&without_a_side(&room));
    let segments = 200_000;
    let report = leaks(&room, Aim::Anywhere, (TARGET, &open), segments, 7, &never);
    let p = 1.0 / 6.0;
    let sigma = (p * (1.0 - p) / segments as f64).sqrt();
    let z = (report.leaks as f64 / segments as f64 - p) / sigma;
    // One sigma is half a percent of the sixth; an error of 4 %, as by a wall that hides some, is eight.
    assert!(z.abs() < 4.5, "{} leaks, z = {z}", report.leaks);
}

#[test]
fn leak_counts_are_thread_independent_and_cancellable() {
    let room = ClosedMesh::new(ClosedForm::Room, 2, 1.0, 0.0);
    let open = build(&without_a_side(&room));
    let segments = 300_000;
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let report = pool
            .expect("threads")
            .install(|| leaks(&room, Aim::Edge, (TARGET, &open), segments, 9, &never));
        (report.segments, report.leaks)
    };
    assert_eq!(on(1), on(3));
    assert!(on(1).1 > 1_000);
    let asked = AtomicU64::new(0);
    let soon = || asked.fetch_add(1, Ordering::Relaxed) >= 2;
    let report = leaks(&room, Aim::Edge, (TARGET, &open), segments, 9, &soon);
    assert!((1..segments).contains(&report.segments), "{report:?}");
}

#[test]
fn closed_meshes_share_each_edge_twice_with_unique_vertices() {
    for mesh in ClosedMesh::all(4) {
        let [Geometry::Mesh(mesh)] = mesh.world().geometries() else {
            panic!("a closed mesh is one mesh");
        };
        let mut edges = std::collections::HashMap::new();
        for t in mesh.indices() {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                *edges.entry((a.min(b), a.max(b))).or_insert(0) += 1;
            }
        }
        assert!(edges.values().all(|&count| count == 2));
        let distinct: std::collections::HashSet<[u32; 3]> = mesh
            .positions()
            .map(|p| p.to_array().map(f32::to_bits))
            .collect();
        assert_eq!(distinct.len(), mesh.positions().len());
    }
}
