//! Metamorphic tests: changes of the scene whose effect on the image is known exactly. Lights are scaled, units and
//! position changed; surfaces are duplicated, turned inside out, reordered, and rotated to other axes. They run on
//! generated scenes with every backend; `determinism.rs` does the same for whole images with the preferred backend.

use crate::common::generated::{Generator, SIZE};
use crate::common::scene::{ready, see};
use crate::common::scene_folder::{SMALL, load_text};
use etendue::internals::accel::Backend;
use etendue::internals::effects::{Effect, EffectSet};
use etendue::internals::film::filter::Filter;
use etendue::internals::geometry::texture::Texture;
use etendue::internals::image::{Image, metrics};
use etendue::internals::integrator::Roulette;
use etendue::internals::math::vec::{DAffine3, DMat3, DVec3};
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::render::{NullRenderObserver, render};
use etendue::internals::scene::description::{
    ColourDescription, GeometryDescription, Keyframe, LightModel, SceneDescription,
};
use std::sync::Arc;

/// Scenes with random effects: the index, one backend in turn, and the scene.
fn generated(seed: u64, count: usize) -> impl Iterator<Item = (usize, Backend, SceneDescription)> {
    let mut generator = Generator::new(seed);
    (0..count).map(move |index| {
        let wanted = generator.wanted();
        let backend = Backend::ALL[index % Backend::ALL.len()];
        (index, backend, generator.scene(wanted))
    })
}

fn settings(description: &SceneDescription) -> RenderSettings {
    RenderSettings {
        seed: 5,
        threads: 1,
        ..RenderSettings::new(description.film.size, 2)
    }
}

fn picture(description: &SceneDescription, backend: Backend, settings: &RenderSettings) -> Image {
    let scene = ready(description, backend);
    let filter = Filter::new(&description.film.filter);
    let size = description.film.size;
    let rendered =
        render(&scene, &filter, size, settings, &NullRenderObserver).expect("valid settings");
    assert_eq!(rendered.rejected.count, 0, "samples that are not finite");
    rendered.film.develop()
}

/// Asserts that the first image equals `factor` times the second one, bit for bit.
#[track_caller]
fn assert_same(what: &str, got: &Image, want: &Image, factor: f32) {
    let pairs = got.pixels().iter().zip(want.pixels());
    let bits = |colour: etendue::internals::math::rgb::Rgb| colour.to_array().map(f32::to_bits);
    let differing = pairs.filter(|(got, want)| bits(**got) != bits(**want * factor));
    assert_eq!(differing.count(), 0, "{what}: number of pixels that differ");
}

/// Asserts equality up to the rounding of positions, by which a path near an edge may diverge.
#[track_caller]
fn assert_close(what: &str, got: &Image, want: &Image) {
    let error = metrics::rel_mse(got, want).expect("same size").sqrt();
    assert!(error <= 1e-4, "{what}: root of relMSE {error}");
}

/// Asserts equality up to the rounding of positions in all but a few pixels, where samples near an edge may differ.
#[track_caller]
fn assert_mostly_close(what: &str, got: &Image, want: &Image) {
    let pairs = got.pixels().iter().zip(want.pixels());
    let differing = pairs.filter(|(got, want)| {
        let pairs = got.to_array().into_iter().zip(want.to_array());
        pairs
            .into_iter()
            .any(|(got, want)| (got - want).abs() > 1e-4 * (1.0 + want.abs()))
    });
    let (differing, all) = (differing.count(), want.pixels().len());
    assert!(
        100 * differing <= 2 * all,
        "{what}: {differing} pixels differ of {all}"
    );
}

/// The scene with all lights and emission multiplied by `factor`.
fn brighter(scene: &SceneDescription, factor: f32) -> SceneDescription {
    let scaled = |colour: &mut ColourDescription| match colour {
        ColourDescription::Constant(constant) => *constant *= factor,
        ColourDescription::Texture(texture) => match Arc::make_mut(texture) {
            Texture::Image { scale, .. } => *scale *= factor,
            Texture::Placed { tint, .. } => *tint *= factor,
            Texture::Checker { colours, .. } => *colours = colours.map(|colour| colour * factor),
        },
    };
    let mut scene = scene.clone();
    scene
        .shapes
        .iter_mut()
        .filter_map(|shape| shape.emission.as_mut())
        .for_each(scaled);
    for light in &mut scene.lights {
        match &mut light.model {
            LightModel::Environment { radiance, .. } => scaled(radiance),
            LightModel::Point { intensity, .. } | LightModel::Spot { intensity, .. } => {
                *intensity *= factor;
            }
            LightModel::Distant { irradiance, .. } => *irradiance *= factor,
            other => panic!("{other:?} is not scaled by this test"),
        }
    }
    scene
}

