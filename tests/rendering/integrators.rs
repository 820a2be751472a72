//! The integrators of the course estimate the same integral: each agrees with `path` in every tile of the image, for
//! each number of bounces, with any roulette; and those that are not path tracers agree with closed forms.
//!
//! Tiles are compared by Welch's test, at a significance of 1e-4 for all tests of this file together.

use crate::common::chi_square::uniformity;
use crate::common::closed_forms::{coaxial_discs, parallel_rectangle};
use crate::common::furnished::{glass, matte, outside, six_scenes};
use crate::common::nightly::{is_nightly, one_in, samples_and_limit};
use crate::common::room::{floor_below, room};
use crate::common::scene::{film, ready, rectangle, slide};
use crate::common::verdict::{assert_mean, sidak};
use etendue::internals::accel::Backend;
use etendue::internals::effects::{Effect, EffectSet, Kernel};
use etendue::internals::film::Film;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::integrator::roulette::{Roulette, WeightWindow};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::stats::{Moments, student_quantile_of};
use etendue::internals::math::vec::{DAffine3, DVec3};
use etendue::internals::render::settings::{RenderSettings, SamplerKind};
use etendue::internals::scene::description::{GeometryDescription, SceneDescription};
use statrs::distribution::{ContinuousCDF, Normal};

/// The path tracers of the course except the last.
const COURSE: [IntegratorKind; 5] = [
    IntegratorKind::Naive,
    IntegratorKind::EmitOrReflect,
    IntegratorKind::Bsdf,
    IntegratorKind::LightOrRest,
    IntegratorKind::NextEvent,
];

/// Renders a scene.
pub fn rendered(description: &SceneDescription, settings: &RenderSettings) -> Film {
    film(&ready(description, Backend::ALL[0]), description, settings)
}

/// The settings of an integrator, with independent samples.
pub fn settings(
    description: &SceneDescription,
    integrator: IntegratorKind,
    seed: u64,
    spp: u64,
) -> RenderSettings {
    RenderSettings {
        integrator,
        sampler: SamplerKind::Independent,
        seed,
        tile_size: 4,
        ..RenderSettings::new(description.film.size, spp)
    }
}

/// The mean and squared standard error of a channel, for each tile and, last, for the whole image.
fn means(film: &Film, channel: usize) -> Vec<(f64, f64)> {
    let mean_of = |parts: &mut dyn ExactSizeIterator<Item = (f64, f64)>| {
        let count = parts.len() as f64;
        let (mean, variance) = parts.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        (mean / count, variance / (count * count))
    };
    let mut means: Vec<(f64, f64)> = film
        .tiles()
        .iter()
        .map(|tile| {
            mean_of(&mut tile.pixels.iter().map(|pixel| {
                let batches = pixel.batch_means(tile.samples);
                let variance = batches.variance().expect("several samples")[channel];
                (batches.mean()[channel], variance / tile.samples as f64)
            }))
        })
        .collect();
    means.push(mean_of(&mut means.clone().into_iter()));
    means
}

/// Asserts equal means by Welch's test of every tile and of the whole image, whose relative standard error has to be below
/// `power`. The tests of this file are about three thousand.
pub fn assert_same(what: &str, a: &Film, b: &Film, power: f64) {
    // Each of the sixteen pixels of a tile has three degrees of freedom.
    let limit = student_quantile_of(48.0, 1.0 - 0.5 * sidak(1e-4, 3000));
    for channel in 0..3 {
        let pairs = means(a, channel).into_iter().zip(means(b, channel));
        for (tile, ((a, va), (b, vb))) in pairs.enumerate() {
            let z = (a - b) / (va + vb).sqrt();
            assert!(
                a == b || z.abs() < limit,
                "{what}, channel {channel}, tile {tile}: {a} and {b}, {z} standard errors apart"
            );
        }
    }
    let (a, va) = *means(a, 1).last().expect("the whole");
    let (_, vb) = *means(b, 1).last().expect("the whole");
    let error = (va + vb).sqrt() / a;
    println!("{what}: standard error {error:.5}");
    assert!(
        error < power,
        "{what}: inconclusive, a standard error of {error}"
    );
}

