//! Tests that bidirectional path tracing agrees with path tracing in every part of the image, for each number of
//! bounces, each kind of light and each effect, and that its error bars are calibrated.
//!
//! Splats of one light subpath fall on several pixels. Images are therefore compared by their blocks of pixels over
//! independent renders, by Welch's t-test, at a significance of 1e-4 for all tests of this file together.

use crate::common::furnished::{glass, glossy, matte, six_scenes};
use crate::common::generated::Generator;
use crate::common::nightly::{one_in, samples_and_limit};
use crate::common::room::{LAMP, room};
use crate::common::scene::{film, mirrored_octahedron, panorama, ready, slide, surface};
use crate::common::verdict::sidak;
use etendue::internals::accel::Backend;
use etendue::internals::effects::{Effect, EffectSet};
use etendue::internals::film::Film;
use etendue::internals::film::filter::{FilterDescription, FilterKind};
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::math::stats::Moments;
use etendue::internals::math::vec::{DMat3, DVec3};
use etendue::internals::render::settings::{Budget, RenderSettings, SamplerKind};
use etendue::internals::scene::description::{
    ColourDescription, LightDescription, LightModel, MaterialModel, SceneDescription,
};
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::sync::Arc;

/// Number of independent renders of each image.
const RENDERS: u64 = 12;

/// Number of blocks of an image along each axis.
const BLOCKS: u32 = 4;

pub fn settings(scene: &SceneDescription, integrator: IntegratorKind, spp: u64) -> RenderSettings {
    RenderSettings {
        integrator,
        sampler: SamplerKind::Independent,
        tile_size: 4,
        ..RenderSettings::new(scene.film.size, spp)
    }
}

/// The moments over several renders of each block's mean, row by row, and last of the whole image's: for each channel.
fn seen(scene: &SceneDescription, settings: &RenderSettings) -> Vec<[Moments; 3]> {
    let ready = ready(scene, Backend::ALL[0]);
    let mut blocks = vec![[Moments::default(); 3]; (BLOCKS * BLOCKS + 1) as usize];
    for seed in 0..RENDERS {
        let settings = RenderSettings {
            seed: settings.seed + seed,
            ..settings.clone()
        };
        let image = film(&ready, scene, &settings).develop();
        let mut means = vec![[Moments::default(); 3]; blocks.len()];
        for y in 0..image.height() {
            for x in 0..image.width() {
                let column = x * BLOCKS / image.width();
                let block = y * BLOCKS / image.height() * BLOCKS + column;
                let pixel = image.get(x, y).to_array();
                for place in [block as usize, blocks.len() - 1] {
                    for (moments, value) in means[place].iter_mut().zip(pixel) {
                        moments.push(value.into());
                    }
                }
            }
        }
        for (block, means) in blocks.iter_mut().zip(means) {
            for (moments, mean) in block.iter_mut().zip(means) {
                moments.push(mean.mean());
            }
        }
    }
    blocks
}

/// Compares every block and channel by Welch's test; there are about three thousand tests in this file. The relative
/// standard error of the whole image has to be below `power`.
fn assert_same(what: &str, a: &[[Moments; 3]], b: &[[Moments; 3]], power: f64) {
    let significance = sidak(1e-4, 6000);
    for (block, (a, b)) in a.iter().zip(b).enumerate() {
        for (channel, (a, b)) in a.iter().zip(b).enumerate() {
            let squares = [a, b].map(|m| m.standard_error().expect("several renders").powi(2));
            let sum = squares[0] + squares[1];
            let off = (a.mean() - b.mean()).abs();
            if off <= 1e-6 * a.mean().abs() {
                continue;
            }
            // Welch-Satterthwaite degrees of freedom.
            let degrees = sum * sum
                / squares
                    .map(|s| s * s / (RENDERS - 1) as f64)
                    .iter()
                    .sum::<f64>();
            let student = StudentsT::new(0.0, 1.0, degrees).expect("some degrees of freedom");
            let limit = student.inverse_cdf(1.0 - 0.5 * significance);
            let t = off / sum.sqrt();
            assert!(
                t < limit,
                "{what}, block {block}, channel {channel}: {} and {}, {t:.2} standard errors apart, limit {limit:.2}",
                a.mean(),
                b.mean()
            );
        }
    }
    let (a, b) = (a[a.len() - 1][1], b[b.len() - 1][1]);
    let [ea, eb] = [a, b].map(|m| m.standard_error().expect("several renders"));
    let error = ea.hypot(eb) / a.mean();
    println!(
        "{what}: {:.5} and {:.5}, standard error {error:.5}",
        a.mean(),
        b.mean()
    );
    assert!(
        error < power,
        "{what}: inconclusive, a standard error of {error}"
    );
}

