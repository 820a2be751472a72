//! Checks a description that was made in code by the rules of `load`.
//!
//! Measure: as in the description.
//! Range: any description; the first violation is an error that names the object and its field.
//! Source: docs/scene-format.md, whose rules these are. Tested in `tests/loading/built_scenes.rs`.

mod light;
mod material;
mod shape;
mod values;

use super::description::{CameraDescription, FilmDescription, SceneDescription};
use crate::error::Result;
use crate::film::filter::MAX_RADIUS;
use crate::image::MAX_SIDE;
use crate::math::transform::is_rotation;
pub use light::{light, panoramas};
pub use material::material;
pub use shape::{instance, shape};
use std::f64::consts::PI;
use values::{keys, require};

/// Checks a whole scene.
///
/// # Errors
/// The error of the first invalid object.
pub fn scene(scene: &SceneDescription) -> Result<()> {
    camera(&scene.camera)?;
    film(&scene.film)?;
    scene.materials.iter().try_for_each(material)?;
    for added in &scene.shapes {
        shape(added, scene)?;
    }
    for added in &scene.instances {
        instance(added, scene)?;
    }
    scene.lights.iter().try_for_each(light)?;
    panoramas(&scene.lights)
}

/// Checks a camera.
///
/// # Errors
/// If the camera is invalid.
pub fn camera(camera: &CameraDescription) -> Result<()> {
    let in_camera = |field: &str| format!("camera.{field}");
    let places = camera.motion.iter().map(|key| &key.transform);
    for placed in [&camera.to_world].into_iter().chain(places) {
        require(
            placed.is_finite() && is_rotation(&placed.matrix3),
            || in_camera("to_world"),
            "expected finite numbers, and rotations and translations only",
        )?;
    }
    keys(&camera.motion, "camera")?;
    let [open, close] = camera.shutter;
    require(
        open.is_finite() && close.is_finite() && open <= close,
        || in_camera("shutter"),
        "expected the times of opening and closing, in order",
    )?;
    require(
        camera.fov > 0.0 && camera.fov < PI,
        || in_camera("fov"),
        "expected an angle above 0 and below 180 degrees",
    )?;
    require(
        camera.lens_radius >= 0.0 && camera.lens_radius.is_finite(),
        || in_camera("lens_radius"),
        "expected a finite number of at least 0",
    )?;
    require(
        camera.focus_distance > 0.0 && camera.focus_distance.is_finite(),
        || in_camera("focus_distance"),
        "expected a finite number above 0",
    )
}

/// Checks a film.
///
/// # Errors
/// If the film is invalid.
pub fn film(film: &FilmDescription) -> Result<()> {
    let is_side = |side: u32| (1..=MAX_SIDE).contains(&(side as usize));
    require(
        is_side(film.size.0) && is_side(film.size.1),
        || "film.size".to_owned(),
        &format!("expected from 1 to {MAX_SIDE} pixels a side"),
    )?;
    require(
        film.filter.radius > 0.0 && film.filter.radius <= MAX_RADIUS,
        || "film.filter".to_owned(),
        "expected a radius of pixels above 0, up to 32",
    )
}
