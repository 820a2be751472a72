//! The irradiance cache compared with closed forms at every point, not on average.
//!
//! Measure: points; irradiance over the exact irradiance.
//! Range: error bounds of 20 and of 5 %; points that the cache leaves to path tracing are not evaluated.
//! Source: the form factor of a rectangle, as in `closed_forms.rs`; the integrating sphere. Tested in
//! `tests/rendering/irradiance_cache.rs` and `lab/tests/reports/battery.rs`.

use super::case::{Case, Effort, Trial};
use super::claim::Claim;
use super::closed_forms::parallel_rectangle;
use super::patch::{patch_scene, ready};
use super::transport::{integrating_sphere, series};
use crate::scene_builder::{ceiling, diffuse, rectangle, sky, surface};
use etendue::Result;
use etendue::internals::film::filter::{Filter, FilterDescription, FilterKind};
use etendue::internals::integrator::Roulette;
use etendue::internals::integrator::irradiance_cache::IrradianceCache;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::DVec3;
use etendue::internals::render::RenderObserver;
use etendue::internals::render::cache_prepass::cache_prepass;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::{MaterialDescription, Place, SceneDescription};
use std::f64::consts::PI;

/// Every case.
pub fn cases(_: Effort) -> Vec<Case> {
    let case = |bound: f64| {
        let name = format!(
            "irradiance cache: points of 100,000 beyond a bound of {} %",
            100.0 * bound
        );
        Case::new(54, name, Claim::exactly(0.0), move |trial| {
            let errors = cache_errors(trial, bound)?;
            // A cache that covers few points can be wrong at few points only.
            let is_conclusive = errors.known > 0.9;
            Ok(vec![if is_conclusive {
                errors.beyond as f64
            } else {
                f64::NAN
            }])
        })
    };
    vec![
        case(0.2),
        case(0.05),
        in_a_sphere(0.5, 50),
        in_a_sphere(0.9, 200),
    ]
}

/// The cache of an integrating sphere, evaluated all over the visible part. Records are free of noise there, and their
/// gradients are 0; but the sphere curves away from the tangent planes of the records.
fn in_a_sphere(albedo: f32, depth: u32) -> Case {
    const BOUND: f64 = 0.05;
    let name = format!(
        "irradiance cache, bound {} %, over the exact: integrating sphere of albedo {albedo}, to depth {depth}",
        100.0 * BOUND
    );
    let claim = Claim::without_noise(1.0, BOUND);
    Case::new(48, name, claim, move |trial| {
        let mut description = integrating_sphere(1.0, albedo);
        description.camera.fov = 1.2;
        description.film.size = (64, 64);
        let filled = filled(trial, &description, BOUND, Some(depth))?;
        // Direct light, the first term of the series, is sampled and not cached.
        let exact = PI * (series(f64::from(albedo), Some(depth - 1)) - 1.0);
        let ours = seen_within(&description).map(|p| {
            let ours = filled.irradiance(p, -p)?;
            Some(f64::from(ours.luminance()) / exact)
        });
        let ours: Vec<Option<f64>> = ours.collect();
        let known: Vec<f64> = ours.iter().copied().flatten().collect();
        // A cache that covers few points can be wrong at few points only.
        let is_conclusive = 2 * known.len() > ours.len();
        Ok(if is_conclusive { known } else { vec![f64::NAN] })
    })
}

/// Points of the unit sphere that are visible to a camera inside of it.
fn seen_within(description: &SceneDescription) -> impl Iterator<Item = DVec3> {
    const SIDE: usize = 100;
    let camera = &description.camera;
    let (eye, axes) = (camera.to_world.translation, camera.to_world.matrix3);
    let half = (0.5 * camera.fov).tan();
    let place = move |i: usize| half * (2.0 * (i as f64 + 0.5) / SIDE as f64 - 1.0);
    (0..SIDE * SIDE).map(move |i| {
        let dir = axes * DVec3::new(place(i % SIDE), place(i / SIDE), -1.0).normalize();
        let b = eye.dot(dir);
        eye + (-b + (b * b - eye.length_squared() + 1.0).sqrt()) * dir
    })
}

/// A prepared scene with its irradiance cache.
struct Filled {
    scene: Scene,
    cache: IrradianceCache,
}

impl Filled {
    /// The cached irradiance at a point in the coordinates of the scene description, with normal `n`; `None` where the
    /// cache has none.
    fn irradiance(&self, p: DVec3, n: DVec3) -> Option<Rgb> {
        let p = self.scene.normalisation.point(p);
        self.cache.irradiance(p, n.as_vec3a())
    }
}

