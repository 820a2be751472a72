//! Filters by splatting: a sample contributes to every pixel that its filter covers.

use crate::common::scene::{film, ready, sky};
use crate::common::scene_folder::{SMALL, load_text};
use etendue::internals::accel::Backend;
use etendue::internals::film::filter::{Filter, FilterDescription, FilterKind, FilterSampling};
use etendue::internals::film::{Film, Window};
use etendue::internals::image::metrics::rel_mse;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::stats::Moments;
use etendue::internals::render::replay::replay;
use etendue::internals::render::settings::{Adaptive, RenderSettings, SamplerKind};
use etendue::internals::scene::description::SceneDescription;

/// A small scene with this filter.
fn scene(kind: FilterKind, radius: f64) -> SceneDescription {
    let mut description = load_text(SMALL);
    description.film.filter = FilterDescription { kind, radius };
    description
}

/// The settings of a render by splatting.
fn splatting(description: &SceneDescription, spp: u64) -> RenderSettings {
    RenderSettings {
        filter_sampling: FilterSampling::Splatting,
        ..RenderSettings::new(description.film.size, spp)
    }
}

fn rendered(description: &SceneDescription, settings: &RenderSettings) -> Film {
    film(&ready(description, Backend::ALL[0]), description, settings)
}

/// The filters that are splatted in these tests: of one, two and three pixels on either side, one with negative lobes.
const SPLATTED: [(FilterKind, f64); 4] = [
    (FilterKind::Gaussian, 1.5),
    (FilterKind::Tent, 1.0),
    (FilterKind::Mitchell, 2.0),
    (FilterKind::BlackmanHarris, 3.2),
];

/// Nothing but a sky of constant radiance.
fn furnace() -> SceneDescription {
    let mut description = load_text(SMALL);
    description.shapes.clear();
    description.lights = vec![sky(Rgb::new(0.25, 1.0, 4.0))];
    description
}

#[test]
fn splatted_furnace_image_is_exact_up_to_the_border() {
    for (kind, radius) in SPLATTED {
        let mut description = furnace();
        description.film.filter = FilterDescription { kind, radius };
        for sampler in [SamplerKind::Sobol, SamplerKind::Independent] {
            let settings = |spp, seed| RenderSettings {
                sampler,
                seed,
                ..splatting(&description, spp)
            };
            for pixel in rendered(&description, &settings(16, 0)).develop().pixels() {
                for (value, exact) in pixel.to_array().into_iter().zip([0.25, 1.0, 4.0]) {
                    assert!((value / exact - 1.0).abs() < 1e-6, "{kind:?}: {value}");
                }
            }
            // A single sample has no control variate: its weights alone have to be right on the mean.
            let corner = |seed| {
                let pixels = rendered(&description, &settings(1, seed)).develop();
                f64::from(pixels.pixels()[0].to_array()[1])
            };
            let moments = Moments::of((0..100).map(corner));
            let error = moments.standard_error().expect("many seeds");
            let off = (moments.mean() - 1.0).abs();
            assert!(off < 4.5 * error, "{kind:?}: {} +- {error}", moments.mean());
            assert!(error < 0.06, "{kind:?}: {error}");
        }
    }
}