#[test]
fn every_path_tracer_agrees_with_path() {
    for (place, (name, scene, power)) in six_scenes().iter().enumerate() {
        let (spp, limit) = samples_and_limit(1 << 12, *power);
        let path = rendered(scene, &settings(scene, IntegratorKind::Path, 1, spp));
        for &integrator in one_in(3, place % 3, &COURSE) {
            if integrator == IntegratorKind::Naive && *name == "rough glass" {
                // At every vertex in the glass the coin flip doubles the throughput, and a uniform direction multiplies its
                // square by more than 1/2 on average: the variance is infinite, and the standard error is meaningless.
                continue;
            }
            let spp = match integrator {
                IntegratorKind::Naive | IntegratorKind::EmitOrReflect => 2 * spp,
                _ => spp,
            };
            let other = rendered(scene, &settings(scene, integrator, 2, spp));
            assert_same(
                &format!("{name}, {}", integrator.name()),
                &other,
                &path,
                limit,
            );
        }
    }
}

#[test]
fn path_tracers_agree_for_zero_to_three_bounces() {
    let scene = glass(0.0);
    for max_bounces in 0..4 {
        let limited = |integrator, seed, spp| {
            let settings = RenderSettings {
                max_bounces: Some(max_bounces),
                ..settings(&scene, integrator, seed, spp)
            };
            rendered(&scene, &settings)
        };
        let (spp, limit) = samples_and_limit(1 << 11, 0.012);
        let path = limited(IntegratorKind::Path, 3, spp);
        for &integrator in one_in(2, max_bounces as usize % 2, &COURSE) {
            let what = format!("{max_bounces} bounces, {}", integrator.name());
            assert_same(&what, &limited(integrator, 4, 2 * spp), &path, limit);
        }
    }
}

#[test]
fn russian_roulette_leaves_the_mean_unchanged() {
    let scene = glass(0.8);
    let (spp, limit) = samples_and_limit(1 << 11, 0.012);
    let with = |integrator, roulette, seed| {
        let settings = RenderSettings {
            roulette: Some(roulette),
            max_bounces: Some(12),
            ..settings(&scene, integrator, seed, spp)
        };
        rendered(&scene, &settings)
    };
    for integrator in [IntegratorKind::Path, IntegratorKind::LightOrRest] {
        let never = with(integrator, Roulette::None, 5);
        let window = Roulette::Window(WeightWindow::reciprocal_of(4).expect("it is at most 64"));
        for roulette in [Roulette::Albedo, Roulette::Throughput, window] {
            let what = format!("{}, {}", integrator.name(), roulette);
            assert_same(&what, &with(integrator, roulette, 6), &never, limit);
        }
    }
}

#[test]
fn light_sampling_integrators_agree_under_mixed_lights() {
    // Four lights, one of them an environment map, two of them delta lights.
    let mut scene = outside();
    let lights = room(
        r#"
[[light]]
type = "point"
position = [0.5, 1.5, 0.5]
intensity = 0.7

[[light]]
type = "spot"
position = [-0.5, 1.8, 0.5]
target = [0, 0, 0]
cone = 40
intensity = 2
"#,
    );
    scene.lights = lights.lights;
    let sky = etendue::internals::scene::description::ColourDescription::Texture(
        std::sync::Arc::new(crate::common::scene::panorama()),
    );
    scene
        .lights
        .push(etendue::internals::scene::description::LightDescription {
            place: Default::default(),
            model: etendue::internals::scene::description::LightModel::Environment {
                radiance: sky,
                to_world: etendue::internals::math::vec::DMat3::IDENTITY,
            },
        });
    let (spp, limit) = samples_and_limit(1 << 12, 0.01);
    let path = rendered(&scene, &settings(&scene, IntegratorKind::Path, 7, spp));
    for integrator in [IntegratorKind::LightOrRest, IntegratorKind::NextEvent] {
        let other = rendered(&scene, &settings(&scene, integrator, 8, spp));
        assert_same(integrator.name(), &other, &path, limit);
    }
    // Integrators without light sampling report that they miss delta lights.
    let effects = ready(&scene, Backend::ALL[0]).effects;
    assert!(effects.has(Effect::DeltaLights));
    for integrator in COURSE {
        let bias = integrator.bias(effects).unwrap_or_default();
        let samples_lights = matches!(
            integrator,
            IntegratorKind::LightOrRest | IntegratorKind::NextEvent
        );
        let lacks = bias.contains("scattered rays cannot hit point, spot and distant lights");
        assert_eq!(lacks, !samples_lights, "{bias}");
        assert_eq!(integrator.bias(EffectSet::NONE), None);
    }
}

