//! Tests that sharing paths between the pixels of a block changes no mean: `path` with it agrees with `path` without in
//! every part of the image, under each kind of light and for each number of bounces, and has less noise.
//!
//! Pixels of a block share samples, so images are compared as in `bidirectional.rs`, by blocks over independent renders.

use super::bidirectional::{
    assert_threads_and_tiles_change_no_bit, claimed_over_true_variance, compare_settings,
    compare_with_path_alone, kinds_of_light, settings, stones,
};
use super::light_paths::{begun, squared_error};
use crate::common::furnished::{glass, glossy, matte, six_scenes};
use crate::common::generated::{Generator, NEVER_SHARED};
use crate::common::nightly::one_in;
use crate::common::room::{LAMP, room, with_metal_ball};
use crate::common::scene::{film, ready, rectangle, slide, surface};
use etendue::internals::accel::Backend;
use etendue::internals::effects::EffectSet;
use etendue::internals::film::Window;
use etendue::internals::film::filter::{Filter, FilterDescription, FilterKind, FilterSampling};
use etendue::internals::integrator::Roulette;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::integrator::light_paths::LightPathShare;
use etendue::internals::integrator::reuse::PathReuse;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::stats::Moments;
use etendue::internals::math::vec::DVec3;
use etendue::internals::render::check;
use etendue::internals::render::options::RenderOptions;
use etendue::internals::render::replay::replay;
use etendue::internals::render::settings::{
    Adaptive, BounceLimit, LightPathRule, PathReuseRule, RenderSettings,
};
use etendue::internals::scene::description::{
    ColourDescription, GeometryDescription, MaterialModel, MeshDescription, SceneDescription,
    ShapeDescription,
};
use std::collections::BTreeSet;
use std::sync::Arc;

/// The settings of `path` with shared paths.
fn with_reuse(scene: &SceneDescription, reuse: PathReuse, spp: u64) -> RenderSettings {
    RenderSettings {
        reuse: PathReuseRule::Pixels(reuse),
        ..settings(scene, IntegratorKind::Path, spp)
    }
}

/// Compares `path` with and without shared paths.
fn compare(
    what: &str,
    scene: &SceneDescription,
    reuse: PathReuse,
    power: f64,
    max_bounces: Option<u32>,
) {
    let with = RenderSettings {
        max_bounces,
        ..with_reuse(scene, reuse, 64)
    };
    compare_with_path_alone(what, scene, with, 128, power);
}

#[test]
fn path_reuse_agrees_with_path_in_every_block_of_six_scenes() {
    let groups = [PathReuse::Sixteen, PathReuse::Four];
    for (place, (name, scene, power)) in six_scenes().iter().enumerate() {
        // Groups of 16 in the first and fifth scene, of 4 in the second and sixth; `make nightly` has both in every scene.
        for &reuse in one_in(4, place % 4, &groups) {
            compare(name, scene, reuse, *power, None);
        }
    }
}

#[test]
fn path_reuse_agrees_with_path_for_zero_to_four_bounces() {
    for (first, (name, scene)) in [("matte", matte()), ("smooth glass", glass(0.0))]
        .iter()
        .enumerate()
    {
        for max_bounces in one_in(2, first, 0..5) {
            let what = format!("{name}, {max_bounces} bounces");
            compare(&what, scene, PathReuse::Sixteen, 0.03, Some(max_bounces));
        }
    }
}

#[test]
fn path_reuse_agrees_with_path_under_every_kind_of_light() {
    for (name, scene) in one_in(3, 1, &kinds_of_light()) {
        compare(name, scene, PathReuse::Sixteen, 0.03, None);
    }
}

/// A wall with vertical stripes, one pixel wide, of metal or black: every block has pixels that share and others that do not.
#[test]
fn path_reuse_agrees_with_path_in_partly_shareable_blocks() {
    let metal = with_metal_ball(0.5, [0.0, 0.3, 0.5], 0.2);
    let mut black = metal.clone();
    let model = MaterialModel::Diffuse {
        reflectance: ColourDescription::Constant(Rgb::BLACK),
    };
    black.materials.last_mut().expect("the metal").model = model;
    // The wall is 4.6 from the camera, whose angle of view is 36 degrees for 16 pixels.
    let width = 2.0 * 4.6 * 18_f64.to_radians().tan() / 16.0;
    for (name, mut scene) in [("metal", metal), ("black", black)] {
        let material = scene.shapes.last().expect("the ball").material;
        for stripe in 0..5 {
            let x = -1.0 + 2.0 * width * f64::from(stripe);
            let strip = rectangle([x, 0.0, -0.99], [width, 0.0, 0.0], [0.0, 2.0, 0.0]);
            scene.shapes.push(ShapeDescription {
                material,
                ..surface(strip, 0.0)
            });
        }
        for reuse in one_in(2, 0, [PathReuse::Sixteen, PathReuse::Four]) {
            let with = with_reuse(&scene, reuse, 256);
            compare_with_path_alone(name, &scene, with, 256, 0.004);
        }
    }
}