/// Compares an integrator with `path` on a scene, each with its number of samples per pixel in each render.
pub fn compare_with_path(
    what: &str,
    scene: &SceneDescription,
    (integrator, [spp, spp_of_path]): (IntegratorKind, [u64; 2]),
    power: f64,
    max_bounces: Option<u32>,
) {
    let both = [(integrator, spp), (IntegratorKind::Path, spp_of_path)];
    let both = both.map(|(integrator, spp)| RenderSettings {
        max_bounces,
        ..settings(scene, integrator, spp)
    });
    compare_settings(what, scene, both, power);
}

/// Compares settings of `path` with `path` alone, with this many samples per pixel in each render.
pub fn compare_with_path_alone(
    what: &str,
    scene: &SceneDescription,
    with: RenderSettings,
    spp_alone: u64,
    power: f64,
) {
    let alone = RenderSettings {
        max_bounces: with.max_bounces,
        ..settings(scene, IntegratorKind::Path, spp_alone)
    };
    compare_settings(what, scene, [with, alone], power);
}

/// Compares renders of a scene by these settings, with seeds of their own.
pub fn compare_settings(
    what: &str,
    scene: &SceneDescription,
    [a, b]: [RenderSettings; 2],
    power: f64,
) {
    let see = |settings: RenderSettings, seed| {
        let spp = settings.budget.spp.expect("a number of samples");
        let budget = match settings.integrator {
            // The sample count is the length of the chains.
            IntegratorKind::Metropolis => settings.budget,
            _ => Budget::samples(samples_and_limit(spp, power).0),
        };
        let settings = RenderSettings {
            seed,
            budget,
            ..settings
        };
        seen(scene, &settings)
    };
    let (_, limit) = samples_and_limit(1, power);
    assert_same(what, &see(a, 100), &see(b, 200), limit);
}

/// Compares bidirectional path tracing with `path`, without a limit on bounces.
fn compare(what: &str, scene: &SceneDescription, spp: [u64; 2], power: f64) {
    compare_limited(what, scene, spp, power, None);
}

fn compare_limited(
    what: &str,
    scene: &SceneDescription,
    spp: [u64; 2],
    power: f64,
    max_bounces: Option<u32>,
) {
    let both = (IntegratorKind::Bidirectional, spp);
    compare_with_path(what, scene, both, power, max_bounces);
}

#[test]
fn bdpt_agrees_with_path_in_every_block_of_six_scenes() {
    for (name, scene, power) in one_in(2, 0, &six_scenes()) {
        compare(name, scene, [32, 128], *power);
    }
}

#[test]
fn bdpt_agrees_with_path_for_zero_to_four_bounces() {
    let scene = glass(0.0);
    for max_bounces in 0..5 {
        let what = format!("{max_bounces} bounces");
        compare_limited(&what, &scene, [32, 128], 0.02, Some(max_bounces));
    }
}

fn light(model: LightModel) -> LightDescription {
    LightDescription {
        place: Default::default(),
        model,
    }
}

/// Objects of several materials in a room without a lamp. They have no delta lobes, because path tracing cannot find
/// caustics of delta lights.
fn unlit() -> SceneDescription {
    room(
        r#"
[[material]]
name = "glass"
type = "dielectric"
roughness = 0.6

[[material]]
name = "plastic"
type = "plastic"
reflectance = [0.2, 0.3, 0.7]
roughness = 0.3

[[shape]]
type = "sphere"
material = "glass"
center = [0.4, 0.4, 0.2]
radius = 0.35

[[shape]]
type = "box"
material = "plastic"
min = [-0.7, 0, -0.6]
max = [-0.1, 0.8, 0]
"#,
    )
}

