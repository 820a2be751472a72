//! Error bars have their nominal coverage, and pixels where they do not are flagged.
//!
//! Every pixel of a closed form has a known expectation: the share of seeds for which its interval contains it is a binomial
//! variable. Bars of whole images are compared with images of many more samples.

use crate::common::closed_forms::parallel_rectangle;
use crate::common::error_bars::{Coverage, TargetsReached, reference_settings, settings};
use crate::common::nightly::{is_nightly, one_in, samplers};
use crate::common::room::{floor_below, with_metal_ball};
use crate::common::scene::{film, ready, rectangle};
use etendue::internals::accel::Backend;
use etendue::internals::film::Film;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::math::vec::DVec3;
use etendue::internals::render::settings::{RenderSettings, SamplerKind};
use etendue::internals::scene::description::{GeometryDescription, SceneDescription};
use std::sync::LazyLock;

#[test]
fn error_bars_have_nominal_coverage_for_closed_forms() {
    let square = rectangle([-1.0, 1.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    let disk = GeometryDescription::Disk {
        center: DVec3::Y,
        normal: DVec3::NEG_Y,
        radius: 1.0,
    };
    let cases = [
        (
            "square",
            square,
            0.5 * 4.0 * parallel_rectangle(1.0, 1.0, 1.0),
        ),
        ("disk", disk, 0.25),
    ];
    for (name, lamp, exact) in cases {
        let description = floor_below(lamp);
        let scene = ready(&description, Backend::ALL[0]);
        for sampler in [
            SamplerKind::Independent,
            SamplerKind::Sobol,
            SamplerKind::Stratified,
        ] {
            for spp in one_in(2, 0, [64, 512]) {
                let settings = RenderSettings {
                    max_bounces: Some(1),
                    ..settings(&description, sampler, 0, spp)
                };
                let mut coverage = Coverage::default();
                coverage.add_images((&scene, &description), &settings, 100, |_| exact);
                println!("| {name}, {}, {spp} spp |{coverage}", sampler.name());
                assert_eq!(coverage.miscalibrated(), None, "{name}, {}", sampler.name());
            }
        }
    }
}

#[test]
fn error_bars_of_rare_events_are_flagged() {
    // Cosine-distributed directions hit the lamp with the probability of its form factor: the planted events of row 63.
    for (side, probability) in [(0.056, 1e-3), (0.0177, 1e-4)] {
        let half = side / 2.0;
        let lamp = rectangle([-half, 1.0, -half], [side, 0.0, 0.0], [0.0, 0.0, side]);
        let form_factor = 4.0 * parallel_rectangle(half, half, 1.0);
        assert!(
            (form_factor / probability - 1.0).abs() < 0.01,
            "{form_factor}"
        );
        let mut description = floor_below(lamp);
        description.film.size = (16, 16);
        let scene = ready(&description, Backend::ALL[0]);
        let settings = RenderSettings {
            max_bounces: Some(1),
            integrator: IntegratorKind::Bsdf,
            ..settings(&description, SamplerKind::Independent, 0, 1024)
        };
        let mut coverage = Coverage::default();
        let exact = 0.5 * form_factor;
        coverage.add_images((&scene, &description), &settings, 10, |_| exact);
        println!("| events of probability {probability} |{coverage}");
        assert!(coverage.flagged() > 0.99, "{}", coverage.flagged());
    }
}

/// A room with a lamp and a metal sphere of this roughness.
fn room_with_metal(roughness: f64) -> SceneDescription {
    let mut description = with_metal_ball(roughness, [0.3, 0.5, 0.0], 0.5);
    description.film.size = (32, 32);
    description
}

/// The reference film of the room with the roughest metal; rendered once for all tests.
static MATTE_ROOM: LazyLock<Film> = LazyLock::new(|| truth(1.0));

/// The samples per pixel of the images.
fn spp() -> u64 {
    if is_nightly() { 256 } else { 64 }
}

/// A reference film of the room, worth 64 times the samples of the images.
fn truth(roughness: f64) -> Film {
    let spp = 64 * spp();
    let description = room_with_metal(roughness);
    let scene = ready(&description, Backend::ALL[0]);
    film(&scene, &description, &reference_settings(&description, spp))
}

/// The coverage of 20 images of a room, given the roughness of its metal and its reference film.
fn of_room(roughness: f64, truth: &Film, sampler: SamplerKind) -> Coverage {
    let spp = spp();
    let description = room_with_metal(roughness);
    let scene = ready(&description, Backend::ALL[0]);
    let settings = settings(&description, sampler, 0, spp);
    let truth = truth.develop();
    let mut coverage = Coverage::default();
    coverage.add_images((&scene, &description), &settings, 20, |index| {
        f64::from(truth.pixels()[index].to_array()[1])
    });
    let sampler = sampler.name();
    println!("| metal of {roughness}, {sampler}, {spp} spp |{coverage}");
    coverage
}

#[test]
fn error_bars_have_nominal_coverage_in_a_rough_metal_room() {
    for &sampler in samplers(&[SamplerKind::Sobol, SamplerKind::Independent]) {
        let coverage = of_room(1.0, &MATTE_ROOM, sampler);
        assert_eq!(coverage.miscalibrated(), None, "{}", sampler.name());
        assert!(coverage.flagged() < 0.1, "{}", coverage.flagged());
    }
}

#[test]
fn error_bars_have_nominal_coverage_with_rare_caustic_paths() {
    // Paths from the floor via the metal to the lamp are rare and bright: from its own samples alone one pixel in eight would
    // have a bar that is far too short.
    let coverage = of_room(0.3, &truth(0.3), SamplerKind::Sobol);
    assert_eq!(coverage.miscalibrated(), None);
    assert!(coverage.flagged() < 0.1, "{}", coverage.flagged());
}

#[test]
fn error_target_is_met_without_much_oversampling() {
    let description = room_with_metal(1.0);
    let scene = ready(&description, Backend::ALL[0]);
    for &sampler in samplers(&[SamplerKind::Sobol, SamplerKind::Independent]) {
        for target in one_in(2, 0, [0.08, 0.06]) {
            let settings = settings(&description, sampler, 0, 1);
            let kept =
                TargetsReached::of((&scene, &description), (&settings, target), 24, &MATTE_ROOM);
            println!("| {}, {target} |{kept}", sampler.name());
            // If each of 24 renders keeps it with probability 95 %, fewer than 19 do with probability 1e-3.
            assert!(kept.kept >= 19, "{kept}");
            assert!(kept.mean() > 0.75, "{kept}");
            assert!(kept.are_foreseen_at(0.75), "{kept}");
        }
    }
}
