//! The picture depends on the scene, the seed and the samples alone: not on threads, tiles, or the scene's units.

mod common;

use common::scene_folder::{SMALL, in_repository, load_text, picture};
use etendue::image::{Image, metrics};
use etendue::math::vec::{DAffine3, DVec3};
use etendue::render::settings::{RenderSettings, SamplerKind};
use etendue::scene::description::{GeometryDescription, SceneDescription};
use etendue::scene::load::load;
use std::sync::Arc;

fn settings(scene: &SceneDescription, spp: u64) -> RenderSettings {
    RenderSettings::new(scene.film.size, spp)
}

/// Moves the whole scene by a matrix that scales by `factor` and translates.
fn moved(scene: &SceneDescription, factor: f64, by: DVec3) -> SceneDescription {
    let matrix = DAffine3::from_translation(by) * DAffine3::from_scale(DVec3::splat(factor));
    let mut moved = scene.clone();
    let camera = &mut moved.camera;
    camera.to_world.translation = matrix.transform_point3(camera.to_world.translation);
    camera.lens_radius *= factor;
    camera.focus_distance *= factor;
    for shape in &mut moved.shapes {
        shape.transform = matrix * shape.transform;
    }
    moved
}

/// Scales every length that is written in the scene, instead of its transforms.
fn rewritten(scene: &SceneDescription, factor: f64) -> SceneDescription {
    let mut scaled = scene.clone();
    let camera = &mut scaled.camera;
    camera.to_world.translation *= factor;
    camera.lens_radius *= factor;
    camera.focus_distance *= factor;
    for shape in &mut scaled.shapes {
        shape.transform.translation *= factor;
        match &mut shape.geometry {
            GeometryDescription::Mesh(mesh) => {
                Arc::make_mut(mesh)
                    .positions
                    .iter_mut()
                    .for_each(|p| *p *= factor);
            }
            GeometryDescription::Sphere { center, radius }
            | GeometryDescription::Disk { center, radius, .. } => {
                *center *= factor;
                *radius *= factor;
            }
            GeometryDescription::Rectangle {
                corner,
                edge_u,
                edge_v,
            } => {
                [corner, edge_u, edge_v]
                    .into_iter()
                    .for_each(|v| *v *= factor);
            }
            GeometryDescription::Box { min, max } => {
                *min *= factor;
                *max *= factor;
            }
        }
    }
    scaled
}

/// The Cornell box, smaller and through a lens.
fn cornell_box() -> SceneDescription {
    let path = in_repository("scenes/cornell-box/cornell-box.toml");
    let mut scene = load(&path).expect("it is valid");
    scene.film.size = (32, 32);
    scene.camera.lens_radius = 5.0;
    scene
}

/// Equal bits; `assert_eq` would print all pixels.
#[track_caller]
fn assert_same(got: &Image, want: &Image, what: &str) {
    let differ = |(a, b): &(_, _)| a != b;
    let differing = got
        .pixels()
        .iter()
        .zip(want.pixels())
        .filter(differ)
        .count();
    assert_eq!(differing, 0, "{what}: so many pixels differ");
}

#[test]
fn threads_and_tiles_change_nothing() {
    let scene = load_text(SMALL);
    for sampler in SamplerKind::ALL {
        // 37 samples are passes of 1, 1, 2, 4, 8, 16 and 5.
        let base = RenderSettings {
            sampler: *sampler,
            threads: 1,
            ..settings(&scene, 37)
        };
        let reference = picture(&scene, &base);
        for threads in [1, 2, 5] {
            for tile_size in [1, 16, 32, 1000] {
                let settings = RenderSettings {
                    threads,
                    tile_size,
                    ..base.clone()
                };
                let what = format!(
                    "{}, {threads} threads, tiles of {tile_size}",
                    sampler.name()
                );
                assert_same(&picture(&scene, &settings), &reference, &what);
            }
        }
    }
}

#[test]
fn seeds_and_samplers_change_the_picture() {
    let scene = load_text(SMALL);
    let base = settings(&scene, 4);
    let independent = RenderSettings {
        sampler: SamplerKind::Independent,
        ..base.clone()
    };
    for other in [
        RenderSettings {
            seed: 1,
            ..base.clone()
        },
        RenderSettings {
            seed: 1 << 63,
            ..base.clone()
        },
        independent.clone(),
    ] {
        assert_ne!(
            picture(&scene, &base).pixels(),
            picture(&scene, &other).pixels()
        );
    }
    let seeded = RenderSettings {
        seed: 7,
        ..independent.clone()
    };
    assert_ne!(
        picture(&scene, &seeded).pixels(),
        picture(&scene, &independent).pixels()
    );
}

#[test]
fn units_that_differ_by_a_power_of_two_change_nothing() {
    for scene in [load_text(SMALL), cornell_box()] {
        for sampler in SamplerKind::ALL {
            let settings = RenderSettings {
                sampler: *sampler,
                ..settings(&scene, 8)
            };
            let reference = picture(&scene, &settings);
            for exponent in [-20, -3, 1, 17] {
                let factor = f64::exp2(f64::from(exponent));
                let what = format!("{}, 2^{exponent}", sampler.name());
                let by_transform = moved(&scene, factor, DVec3::ZERO);
                assert_same(&picture(&by_transform, &settings), &reference, &what);
                let by_lengths = rewritten(&scene, factor);
                assert_same(&picture(&by_lengths, &settings), &reference, &what);
            }
        }
    }
}

#[test]
fn a_scene_far_from_the_origin_looks_the_same() {
    // Places are rounded to 2^-29 there, in double precision: only a path that grazes an edge may take another way.
    for scene in [load_text(SMALL), cornell_box()] {
        for sampler in SamplerKind::ALL {
            let settings = RenderSettings {
                sampler: *sampler,
                ..settings(&scene, 16)
            };
            let reference = picture(&scene, &settings);
            let far = moved(&scene, 1.0, DVec3::new(1e7, -1e7, 1e7));
            let error = metrics::rel_mse(&picture(&far, &settings), &reference).expect("same size");
            assert!(error.sqrt() <= 1e-4, "{}: {}", sampler.name(), error.sqrt());
        }
    }
}
