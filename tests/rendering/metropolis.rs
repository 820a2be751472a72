//! Metropolis light transport has the mean of path tracing, from the first step of the shortest chain on, and its stated
//! errors are correct.

use super::bidirectional::{compare_with_path, settings};
use crate::common::error_bars::{Coverage, reference_settings};
use crate::common::furnished::{glass, glossy, matte, outside, small_light};
use crate::common::nightly::{is_nightly, one_in};
use crate::common::room::room;
use crate::common::scene::{film, ready};
use etendue::internals::accel::Backend;
use etendue::internals::film::filter::Filter;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::math::stats::Moments;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::render::{NullRenderObserver, render};
use etendue::internals::scene::description::SceneDescription;

fn compare(
    what: &str,
    scene: &SceneDescription,
    spp: [u64; 2],
    power: f64,
    max_bounces: Option<u32>,
) {
    let chains = (IntegratorKind::Metropolis, spp);
    compare_with_path(what, scene, chains, power, max_bounces);
}

#[test]
fn metropolis_agrees_with_path_in_every_block_of_six_scenes() {
    let cases = [
        ("matte", matte(), 64, 0.02),
        ("glossy", glossy(), 64, 0.03),
        ("outside", outside(), 64, 0.03),
        ("smooth glass", glass(0.0), 64, 0.02),
        ("rough glass", glass(0.8), 64, 0.02),
        ("small light", small_light(), 128, 0.05),
    ];
    for (name, scene, spp, power) in one_in(2, 1, &cases) {
        compare(name, scene, [*spp, 128], *power, None);
    }
}

#[test]
fn metropolis_agrees_with_path_for_zero_to_three_bounces() {
    for max_bounces in 0..4 {
        let what = format!("{max_bounces} bounces");
        compare(&what, &glass(0.0), [64, 128], 0.03, Some(max_bounces));
    }
}

/// Each render has 512 chains of 8 steps: thousands in all, too short to become independent of their initial states.
#[test]
fn short_chains_are_unbiased() {
    compare("short chains", &glass(0.0), [16, 128], 0.03, None);
}

#[test]
fn variance_estimate_matches_that_between_renders() {
    let scene = matte();
    let ready = ready(&scene, Backend::ALL[0]);
    let films: Vec<_> = (0..32)
        .map(|seed| {
            let settings = RenderSettings {
                seed,
                ..settings(&scene, IntegratorKind::Metropolis, 32)
            };
            film(&ready, &scene, &settings).estimates()
        })
        .collect();
    let (mut claimed, mut true_one) = (0.0, 0.0);
    for pixel in 0..films[0].len() {
        let mean = Moments::of(films.iter().map(|it| it[pixel].mean[1]));
        let stated = Moments::of(films.iter().map(|it| it[pixel].variance[1]));
        let weight = 1.0 / (mean.mean() * mean.mean());
        claimed += weight * stated.mean();
        true_one += weight * mean.variance().expect("many renders");
    }
    let ratio = claimed / true_one;
    println!("claimed over true variance {ratio:.3}");
    // 256 pixels with 31 degrees of freedom each; neighbours are correlated.
    assert!((ratio - 1.0).abs() < 0.15, "{ratio}");
}

/// One step per pixel in each batch is too few for the batches to agree; 64 steps are enough.
#[test]
fn chain_disagreement_falls_with_more_steps() {
    let scene = glass(0.0);
    let ready = ready(&scene, Backend::ALL[0]);
    let told = |spp| {
        let settings = RenderSettings {
            tile_size: 1,
            ..settings(&scene, IntegratorKind::Metropolis, spp)
        };
        let film = film(&ready, &scene, &settings);
        film.uncertain_tile_share()
    };
    let (few, many) = (told(16), told(1024));
    println!("disagreement {few} and {many}");
    assert!(few > 0.2 && many < 0.5 * few, "{few} {many}");
}

#[test]
fn unlit_scene_fails_with_an_error_about_missing_light() {
    let scene = room("");
    let ready = ready(&scene, Backend::ALL[0]);
    let filter = Filter::new(&scene.film.filter);
    let settings = settings(&scene, IntegratorKind::Metropolis, 16);
    let error = render(
        &ready,
        &filter,
        scene.film.size,
        &settings,
        &NullRenderObserver,
    );
    let error = error.expect_err("there is no light");
    assert!(error.to_string().contains("found any light"), "{error}");
}

/// Successive states of a chain are strongly correlated; the batches of chains are independent of each other nevertheless.
///
/// Power: that of about 2000 intervals, for any length of the chains. The truth has eight times the samples of the longest ones,
/// so that its own error is small beside their bars.
#[test]
fn unflagged_error_bars_have_nominal_coverage() {
    let scene = matte();
    let ready = ready(&scene, Backend::ALL[0]);
    let long = if is_nightly() { 8192 } else { 256 };
    let path = reference_settings(&scene, 8 * long);
    let truth = film(&ready, &scene, &path).develop();
    let coverage = |spp, seeds| {
        let mut coverage = Coverage::default();
        let settings = settings(&scene, IntegratorKind::Metropolis, spp);
        coverage.add_images((&ready, &scene), &settings, seeds, |index| {
            truth.pixels()[index].to_array()[1].into()
        });
        println!("| mlt, {spp} steps a pixel |{coverage}");
        coverage
    };
    for coverage in [coverage(64, 8), coverage(long, 8)] {
        assert!(coverage.flagged() < 0.1, "{}", coverage.flagged());
        // About 2000 intervals; neighbours are correlated.
        assert_eq!(coverage.miscalibrated(), None);
    }
}
