//! The image depends on the scene, the seed and the samples alone: not on threads, tiles, or the scene's units.

use crate::common::scene_folder::{SMALL, in_repository, load_text, picture};
use etendue::internals::accel::{AccelOptions, Backend, Precision};
use etendue::internals::film::Film;
use etendue::internals::film::filter::Filter;
use etendue::internals::film::pixel::PixelSums;
use etendue::internals::image::{Image, metrics};
use etendue::internals::integrator::observer::NullPathObserver;
use etendue::internals::math::vec::{DAffine3, DVec3};
use etendue::internals::render::observe_tile;
use etendue::internals::render::replay::replay;
use etendue::internals::render::settings::{RenderSettings, SamplerKind};
use etendue::internals::scene::description::{GeometryDescription, SceneDescription};
use etendue::internals::scene::load::load;
use etendue::internals::scene::prepare::prepare;
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

/// Scales every length in the scene's description, instead of its transforms.
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
            other => panic!("no scaling implemented for {other:?}"),
        }
    }
    scaled
}

/// The Cornell box, at a lower resolution and through a lens.
fn cornell_box() -> SceneDescription {
    let path = in_repository("scenes/cornell-box/cornell-box.toml");
    let mut scene = load(&path).expect("it is valid");
    scene.film.size = (32, 32);
    scene.camera.lens_radius = 5.0;
    scene
}

/// Asserts that pixels are bit-identical; `assert_eq` would print all of them.
#[track_caller]
fn assert_same(got: &Image, want: &Image, what: &str) {
    let differ = |(a, b): &(_, _)| a != b;
    let differing = got
        .pixels()
        .iter()
        .zip(want.pixels())
        .filter(differ)
        .count();
    assert_eq!(differing, 0, "{what}: number of pixels that differ");
}

/// Coincident surfaces, of which each ray hits one: which one could depend on how rays are traced together.
fn coincident() -> SceneDescription {
    let mut text = String::from(
        "version = 1\n[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n[film]\nsize = [24, 16]\n",
    );
    for emission in 1..=6 {
        let turn = 37 * emission;
        text += &format!(
            "[[shape]]\ntype = \"rectangle\"\ncorner = [-1, -1, 0]\nedge_u = [2, 0, 0]\nedge_v = [0, 2, 0]\n\
             transform = [{{ rotate = {{ axis = [0, 0, 1], angle = {turn} }} }}]\n\
             emission = {emission}\n"
        );
    }
    load_text(&text)
}

#[test]
fn samples_are_independent_of_how_they_are_batched() {
    let description = coincident();
    let filter = Filter::new(&description.film.filter);
    for &backend in Backend::ALL {
        for precision in [Precision::Fast, Precision::Robust] {
            let options = AccelOptions {
                backend,
                precision,
                quality: None,
                threads: 1,
            };
            let scene = prepare(&description, options).expect("it is valid").scene;
            let settings = settings(&description, 53);
            let image = |cuts: &[u64]| {
                let mut film = Film::new(settings.window, 1000);
                let tile = &mut film.tiles_mut()[0];
                for ends in cuts.windows(2) {
                    let range = ends[0]..ends[1];
                    observe_tile(
                        &scene,
                        &filter,
                        &settings,
                        None,
                        tile,
                        range,
                        &mut NullPathObserver,
                    );
                }
                film.develop()
            };
            let reference = image(&[0, 53]);
            for cuts in [
                &[0, 5, 6, 7, 11, 19, 40, 41, 53][..],
                &[0, 16, 32, 48, 53],
                &Vec::from_iter(0..=53),
            ] {
                let what = format!("{} {}: {cuts:?}", backend.name(), precision.name());
                assert_same(&image(cuts), &reference, &what);
            }
            let replayed = |pixel: [u32; 2]| {
                let mut sums = PixelSums::default();
                for sample in 0..53 {
                    let replayed = replay(&scene, &filter, &settings, pixel, sample);
                    let replayed = replayed.expect("the settings are valid");
                    sums.add(sample, replayed.radiance);
                }
                sums.mean(53).map(|x| x as f32)
            };
            for pixel in [[12, 8], [9, 6], [15, 9]] {
                let got = replayed(pixel);
                let at = (pixel[1] * reference.width() + pixel[0]) as usize;
                assert_eq!(reference.pixels()[at].to_array(), got);
            }
        }
    }
}

#[test]
fn images_are_bit_identical_across_threads_and_tiles() {
    let scene = load_text(SMALL);
    for sampler in SamplerKind::ALL {
        // 37 samples are taken in passes of 1, 1, 2, 4, 8, 16 and 5.
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
fn seeds_and_samplers_change_the_image() {
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
fn power_of_two_unit_scaling_leaves_images_bit_identical() {
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
fn distant_translation_preserves_the_image() {
    // Positions are rounded to 2^-29 there, in double precision: only a path that grazes an edge may differ.
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