/// Both ways to estimate a filter agree in tiles of 8 x 8 pixels, by Welch's test over independent seeds.
#[test]
fn splatting_agrees_with_importance_sampling() {
    const SEEDS: u64 = 24;
    for (kind, radius) in SPLATTED {
        let description = scene(kind, radius);
        let (width, height) = description.film.size;
        let of_tiles = |filter_sampling, seed| -> Vec<f64> {
            let settings = RenderSettings {
                filter_sampling,
                seed,
                ..splatting(&description, 16)
            };
            let image = rendered(&description, &settings).develop();
            let across = width.div_ceil(8) as usize;
            let mut tiles = vec![0.0; across * height.div_ceil(8) as usize];
            for (index, pixel) in image.pixels().iter().enumerate() {
                let (x, y) = (index % width as usize, index / width as usize);
                tiles[y / 8 * across + x / 8] += f64::from(pixel.to_array()[1]) / 64.0;
            }
            tiles
        };
        let of_seeds = |filter_sampling, first: u64| -> Vec<Vec<f64>> {
            let seeds = first..first + SEEDS;
            seeds.map(|seed| of_tiles(filter_sampling, seed)).collect()
        };
        let one = of_seeds(FilterSampling::Splatting, 0);
        let other = of_seeds(FilterSampling::Importance, 1000);
        for tile in 0..one[0].len() {
            let moments =
                [&one, &other].map(|seeds| Moments::of(seeds.iter().map(|tiles| tiles[tile])));
            let [a, b] = moments.each_ref().map(Moments::mean);
            let error = moments
                .map(|it| it.standard_error().expect("many seeds"))
                .into_iter()
                .fold(0.0, f64::hypot);
            // 24 tests, some 40 degrees of freedom: 4.6 standard errors by chance once in a thousand runs.
            assert!(
                (a - b).abs() < 4.6 * error,
                "{kind:?}, tile {tile}: {a} {b} {error}"
            );
            assert!(error < 0.03 * a, "{kind:?}, tile {tile}: {a} +- {error}");
        }
    }
}

#[test]
fn splatted_images_are_independent_of_tiles_threads_and_crops() {
    for (kind, radius) in SPLATTED {
        let description = scene(kind, radius);
        let whole = rendered(&description, &splatting(&description, 8));
        for (tile_size, threads) in [(1, 1), (3, 2), (16, 1), (100, 2)] {
            let settings = RenderSettings {
                tile_size,
                threads,
                ..splatting(&description, 8)
            };
            let other = rendered(&description, &settings);
            assert_eq!(
                other.develop(),
                whole.develop(),
                "{kind:?}, tiles of {tile_size}"
            );
            assert_eq!(other.error_bars(), whole.error_bars(), "{kind:?}");
            assert_eq!(other.error(0.95), whole.error(0.95), "{kind:?}");
        }
        for window in [(0, 0, 5, 4), (7, 3, 6, 9), (23, 15, 1, 1)] {
            let (x, y, width, height) = window;
            let settings = RenderSettings {
                window: Window {
                    x,
                    y,
                    width,
                    height,
                },
                ..splatting(&description, 8)
            };
            let part = rendered(&description, &settings).develop();
            for (index, pixel) in part.pixels().iter().enumerate() {
                let (column, row) = (index as u32 % width, index as u32 / width);
                let of_whole = (y + row) * description.film.size.0 + x + column;
                let expected = whole.develop().pixels()[of_whole as usize];
                assert_eq!(*pixel, expected, "{kind:?}, {window:?}, {column}, {row}");
            }
        }
    }
}

#[test]
fn box_wide_and_adaptive_filters_use_importance_sampling() {
    let border_size = |kind, radius, change: &dyn Fn(&mut RenderSettings)| {
        let filter = Filter::new(&FilterDescription { kind, radius });
        let mut settings = splatting(&load_text(SMALL), 4);
        change(&mut settings);
        settings.border_size(&filter)
    };
    let none = |_: &mut RenderSettings| {};
    assert_eq!(border_size(FilterKind::Gaussian, 1.5, &none), 1);
    assert_eq!(border_size(FilterKind::Mitchell, 2.0, &none), 2);
    assert_eq!(border_size(FilterKind::Gaussian, 4.5, &none), 4);
    assert_eq!(border_size(FilterKind::Gaussian, 4.6, &none), 0);
    assert_eq!(border_size(FilterKind::Tent, 0.5, &none), 0);
    assert_eq!(border_size(FilterKind::Box, 0.5, &none), 0);
    assert_eq!(border_size(FilterKind::Box, 2.0, &none), 0);
    let adaptive = |it: &mut RenderSettings| it.adaptive = Adaptive::TwoPhase;
    assert_eq!(border_size(FilterKind::Gaussian, 1.5, &adaptive), 0);
    let boxes = scene(FilterKind::Box, 0.5);
    let by = |filter_sampling| {
        let settings = RenderSettings {
            filter_sampling,
            ..splatting(&boxes, 4)
        };
        rendered(&boxes, &settings).develop()
    };
    assert_eq!(
        by(FilterSampling::Splatting),
        by(FilterSampling::Importance)
    );
}

