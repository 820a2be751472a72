//! Tests that light paths beside camera paths change no mean: `path` with any number of them agrees with `path` without and
//! with bidirectional path tracing, in every part of the image, under each kind of light and for each number of bounces.
//!
//! Splats of one light path fall on several pixels, so images are compared as in `bidirectional.rs`.

use super::bidirectional::{
    assert_threads_and_tiles_change_no_bit, claimed_over_true_variance, compare_settings,
    compare_with_path_alone, kinds_of_light, settings, stones, wall_within_glass,
};
use crate::common::furnished::{glass, matte, six_scenes};
use crate::common::generated::Generator;
use crate::common::nightly::one_in;
use crate::common::scene::slide;
use crate::common::scene_folder::in_repository;
use etendue::internals::effects::{Effect, EffectSet, Kernel};
use etendue::internals::film::Window;
use etendue::internals::film::filter::{FilterDescription, FilterKind};
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::integrator::light_paths::LightPathShare;
use etendue::internals::math::vec::DVec3;
use etendue::internals::render::NullRenderObserver;
use etendue::internals::render::auto::PathChoices;
use etendue::internals::render::options::RenderOptions;
use etendue::internals::render::settings::{
    Adaptive, Budget, LightPathRule, PathReuseRule, RenderSettings, SamplerKind,
};
use etendue::internals::scene::description::SceneDescription;
use etendue::internals::scene::load::load;
use etendue::internals::session::{Rendering, Session, tracing};

/// The settings of `path` with light paths.
fn with_light_paths(scene: &SceneDescription, share: LightPathShare, spp: u64) -> RenderSettings {
    RenderSettings {
        light_paths: LightPathRule::Share(share),
        ..settings(scene, IntegratorKind::Path, spp)
    }
}

/// Settings with as many light paths, but for caustics only.
fn caustics_only(settings: &RenderSettings) -> RenderSettings {
    RenderSettings {
        light_paths: LightPathRule::Caustics(settings.light_path_share()),
        ..settings.clone()
    }
}

/// Compares `path` with and without light paths: with all, and with those for caustics.
fn compare(what: &str, scene: &SceneDescription, power: f64, max_bounces: Option<u32>) {
    let all = RenderSettings {
        max_bounces,
        ..with_light_paths(scene, LightPathShare::One, 32)
    };
    for with in [caustics_only(&all), all] {
        let what = format!("{what}, {}", with.light_path_rule().name());
        compare_with_path_alone(&what, scene, with, 128, power);
    }
}

#[test]
fn light_paths_agree_with_path_in_every_block_of_six_scenes() {
    for (name, scene, power) in one_in(2, 1, &six_scenes()) {
        compare(name, scene, *power, None);
    }
}

#[test]
fn light_paths_agree_with_path_for_bounce_limits_and_shares() {
    let scene = glass(0.0);
    for max_bounces in one_in(2, 0, 0..5) {
        compare(
            &format!("{max_bounces} bounces"),
            &scene,
            0.03,
            Some(max_bounces),
        );
    }
    for &share in one_in(2, 0, LightPathShare::ALL) {
        let with = with_light_paths(&scene, share, 64);
        compare_with_path_alone(share.name(), &scene, with, 128, 0.03);
    }
}

#[test]
fn light_paths_agree_with_path_under_every_kind_of_light() {
    for (name, scene) in one_in(2, 0, &kinds_of_light()) {
        let with = with_light_paths(scene, LightPathShare::One, 32);
        compare_with_path_alone(name, scene, with, 192, 0.03);
    }
}

/// Point and spot lights in a room with a glass ball, whose caustics `path` misses and `bdpt` finds. With more than three
/// bounces, `bdpt` alone finds the light of a caustic on a wall that is seen through the ball.
#[test]
fn light_paths_and_bdpt_agree_on_delta_light_caustics() {
    for (name, lit) in &kinds_of_light()[..2] {
        let mut scene = glass(0.0);
        for shape in &mut scene.shapes {
            shape.emission = None;
        }
        scene.lights = lit.lights.clone();
        let with = caustics_only(&with_light_paths(&scene, LightPathShare::One, 64));
        let bidirectional = settings(&scene, IntegratorKind::Bidirectional, 64);
        let limited = [with, bidirectional].map(|settings| RenderSettings {
            max_bounces: Some(3),
            ..settings
        });
        compare_settings(name, &scene, limited, 0.03);
    }
}