/// The scene of [`unlit`] under each kind of light, and under all of them.
pub fn kinds_of_light() -> Vec<(&'static str, SceneDescription)> {
    let sky = ColourDescription::Texture(Arc::new(panorama()));
    let environment = LightModel::Environment {
        radiance: sky,
        to_world: DMat3::from_rotation_x(1.1),
    };
    let tables = [
        (
            "point",
            "[[light]]\ntype = \"point\"\nposition = [0.3, 1.6, 0.2]\nintensity = 1",
        ),
        (
            "spot",
            "[[light]]\ntype = \"spot\"\nposition = [-0.5, 1.9, 0.5]\ntarget = [0.3, 0, 0]\ncone = 35\npenumbra = 20\nintensity = 3",
        ),
        (
            "distant",
            "[[light]]\ntype = \"distant\"\ndirection = [0.3, -0.4, -1]\nirradiance = 2",
        ),
        (
            "disk",
            "[[shape]]\ntype = \"disk\"\nmaterial = \"white\"\nemission = 6\ncenter = [0, 1.5, 0]\nnormal = [0.2, -1, 0.1]\nradius = 0.3",
        ),
        (
            "sphere",
            "[[shape]]\ntype = \"sphere\"\nmaterial = \"white\"\nemission = 6\ncenter = [0, 1.5, 0]\nradius = 0.2",
        ),
        (
            "both sides",
            "[[shape]]\ntype = \"mesh\"\nmaterial = \"white\"\nemission = 6\ntwo_sided_emission = true\npositions = [[-0.4, 1.3, 0], [0.3, 1.5, 0.3], [0.2, 1.4, -0.4]]\nindices = [[0, 1, 2]]",
        ),
    ];
    let mut scenes = Vec::new();
    for (name, table) in tables {
        let mut scene = unlit();
        let lit = room(table);
        scene.lights = lit.lights;
        // The room's own shapes come first.
        let white = scene.shapes[0].material;
        let own = room("").shapes.len();
        scene
            .shapes
            .extend(lit.shapes.into_iter().skip(own).map(|mut shape| {
                shape.material = white;
                shape
            }));
        scenes.push((name, scene));
    }
    let mut scene = unlit();
    scene.lights.push(light(environment));
    scenes.push(("environment", scene.clone()));
    // All lights at once, so that one of many is sampled.
    for (_, other) in &scenes[..6] {
        scene.lights.extend(other.lights.iter().cloned());
        scene
            .shapes
            .extend(other.shapes.iter().skip(unlit().shapes.len()).cloned());
    }
    scenes.push(("all", scene));
    scenes
}

#[test]
fn bdpt_agrees_with_path_under_every_kind_of_light() {
    for (name, scene) in one_in(2, 1, &kinds_of_light()) {
        compare(name, scene, [32, 192], 0.03);
    }
}

/// Stones with shading normals up to 55 degrees off the geometric ones: diffuse, a mirror, smooth glass and rough glass.
pub fn stones() -> SceneDescription {
    let mut scene = room(LAMP);
    let materials = [
        MaterialModel::Diffuse {
            reflectance: ColourDescription::Constant(etendue::internals::math::rgb::Rgb::grey(0.8)),
        },
        MaterialModel::Mirror {
            reflectance: ColourDescription::Constant(etendue::internals::math::rgb::Rgb::grey(0.9)),
        },
        MaterialModel::Dielectric {
            ior: 1.5,
            roughness: 0.0,
            tint: ColourDescription::Constant(etendue::internals::math::rgb::Rgb::WHITE),
        },
        MaterialModel::Dielectric {
            ior: 1.4,
            roughness: 0.6,
            tint: ColourDescription::Constant(etendue::internals::math::rgb::Rgb::WHITE),
        },
    ];
    for (index, model) in materials.into_iter().enumerate() {
        let mut material = scene.materials[0].clone();
        material.model = model;
        scene.materials.push(material);
        let (x, z) = ([-0.45, 0.45][index % 2], [-0.4, 0.4][index / 2]);
        let y = [0.5, 0.9][index / 2];
        let mut stone = surface(mirrored_octahedron(DVec3::new(x, y, z), 0.42), 0.0);
        stone.material = scene.materials.len() - 1;
        scene.shapes.push(stone);
    }
    scene
}

#[test]
fn bdpt_agrees_with_path_with_shading_normals() {
    compare("stones", &stones(), [64, 256], 0.01);
}

/// Light and camera subpaths agree in scenes with lenses, motion, instances, textures, normal maps, alpha and one-sided
/// surfaces. Effects for which path tracing converges too slowly are left out of some scenes.
#[test]
fn bdpt_agrees_with_path_in_generated_scenes() {
    let mut generator = Generator::new(42);
    let all = EffectSet::ALL;
    for index in 0..12 {
        let wanted = match index % 4 {
            0 => all,
            1 => all.without(Effect::Specular),
            2 => all.without(Effect::EnvironmentMap).without(Effect::Motion),
            _ => all
                .without(Effect::Transmission)
                .without(Effect::DeltaLights),
        };
        let scene = generator.scene(wanted);
        compare_limited(&format!("scene {index}"), &scene, [16, 64], 0.2, Some(6));
    }
}