/// A room whose walls and blocks are rough: dielectrics with a diffuse base, or metal.
fn rough(metallic: f32, roughness: f32) -> SceneDescription {
    let mut scene = matte();
    for material in &mut scene.materials {
        if let MaterialModel::Diffuse { reflectance } = &material.model {
            material.model = MaterialModel::Principled {
                base_color: reflectance.clone(),
                metallic,
                roughness,
                ior: 1.5,
                transmission: 0.0,
            };
        }
    }
    scene
}

#[test]
fn path_reuse_agrees_with_path_between_rough_surfaces() {
    let surfaces = [
        ("rough metal", 1.0, 0.4),
        ("smooth coat", 0.0, 0.2),
        ("mirroring coat", 0.0, 0.0),
        ("rough coat", 0.0, 0.7),
    ];
    for (place, (name, metallic, roughness)) in surfaces.into_iter().enumerate() {
        let scene = rough(metallic, roughness);
        for reuse in one_in(2, place % 2, [PathReuse::Sixteen, PathReuse::Four]) {
            compare(name, &scene, reuse, 0.03, None);
        }
    }
}

/// A lit panel before the left wall of a dark room, whose normals lean by 60 degrees towards the camera: from the back of the
/// room they have to be tilted, from its front not.
fn with_leaning_normals() -> SceneDescription {
    let spot = "[[light]]\ntype = \"spot\"\nposition = [-0.5, 1, 0.98]\ntarget = [-1, 1, 0]\nintensity = 9\ncone = 40\n";
    let mut scene = room(spot);
    let corners = [[0.1, -0.95], [0.1, 0.95], [1.9, 0.95], [1.9, -0.95]];
    let panel = MeshDescription {
        positions: corners.map(|[y, z]| DVec3::new(-0.97, y, z)).to_vec(),
        normals: vec![DVec3::new(0.5, 0.0, 0.75_f64.sqrt()); 4],
        indices: vec![[0, 2, 1], [0, 3, 2]],
        ..MeshDescription::default()
    };
    let panel = GeometryDescription::Mesh(Arc::new(panel));
    scene.shapes.push(surface(panel, 0.0));
    scene
}

#[test]
fn path_reuse_agrees_with_path_with_shading_normals() {
    compare("stones", &stones(), PathReuse::Sixteen, 0.02, None);
    let leaning = with_leaning_normals();
    let with = with_reuse(&leaning, PathReuse::Sixteen, 256);
    compare_with_path_alone("leaning", &leaning, with, 256, 0.006);
}

/// Lenses, instances, textures, normal maps and one-sided surfaces.
#[test]
fn path_reuse_agrees_with_path_in_generated_scenes() {
    let mut generator = Generator::new(44);
    let wanted = NEVER_SHARED
        .into_iter()
        .fold(EffectSet::ALL, EffectSet::without);
    for index in 0..6 {
        let scene = generator.scene(wanted);
        compare(
            &format!("scene {index}"),
            &scene,
            PathReuse::Sixteen,
            0.2,
            Some(6),
        );
    }
}

/// Crops that begin and end within blocks, with a lens and filters with negative weights, sampled and splatted.
#[test]
fn path_reuse_agrees_with_path_with_crops_lenses_and_filters() {
    let mut scene = matte();
    scene.film.size = (24, 24);
    scene.camera.lens_radius = 0.1;
    scene.camera.focus_distance = 3.0;
    let (kind, radius) = (FilterKind::Mitchell, 2.0);
    scene.film.filter = FilterDescription { kind, radius };
    for filter_sampling in [FilterSampling::Importance, FilterSampling::Splatting] {
        let crop = |settings: RenderSettings| RenderSettings {
            window: Window {
                x: 5,
                y: 3,
                width: 12,
                height: 16,
            },
            filter_sampling,
            ..settings
        };
        let with = crop(with_reuse(&scene, PathReuse::Sixteen, 64));
        let without = crop(settings(&scene, IntegratorKind::Path, 128));
        compare_settings("crop", &scene, [with, without], 0.04);
    }
}

