//! A test that all strategies that find a path use the same densities of it: those recomputed from its vertices alone.
//!
//! Their weights are then those of one set of densities, and sum to one, as `weights.rs` shows of any set.
//!
//! Measure: weights.
//! Range: the subpaths of random samples through scenes of the repository.
//! Source: none needed. Tests only.

use super::connect::{Connector, LightSubpath};
use super::vertex::{Densities, RayDensity, SubpathVertex};
use super::walk::{Subpath, SubpathKind, SubpathSampler, SubpathStart};
use super::weights::WholePath;
use super::{Bidirectional, Roulette};
use crate::accel::{AccelOptions, Backend, Precision};
use crate::effects::kernel::types::Everything;
use crate::integrator::RayCounts;
use crate::integrator::observer::NullPathObserver;
use crate::light::types::LightChoice;
use crate::math::measure::PdfSolidAngle;
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3};
use crate::sampler::{Decision, Independent, Sampler};
use crate::scene::Scene;
use crate::scene::load::load;
use crate::scene::prepare::prepare;
use std::path::Path;

type V<'a> = SubpathVertex<'a, Everything>;

/// A scene of the repository, and the size of its image.
fn scene(path: &str) -> (Scene, Vec2) {
    let description = load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).expect("it is valid");
    let options = AccelOptions {
        backend: Backend::ALL[0],
        precision: Precision::Robust,
        quality: None,
        threads: 1,
    };
    let (width, height) = description.film.size;
    let scene = prepare(&description, options).expect("it is valid").scene;
    (scene, Vec2::new(width as f32, height as f32))
}

/// The densities per steradian of continuing from a vertex towards the light and towards the camera.
fn both_ways(scene: &Scene, vertex: &V<'_>, to_camera: Vec3, to_light: Vec3) -> [PdfSolidAngle; 2] {
    if vertex.is_delta {
        let tilted = [to_camera, to_light]
            .iter()
            .any(|&w| vertex.at.is_tilted_for(w));
        return [1.0, if tilted { 0.0 } else { 1.0 }].map(PdfSolidAngle);
    }
    let scattering = vertex.scattering(scene, to_camera, to_light);
    scattering.map_or([PdfSolidAngle(0.0); 2], |it| {
        [it.pdf_to_light, it.pdf_to_camera]
    })
}

