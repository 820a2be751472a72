//! Bidirectional path tracing, Metropolis light transport, and light paths beside camera paths: the rows about transport
//! repeated with each, and light that no camera subpath can find.
//!
//! Measure: radiance; where an image is not uniform, radiance over the exact radiance.
//! Range: scenes that all can render in seconds. Connecting subpaths of n vertices takes n^2 rays, so that rooms are
//! limited to 20 bounces.
//! Source: formulas at each; Veach 1997, chapter 11, for Markov chains without start-up bias. Tested in
//! `lab/tests/reports/battery.rs`.

use super::case::{Case, Effort};
use super::claim::Claim;
use super::closed_forms::rectangle_below;
use super::lamps::{distant, floor, point, reflected, square_through};
use super::patch::{PatchEstimator, PatchSettings, SIZE, bounces, mean, patch_scene, see_again};
use super::transport::{floor_under_a_lamp, integrating_sphere, lit_room, ratio_of, room, series};
use crate::scene_builder::{diffuse, light, mirror, rectangle, sky, sphere, surface};
use etendue::internals::geometry::texture::Texture;
use etendue::internals::image::Image;
use etendue::internals::integrator::Roulette;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DAffine3, DMat3, DVec3};
use etendue::internals::scene::description::{
    CameraDescription, ColourDescription, GeometryDescription, LightModel, MaterialDescription,
    Place, SceneDescription,
};
use std::sync::Arc;

const BIDIRECTIONAL: PatchEstimator = PatchEstimator::alone(IntegratorKind::Bidirectional);
const METROPOLIS: PatchEstimator = PatchEstimator::alone(IntegratorKind::Metropolis);
const ALL: [PatchEstimator; 3] = [BIDIRECTIONAL, METROPOLIS, PatchEstimator::WITH_LIGHT_PATHS];