#[test]
fn unlisted_emitters_are_found_by_scattering() {
    // A moving sphere is not in the list of lights, so that the list is empty here.
    let mut scene = floor_below(GeometryDescription::Sphere {
        center: 2.0 * DVec3::Y,
        radius: 1.0,
    });
    scene.shapes[1].motion = slide(DVec3::ZERO, DVec3::new(0.3, 0.2, 0.0));
    scene.camera.shutter = [0.0, 1.0];
    assert!(ready(&scene, Backend::ALL[0]).lights.is_empty());
    let path = seen(&scene, IntegratorKind::Path, 1 << 13, None);
    for integrator in COURSE {
        let other = seen(&scene, integrator, 1 << 13, None);
        let [error, of_path] = [&other, &path].map(|it| it.standard_error().expect("many pixels"));
        let off = (other.mean() - path.mean()).abs();
        let (name, error) = (integrator.name(), error.hypot(of_path));
        assert!(
            off < 5.2 * error,
            "{name}: {} and {}",
            other.mean(),
            path.mean()
        );
        assert!(error < 0.02 * path.mean(), "{name}: inconclusive, {error}");
    }
}

/// The moments over pixels that all see the same point.
fn seen(
    scene: &SceneDescription,
    integrator: IntegratorKind,
    spp: u64,
    far: Option<f64>,
) -> Moments {
    let settings = RenderSettings {
        integrator,
        occlusion_distance: far,
        max_bounces: Some(1),
        tile_size: 1,
        ..RenderSettings::new(scene.film.size, spp)
    };
    let film = rendered(scene, &settings);
    Moments::of(film.tiles().iter().map(|t| t.pixels[0].mean(t.samples)[1]))
}

