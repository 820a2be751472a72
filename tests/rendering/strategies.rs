//! The strategies of bidirectional path tracing, and of path tracing beside light paths: the weighted images add up to the
//! render, and the unweighted image of each bidirectional strategy is the light of its path length.

use super::bidirectional::settings;
use crate::common::furnished::{glass, matte};
use crate::common::scene::{film, ready};
use etendue::internals::accel::Backend;
use etendue::internals::film::filter::Filter;
use etendue::internals::film::splats::Strategy;
use etendue::internals::image::Image;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::integrator::light_paths::LightPathShare;
use etendue::internals::math::stats::Moments;
use etendue::internals::render::path_strategies::{PathStrategy, path_strategies};
use etendue::internals::render::settings::{LightPathRule, RenderSettings};
use etendue::internals::render::strategies::{StrategyImages, check, strategies};
use etendue::internals::render::{RenderInput, Threads};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::SceneDescription;

const BOUNCES: u32 = 2;

fn limited(scene: &SceneDescription, seed: u64, spp: u64) -> RenderSettings {
    RenderSettings {
        seed,
        max_bounces: Some(BOUNCES),
        ..settings(scene, IntegratorKind::Bidirectional, spp)
    }
}

fn with_input<T>(
    description: &SceneDescription,
    scene: &Scene,
    make: impl FnOnce(&RenderInput<'_>, &Threads) -> T,
) -> T {
    let filter = Filter::new(&description.film.filter);
    let input = RenderInput {
        scene,
        filter: &filter,
        size: description.film.size,
    };
    make(&input, &Threads::new(2).expect("threads"))
}

fn pictures(
    description: &SceneDescription,
    scene: &Scene,
    settings: &RenderSettings,
) -> Vec<StrategyImages> {
    let pictures = with_input(description, scene, |input, threads| {
        strategies(input, threads, settings)
    });
    pictures.expect("the settings fit")
}

fn mean(image: &Image) -> f64 {
    Moments::of(image.pixels().iter().map(|p| f64::from(p.to_array()[1]))).mean()
}

#[test]
fn weighted_bdpt_strategies_sum_to_the_image() {
    let description = matte();
    let scene = ready(&description, Backend::ALL[0]);
    let settings = limited(&description, 3, 8);
    let whole = film(&scene, &description, &settings).develop();
    let pictures = pictures(&description, &scene, &settings);
    let made: Vec<Strategy> = pictures.iter().map(|it| it.strategy).collect();
    // Every strategy for paths of one, two and three edges, except s = t = 1.
    let all = (0..4).flat_map(|s| (1..5).map(move |t| Strategy { s, t }));
    let possible = |it: &Strategy| {
        let edges = it.s + it.t - 1;
        (1..=3).contains(&edges)
            && it.s + it.t > 1
            && (it.s, it.t) != (1, 1)
            && (it.t > 1 || it.s > 1)
    };
    assert_eq!(made, all.filter(possible).collect::<Vec<_>>());
    for (index, pixel) in whole.pixels().iter().enumerate() {
        for channel in 0..3 {
            let of =
                |it: &StrategyImages| f64::from(it.weighted.pixels()[index].to_array()[channel]);
            let sum: f64 = pictures.iter().map(of).sum();
            let expected = f64::from(pixel.to_array()[channel]);
            // Each of nine images is rounded to single precision, and so are its contributions.
            assert!(
                (sum - expected).abs() <= 1e-5 * expected,
                "{index}: {sum} {expected}"
            );
        }
    }
}

#[test]
fn unweighted_strategies_of_equal_path_length_agree() {
    let description = matte();
    let scene = ready(&description, Backend::ALL[0]);
    let renders: Vec<_> = (0..12)
        .map(|seed| pictures(&description, &scene, &limited(&description, 50 + seed, 64)))
        .collect();
    let alone = |s, t| {
        let picture = |all: &Vec<StrategyImages>| {
            let found = all.iter().find(|it| it.strategy == Strategy { s, t });
            found.map_or(0.0, |it| mean(&it.unweighted))
        };
        Moments::of(renders.iter().map(picture))
    };
    // Light that scattered once, and twice. Strategies with s = 0 hit the light by chance, with more noise.
    for (edges, strategies) in [
        (2, [(0, 3), (1, 2), (2, 1)].as_slice()),
        (3, &[(0, 4), (1, 3), (2, 2), (3, 1)]),
    ] {
        let reference = alone(1, edges);
        for &(s, t) in strategies {
            let other = alone(s, t);
            let errors = [other, reference].map(|it| it.standard_error().expect("twelve renders"));
            let off = (other.mean() - reference.mean()).abs();
            let error = errors[0].hypot(errors[1]);
            println!("s {s}, t {t}: {:.5} +- {:.5}", other.mean(), errors[0]);
            assert!(
                off <= 6.0 * error,
                "s {s}, t {t}: {} and {}",
                other.mean(),
                reference.mean()
            );
            assert!(
                error < 0.03 * reference.mean(),
                "s {s}, t {t}: inconclusive, {error}"
            );
        }
    }
}

#[test]
fn path_strategies_sum_to_the_rendered_image() {
    let description = glass(0.0);
    let scene = ready(&description, Backend::ALL[0]);
    for (share, has_light_paths) in [(LightPathShare::One, true), (LightPathShare::None, false)] {
        let settings = RenderSettings {
            light_paths: LightPathRule::Share(share),
            ..settings(&description, IntegratorKind::Path, 16)
        };
        let whole = film(&scene, &description, &settings).develop();
        let images = with_input(&description, &scene, |input, threads| {
            path_strategies(input, threads, &settings)
        });
        let images = images.expect("the settings fit");
        for (strategy, image) in PathStrategy::ALL.iter().zip(&images) {
            let finds_light = *strategy != PathStrategy::LightPaths || has_light_paths;
            assert_eq!(mean(image) > 0.0, finds_light, "{}", strategy.name());
        }
        for (index, pixel) in whole.pixels().iter().enumerate() {
            for channel in 0..3 {
                let of = |image: &Image| f64::from(image.pixels()[index].to_array()[channel]);
                let sum: f64 = images.iter().map(of).sum();
                let expected = f64::from(pixel.to_array()[channel]);
                // Contributions to a sample are summed in another order, in single precision.
                assert!(
                    (sum - expected).abs() <= 1e-5 * expected,
                    "{index}: {sum} {expected}"
                );
            }
        }
    }
}

#[test]
fn strategy_images_of_unsupported_settings_are_rejected() {
    let description = matte();
    let fine = limited(&description, 0, 4);
    assert_eq!(check(&fine).expect("it fits"), 4);
    let course = RenderSettings {
        integrator: IntegratorKind::NextEvent,
        ..fine.clone()
    };
    let endless = RenderSettings {
        max_bounces: None,
        ..fine.clone()
    };
    for (settings, says) in [(course, "--integrator bdpt"), (endless, "--max-bounces")] {
        let error = check(&settings).expect_err("it does not fit");
        assert!(error.to_string().contains(says), "{error}");
    }
}
