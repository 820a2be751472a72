//! Tests that the error of the irradiance cache stays within its bound: against a closed form at every point, and
//! against the path tracer.

use crate::common::furnished::furnished;
use crate::common::room::{LAMP, room};
use crate::common::scene::{film, ready, robust};
use crate::common::verdict::sidak;
use etendue::internals::accel::Backend;
use etendue::internals::film::Film;
use etendue::internals::film::filter::Filter;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::stats::Moments;
use etendue::internals::render::cache_prepass::cache_prepass;
use etendue::internals::render::replay::{PathEvent, replay};
use etendue::internals::render::settings::{RenderSettings, SamplerKind};
use etendue::internals::render::{NullRenderObserver, render};
use etendue::internals::scene::description::SceneDescription;
use etendue_lab::battery::case::{Effort, Trial};
use etendue_lab::battery::irradiance::cache_errors;
use statrs::distribution::{ContinuousCDF, Normal};

fn settings(description: &SceneDescription, cache_error: f64, spp: u64) -> RenderSettings {
    RenderSettings {
        integrator: IntegratorKind::IrradianceCache,
        cache_error,
        ..RenderSettings::new(description.film.size, spp)
    }
}

#[test]
fn cached_irradiance_error_is_within_its_bound() {
    let mut counts = Vec::new();
    for (bound, seed) in [(0.2, 0), (0.05, 0), (0.2, 1), (0.2, 2), (0.2, 3)] {
        let trial = Trial {
            options: robust(Backend::ALL[0]),
            seed,
            effort: Effort::Quick,
            is_cancelled: &|| false,
        };
        let errors = cache_errors(&trial, bound).expect("a valid scene");
        println!("{bound} {errors:?}");
        assert!(
            errors.worst < bound && errors.known > 0.9,
            "{bound} {errors:?}"
        );
        counts.push(errors.records);
    }
    // A quarter of the error bound halves the spacing of records.
    assert!(counts[1] > 2 * counts[0], "{counts:?}");
}

/// The moments of luminance in each quadrant of the image.
fn tiles(film: &Film) -> Vec<Moments> {
    let image = film.develop();
    let side = image.width() as usize;
    let mut tiles = vec![Moments::default(); 4];
    for (i, value) in image.pixels().iter().enumerate() {
        let tile = i / side / (side / 2) * 2 + i % side / (side / 2);
        tiles[tile].push(value.luminance().into());
    }
    tiles
}

#[test]
fn cached_room_agrees_with_path_within_the_error_bound() {
    let mut description = furnished();
    // Large enough that the cache is used for most of the image: smaller images are left to path tracing.
    description.film.size = (64, 64);
    let scene = ready(&description, Backend::ALL[0]);
    let bound = 0.3;
    for max_bounces in [None, Some(2)] {
        // Several independent images of both integrators.
        let pictures = |integrator, count: u64, spp| -> Vec<Vec<Moments>> {
            let one = |seed| {
                let settings = RenderSettings {
                    integrator,
                    max_bounces,
                    seed,
                    ..settings(&description, bound, spp)
                };
                tiles(&film(&scene, &description, &settings))
            };
            (0..count).map(one).collect()
        };
        let cached = pictures(IntegratorKind::IrradianceCache, 8, 4);
        let path = pictures(IntegratorKind::Path, 8, 16);
        let quantile = Normal::standard().inverse_cdf(1.0 - 0.5 * sidak(1e-4, 2 * 4));
        for tile in 0..4 {
            let means = |pictures: &[Vec<Moments>]| {
                Moments::of(pictures.iter().map(|tiles| tiles[tile].mean()))
            };
            let (a, b) = (means(&cached), means(&path));
            let error = |it: &Moments| it.standard_error().expect("several images");
            let noise = quantile * error(&a).hypot(error(&b));
            // The factor 2 allows for the heavier tails of Student's t with 8 images each.
            let allowed = 2.0 * noise + bound * b.mean();
            assert!(
                noise < 0.06 * b.mean(),
                "inconclusive: noise {noise}, mean {}",
                b.mean()
            );
            println!(
                "{max_bounces:?} {tile}: {:.5} {:.5} {noise:.5}",
                a.mean(),
                b.mean()
            );
            let off = (a.mean() - b.mean()).abs();
            assert!(off < allowed, "tile {tile}: {} {}", a.mean(), b.mean());
        }
    }
}