#[test]
fn direct_lighting_matches_closed_forms() {
    let square = rectangle([-1.0, 1.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    let disk = GeometryDescription::Disk {
        center: DVec3::Y,
        normal: DVec3::NEG_Y,
        radius: 1.0,
    };
    let sphere = GeometryDescription::Sphere {
        center: 2.0 * DVec3::Y,
        radius: 1.0,
    };
    let triangles = crate::common::scene::polygon(vec![
        DVec3::new(-1.0, 1.0, -1.0),
        DVec3::new(1.0, 1.0, -1.0),
        DVec3::new(1.0, 1.0, 1.0),
        DVec3::new(-1.0, 1.0, 1.0),
    ]);
    let of_square = 4.0 * parallel_rectangle(1.0, 1.0, 1.0);
    // A disk of radius 1 at distance 1 from a point: r^2 / (r^2 + h^2), the limit of coaxial discs.
    assert!((coaxial_discs(1e-4, 1.0, 1.0) - 0.5).abs() < 1e-7);
    for (name, lamp, factor) in [
        ("square", square, of_square),
        ("triangles", triangles, of_square),
        ("disk", disk, 0.5),
        ("sphere", sphere, 0.25),
    ] {
        let scene = floor_below(lamp);
        // Scattered rays hit any shape of lamp in the same way: one shape is enough.
        let by_scattering = [
            (IntegratorKind::DirectDirectional, 1 << 15),
            (IntegratorKind::Bsdf, 1 << 15),
            (IntegratorKind::EmitOrReflect, 1 << 15),
            (IntegratorKind::Naive, 1 << 17),
        ];
        let by_light = [
            (IntegratorKind::DirectArea, 1 << 15),
            (IntegratorKind::NextEvent, 1 << 15),
            (IntegratorKind::LightOrRest, 1 << 15),
        ];
        let scattering = if name == "disk" {
            &by_scattering[..]
        } else {
            &[]
        };
        for &(integrator, spp) in scattering.iter().chain(&by_light) {
            let what = format!("{name}, {}", integrator.name());
            let (spp, limit) = match is_nightly() {
                true => (spp, 0.002),
                false => (spp / 4, 0.004),
            };
            let seen = seen(&scene, integrator, spp, None);
            assert_mean(&what, &seen, 0.5 * factor, limit);
        }
    }
}

/// Where a transform mirrors a rectangle, its outside stays outside: for the light that is sampled, and for the mesh that is hit.
#[test]
fn mirrored_rectangle_light_emits_from_its_outside() {
    let square = rectangle([-1.0, 1.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    let mut scene = floor_below(square);
    let lamp = scene.shapes.last_mut().expect("it has a lamp");
    lamp.transform = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let exact = 0.5 * 4.0 * parallel_rectangle(1.0, 1.0, 1.0);
    for (integrator, spp) in [
        (IntegratorKind::Path, 1 << 12),
        (IntegratorKind::NextEvent, 1 << 14),
        (IntegratorKind::Bidirectional, 1 << 12),
    ] {
        let seen = seen(&scene, integrator, spp, None);
        assert_mean(integrator.name(), &seen, exact, 0.005);
    }
}

/// From outside, light sampling finds the near side of a sphere alone: its inner face, seen through the near side, is found by
/// scattering with a weight of one.
#[test]
fn inner_face_of_a_transparent_sphere_light_is_found() {
    let mut scene = floor_below(GeometryDescription::Sphere {
        center: 2.0 * DVec3::Y,
        radius: 1.0,
    });
    let mut material = scene.materials[0].clone();
    material.alpha = Rgb::grey(0.5).into();
    scene.materials.push(material);
    let lamp = scene.shapes.last_mut().expect("it has a lamp");
    lamp.material = scene.materials.len() - 1;
    lamp.two_sided_emission = true;
    // Half of the light of the near side, and half of half of that of the far one.
    let exact = 0.5 * 0.25 * (0.5 + 0.25);
    for (integrator, spp) in [
        (IntegratorKind::Path, 1 << 14),
        (IntegratorKind::Bsdf, 1 << 15),
    ] {
        let seen = seen(&scene, integrator, spp, None);
        assert_mean(integrator.name(), &seen, exact, 0.005);
    }
}

#[test]
fn ambient_occlusion_matches_closed_forms() {
    let square = rectangle([-1.0, 1.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    let scene = floor_below(square);
    let open = 1.0 - 4.0 * parallel_rectangle(1.0, 1.0, 1.0);
    let ambient = |far| seen(&scene, IntegratorKind::AmbientOcclusion, 1 << 14, far);
    assert_mean("unlimited", &ambient(None), open, 0.002);
    // Rays of length sqrt(4/3) reach a disk of radius sqrt(1/3) on the square at height 1.
    let near = 1.0 - (1.0 / 3.0) / (1.0 / 3.0 + 1.0);
    assert_mean(
        "limited",
        &ambient(Some((4.0_f64 / 3.0).sqrt())),
        near,
        0.002,
    );
    let none = ambient(Some(0.99));
    assert_eq!((none.mean(), none.variance()), (1.0, Some(0.0)));
}

#[test]
fn variance_falls_as_1_over_n_and_faster_for_sobol() {
    let square = rectangle([-1.0, 1.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    let scene = floor_below(square);
    let slope = |sampler| {
        let sizes = [16, 64, 256, 1024];
        let points = sizes.map(|spp| {
            let mut moments = Moments::default();
            for seed in 0..64 {
                let settings = RenderSettings {
                    sampler,
                    max_bounces: Some(1),
                    roulette: Some(Roulette::None),
                    ..settings(&scene, IntegratorKind::NextEvent, seed, spp)
                };
                let film = rendered(&scene, &settings);
                let pixels = film.develop();
                let values = pixels.pixels().iter().map(|p| f64::from(p.to_array()[1]));
                moments = moments.merge(Moments::of(values));
            }
            let variance = moments.variance().expect("many pixels");
            [(spp as f64).ln(), variance.ln()]
        });
        let mean = |i: usize| points.iter().map(|p| p[i]).sum::<f64>() / points.len() as f64;
        let (x, y) = (mean(0), mean(1));
        let products = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>();
        products / points.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>()
    };
    // 2048 pixels determine each variance to 3 %, and the slope to 0.01.
    let independent = slope(SamplerKind::Independent);
    assert!((independent + 1.0).abs() < 0.05, "{independent}");
    let sobol = slope(SamplerKind::Sobol);
    println!("slopes {independent:.3} and {sobol:.3}");
    assert!(sobol < -1.5, "{sobol}");
}

#[test]
fn images_are_independent_of_kernels_tiles_and_threads() {
    let scene = matte();
    for &integrator in IntegratorKind::ALL {
        let pixels = |kernel, tile_size, threads| {
            let settings = RenderSettings {
                kernel,
                tile_size,
                threads,
                ..settings(&scene, integrator, 11, 5)
            };
            rendered(&scene, &settings).develop()
        };
        let one = pixels(None, 16, 1);
        assert!(one.pixels().iter().any(|pixel| !pixel.is_black()));
        for other in [
            pixels(Some(Kernel::Everything), 16, 1),
            pixels(Some(Kernel::Matte), 3, 2),
        ] {
            assert_eq!(one.pixels(), other.pixels(), "{}", integrator.name());
        }
    }
}

#[test]
fn tile_welch_test_is_calibrated_and_detects_a_bias() {
    let scene = matte();
    let path = |seed| {
        rendered(
            &scene,
            &settings(&scene, IntegratorKind::Path, seed, 1 << 10),
        )
    };
    // The z-scores of tiles of the same integrator are normally distributed.
    let normal = Normal::standard();
    let mut cells = [0_u32; 8];
    let seeds = if is_nightly() { 16 } else { 8 };
    for seed in 0..seeds {
        let (a, b) = (path(100 + 2 * seed), path(101 + 2 * seed));
        let (a, b) = (means(&a, 1), means(&b, 1));
        for ((a, va), (b, vb)) in a.iter().zip(&b).take(a.len() - 1) {
            let p = normal.cdf((a - b) / (va + vb).sqrt());
            cells[((8.0 * p) as usize).min(7)] += 1;
        }
    }
    let p = uniformity(&cells);
    assert!(p > 1e-4, "{cells:?}: p = {p}");
    let (spp, factor) = if is_nightly() {
        (1 << 14, 1.01)
    } else {
        (1 << 12, 1.02)
    };
    let mut brighter = scene.clone();
    for shape in &mut brighter.shapes {
        if let Some(etendue::internals::scene::description::ColourDescription::Constant(light)) =
            &mut shape.emission
        {
            *light = factor * *light;
        }
    }
    let film = rendered(
        &brighter,
        &settings(&brighter, IntegratorKind::Path, 9, spp),
    );
    let reference = rendered(&scene, &settings(&scene, IntegratorKind::Path, 10, spp));
    let told = std::panic::catch_unwind(|| assert_same("brighter", &film, &reference, 1.0));
    assert!(told.is_err());
}