/// Crops with wide filters, one of them with negative lobes, and with a lens and motion.
#[test]
fn bdpt_agrees_with_path_with_filters_crops_and_lenses() {
    let mut scene = matte();
    scene.film.size = (24, 24);
    scene.camera.lens_radius = 0.1;
    scene.camera.focus_distance = 3.0;
    scene.camera.shutter = [0.0, 1.0];
    scene.shapes[3].motion = slide(DVec3::ZERO, DVec3::new(0.2, 0.3, 0.4));
    for (kind, radius) in [(FilterKind::Mitchell, 2.0), (FilterKind::Gaussian, 1.5)] {
        scene.film.filter = FilterDescription { kind, radius };
        let see = |integrator, spp, seed| {
            let mut settings = settings(&scene, integrator, spp);
            settings.window = etendue::internals::film::Window {
                x: 5,
                y: 3,
                width: 12,
                height: 16,
            };
            settings.seed = seed;
            seen(&scene, &settings)
        };
        let a = see(IntegratorKind::Bidirectional, 48, 300);
        let b = see(IntegratorKind::Path, 192, 400);
        assert_same(&format!("{kind:?}"), &a, &b, 0.03);
    }
}

/// The variance that renders estimate for their pixels equals the variance between renders, averaged over the image.
#[test]
fn bdpt_variance_estimate_matches_that_between_renders() {
    let scene = glass(0.0);
    let settings = settings(&scene, IntegratorKind::Bidirectional, 16);
    let ratio = claimed_over_true_variance(&scene, &settings);
    // 256 pixels with 47 degrees of freedom each give a precision of 1.3 % for normal values; caustics are not normal.
    assert!((ratio - 1.0).abs() < 0.15, "{ratio}");
}

/// The variance that 48 renders estimate for their pixels over that between the renders, averaged over the image.
pub fn claimed_over_true_variance(scene: &SceneDescription, settings: &RenderSettings) -> f64 {
    let ready = ready(scene, Backend::ALL[0]);
    let films: Vec<Film> = (0..48)
        .map(|seed| {
            let settings = RenderSettings {
                seed,
                ..settings.clone()
            };
            film(&ready, scene, &settings)
        })
        .collect();
    let (mut claimed, mut true_one) = (0.0, 0.0);
    let estimates: Vec<_> = films.iter().map(Film::estimates).collect();
    for pixel in 0..estimates[0].len() {
        let values = estimates.iter().map(|it| it[pixel].mean[1]);
        let spread = Moments::of(values).variance().expect("many renders");
        let stated = estimates.iter().map(|it| it[pixel].variance[1]);
        // Relative to the mean, so that bright pixels do not dominate.
        let mean = Moments::of(estimates.iter().map(|it| it[pixel].mean[1])).mean();
        claimed += Moments::of(stated).mean() / (mean * mean);
        true_one += spread / (mean * mean);
    }
    let ratio = claimed / true_one;
    println!("claimed over true variance {ratio:.3}");
    ratio
}

#[test]
fn bdpt_images_are_bit_identical_across_threads_and_tiles() {
    let scene = glossy();
    let settings = settings(&scene, IntegratorKind::Bidirectional, 16);
    assert_threads_and_tiles_change_no_bit(&scene, &settings);
}

/// Checks that an image and its error bars have the same bits for any number of threads and size of tiles.
pub fn assert_threads_and_tiles_change_no_bit(scene: &SceneDescription, settings: &RenderSettings) {
    let ready = ready(scene, Backend::ALL[0]);
    let picture = |threads, tile_size| {
        let settings = RenderSettings {
            threads,
            tile_size,
            ..settings.clone()
        };
        let film = film(&ready, scene, &settings);
        (film.develop(), film.develop_half(), film.error_bars())
    };
    let one = picture(1, 16);
    assert!(one == picture(4, 16), "the image depends on threads");
    assert!(one == picture(3, 5), "the image depends on tiles");
}

#[test]
fn adaptive_bdpt_is_rejected_with_a_hint_to_use_path() {
    let scene = matte();
    let settings = RenderSettings {
        adaptive: etendue::internals::render::settings::Adaptive::TwoPhase,
        ..settings(&scene, IntegratorKind::Bidirectional, 64)
    };
    let error = settings
        .validate(scene.film.size)
        .expect_err("it is not supported");
    assert!(error.to_string().contains("--integrator path"), "{error}");
}