#[test]
fn light_paths_agree_with_path_with_shading_normals() {
    compare("stones", &stones(), 0.02, None);
}

#[test]
fn light_paths_agree_with_path_on_a_wall_inside_glass() {
    compare("a wall within glass", &wall_within_glass(), 0.03, None);
}

/// Lenses, motion, instances, textures, normal maps, alpha and one-sided surfaces.
#[test]
fn light_paths_agree_with_path_in_generated_scenes() {
    let mut generator = Generator::new(43);
    for index in 0..6 {
        // Caustics of delta lights are found by light paths alone.
        let lacking = [Effect::Specular, Effect::DeltaLights][index % 2];
        let scene = generator.scene(EffectSet::ALL.without(lacking));
        compare(&format!("scene {index}"), &scene, 0.2, Some(6));
    }
}

/// Crops with a wide filter, a lens and motion.
#[test]
fn light_paths_agree_with_path_with_crops_and_lenses() {
    let mut scene = glass(0.0);
    scene.film.size = (24, 24);
    scene.camera.lens_radius = 0.1;
    scene.camera.focus_distance = 3.0;
    scene.camera.shutter = [0.0, 1.0];
    scene.shapes[3].motion = slide(DVec3::ZERO, DVec3::new(0.2, 0.3, 0.4));
    let (kind, radius) = (FilterKind::Mitchell, 2.0);
    scene.film.filter = FilterDescription { kind, radius };
    let crop = |settings: RenderSettings| RenderSettings {
        window: Window {
            x: 5,
            y: 3,
            width: 12,
            height: 16,
        },
        ..settings
    };
    let with = crop(with_light_paths(&scene, LightPathShare::Half, 64));
    let without = crop(settings(&scene, IntegratorKind::Path, 192));
    compare_settings("crop", &scene, [with, without], 0.04);
}

/// The variance that renders estimate for their pixels equals the variance between renders, averaged over the image.
#[test]
fn light_path_variance_estimate_matches_that_between_renders() {
    let scene = glass(0.0);
    let settings = with_light_paths(&scene, LightPathShare::Half, 16);
    let ratio = claimed_over_true_variance(&scene, &settings);
    assert!((ratio - 1.0).abs() < 0.15, "{ratio}");
}

/// A render of a scene of the gallery, small, that has just begun.
pub fn begun(name: &str, options: &RenderOptions) -> (Session, Rendering) {
    let path = in_repository(&format!("scenes/{name}/{name}.toml"));
    let mut scene = load(&path).expect("it is valid");
    scene.film.size = (64, 43);
    let session = Session::new(scene, tracing()).expect("it is valid");
    let rendering = session.start(options).expect("valid options");
    (session, rendering)
}

/// The estimated relMSE of a render of a small scene of the gallery with independent samples, and the choices of pilots.
pub fn squared_error(name: &str, mut options: RenderOptions) -> (f64, PathChoices) {
    options.sampler = Some(SamplerKind::Independent);
    let (session, mut rendering) = begun(name, &options);
    let until = rendering.settings().budget;
    rendering
        .continue_until(&session, until, &NullRenderObserver)
        .expect("it renders");
    let error = rendering.rendered().film.error(0.95);
    let rel_rmse = error.expect("samples in every batch").rel_rmse;
    (rel_rmse.powi(2), rendering.choices())
}