/// A wedge whose opening is a thousandth of its length: pixels near its edge find surfaces at distances over many orders of
/// magnitude, and at grazing angles.
#[test]
fn path_reuse_is_finite_and_agrees_with_path_in_a_narrow_wedge() {
    let mut scene = room(LAMP);
    let lid = rectangle([-1.0, 0.0, -1.0], [2.0, 0.0, 0.0], [0.0, 2e-3, 2.0]);
    scene.shapes.push(surface(lid, 0.0));
    let with = with_reuse(&scene, PathReuse::Sixteen, 64);
    let rendered = film(&ready(&scene, Backend::ALL[0]), &scene, &with);
    let pixels = rendered.develop();
    let is_finite = |value: f32| value.is_finite() && value >= 0.0;
    assert!(
        pixels
            .pixels()
            .iter()
            .all(|p| p.to_array().into_iter().all(is_finite))
    );
    compare("wedge", &scene, PathReuse::Sixteen, 0.03, None);
}

/// The mean variance of pixels over independent renders, relative to their means, in the indirect light of a scene.
fn variance(scene: &SceneDescription, reuse: PathReuse) -> f64 {
    let ready = ready(scene, Backend::ALL[0]);
    let images: Vec<_> = (0..8)
        .map(|seed| {
            let settings = RenderSettings {
                seed,
                ..with_reuse(scene, reuse, 16)
            };
            film(&ready, scene, &settings).develop()
        })
        .collect();
    let count = images[0].pixels().len();
    let relative = (0..count).map(|pixel| {
        let values = images
            .iter()
            .map(|it| f64::from(it.pixels()[pixel].to_array()[1]));
        let moments = Moments::of(values);
        moments.variance().expect("several renders") / moments.mean().powi(2)
    });
    relative.sum::<f64>() / count as f64
}

#[test]
fn more_path_reuse_lowers_the_variance() {
    let mut scene = matte();
    // Pixels of a group are to see neighbouring points.
    scene.film.size = (48, 48);
    let [off, four, sixteen] =
        [PathReuse::Off, PathReuse::Four, PathReuse::Sixteen].map(|reuse| variance(&scene, reuse));
    println!("relative variances {off:.5}, {four:.5}, {sixteen:.5}");
    assert!(
        four < 0.7 * off && sixteen < 0.7 * four,
        "{off} {four} {sixteen}"
    );
}

/// The variance that renders estimate for their pixels equals the variance between renders, averaged over the image.
#[test]
fn path_reuse_variance_estimate_matches_that_between_renders() {
    let scene = matte();
    for filter_sampling in [FilterSampling::Importance, FilterSampling::Splatting] {
        let settings = RenderSettings {
            filter_sampling,
            ..with_reuse(&scene, PathReuse::Sixteen, 16)
        };
        let ratio = claimed_over_true_variance(&scene, &settings);
        assert!((ratio - 1.0).abs() < 0.15, "{filter_sampling:?}: {ratio}");
    }
}

/// In closed rooms of matte surfaces shared paths pay; not where most light is direct, or leaves after one surface.
#[test]
fn pilot_enables_path_reuse_only_where_more_efficient() {
    for (name, pays) in [
        ("cornell-box", true),
        ("four-lights", false),
        ("environment", false),
        ("phong-lobes", false),
    ] {
        let mut chosen = BTreeSet::new();
        for (seed, threads) in [(1, 1), (2, 2)] {
            let mut options = RenderOptions::samples(4);
            options.seed = Some(seed);
            options.threads = Some(threads);
            options.light_paths = Some(LightPathRule::OFF);
            let (_, rendering) = begun(name, &options);
            let choice = rendering.choices().reuse.expect("it took a pilot");
            assert_eq!(rendering.settings().reuse(), choice.reuse, "{name}");
            chosen.insert((choice.reuse.name(), choice.gain.to_bits()));
        }
        assert_eq!(chosen.len(), 1, "{name}: {chosen:?}");
        let (reuse, gain) = chosen.pop_first().expect("one choice");
        let gain = f64::from_bits(gain);
        assert_eq!(reuse != "off", pays, "{name}: {reuse}, {gain}");
    }
}

