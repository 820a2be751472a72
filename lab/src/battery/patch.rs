//! A tiny patch of a scene, rendered: as many independent numbers as it has pixels.
//!
//! Measure: world units; radiance.
//! Range: a film of 32 pixels that all look at one point, so that each is an independent replicate.
//! Source: none needed. Tested through all that is built with it.

use super::trial::Trial;
use etendue::Result;
use etendue::internals::film::filter::{Filter, FilterDescription, FilterKind};
use etendue::internals::integrator::Roulette;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::math::vec::{DAffine3, DMat3, DVec3};
use etendue::internals::render::render;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::{
    CameraDescription, FilmDescription, MaterialDescription, MaterialModel, Place, SceneDescription,
};
use etendue::internals::scene::prepare::prepare;

/// The film of a patch.
pub const SIZE: (u32, u32) = (8, 4);

/// Renders that [`see_again`] makes: as many independent numbers as a patch has pixels.
const RENDERS: u64 = 32;

/// The angle that a patch is seen under, in radians.
const FOV: f64 = 1e-4;

/// How a patch is looked at.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    /// Samples a pixel that are needed at least.
    pub spp: u64,
    /// Scattering events at most.
    pub max_bounces: Option<u32>,
    /// When paths end by chance.
    pub roulette: Roulette,
}

/// Direct light, without roulette.
pub fn direct(spp: u64) -> Look {
    bounces(1, spp)
}

/// So many scattering events, without roulette.
pub fn bounces(max_bounces: u32, spp: u64) -> Look {
    Look {
        spp,
        max_bounces: Some(max_bounces),
        roulette: Roulette::None,
    }
}

/// An empty scene of one material, seen from `eye` within 1e-4 radians around `target`.
pub fn looking(eye: DVec3, target: DVec3, model: MaterialModel) -> SceneDescription {
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

/// A scene made ready.
///
/// # Errors
/// What the scene or the backend says.
pub fn ready(trial: &Trial<'_>, description: &SceneDescription) -> Result<Scene> {
    Ok(prepare(description, trial.options)?.scene)
}

/// What each pixel of a patch saw, with eight times as many samples where the effort is full.
///
/// # Errors
/// What the scene or the backend says.
pub fn see(trial: &Trial<'_>, description: &SceneDescription, look: Look) -> Result<Vec<f64>> {
    let spp = trial.samples(look.spp);
    see_exactly(trial, description, Look { spp, ..look })
}

/// What each pixel saw with just so many samples.
///
/// # Errors
/// What the scene or the backend says.
pub fn see_exactly(
    trial: &Trial<'_>,
    description: &SceneDescription,
    look: Look,
) -> Result<Vec<f64>> {
    see_by(trial, IntegratorKind::default(), description, look)
}

/// The same by an integrator whose samples find light for their own pixel alone.
///
/// # Errors
/// What the scene or the backend says.
pub fn see_by(
    trial: &Trial<'_>,
    integrator: IntegratorKind,
    description: &SceneDescription,
    look: Look,
) -> Result<Vec<f64>> {
    let scene = ready(trial, description)?;
    picture(trial, integrator, (description, &scene), look, trial.seed)
}

/// What `of` makes of the pixels of each of `RENDERS` renders by any integrator. Where samples find light for other pixels,
/// or chains wander from one to the next, the pixels of one render know of each other; those of several do not.
///
/// # Errors
/// What the scene or the backend says.
pub fn see_again(
    trial: &Trial<'_>,
    integrator: IntegratorKind,
    description: &SceneDescription,
    look: Look,
    of: impl Fn(&[f64]) -> f64,
) -> Result<Vec<f64>> {
    let scene = ready(trial, description)?;
    let of_render = |number: u64| {
        let seed = trial.seed.wrapping_mul(RENDERS).wrapping_add(number);
        let pixels = picture(trial, integrator, (description, &scene), look, seed)?;
        Ok(of(&pixels))
    };
    (0..RENDERS).map(of_render).collect()
}

/// The mean of some numbers.
pub fn mean(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / numbers.len() as f64
}

/// What each pixel of a render saw with just so many samples.
fn picture(
    trial: &Trial<'_>,
    integrator: IntegratorKind,
    (description, scene): (&SceneDescription, &Scene),
    look: Look,
    seed: u64,
) -> Result<Vec<f64>> {
    let size = description.film.size;
    let settings = RenderSettings {
        integrator,
        seed,
        max_bounces: look.max_bounces,
        roulette: Some(look.roulette),
        threads: trial.options.threads,
        tile_size: 1,
        ..RenderSettings::new(size, look.spp)
    };
    let filter = Filter::new(&description.film.filter);
    let rendered = render(scene, &filter, size, &settings, trial)?;
    // A sample that was rejected would be missing in silence.
    let lost = rendered.rejected.count > 0;
    let pixels = rendered.film.estimates().into_iter();
    Ok(pixels
        .map(|pixel| if lost { f64::NAN } else { pixel.mean[1] })
        .collect())
}
