//! Scenes built in code, and what a tiny patch of one looks like.
//!
//! Measure: world units; radiance.
//! Range: a film of 32 pixels that all look at one point, so that each is an independent replicate.
//! Source: none needed. Tested through all that is built with it.

use super::trial::Trial;
use etendue::Result;
use etendue::internals::film::filter::{Filter, FilterDescription, FilterKind};
use etendue::internals::integrator::Roulette;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DAffine3, DMat3, DVec3};
use etendue::internals::render::render;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::{
    CameraDescription, ColourDescription, FilmDescription, GeometryDescription, LightDescription,
    LightModel, MaterialDescription, MaterialModel, MeshDescription, Place, SceneDescription,
    ShapeDescription,
};
use etendue::internals::scene::prepare::prepare;
use std::sync::Arc;

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

/// The same everywhere.
pub fn grey(value: f32) -> ColourDescription {
    ColourDescription::Constant(Rgb::grey(value))
}

/// Lambert's model.
pub fn diffuse(albedo: f32) -> MaterialModel {
    MaterialModel::Diffuse {
        reflectance: grey(albedo),
    }
}

/// A perfect mirror.
pub fn mirror(reflectance: f32) -> MaterialModel {
    MaterialModel::Mirror {
        reflectance: grey(reflectance),
    }
}

/// Clear glass.
pub fn glass(ior: f32, roughness: f32) -> MaterialModel {
    MaterialModel::Dielectric {
        ior,
        roughness,
        tint: grey(1.0),
    }
}

/// The same radiance from everywhere beyond the scene.
pub fn sky(radiance: Rgb) -> LightDescription {
    LightDescription::sky(Place::default(), radiance)
}

/// A light that is no shape.
pub fn light(model: LightModel) -> LightDescription {
    LightDescription {
        place: Place::default(),
        model,
    }
}

/// A shape of the scene's material that emits `radiance`, if any, on the side of its normal.
pub fn shape(geometry: GeometryDescription, radiance: f32) -> ShapeDescription {
    ShapeDescription {
        emission: (radiance > 0.0).then_some(grey(radiance)),
        ..ShapeDescription::new("shape", Place::default(), geometry)
    }
}

/// The rectangle at `corner`, with the normal u x v.
pub fn rectangle(corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> GeometryDescription {
    GeometryDescription::Rectangle {
        corner: corner.into(),
        edge_u: u.into(),
        edge_v: v.into(),
    }
}

/// A rectangle at height `z` over [x0, x1] x [y0, y1] that looks down.
pub fn ceiling([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], z: f64) -> GeometryDescription {
    rectangle([x0, y0, z], [0.0, y1 - y0, 0.0], [x1 - x0, 0.0, 0.0])
}

/// A sphere.
pub fn sphere(center: DVec3, radius: f64) -> GeometryDescription {
    GeometryDescription::Sphere { center, radius }
}

/// Triangles without normals or texture coordinates.
pub fn mesh(positions: Vec<DVec3>, indices: Vec<[u32; 3]>) -> GeometryDescription {
    GeometryDescription::Mesh(Arc::new(MeshDescription {
        positions,
        indices,
        ..Default::default()
    }))
}

/// A convex polygon as a fan of triangles.
pub fn polygon(positions: Vec<DVec3>) -> GeometryDescription {
    let indices = (2..positions.len() as u32).map(|i| [0, i - 1, i]).collect();
    mesh(positions, indices)
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