#[test]
fn path_reuse_stays_off_where_unsupported() {
    let options = |change: &dyn Fn(&mut RenderOptions)| {
        let mut options = RenderOptions::samples(4);
        change(&mut options);
        options
    };
    for (name, options) in [
        ("cornell-box", options(&|it| it.layers = true)),
        (
            "cornell-box",
            options(&|it| it.adaptive = Some(Adaptive::TwoPhase)),
        ),
        (
            "cornell-box",
            options(&|it| it.max_bounces = Some(BounceLimit::AtMost(1))),
        ),
        (
            "cornell-box",
            options(&|it| {
                it.roulette = Some(Roulette::None);
                it.max_bounces = Some(BounceLimit::AtMost(7));
            }),
        ),
        (
            "cornell-box",
            options(&|it| it.integrator = Some(IntegratorKind::Bidirectional)),
        ),
        ("caustics", options(&|_| {})),
        ("motion-blur", options(&|_| {})),
    ] {
        let (_, rendering) = begun(name, &options);
        assert_eq!(rendering.choices().reuse, None, "{name}");
        assert_eq!(rendering.settings().reuse(), PathReuse::Off, "{name}");
    }
}

/// The ratio of squared errors that a pilot measures in a few windows is that of whole renders.
#[test]
fn pilot_predicts_the_error_reduction_of_path_reuse() {
    let error = |rule| {
        let mut options = RenderOptions::samples(64);
        options.reuse = Some(rule);
        let (error, choices) = squared_error("cornell-box", options);
        (error, choices.reuse)
    };
    let (with, choice) = error(PathReuseRule::Auto);
    let (without, _) = error(PathReuseRule::Pixels(PathReuse::Off));
    let (foreseen, gain) = (choice.expect("a pilot").ratio, without / with);
    assert!(
        (0.7..1.4).contains(&(foreseen / gain)),
        "{foreseen} for {gain}"
    );
}

#[test]
fn path_reuse_images_are_bit_identical_across_threads_and_tiles() {
    let scene = glossy();
    for reuse in [PathReuse::Four, PathReuse::Sixteen] {
        let settings = with_reuse(&scene, reuse, 16);
        assert_threads_and_tiles_change_no_bit(&scene, &settings);
    }
}

/// With a box filter and one sample per pixel, an image is its replayed samples.
#[test]
fn replayed_sample_includes_light_shared_by_its_group() {
    let scene = matte();
    let ready = ready(&scene, Backend::ALL[0]);
    let filter = Filter::new(&scene.film.filter);
    for reuse in [PathReuse::Four, PathReuse::Sixteen] {
        let settings = with_reuse(&scene, reuse, 1);
        let image = film(&ready, &scene, &settings).develop();
        let mut others = 0;
        for pixel in settings.window.pixels() {
            let replayed = replay(&ready, &filter, &settings, pixel, 0).expect("valid settings");
            assert_eq!(
                replayed.radiance,
                image.pixels()[settings.window.index(pixel)]
            );
            assert!(!replayed.events.is_empty());
            let alone = replayed.alone.expect("its own path");
            others += usize::from(alone != replayed.radiance);
        }
        assert!(others > 100, "{others} pixels have the light of others");
    }
}

#[test]
fn settings_incompatible_with_path_reuse_are_rejected() {
    let scene = matte();
    let options = |change: &dyn Fn(&mut RenderOptions)| {
        let mut options = RenderOptions::samples(64);
        options.reuse = Some(PathReuseRule::Pixels(PathReuse::Sixteen));
        change(&mut options);
        options.settings(&scene)
    };
    assert!(options(&|_| {}).is_ok_and(|it| it.reuse() == PathReuse::Sixteen));
    for wrong in [
        options(&|it| it.adaptive = Some(Adaptive::TwoPhase)),
        options(&|it| it.integrator = Some(IntegratorKind::Bidirectional)),
        options(&|it| it.light_paths = Some(LightPathRule::Share(LightPathShare::One))),
        options(&|it| it.layers = true),
    ] {
        let error = wrong.expect_err("shared paths do not fit");
        assert_eq!(error.kind(), etendue::ErrorKind::Usage);
    }
    let mut moving = matte();
    moving.camera.shutter = [0.0, 1.0];
    moving.shapes[3].motion = slide(DVec3::ZERO, DVec3::new(0.2, 0.3, 0.4));
    let settings = with_reuse(&moving, PathReuse::Sixteen, 1);
    let scene = ready(&moving, Backend::ALL[0]);
    let error = check(&scene, &settings).expect_err("motion does not fit");
    assert!(error.to_string().contains("motion"), "{error}");
}