/// The whole scene, rotated by `turn`, scaled by `factor` and translated; the intensity of point and spot lights is
/// scaled so that the image stays the same.
fn moved(scene: &SceneDescription, turn: DMat3, factor: f64, by: DVec3) -> SceneDescription {
    let matrix = DAffine3::from_mat3_translation(factor * turn, by);
    let within = |keys: &mut Vec<Keyframe>| {
        for key in keys {
            key.transform = matrix * key.transform * matrix.inverse();
        }
    };
    let mut scene = scene.clone();
    let camera = &mut scene.camera;
    camera.to_world.matrix3 = turn * camera.to_world.matrix3;
    camera.to_world.translation = matrix.transform_point3(camera.to_world.translation);
    camera.lens_radius *= factor;
    let bumps = scene.materials.iter_mut();
    for bumps in bumps.filter_map(|material| material.bump_map.as_mut()) {
        bumps.height *= factor as f32;
    }
    camera.focus_distance *= factor;
    for shape in scene
        .shapes
        .iter_mut()
        .filter(|shape| shape.group.is_none())
    {
        shape.transform = matrix * shape.transform;
        within(&mut shape.motion);
    }
    for instance in scene.instances.iter_mut().filter(|it| it.group.is_none()) {
        instance.transform = matrix * instance.transform;
        within(&mut instance.motion);
    }
    let area = (factor * factor) as f32;
    for light in &mut scene.lights {
        match &mut light.model {
            LightModel::Environment { to_world, .. } => *to_world = turn * *to_world,
            LightModel::Point {
                position,
                intensity,
            } => {
                *position = matrix.transform_point3(*position);
                *intensity *= area;
            }
            LightModel::Spot {
                position,
                target,
                intensity,
                ..
            } => {
                *position = matrix.transform_point3(*position);
                *target = matrix.transform_point3(*target);
                *intensity *= area;
            }
            LightModel::Distant { direction, .. } => *direction = turn * *direction,
            other => panic!("{other:?} is not moved by this test"),
        }
    }
    scene
}

#[test]
fn scaling_lights_by_powers_of_two_scales_pixels_exactly() {
    for (index, backend, scene) in generated(11, 24) {
        let settings = settings(&scene);
        let reference = picture(&scene, backend, &settings);
        for exponent in [-60, -31, -1, 1, 17, 60] {
            let factor = f32::exp2(exponent as f32);
            let what = format!("scene {index}, {}, 2^{exponent}", backend.name());
            let got = picture(&brighter(&scene, factor), backend, &settings);
            assert_same(&what, &got, &reference, factor);
        }
    }
}

#[test]
fn scaling_units_by_powers_of_two_leaves_images_bit_identical() {
    for (index, backend, scene) in generated(12, 24) {
        let settings = settings(&scene);
        let reference = picture(&scene, backend, &settings);
        for exponent in [-40, -1, 40] {
            let factor = f64::exp2(f64::from(exponent));
            let what = format!("scene {index}, {}, 2^{exponent}", backend.name());
            let scaled = moved(&scene, DMat3::IDENTITY, factor, DVec3::ZERO);
            assert_same(
                &what,
                &picture(&scaled, backend, &settings),
                &reference,
                1.0,
            );
        }
    }
}

#[test]
fn distant_translation_preserves_images_with_every_backend() {
    let scene = load_text(SMALL);
    let settings = settings(&scene);
    for &backend in Backend::ALL {
        let reference = picture(&scene, backend, &settings);
        for distance in [1e4, 1e7] {
            let by = distance * DVec3::new(1.0, -1.0, 1.0);
            let far = moved(&scene, DMat3::IDENTITY, 1.0, by);
            let what = format!("{}, {distance}", backend.name());
            assert_close(&what, &picture(&far, backend, &settings), &reference);
        }
    }
}

#[test]
fn images_are_independent_of_threads_and_tiles_for_any_backend() {
    for (index, _, scene) in generated(13, 4) {
        for &backend in Backend::ALL {
            let base = settings(&scene);
            let reference = picture(&scene, backend, &base);
            for (threads, tile_size) in (1..=8).zip([1, 2, 3, 5, 7, 8, 11, 100]) {
                let what = format!(
                    "scene {index}, {}, {threads} threads, tiles of {tile_size}",
                    backend.name()
                );
                let other = RenderSettings {
                    threads,
                    tile_size,
                    ..base.clone()
                };
                assert_same(&what, &picture(&scene, backend, &other), &reference, 1.0);
            }
        }
    }
}

/// The subset of these effects with opaque shapes and without area lights.
fn opaque(wanted: EffectSet) -> EffectSet {
    use Effect::{Alpha, AreaLights, Transmission};
    let others = wanted.without(Transmission).without(Alpha);
    others.without(AreaLights)
}