/// Light paths double the efficiency of caustics, halve that of four-lights, and find light in materials that camera paths
/// miss. Only in shaded-lamps do those that are no caustics save anything.
#[test]
fn pilot_enables_light_paths_only_where_more_efficient() {
    let off = LightPathRule::OFF;
    let caustics = LightPathRule::Caustics(LightPathShare::Quarter);
    let all = LightPathRule::Share(LightPathShare::One);
    for (name, least, most, expected) in [
        ("caustics", 1.2, 10.0, caustics),
        ("four-lights", 1.0, 1.2, off),
        ("rough-glass", 1.0, 1.2, off),
        ("materials", 1e4, f64::INFINITY, caustics),
        ("shaded-lamps", 1.2, 10.0, all),
    ] {
        for seed in 1..4 {
            let mut options = RenderOptions::samples(4);
            options.seed = Some(seed);
            options.light_paths = Some(LightPathRule::Auto);
            options.integrator = Some(IntegratorKind::Path);
            let (_, rendering) = begun(name, &options);
            let choice = rendering.choices().light_paths.expect("it took a pilot");
            let ratio = choice.ratio;
            assert!((least..most).contains(&ratio), "{name}, {seed}: {ratio}");
            assert_eq!(choice.rule, expected, "{name}");
            assert_eq!(rendering.settings().light_path_rule(), expected, "{name}");
        }
    }
    // A kernel without light paths cannot have any.
    let mut options = RenderOptions::samples(4);
    options.light_paths = Some(LightPathRule::Auto);
    options.reuse = Some(PathReuseRule::Auto);
    options.kernel = Some(Kernel::Studio);
    let (session, mut rendering) = begun("caustics", &options);
    assert_eq!(rendering.choices().light_paths, None);
    assert_eq!(rendering.choices().reuse, None);
    rendering
        .continue_until(&session, Budget::samples(4), &NullRenderObserver)
        .expect("the kernel has all effects");
    // There is nothing that throws light.
    let mut options = RenderOptions::samples(4);
    options.light_paths = Some(LightPathRule::Auto);
    let (_, rendering) = begun("cornell-box", &options);
    assert_eq!(rendering.choices().light_paths, None);
}

/// The ratio of squared errors that a pilot expects from the gains of light paths is that of renders with and without.
#[test]
fn pilot_predicts_the_error_reduction_of_light_paths() {
    let error = |rule| {
        let mut options = RenderOptions::samples(512);
        options.light_paths = Some(rule);
        let (error, choices) = squared_error("caustics", options);
        (error, choices.light_paths)
    };
    let (with, choice) = error(LightPathRule::Auto);
    let (without, _) = error(LightPathRule::OFF);
    let (foreseen, ratio) = (choice.expect("a pilot").ratio, without / with);
    // The pilot has a thousandth of these samples, and is cautious.
    let share = (foreseen - 1.0) / (ratio - 1.0);
    assert!((0.4..1.6).contains(&share), "{foreseen} for {ratio}");
}

#[test]
fn light_path_images_are_bit_identical_across_threads_and_tiles() {
    let scene = glass(0.0);
    let settings = with_light_paths(&scene, LightPathShare::Two, 16);
    assert_threads_and_tiles_change_no_bit(&scene, &settings);
}

/// The film divides splats by the samples of all pixels, whose counts differ here by more than a factor of four.
#[test]
fn adaptive_light_paths_agree_with_path() {
    let scene = glass(0.0);
    for share in [LightPathShare::One, LightPathShare::Quarter] {
        let with = RenderSettings {
            adaptive: Adaptive::TwoPhase,
            ..caustics_only(&with_light_paths(&scene, share, 64))
        };
        compare_with_path_alone("adaptive", &scene, with, 192, 0.02);
    }
}

#[test]
fn light_paths_are_rejected_with_greedy_sampling_or_bdpt() {
    let scene = matte();
    let options = |change: &dyn Fn(&mut RenderOptions)| {
        let mut options = RenderOptions::samples(64);
        options.light_paths = Some(LightPathRule::Share(LightPathShare::One));
        change(&mut options);
        options.settings(&scene)
    };
    assert!(options(&|_| {}).is_ok());
    assert!(options(&|it| it.adaptive = Some(Adaptive::TwoPhase)).is_ok());
    for wrong in [
        options(&|it| {
            it.adaptive = Some(Adaptive::Greedy);
            it.error = Some(0.1);
        }),
        options(&|it| it.integrator = Some(IntegratorKind::Bidirectional)),
    ] {
        let error = wrong.expect_err("light paths do not fit");
        assert_eq!(error.kind(), etendue::ErrorKind::Usage);
    }
}
