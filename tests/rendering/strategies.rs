//! The strategies of bidirectional path tracing: the weighted images add up to the render, and the unweighted image of each
//! strategy is the light of its path length.

use super::bidirectional::settings;
use crate::common::furnished::matte;
use crate::common::scene::{film, ready};
use etendue::internals::accel::Backend;
use etendue::internals::film::filter::Filter;
use etendue::internals::film::splats::Strategy;
use etendue::internals::image::Image;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::math::stats::Moments;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::render::strategies::{StrategyPictures, check, strategies};
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

fn pictures(
    description: &SceneDescription,
    scene: &Scene,
    settings: &RenderSettings,
) -> Vec<StrategyPictures> {
    let filter = Filter::new(&description.film.filter);
    let view = RenderInput {
        scene,
        filter: &filter,
        size: description.film.size,
    };
    let threads = Threads::new(2).expect("threads");
    strategies(&view, &threads, settings).expect("the settings fit")
}

fn mean(image: &Image) -> f64 {
    Moments::of(image.pixels().iter().map(|p| f64::from(p.to_array()[1]))).mean()
}

#[test]
fn weighted_strategies_add_up_to_the_picture() {
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
                |it: &StrategyPictures| f64::from(it.weighted.pixels()[index].to_array()[channel]);
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
fn unweighted_strategies_of_a_length_are_the_same_light() {
    let description = matte();
    let scene = ready(&description, Backend::ALL[0]);
    let renders: Vec<_> = (0..12)
        .map(|seed| pictures(&description, &scene, &limited(&description, 50 + seed, 64)))
        .collect();
    let alone = |s, t| {
        let picture = |all: &Vec<StrategyPictures>| {
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
fn strategies_are_refused_where_there_are_none() {
    let description = matte();
    let fine = limited(&description, 0, 4);
    assert_eq!(check(&fine).expect("it fits"), 4);
    let path = RenderSettings {
        integrator: IntegratorKind::Path,
        ..fine.clone()
    };
    let endless = RenderSettings {
        max_bounces: None,
        ..fine.clone()
    };
    for (settings, says) in [(path, "--integrator bdpt"), (endless, "--max-bounces")] {
        let error = check(&settings).expect_err("it does not fit");
        assert!(error.to_string().contains(says), "{error}");
    }
}