#[test]
fn zero_error_bound_is_bit_identical_to_path() {
    let description = furnished();
    let scene = ready(&description, Backend::ALL[0]);
    let cached = settings(&description, 0.0, 4);
    let path = RenderSettings {
        integrator: IntegratorKind::Path,
        ..cached.clone()
    };
    assert!(cached.bias(scene.effects).is_empty());
    let [cached, path] =
        [cached, path].map(|settings| film(&scene, &description, &settings).develop());
    assert_eq!(cached.pixels(), path.pixels());
}

#[test]
fn cached_image_is_independent_of_threads_and_replayable() {
    let description = furnished();
    let scene = ready(&description, Backend::ALL[0]);
    for sampler in SamplerKind::ALL {
        let with = |threads| RenderSettings {
            threads,
            sampler: *sampler,
            ..settings(&description, 0.1, 2)
        };
        let one = film(&scene, &description, &with(1)).develop();
        let three = film(&scene, &description, &with(3)).develop();
        assert_eq!(one.pixels(), three.pixels());

        let filter = Filter::new(&description.film.filter);
        let alone = |pixel, sample| {
            let replayed = replay(&scene, &filter, &with(1), pixel, sample);
            replayed.expect("the settings are valid")
        };
        let is_known = |event: &PathEvent| matches!(event, PathEvent::CachedIndirect { .. });
        let mut of_row = (0..32).map(|x| (x, [alone([x, 12], 0), alone([x, 12], 1)]));
        let (x, pixels) = of_row
            .find(|(_, pair)| {
                pair.iter()
                    .all(|path| path.events.last().is_some_and(is_known))
            })
            .expect("the cache is used for most pixels");
        let mean = pixels
            .iter()
            .fold(Rgb::BLACK, |sum, path| sum + path.radiance)
            * 0.5;
        let developed = one.pixels()[12 * 32 + x as usize];
        assert!((mean - developed).max_channel().abs() < 1e-6 * mean.max_channel());
    }
}

#[test]
fn interrupted_cache_prepass_keeps_a_prefix_of_the_records() {
    let description = furnished();
    let scene = ready(&description, Backend::ALL[0]);
    let filter = Filter::new(&description.film.filter);
    let settings = settings(&description, 0.1, 2);
    let calls = std::cell::Cell::new(0);
    let watch = |share: f64, _| {
        assert!((0.0..=1.0).contains(&share));
        calls.set(calls.get() + 1);
        calls.get() < 3
    };
    let (some, _) = cache_prepass(&scene, &filter, &settings, &watch);
    let (all, rays) = cache_prepass(&scene, &filter, &settings, &|_, _| true);
    let [some, all] = [some, all].map(|cache| cache.expect("the integrator has a cache"));
    assert_eq!(calls.get(), 3);
    assert!((1..all.records().len()).contains(&some.records().len()));
    assert_eq!(some.records(), &all.records()[..some.records().len()]);
    assert!(rays.closest > 256 * all.records().len() as u64);
    assert!(all.memory() < 300 * all.records().len());
}

#[test]
fn moving_scene_is_rejected_with_a_hint_to_use_path() {
    let text = format!(
        "{LAMP}
[[shape]]
type = \"sphere\"
center = [0, 0.5, 0]
radius = 0.4
motion = [{{ time = 0, transform = [{{ translate = [0, 0, 0] }}] }}, {{ time = 1, transform = [{{ translate = [0.2, 0, 0] }}] }}]
"
    );
    let mut description = room(&text);
    description.camera.shutter = [0.0, 1.0];
    let scene = ready(&description, Backend::ALL[0]);
    let filter = Filter::new(&description.film.filter);
    let settings = settings(&description, 0.1, 1);
    let refused = render(
        &scene,
        &filter,
        description.film.size,
        &settings,
        &NullRenderObserver,
    );
    let error = refused.expect_err("the scene has motion").to_string();
    assert!(error.contains("--integrator path"), "{error}");
    assert!(replay(&scene, &filter, &settings, [0, 0], 0).is_err());
}