/// Fills a cache for the visible points of a scene, with error bound `bound`.
fn filled(
    trial: &Trial<'_>,
    description: &SceneDescription,
    bound: f64,
    max_bounces: Option<u32>,
) -> Result<Filled> {
    let settings = RenderSettings {
        integrator: IntegratorKind::IrradianceCache,
        cache_error: bound,
        seed: trial.seed,
        max_bounces,
        roulette: max_bounces.map(|_| Roulette::None),
        threads: trial.options.threads,
        ..RenderSettings::new(description.film.size, 1)
    };
    let filter = Filter::new(&description.film.filter);
    let scene = ready(trial, description)?;
    let keep_going = |_, _| !trial.is_cancelled();
    let (cache, _) = cache_prepass(&scene, &filter, &settings, &keep_going);
    let cache = cache.expect("it is the integrator's");
    Ok(Filled { scene, cache })
}

/// The height of the ceiling.
const HEIGHT: f64 = 1.5;

/// Half the width of floor and ceiling.
const HALF_WIDTH: f64 = 40.0;

/// Half the width of the visible part of the floor.
const HALF: f64 = 2.0;

/// A floor below a black ceiling with a hole of 2 x 2, under a constant white sky, which is not sampled as a light.
fn below_a_hole() -> SceneDescription {
    let eye = DVec3::new(0.0, 0.0, 1.2);
    let mut scene = patch_scene(eye, DVec3::ZERO, diffuse(0.5));
    scene.camera.fov = 2.0 * f64::atan(HALF / eye.z);
    scene.film.size = (64, 64);
    scene.film.filter = FilterDescription {
        kind: FilterKind::Box,
        radius: 0.5,
    };
    let far = 2.0 * HALF_WIDTH;
    let corner = [-HALF_WIDTH, -HALF_WIDTH, 0.0];
    let floor = rectangle(corner, [far, 0.0, 0.0], [0.0, far, 0.0]);
    scene.shapes = vec![surface(floor, 0.0)];
    for (x, y) in [
        ([-HALF_WIDTH, HALF_WIDTH], [-HALF_WIDTH, -1.0]),
        ([-HALF_WIDTH, HALF_WIDTH], [1.0, HALF_WIDTH]),
        ([-HALF_WIDTH, -1.0], [-1.0, 1.0]),
        ([1.0, HALF_WIDTH], [-1.0, 1.0]),
    ] {
        let mut part = surface(ceiling(x, y, HEIGHT), 0.0);
        part.material = scene.materials.len();
        scene.shapes.push(part);
    }
    let black = MaterialDescription::new("black", Place::default(), diffuse(0.0));
    scene.materials.push(black);
    scene.lights = vec![sky(Rgb::WHITE)];
    scene
}

/// The exact irradiance of its floor: pi times the fractions of the sky seen through the hole and beyond the ceiling.
fn irradiance(x: f64, y: f64) -> f64 {
    let corner = |a: f64, b: f64| parallel_rectangle(a, b, HEIGHT);
    let share = |half: f64| {
        corner(half - x, half - y)
            + corner(half + x, half - y)
            + corner(half - x, half + y)
            + corner(half + x, half + y)
    };
    PI * (share(1.0) + 1.0 - share(HALF_WIDTH))
}

/// The errors of a cache over the floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CacheErrors {
    /// Number of records.
    pub records: usize,
    /// The fraction of the points that the cache covers.
    pub known: f64,
    /// The largest relative error at a covered point; NaN if there is none.
    pub worst: f64,
    /// Number of points with an error beyond the bound.
    pub beyond: usize,
}

/// Fills a cache for this bound and evaluates it at about 100,000 visible points.
///
/// # Errors
/// An error of the scene or the backend.
pub fn cache_errors(trial: &Trial<'_>, bound: f64) -> Result<CacheErrors> {
    const SIDE: usize = 316;
    let filled = filled(trial, &below_a_hole(), bound, None)?;
    let place = |i: usize| HALF * (2.0 * (i as f64 + 0.5) / SIDE as f64 - 1.0);
    let (mut known, mut worst, mut beyond) = (0, f64::NAN, 0);
    for i in 0..SIDE * SIDE {
        let (x, y) = (place(i % SIDE), place(i / SIDE));
        if let Some(ours) = filled.irradiance(DVec3::new(x, y, 0.0), DVec3::Z) {
            let error = f64::from(ours.luminance()) / irradiance(x, y) - 1.0;
            worst = worst.max(error.abs());
            beyond += usize::from(error.abs() > bound);
            known += 1;
        }
    }
    Ok(CacheErrors {
        records: filled.cache.records().len(),
        known: f64::from(known) / (SIDE * SIDE) as f64,
        worst,
        beyond,
    })
}