#[test]
fn duplicated_opaque_shapes_leave_images_bit_identical() {
    let mut generator = Generator::new(14);
    for index in 0..12 {
        let wanted = opaque(generator.wanted());
        let mut scene = generator.scene(wanted);
        // Two-sided, because either of two coincident faces may be hit first.
        scene
            .materials
            .iter_mut()
            .for_each(|material| material.two_sided = true);
        let settings = settings(&scene);
        let twice = SceneDescription {
            shapes: scene
                .shapes
                .iter()
                .flat_map(|shape| [shape.clone(), shape.clone()])
                .collect(),
            ..scene.clone()
        };
        for &backend in Backend::ALL {
            let what = format!("scene {index}, {}", backend.name());
            let got = picture(&twice, backend, &settings);
            assert_same(&what, &got, &picture(&scene, backend, &settings), 1.0);
        }
    }
}

#[test]
fn unreferenced_vertices_leave_images_bit_identical() {
    let mut generator = Generator::new(18);
    for index in 0..6 {
        let wanted = generator.wanted().with(Effect::ShadingNormals);
        let scene = generator.scene(wanted);
        let settings = settings(&scene);
        let mut strayed = scene.clone();
        for shape in &mut strayed.shapes {
            if let GeometryDescription::Mesh(mesh) = &mut shape.geometry {
                let mesh = Arc::make_mut(mesh);
                mesh.positions.push(DVec3::new(1e12, -1e300, 3.0));
                mesh.normals.extend(mesh.normals.first().copied());
                mesh.uvs.extend(mesh.uvs.first().copied());
            }
        }
        for &backend in Backend::ALL {
            let what = format!("scene {index}, {}", backend.name());
            let got = picture(&strayed, backend, &settings);
            assert_same(&what, &got, &picture(&scene, backend, &settings), 1.0);
        }
    }
}

#[test]
fn reordered_nonemissive_shapes_leave_images_bit_identical() {
    for (index, _, scene) in generated(15, 12) {
        let settings = settings(&scene);
        let (mut lamps, mut others): (Vec<_>, Vec<_>) = scene
            .shapes
            .iter()
            .cloned()
            .partition(|shape| shape.emission.is_some());
        // Area lights keep their order, as it determines which random number selects which light.
        others.reverse();
        others.append(&mut lamps);
        let reversed = SceneDescription {
            shapes: others,
            ..scene.clone()
        };
        for &backend in Backend::ALL {
            let what = format!("scene {index}, {}", backend.name());
            let got = picture(&reversed, backend, &settings);
            assert_same(&what, &got, &picture(&scene, backend, &settings), 1.0);
        }
    }
}

#[test]
fn flipping_two_sided_triangles_preserves_most_pixels() {
    let wanted = opaque(EffectSet::ALL.without(Effect::Instances));
    let mut generator = Generator::new(16);
    let mut flipped = 0;
    for index in 0..12 {
        let mut scene = generator.scene(wanted);
        for material in &mut scene.materials {
            material.two_sided = true;
            material.normal_map = None;
            material.bump_map = None;
        }
        let settings = settings(&scene);
        let mut inside_out = scene.clone();
        for shape in &mut inside_out.shapes {
            if let GeometryDescription::Mesh(mesh) = &mut shape.geometry {
                let mesh = Arc::make_mut(mesh);
                mesh.normals
                    .iter_mut()
                    .for_each(|normal| *normal = -*normal);
                mesh.indices
                    .iter_mut()
                    .for_each(|[_, b, c]| std::mem::swap(b, c));
                flipped += mesh.indices.len();
            }
        }
        for &backend in Backend::ALL {
            let what = format!("scene {index}, {}", backend.name());
            let got = picture(&inside_out, backend, &settings);
            assert_mostly_close(&what, &got, &picture(&scene, backend, &settings));
        }
    }
    assert!(flipped >= 20, "{flipped} triangles");
}

#[test]
fn cyclic_axis_permutation_preserves_the_mean() {
    // Maps x to y, y to z and z to x.
    let turn = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
    for (index, backend, mut scene) in generated(17, 12) {
        // All pixels see the same point and are replicates.
        scene.camera.fov = 1e-4;
        scene.film.size = (8, 4);
        let turned = moved(&scene, turn, 1.0, DVec3::ZERO);
        let [a, b] = [&scene, &turned].map(|scene| {
            let seen = see(scene, backend, 256, Some(4), Roulette::None);
            (seen.mean(), seen.standard_error().expect("32 pixels"))
        });
        let error = a.1.hypot(b.1);
        let what = format!("scene {index}, {}: {a:?}, turned {b:?}", backend.name());
        assert!((a.0 - b.0).abs() <= 5.2 * error + 4e-6 * a.0, "{what}");
        assert!(error <= 0.05 * a.0, "inconclusive: {what}");
    }
}

#[test]
fn most_generated_images_are_not_black() {
    let lit = generated(11, 24).filter(|(_, backend, scene)| {
        let image = picture(scene, *backend, &settings(scene));
        assert_eq!((image.width(), image.height()), SIZE);
        image.mean().iter().any(|mean| *mean > 1e-3)
    });
    assert!(lit.count() >= 16);
}