/// A wall inside a glass ball, seen from inside. Radiance is scaled when it enters glass and scaled back when it leaves,
/// so that only scattering inside the glass reveals a wrong factor.
pub fn wall_within_glass() -> SceneDescription {
    crate::common::scene_folder::load_text(
        r#"version = 1
[camera]
eye = [0, 0, 0.8]
target = [0, 0, -0.5]
fov = 45
[film]
size = [16, 16]
filter = "box"
[[material]]
name = "white"
type = "diffuse"
reflectance = 0.8
[[material]]
name = "glass"
type = "dielectric"
[[shape]]
type = "sphere"
material = "glass"
center = [0, 0, 0]
radius = 1.2
[[shape]]
type = "rectangle"
material = "white"
corner = [-0.5, -0.5, -0.5]
edge_u = [1, 0, 0]
edge_v = [0, 1, 0]
[[shape]]
type = "sphere"
material = "white"
emission = 30
center = [0.5, 1.5, 2]
radius = 0.3
"#,
    )
}

#[test]
fn bdpt_agrees_with_path_on_a_wall_inside_glass() {
    let scene = wall_within_glass();
    compare_limited("a wall within glass", &scene, [256, 2048], 0.02, Some(2));
}

/// A floor beside a mirror, and a spot light that illuminates only the mirror; or, without the mirror, the spot light's
/// mirror image, which gives the same illumination.
pub fn by_a_mirror(is_there: bool) -> SceneDescription {
    let (x, intensity) = if is_there {
        (0.5, 4.0)
    } else {
        (-2.5, 0.9 * 4.0)
    };
    let mirror = if is_there {
        "[[shape]]\ntype = \"rectangle\"\nmaterial = \"mirror\"\ncorner = [-1, 0, -3]\nedge_u = [0, 0, 6]\nedge_v = [0, 4, 0]\n"
    } else {
        ""
    };
    crate::common::scene_folder::load_text(&format!(
        r#"version = 1
[camera]
eye = [0.5, 3, 1.5]
target = [0.5, 0, 0.1]
fov = 40
[film]
size = [16, 16]
filter = "box"
[[material]]
name = "white"
type = "diffuse"
reflectance = 0.6
[[material]]
name = "mirror"
type = "mirror"
reflectance = 0.9
[[shape]]
type = "rectangle"
material = "white"
corner = [-4, 0, 3]
edge_u = [8, 0, 0]
edge_v = [0, 0, -6]
{mirror}
[[light]]
type = "spot"
position = [{x}, 1, 0]
target = [-1, 0.4, 0]
cone = 10
penumbra = 4
intensity = {intensity}
"#
    ))
}

/// With the mirror only light subpaths from the spot find light, so their importance scattering (the adjoint BSDF) has
/// full weight: at a shape whose shading normals are up to 55 degrees off the geometric ones.
#[test]
fn bdpt_adjoint_scattering_by_shading_normals_matches_path() {
    let with = |integrator, is_there, spp, max_bounces| {
        let mut scene = by_a_mirror(is_there);
        let stone = mirrored_octahedron(DVec3::new(-0.1, 0.15, 0.0), 0.3);
        scene.shapes.push(surface(stone, 0.0));
        let settings = RenderSettings {
            max_bounces: Some(max_bounces),
            ..settings(&scene, integrator, spp)
        };
        seen(&scene, &settings)
    };
    let image = with(IntegratorKind::Path, false, 64, 1);
    let mirror = with(IntegratorKind::Bidirectional, true, 512, 2);
    assert_same("a stone by a mirror", &mirror, &image, 0.02);
}

/// A caustic of a delta light, which path tracing cannot find: a mirror reflects a spot light onto a floor. The result
/// equals the illumination by the light's mirror image.
#[test]
fn delta_light_caustic_of_a_mirror_equals_its_virtual_image() {
    let with = |integrator, is_there, spp, max_bounces| {
        let scene = by_a_mirror(is_there);
        let settings = RenderSettings {
            max_bounces: Some(max_bounces),
            ..settings(&scene, integrator, spp)
        };
        seen(&scene, &settings)
    };
    let image = with(IntegratorKind::Path, false, 64, 1);
    let mirror = with(IntegratorKind::Bidirectional, true, 256, 2);
    assert_same("by a mirror", &mirror, &image, 0.02);
    let chains = with(IntegratorKind::Metropolis, true, 128, 2);
    assert_same("by a mirror, by chains", &chains, &image, 0.05);
    let path = with(IntegratorKind::Path, true, 16, 2);
    assert!(
        path.iter()
            .all(|block| block.iter().all(|it| it.mean() == 0.0))
    );
}
