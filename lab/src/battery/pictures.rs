//! Whole images that have to be the same, bit for bit, or up to a power of two.
//!
//! Measure: pixels that differ.
//! Range: a small scene with a lamp, a sky and shading normals.
//! Source: none needed: equality. Tested in `lab/tests/reports/battery.rs`.

use super::case::{Case, Effort, Trial};
use super::claim::Claim;
use super::patch::{patch_scene, ready};
use crate::scene_builder::{diffuse, grey, rectangle, sky, sphere, surface};
use etendue::Result;
use etendue::internals::film::filter::Filter;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DAffine3, DVec3};
use etendue::internals::render::render;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::scene::description::{
    ColourDescription, GeometryDescription, Keyframe, LightModel, MeshDescription, SceneDescription,
};
use std::sync::Arc;

/// A change of the scene, which returns the factor by which the original pixels have to be multiplied.
type SceneChange = fn(&mut SceneDescription, i32) -> f32;

/// Every case.
pub fn cases(_: Effort) -> Vec<Case> {
    let case = |row, name: String, change: SceneChange, argument: i32| {
        let name = format!("pixels that differ: {name}");
        Case::new(row, name, Claim::exactly(0.0), move |trial| {
            differing(trial, change, argument)
        })
    };
    let scaled =
        [-40, -20, -3, 1, 17, 40].map(|k| case(34, format!("scene scaled by 2^{k}"), scale, k));
    let lit = [-100, -20, 1, 60, 100].map(|k| case(58, format!("light times 2^{k}"), brighten, k));
    let others = [
        case(44, "equal keys of motion".to_owned(), stand_still, 0),
        case(44, "one key of motion".to_owned(), stand_still, 1),
        case(
            45,
            "lens of no width, focused at 1e-3".to_owned(),
            focus,
            -3,
        ),
        case(
            45,
            "lens of no width, focused at 1e30".to_owned(),
            focus,
            30,
        ),
        case(39, "triangles of no area added".to_owned(), degenerate, 0),
    ];
    scaled.into_iter().chain(lit).chain(others).collect()
}

/// A lit floor, an emissive sphere, and an octahedron with shading normals.
fn gallery() -> SceneDescription {
    let mut scene = patch_scene(DVec3::new(1.0, -4.0, 2.0), DVec3::ZERO, diffuse(0.6));
    scene.film.size = (16, 12);
    scene.camera.fov = 0.7;
    let ball = sphere(DVec3::new(0.5, 0.5, 0.5), 0.25);
    let floor = rectangle([-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]);
    let stone = GeometryDescription::Mesh(Arc::new(stone()));
    scene.shapes = vec![surface(stone, 0.0), surface(ball, 4.0), surface(floor, 0.0)];
    scene.lights = vec![sky(Rgb::new(0.1, 0.2, 0.3))];
    scene
}

/// An octahedron with a normal for each vertex.
fn stone() -> MeshDescription {
    let axes = [
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        -DVec3::X,
        -DVec3::Y,
        -DVec3::Z,
    ];
    let center = DVec3::new(-0.5, -0.25, 0.5);
    let faces = [0, 3].into_iter().flat_map(|x| {
        [1, 4]
            .into_iter()
            .flat_map(move |y| [2, 5].map(|z| [x, y, z]))
    });
    MeshDescription {
        positions: axes.map(|axis| center + 0.5 * axis).to_vec(),
        normals: axes.to_vec(),
        uvs: vec![],
        indices: faces.collect(),
    }
}

fn picture(trial: &Trial<'_>, scene: &SceneDescription) -> Result<Vec<Rgb>> {
    let size = scene.film.size;
    let settings = RenderSettings {
        seed: trial.seed,
        threads: trial.options.threads,
        ..RenderSettings::new(size, trial.samples(8))
    };
    let filter = Filter::new(&scene.film.filter);
    let rendered = render(&ready(trial, scene)?, &filter, size, &settings, trial)?;
    Ok(rendered.film.develop().pixels().to_vec())
}

fn differing(trial: &Trial<'_>, change: SceneChange, argument: i32) -> Result<Vec<f64>> {
    let before = picture(trial, &gallery())?;
    let mut changed = gallery();
    let factor = change(&mut changed, argument);
    let after = picture(trial, &changed)?;
    let differ = |a: &Rgb, b: &Rgb| {
        let bits = |rgb: Rgb| rgb.to_array().map(f32::to_bits);
        bits(*a * factor) != bits(*b)
    };
    let pairs = before.iter().zip(&after);
    let count = pairs.filter(|(a, b)| differ(a, b)).count();
    // Black images would be equal in any case.
    let black = before.iter().all(|pixel| pixel.is_black());
    Ok(vec![if black { f64::NAN } else { count as f64 }])
}

fn scale(scene: &mut SceneDescription, exponent: i32) -> f32 {
    let factor = f64::exp2(f64::from(exponent));
    let camera = &mut scene.camera;
    camera.to_world.translation *= factor;
    camera.focus_distance *= factor;
    let larger = DAffine3::from_scale(DVec3::splat(factor));
    scene.shapes.iter_mut().for_each(|s| s.transform = larger);
    1.0
}

fn brighten(scene: &mut SceneDescription, exponent: i32) -> f32 {
    let factor = f32::exp2(exponent as f32);
    scene.shapes[1].emission = Some(grey(4.0 * factor));
    for light in &mut scene.lights {
        if let LightModel::Environment { radiance, .. } = &mut light.model
            && let Some(colour) = radiance.constant()
        {
            *radiance = ColourDescription::Constant(colour * factor);
        }
    }
    factor
}

fn stand_still(scene: &mut SceneDescription, one: i32) -> f32 {
    let key = |time: f64| Keyframe {
        time,
        transform: DAffine3::IDENTITY,
    };
    scene.camera.shutter = [0.0, 1.0];
    scene.shapes[0].motion = match one {
        0 => vec![key(0.0), key(1.0)],
        _ => vec![key(0.5)],
    };
    1.0
}

fn focus(scene: &mut SceneDescription, exponent: i32) -> f32 {
    scene.camera.focus_distance = 10.0_f64.powi(exponent);
    1.0
}

fn degenerate(scene: &mut SceneDescription, _: i32) -> f32 {
    let mut stone = stone();
    stone.indices.extend([[0, 0, 1], [2, 2, 2], [0, 1, 0]]);
    scene.shapes[0].geometry = GeometryDescription::Mesh(Arc::new(stone));
    1.0
}