/// Every case.
pub fn cases(_: Effort) -> Vec<Case> {
    [
        integrating_spheres(),
        white_rooms(),
        roulette(),
        lengths(),
        kinds_of_light(),
        short_chains(),
        by_a_mirror(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A case about the mean over an image of uniform radiance.
fn plain(
    (row, what): (u32, &str),
    estimator: PatchEstimator,
    claim: Claim,
    scene: SceneDescription,
    patch: PatchSettings,
) -> Case {
    let name = format!("{what} by {}", estimator.name());
    Case::new(row, name, claim, move |trial| {
        let spp = trial.samples(patch.spp);
        see_again(
            trial,
            estimator,
            &scene,
            PatchSettings { spp, ..patch },
            mean,
        )
    })
}

/// Integrating spheres: all path lengths contribute, with different strategies but the same mean.
fn integrating_spheres() -> Vec<Case> {
    let what = "integrating sphere of albedo 0.5, with roulette,";
    let case = |(estimator, power, spp)| {
        let scene = integrating_sphere(1.0, 0.5);
        let patch = PatchSettings {
            spp,
            max_bounces: None,
            roulette: Roulette::Throughput,
        };
        plain((48, what), estimator, Claim::mean(1.0, power), scene, patch)
    };
    let limits = [
        (BIDIRECTIONAL, 1e-3, 1 << 9),
        (METROPOLIS, 2e-3, 1 << 6),
        (PatchEstimator::WITH_LIGHT_PATHS, 1e-3, 1 << 9),
    ];
    limits.map(case).into()
}

/// Rooms with long subpaths, without roulette.
fn white_rooms() -> Vec<Case> {
    let case = |estimator| {
        let exact = series(f64::from(0.999_f32), Some(20));
        let what = "room of albedo 0.999 that emits 1, 20 bounces,";
        let claim = Claim::mean(exact, 5e-3);
        plain(
            (49, what),
            estimator,
            claim,
            room(0.999),
            bounces(20, 1 << 4),
        )
    };
    ALL.map(case).into()
}

/// The ratio of a render with roulette to one without.
fn roulette() -> Vec<Case> {
    let ways = [
        (Roulette::Throughput, BIDIRECTIONAL, 1 << 6),
        (Roulette::Albedo, BIDIRECTIONAL, 1 << 6),
        (Roulette::Throughput, METROPOLIS, 1 << 6),
        (
            Roulette::Throughput,
            PatchEstimator::WITH_LIGHT_PATHS,
            1 << 8,
        ),
    ];
    let case = |(roulette, estimator, spp): (Roulette, PatchEstimator, u64)| {
        let (by, estimator_name) = (roulette, estimator.name());
        let name = format!("roulette by {by} over none, to depth 3, by {estimator_name}");
        Case::new(50, name, Claim::mean(1.0, 1e-3), move |trial| {
            let scene = lit_room();
            ratio_of(trial, roulette, |trial, roulette| {
                let patch = PatchSettings {
                    spp: trial.samples(spp),
                    max_bounces: Some(3),
                    roulette,
                };
                see_again(trial, estimator, &scene, patch, mean)
            })
        })
    };
    ways.map(case).into()
}

/// Scenes rendered up to each number of bounces.
fn lengths() -> Vec<Case> {
    let mut cases = Vec::new();
    for estimator in ALL {
        for depth in [0, 1, 2, 3] {
            let what = format!("grey room to depth {depth}");
            let claim = Claim::mean(series(0.5, Some(depth)), 2e-3);
            let patch = bounces(depth, 1 << 6);
            cases.push(plain((52, &what), estimator, claim, room(0.5), patch));
        }
        let (scene, exact) = floor_under_a_lamp();
        let claim = Claim::mean(exact, 2e-3);
        let what = "floor under a lamp";
        cases.push(plain(
            (52, what),
            estimator,
            claim,
            scene,
            bounces(1, 1 << 6),
        ));
    }
    cases
}

/// Floors of albedo 1/2 under one light of each kind: its name, the scene and the exact radiance.
fn lit_floors() -> Vec<(&'static str, SceneDescription, f64)> {
    let position = DVec3::new(0.8, 1.5, -0.2);
    let (d2, cos) = (position.length_squared(), position.y / position.length());
    let spot = LightModel::Spot {
        position,
        target: DVec3::ZERO,
        intensity: Rgb::grey(4.0),
        cone: 0.4,
        penumbra: 0.1,
    };
    let image = Arc::new(Image::new(8, 4, vec![Rgb::grey(0.75); 32]).into());
    let panorama = LightModel::Environment {
        radiance: ColourDescription::Texture(Arc::new(Texture::Image { image, scale: 2.0 })),
        to_world: DMat3::from_rotation_y(1.0),
    };
    let mut under_the_sky = floor(3.0, []);
    under_the_sky.lights = vec![sky(Rgb::grey(0.75))];
    let lamp = |lamp: GeometryDescription| {
        let mut scene = floor(3.0, []);
        scene.camera = patch_scene(DVec3::new(2.0, 0.8, 0.0), DVec3::ZERO, diffuse(0.5)).camera;
        scene.shapes.push(surface(lamp, 1.0));
        scene
    };
    let mut in_a_square = floor(3.0, [point(position, 4.0)]);
    let square = square_through(position, 0.05);
    in_a_square.shapes.push(surface(square, 0.0));
    let ball = sphere(DVec3::Y, 0.5);
    let disk = GeometryDescription::Disk {
        center: 2.0 * DVec3::Y,
        normal: DVec3::NEG_Y,
        radius: 2.0,
    };
    vec![
        (
            "a point",
            floor(3.0, [point(position, 4.0)]),
            reflected(4.0 * cos / d2),
        ),
        (
            "a point in a square's plane",
            in_a_square,
            reflected(4.0 * cos / d2),
        ),
        ("a spot", floor(3.0, [spot]), reflected(4.0 * cos / d2)),
        (
            "parallel light",
            floor(3.0, [distant(-position, 7.0)]),
            reflected(7.0 * cos),
        ),
        ("a plain sky", under_the_sky, 0.5 * 0.75),
        ("a panorama", floor(3.0, [panorama]), 0.5 * 1.5),
        // The sphere's radius is half its distance, the disk's equals it.
        ("a sphere", lamp(ball), 0.5 * 0.25),
        ("a disk", lamp(disk), 0.5 * 0.5),
    ]
}

fn kinds_of_light() -> Vec<Case> {
    let mut cases = Vec::new();
    for estimator in ALL {
        for (what, scene, exact) in lit_floors() {
            // The tolerance accounts for the size of the patch that is seen.
            let claim = Claim::mean(exact, 2e-3).within(3e-4 * exact);
            let what = format!("floor under {what}");
            cases.push(plain(
                (52, &what),
                estimator,
                claim,
                scene,
                bounces(1, 1 << 6),
            ));
        }
    }
    cases
}

/// Half the width of the floor seen by [`from_above`].
const HALF: f64 = 2.0;

/// A floor of albedo 1/2 seen from above the origin: x runs from minus [`HALF`] to [`HALF`], y half as far.
fn from_above() -> SceneDescription {
    const HEIGHT: f64 = 3.0;
    let mut scene = patch_scene(HEIGHT * DVec3::Z, DVec3::ZERO, diffuse(0.5));
    let to_world = DAffine3::from_translation(HEIGHT * DVec3::Z);
    let fov = 2.0 * (0.5 * HALF / HEIGHT).atan();
    scene.camera = CameraDescription::pinhole(to_world, fov);
    let far = 8.0;
    let ground = rectangle(
        [-far, -far, 0.0],
        [2.0 * far, 0.0, 0.0],
        [0.0, 2.0 * far, 0.0],
    );
    scene.shapes.push(surface(ground, 0.0));
    scene
}

/// The exact radiance of each of its pixels under a point light: the flux onto the area seen by a pixel is the
/// intensity times the solid angle of that area from the light.
fn lit(at: DVec3, intensity: f64) -> Vec<f64> {
    let (columns, rows) = SIZE;
    let side = 2.0 * HALF / f64::from(columns);
    let pixel = |index: u32| {
        let (column, row) = (f64::from(index % columns), f64::from(index / columns));
        let x = -HALF + side * column - at.x;
        let y = 0.5 * HALF - side * (row + 1.0) - at.y;
        let omega = rectangle_below([x, x + side], [y, y + side], at.z);
        reflected(intensity * omega / (side * side))
    };
    (0..columns * rows).map(pixel).collect()
}

/// The ratio of the measured to the exact mean radiance of the pixels for which `counts` is true.
fn over_exact(seen: &[f64], exact: &[f64], counts: impl Fn(usize) -> bool) -> f64 {
    let sum = |of: &[f64]| -> f64 {
        let pixels = of.iter().enumerate();
        pixels.filter(|(i, _)| counts(*i)).map(|(_, x)| x).sum()
    };
    sum(seen) / sum(exact)
}

/// Markov chains of few steps, a thousand of them in each render: with start-up bias, the dim half of a floor beside a
/// point light, which reflects a tenth as much as the other half, would be too bright.
fn short_chains() -> Vec<Case> {
    let at = DVec3::new(-0.5 * HALF, 0.0, 0.5);
    let case = |(half, is_left, power): (&str, bool, f64)| {
        let name = format!("{half} half of a floor beside a point, over the exact, by mlt");
        Case::new(53, name, Claim::mean(1.0, power), move |trial| {
            let mut scene = from_above();
            scene.lights = vec![light(point(at, 1.0))];
            let exact = lit(at, 1.0);
            let counts = |pixel: usize| (pixel % 8 < 4) == is_left;
            let patch = bounces(1, trial.samples(1 << 10));
            see_again(trial, METROPOLIS, &scene, patch, |seen| {
                over_exact(seen, &exact, counts)
            })
        })
    };
    [("bright", true, 5e-3), ("dim", false, 1e-2)]
        .map(case)
        .into()
}

/// A spot that illuminates only a mirror, which reflects its light onto the floor: the light of its image behind the
/// mirror. No camera subpath finds it, as the mirror is specular and the spot cannot be sampled there.
fn by_a_mirror() -> Vec<Case> {
    const WALL: f64 = -3.0;
    let at = DVec3::new(1.0, 0.0, 2.0);
    let image = DVec3::new(2.0 * WALL - at.x, at.y, at.z);
    let mut scene = from_above();
    let silver = MaterialDescription::new("silver", Place::default(), mirror(0.75));
    scene.materials.push(silver);
    let wall = rectangle([WALL, -4.0, 0.0], [0.0, 8.0, 0.0], [0.0, 0.0, 4.0]);
    let mut wall = surface(wall, 0.0);
    wall.material = 1;
    scene.shapes.push(wall);
    // The whole visible floor is inside the full intensity of the image's cone.
    scene.lights = vec![light(LightModel::Spot {
        position: at,
        target: image.lerp(DVec3::ZERO, (WALL - image.x) / -image.x),
        intensity: Rgb::grey(4.0),
        cone: 0.25,
        penumbra: 0.02,
    })];
    let exact = lit(image, 0.75 * 4.0);
    let unseen = Case::seen(
        56,
        "what a mirror throws of a spot on a floor by path without light paths, which says that it lacks it",
        Claim::exactly(0.0),
        scene.clone(),
        bounces(4, 16),
    );
    let found = ALL.map(|estimator| {
        let what = "what a mirror throws of a spot on a floor, over the exact,";
        let name = format!("{what} by {}", estimator.name());
        let (scene, exact) = (scene.clone(), exact.clone());
        Case::new(56, name, Claim::mean(1.0, 5e-3), move |trial| {
            let patch = bounces(2, trial.samples(1 << 9));
            see_again(trial, estimator, &scene, patch, |seen| {
                over_exact(seen, &exact, |_| true)
            })
        })
    });
    [unseen].into_iter().chain(found).collect()
}