/// Recomputes the densities of the path through these surfaces, from the light to the camera. `is_delta` is false for
/// the connected vertices, whatever lobe their subpaths sampled next.
fn anew(
    scene: &Scene,
    light: &LightSubpath<'_, '_, Everything>,
    surfaces: &[&V<'_>],
    is_delta: &[bool],
    camera: (Vec3, RayDensity),
) -> WholePath {
    let mut whole = WholePath::default();
    let m = surfaces.len();
    whole.clear(m + 2);
    whole.densities[0].by_light = light.source.densities.by_light;
    whole.nee_pdf = light.source.nee_pdf;
    whole.is_delta.copy_from_slice(is_delta);
    let p = |k: usize| surfaces[k].at.p;
    // The light subpath hit its first surface along this direction.
    let direction = -light.subpath.vertices[0].at.wo;
    let from_source = |p: Vec3| light.source.offset_to(p, direction);
    whole.densities[1].by_light = light
        .ray_density
        .density_at(from_source(p(0)), surfaces[0].at.ng);
    whole.densities[m].by_camera = camera
        .1
        .density_at(p(m - 1) - camera.0, surfaces[m - 1].at.ng);
    for k in 0..m {
        let to_light = match k {
            0 => -from_source(p(0)),
            _ => p(k - 1) - p(k),
        };
        let to_camera = if k + 1 == m { camera.0 } else { p(k + 1) } - p(k);
        let vertex = V {
            at: surfaces[k].at,
            bsdf: surfaces[k].bsdf.clone(),
            is_delta: is_delta[k + 1],
            ..*surfaces[k]
        };
        let [light_side, eye_side] =
            both_ways(scene, &vertex, to_camera.normalize(), to_light.normalize());
        whole.densities[k].by_camera = match k {
            0 => light.source.density_from(p(0), light_side),
            _ => surfaces[k - 1].density_from(p(k), light_side),
        };
        if k + 1 < m {
            whole.densities[k + 2].by_light = surfaces[k + 1].density_from(p(k), eye_side);
        }
    }
    whole
}

/// Counts the connections of some subpaths, and those whose recomputed weight differs.
fn differing((scene, size): (&Scene, Vec2), samples: u64) -> (u64, u64) {
    let integrator = Bidirectional {
        max_bounces: Some(8),
        roulette: Roulette::None,
        film_area: 100.0,
        light_choice: LightChoice::Contribution,
    };
    let (mut count, mut differ) = (0, 0);
    let (mut of_light, mut of_camera) = (Subpath::default(), Subpath::default());
    let mut sampler = Independent::new(5);
    for sample in 0..samples {
        sampler.start([1, 2], sample);
        let [x, y, time] = [0, 1, 2].map(|b| {
            let [u]: [f32; 1] = sampler.draw(Decision::Emission(b));
            u
        });
        let film = Vec2::new(x, y) * size;
        let ray = scene.camera.ray::<Everything>(film, Vec2::splat(0.5), time);
        let viewpoint = scene.camera.viewpoint::<Everything>(Vec2::splat(0.5), time);
        let seen = viewpoint.film_point(ray.dir).expect("it goes forwards");
        let camera = (ray.origin, RayDensity::Point(seen.per_steradian / 100.0));
        let (mut rays, mut observer) = (RayCounts::default(), NullPathObserver);
        let mut subpath_sampler = SubpathSampler {
            scene,
            time,
            roulette: Roulette::None,
            sampler: &mut sampler,
            rays: &mut rays,
            observer: &mut observer,
        };
        let Some(light) = integrator.sample_light_subpath::<Everything, _, _>(
            &mut subpath_sampler,
            integrator.max_bounces.map(u64::from),
            &mut of_light,
        ) else {
            continue;
        };
        let start = SubpathStart {
            kind: SubpathKind::Camera,
            ray,
            origin: ray.origin,
            hit: scene.accel.intersect(&ray, time, None),
            ray_density: camera.1,
            beta: Rgb::WHITE,
            max_surfaces: Some(5),
        };
        subpath_sampler.sample::<Everything>(start, &mut of_camera);
        let (camera_subpath, surfaces) = (&of_camera, light.subpath.vertices.len());
        let mut connector = Connector {
            scene,
            time,
            max_bounces: None,
            light_choice: LightChoice::Contribution,
            per_pixel: 0.01,
            light: Some(light),
            camera_subpath,
            rays: &mut rays,
            observer: &mut observer,
            whole: &mut WholePath::default(),
        };
        for i in 0..surfaces {
            for j in 0..camera_subpath.vertices.len() {
                let is_connectible = camera_subpath.vertices[j].is_connectible();
                if !is_connectible || connector.connection(i, j).is_none() {
                    continue;
                }
                let known = connector.whole.clone();
                let light = connector.light.as_ref().expect("it was put there");
                let of_light = light.subpath.vertices[..=i].iter();
                let all: Vec<&V<'_>> = of_light
                    .chain(camera_subpath.vertices[..=j].iter().rev())
                    .collect();
                let fresh = anew(scene, light, &all, &known.is_delta, camera);
                count += 1;
                differ += u64::from(have_other_weights(&known, &fresh));
                assert_is_normalised(&known);
            }
        }
    }
    (count, differ)
}

/// Whether the weights of any strategy differ. The rounding of a direction changes the density of a narrow lobe, but not the
/// weights.
fn have_other_weights(known: &WholePath, fresh: &WholePath) -> bool {
    let off = |s: usize| (known.weight(s) - fresh.weight(s)).abs();
    (0..known.densities.len()).map(off).fold(0.0, f64::max) > 0.01
}

/// Asserts that the weights of the strategies that can find a path sum to one.
fn assert_is_normalised(path: &WholePath) {
    let can = |s: &usize| *s == 0 || !(path.is_delta[s - 1] || path.is_delta[*s]);
    let strategies = (0..path.densities.len()).filter(can);
    let sum: f64 = strategies.map(|s| path.weight(s)).sum();
    assert!((sum - 1.0).abs() < 1e-9, "weights sum to {sum}: {path:?}");
    assert!(path.densities.iter().all(|&it| is_density(it)), "{path:?}");
}

fn is_density(
    Densities {
        by_light,
        by_camera,
    }: Densities,
) -> bool {
    by_light >= 0.0 && by_camera >= 0.0 && by_light.is_finite() && by_camera.is_finite()
}

/// A test of a million paths in `make nightly`, else of an eighth. Where surfaces touch, rounding moves a point by more
/// than its distance from the next
/// surface: that is as rare as one in ten thousand.
#[test]
fn mis_weights_match_those_recomputed_from_path_vertices() {
    let scenes = [
        ("scenes/cornell-box/cornell-box.toml", 170_000),
        ("scenes/materials/materials.toml", 120_000),
        ("scenes/caustics/caustics.toml", 60_000),
        ("scenes/environment/environment.toml", 60_000),
    ];
    // `make nightly` has time for all of them.
    let share = match std::env::var_os("ETENDUE_NIGHTLY") {
        Some(_) => 1,
        None => 8,
    };
    let mut all = 0;
    for (path, samples) in scenes {
        let (scene, size) = scene(path);
        let (count, differ) = differing((&scene, size), samples / share);
        println!("{path}: {count} paths, {differ} with other weights");
        assert!(
            differ as f64 <= 1e-4 * count as f64,
            "{path}: {differ} of {count}"
        );
        all += count;
    }
    assert!(all > 1_000_000 / share, "{all}");
}