/// With independent samples the default filter has 3.0 times less variance, where light is smooth.
#[test]
fn splatting_reduces_error_and_reports_it_accurately() {
    // Rare bright paths would make the ratio of errors uncertain.
    let matte = "type = \"diffuse\"\nreflectance = 0.5";
    let text = SMALL.replace("type = \"dielectric\"", matte).replace(
        "type = \"conductor\"\npreset = \"gold\"\nroughness = 0.4",
        matte,
    );
    let description = load_text(&text);
    let truth = rendered(&description, &splatting(&description, 1 << 13)).develop();
    let errors = |filter_sampling| {
        let (mut exact, mut told, mut held) = (0.0, 0.0, 0);
        for seed in 0..16 {
            let settings = RenderSettings {
                filter_sampling,
                seed: 100 + seed,
                sampler: SamplerKind::Independent,
                ..splatting(&description, 64)
            };
            let film = rendered(&description, &settings);
            let error = film.error(0.95).expect("64 samples");
            let apart = rel_mse(&film.develop(), &truth).expect("one size");
            exact += apart;
            told += error.rel_rmse * error.rel_rmse;
            held += u32::from(apart.sqrt() <= error.upper_bound);
        }
        (exact, told / exact, held)
    };
    let (splatted, told, held) = errors(FilterSampling::Splatting);
    let (sampled, told_sampled, _) = errors(FilterSampling::Importance);
    println!(
        "{} times; told {told}, {told_sampled}; held {held} of 16",
        sampled / splatted
    );
    assert!(sampled / splatted > 1.8, "{sampled} {splatted}");
    assert!((0.75..1.33).contains(&told), "{told}");
    // Of 16 bounds that hold with 95 %, fewer than 13 do with a probability of 7e-3; ours hold more often.
    assert!(held >= 13, "{held}");
}

/// A sample is taken at the same place of its pixel for a splatted filter as for a box filter.
#[test]
fn replay_of_a_splatted_sample_follows_the_path_of_its_pixel_alone() {
    let splatted = scene(FilterKind::Gaussian, 1.5);
    let boxed = scene(FilterKind::Box, 0.5);
    let ready = ready(&splatted, Backend::ALL[0]);
    let settings = splatting(&splatted, 4);
    let (width, height) = splatted.film.size;
    let mut lit = 0;
    for pixel in [[0, 0], [width - 1, height - 1], [9, 9], [5, 12]] {
        for sample in [0, 3] {
            let [by_splatting, by_box] = [&splatted, &boxed].map(|description| {
                let filter = Filter::new(&description.film.filter);
                replay(&ready, &filter, &settings, pixel, sample).expect("valid settings")
            });
            assert_eq!(by_splatting, by_box, "{pixel:?}, {sample}");
            lit += u32::from(by_box.radiance != Rgb::BLACK);
        }
    }
    assert!(lit > 0);
}

/// Each pixel of an image of one sample a pixel is a sum of the replayed samples around it, with weights below 1.
#[test]
fn replayed_samples_are_consistent_with_splatted_pixels() {
    let description = scene(FilterKind::Gaussian, 1.5);
    let scene = ready(&description, Backend::ALL[0]);
    let filter = Filter::new(&description.film.filter);
    let settings = splatting(&description, 1);
    let image = film(&scene, &description, &settings).develop();
    let (width, height) = description.film.size;
    let replayed = |[x, y]: [u32; 2]| {
        let sample = replay(&scene, &filter, &settings, [x, y], 0).expect("valid settings");
        f64::from(sample.radiance.to_array()[1])
    };
    let mut lit = 0;
    for y in (1..height - 1).step_by(3) {
        for x in (1..width - 1).step_by(3) {
            let around = (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| [x, y]));
            let sum: f64 = around.map(replayed).sum();
            let value = f64::from(image.pixels()[(y * width + x) as usize].to_array()[1]);
            assert!(value < sum || sum == 0.0, "{x}, {y}: {value} of {sum}");
            assert!((value > 0.0) == (sum > 0.0), "{x}, {y}: {value} of {sum}");
            lit += u32::from(value > 0.0);
        }
    }
    assert!(lit > 20, "{lit}");
}
