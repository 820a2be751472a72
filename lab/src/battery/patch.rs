//! Renders a tiny patch of a scene, with one independent number per pixel.
//!
//! Measure: world units; radiance.
//! Range: a film of 32 pixels that all look at one point, so that each is an independent replicate.
//! Source: none needed. Tested through the cases that use it.

use super::trial::Trial;
use etendue::Result;
use etendue::internals::film::filter::{Filter, FilterDescription, FilterKind};
use etendue::internals::integrator::Roulette;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::integrator::light_paths::LightPathShare;
use etendue::internals::math::vec::{DAffine3, DMat3, DVec3};
use etendue::internals::render::render;
use etendue::internals::render::settings::{LightPathRule, RenderSettings};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::{
    CameraDescription, FilmDescription, MaterialDescription, MaterialModel, Place, SceneDescription,
};
use etendue::internals::scene::prepare::prepare;

/// The film of a patch, in pixels.
pub const SIZE: (u32, u32) = (8, 4);

/// Number of renders in [`see_again`]: as many independent numbers as a patch has pixels.
const RENDERS: u64 = 32;

/// The field of view of a patch, in radians.
const FOV: f64 = 1e-4;

/// The render settings for a patch.
#[derive(Debug, Clone, Copy)]
pub struct PatchSettings {
    /// Minimum number of samples per pixel.
    pub spp: u64,
    /// Maximum number of scattering events.
    pub max_bounces: Option<u32>,
    /// The rule of Russian roulette.
    pub roulette: Roulette,
}

/// An integrator, with light paths beside its camera paths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PatchEstimator {
    /// The integrator.
    pub integrator: IntegratorKind,
    /// The number of light paths for each camera path of `path`.
    pub light_paths: LightPathShare,
}

impl PatchEstimator {
    /// `path` with as many light paths as camera paths.
    pub const WITH_LIGHT_PATHS: Self = Self {
        integrator: IntegratorKind::Path,
        light_paths: LightPathShare::One,
    };

    /// An integrator without light paths beside it.
    pub const fn alone(integrator: IntegratorKind) -> Self {
        Self {
            integrator,
            light_paths: LightPathShare::None,
        }
    }

    /// The name in cases.
    pub fn name(self) -> &'static str {
        match self.light_paths {
            LightPathShare::None => self.integrator.name(),
            _ => "path with light paths",
        }
    }
}

/// Settings for direct light, without roulette.
pub fn direct(spp: u64) -> PatchSettings {
    bounces(1, spp)
}

/// Settings for at most `max_bounces` scattering events, without roulette.
pub fn bounces(max_bounces: u32, spp: u64) -> PatchSettings {
    PatchSettings {
        spp,
        max_bounces: Some(max_bounces),
        roulette: Roulette::None,
    }
}

/// An empty scene of one material, seen from `eye` with a field of view of 1e-4 radians around `target`.
pub fn patch_scene(eye: DVec3, target: DVec3, model: MaterialModel) -> SceneDescription {
    let back = (eye - target).normalize();
    let (right, up) = back.any_orthonormal_pair();
    // (right, up, back) is right-handed as (x, y, z) is.
    let to_world = DAffine3::from_mat3_translation(DMat3::from_cols(right, up, back), eye);
    SceneDescription {
        film: FilmDescription {
            size: SIZE,
            filter: FilterDescription {
                kind: FilterKind::Box,
                radius: 0.5,
            },
        },
        materials: vec![MaterialDescription::new(
            "material",
            Place::default(),
            model,
        )],
        ..SceneDescription::new("battery", CameraDescription::pinhole(to_world, FOV))
    }
}

/// Prepares a scene for rendering.
///
/// # Errors
/// An error of the scene or the backend.
pub fn ready(trial: &Trial<'_>, description: &SceneDescription) -> Result<Scene> {
    Ok(prepare(description, trial.options)?.scene)
}

/// The radiance of each pixel of a patch, with eight times as many samples with full effort.
///
/// # Errors
/// An error of the scene or the backend.
pub fn see(
    trial: &Trial<'_>,
    description: &SceneDescription,
    patch: PatchSettings,
) -> Result<Vec<f64>> {
    let spp = trial.samples(patch.spp);
    see_exactly(trial, description, PatchSettings { spp, ..patch })
}

/// The radiance of each pixel with exactly `patch.spp` samples.
///
/// # Errors
/// An error of the scene or the backend.
pub fn see_exactly(
    trial: &Trial<'_>,
    description: &SceneDescription,
    patch: PatchSettings,
) -> Result<Vec<f64>> {
    see_by(trial, IntegratorKind::default(), description, patch)
}

/// The radiance of each pixel with exactly `patch.spp` samples, by an integrator whose samples contribute to their own
/// pixel only.
///
/// # Errors
/// An error of the scene or the backend.
pub fn see_by(
    trial: &Trial<'_>,
    integrator: IntegratorKind,
    description: &SceneDescription,
    patch: PatchSettings,
) -> Result<Vec<f64>> {
    let scene = ready(trial, description)?;
    let estimator = PatchEstimator::alone(integrator);
    picture(trial, estimator, (description, &scene), patch, trial.seed)
}

/// Evaluates `of` on the pixels of each of `RENDERS` renders by any estimator. Where samples splat to other pixels, or
/// Markov chains move between pixels, the pixels of one render are correlated; separate renders are independent.
///
/// # Errors
/// An error of the scene or the backend.
pub fn see_again(
    trial: &Trial<'_>,
    estimator: PatchEstimator,
    description: &SceneDescription,
    patch: PatchSettings,
    of: impl Fn(&[f64]) -> f64,
) -> Result<Vec<f64>> {
    let scene = ready(trial, description)?;
    let of_render = |number: u64| {
        let seed = trial.seed.wrapping_mul(RENDERS).wrapping_add(number);
        let pixels = picture(trial, estimator, (description, &scene), patch, seed)?;
        Ok(of(&pixels))
    };
    (0..RENDERS).map(of_render).collect()
}

/// The mean of some numbers.
pub fn mean(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / numbers.len() as f64
}

/// Renders with exactly `patch.spp` samples and returns the radiance of each pixel.
fn picture(
    trial: &Trial<'_>,
    estimator: PatchEstimator,
    (description, scene): (&SceneDescription, &Scene),
    patch: PatchSettings,
    seed: u64,
) -> Result<Vec<f64>> {
    let size = description.film.size;
    let settings = RenderSettings {
        integrator: estimator.integrator,
        light_paths: LightPathRule::Share(estimator.light_paths),
        seed,
        max_bounces: patch.max_bounces,
        roulette: Some(patch.roulette),
        threads: trial.options.threads,
        tile_size: 1,
        ..RenderSettings::new(size, patch.spp)
    };
    let filter = Filter::new(&description.film.filter);
    let rendered = render(scene, &filter, size, &settings, trial)?;
    // The estimates would otherwise silently lack a rejected sample.
    let lost = rendered.rejected.count > 0;
    let pixels = rendered.film.estimates().into_iter();
    Ok(pixels
        .map(|pixel| if lost { f64::NAN } else { pixel.mean[1] })
        .collect())
}
