//! `auto` renders the image of the integrator that it selects, always selects the same, and selects one that suits the scene.

use crate::common::furnished::{glass, matte, outside, small_light};
use crate::common::nightly::is_nightly;
use crate::common::room::{room, with_mirrored_point_light};
use crate::common::session::session_of;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::NullRenderObserver;
use etendue::internals::render::auto::Recommendation;
use etendue::internals::render::options::RenderOptions;
use etendue::internals::render::settings::Adaptive;
use etendue::internals::scene::description::SceneDescription;
use etendue::internals::session::Session;

/// A bulb in a shade that is open above and below: all but two spots is lit indirectly, by ceiling and floor.
fn shaded() -> SceneDescription {
    room(
        r#"
[[shape]]
type = "mesh"
material = "white"
positions = [[-0.2, 1.2, -0.2], [0.2, 1.2, -0.2], [0.2, 1.2, 0.2], [-0.2, 1.2, 0.2], [-0.2, 1.8, -0.2], [0.2, 1.8, -0.2], [0.2, 1.8, 0.2], [-0.2, 1.8, 0.2]]
indices = [[0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]]

[[shape]]
type = "disk"
material = "white"
center = [0, 1.3, 0]
normal = [0, 1, 0]
radius = 0.19

[[shape]]
type = "sphere"
material = "white"
emission = 900
center = [0, 1.45, 0]
radius = 0.02
"#,
    )
}

/// A session of the scene with enough pixels for a pilot.
fn session(scene: SceneDescription, threads: usize) -> Session {
    let mut scene = scene;
    scene.film.size = (64, 64);
    session_of(scene, threads)
}

fn options(integrator: IntegratorKind) -> RenderOptions {
    let mut options = RenderOptions::samples(16);
    options.integrator = Some(integrator);
    options.seed = Some(3);
    options
}

fn recommended(session: &Session, options: &RenderOptions) -> Recommendation {
    session
        .recommend(options, &NullRenderObserver)
        .expect("a valid scene and valid options")
}

#[test]
fn auto_image_equals_that_of_the_recommended_integrator() {
    for scene in [matte(), shaded(), with_mirrored_point_light()] {
        let session = session(scene, 2);
        let see = |integrator| {
            let rendering = session.render(&options(integrator), &NullRenderObserver);
            rendering.expect("valid options")
        };
        let auto = see(IntegratorKind::Auto);
        let told = auto.recommendation().expect("it was left to auto");
        assert_eq!(auto.settings().integrator, told.integrator);
        let named = see(told.integrator);
        assert!(named.recommendation().is_none());
        assert_eq!(auto.image(), named.image(), "{}", told.integrator.name());
    }
}

#[test]
fn recommendation_is_independent_of_thread_count() {
    let on = |threads| {
        let session = session(shaded(), threads);
        recommended(&session, &options(IntegratorKind::Auto))
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn recommendation_is_the_expected_integrator_for_each_scene() {
    let path = &[IntegratorKind::Path][..];
    let bidirectional = &[IntegratorKind::Bidirectional, IntegratorKind::Metropolis];
    for (what, scene, expected, says) in [
        ("matte", matte(), path, "no other integrator"),
        (
            "a ball of glass under a large lamp",
            glass(0.0),
            path,
            "no other integrator",
        ),
        ("a small lamp", small_light(), path, "no other integrator"),
        ("a lamp in a shade", shaded(), bidirectional, "rarely find"),
        // Light paths find what the mirror throws.
        (
            "a mirror",
            with_mirrored_point_light(),
            path,
            "no other integrator",
        ),
    ] {
        let seeds = if is_nightly() { 3 } else { 1 };
        for seed in 0..seeds {
            let mut options = options(IntegratorKind::Auto);
            options.seed = Some(seed);
            let told = recommended(&session(scene.clone(), 2), &options);
            println!("{what}: {told:?}");
            assert!(expected.contains(&told.integrator), "{what}: {told:?}");
            assert!(told.why.contains(says), "{what}: {told:?}");
        }
    }
}

#[test]
fn adaptive_sampling_restricts_auto_to_path() {
    let session = session(shaded(), 2);
    let mut options = options(IntegratorKind::Auto);
    options.adaptive = Some(Adaptive::TwoPhase);
    let told = recommended(&session, &options);
    assert_eq!(told.integrator, IntegratorKind::Path);
    assert!(told.why.contains("only path"), "{told:?}");
    assert!(session.render(&options, &NullRenderObserver).is_ok());
}

#[test]
fn biased_irradiance_cache_is_suggested_only_for_matte_scenes() {
    let told = recommended(&session(matte(), 2), &options(IntegratorKind::Auto));
    let option = told.option.expect("all materials are matte");
    assert!(option.contains("irradiance-cache") && option.contains("biased"));
    // A mirror is not matte.
    let told = recommended(&session(outside(), 2), &options(IntegratorKind::Auto));
    assert_eq!(told.option, None);
}
