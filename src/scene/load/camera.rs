//! Reads the `[camera]` table of a scene file.
//!
//! Measure: world units, degrees.
//! Range: a field of view above 0 and below 180 degrees; a transform of rotations and translations only.
//! Source: docs/scene-format.md. Tested in `tests/loading/scene_files.rs`.

use super::motion::{keys, shutter};
use super::reader::{Table, Value};
use super::transform::transform;
use crate::error::Result;
use crate::math::transform::{is_rotation, look_at};
use crate::math::vec::{DAffine3, DVec3};
use crate::scene::description::{CameraDescription, Keyframe};
use std::f64::consts::PI;

/// Reads `[camera]`.
///
/// # Errors
/// If an entry is not as the format requires.
pub fn camera(table: &Table<'_>) -> Result<CameraDescription> {
    let (to_world, to_target, motion) = standing_or_moving(table)?;
    let positive = |key, default| match table.optional(key) {
        Some(value) => value.number_where("a number above 0", |x: f64| x > 0.0),
        None => Ok(default),
    };
    let fov = match table.optional("fov") {
        Some(fov) => fov.angle_where("an angle in degrees above 0 and below 180", |x| {
            x > 0.0 && x < PI
        })?,
        None => 40_f64.to_radians(),
    };
    let lens_radius = table.optional("lens_radius").map_or(Ok(0.0), |radius| {
        radius.number_where("a number of at least 0", |x| x >= 0.0)
    })?;
    let shutter = table
        .optional("shutter")
        .map_or(Ok([0.0; 2]), |value| shutter(&value))?;
    let is_mirrored = table
        .optional("mirrored")
        .map_or(Ok(false), |value| value.truth())?;
    let camera = CameraDescription {
        to_world,
        is_mirrored,
        fov,
        lens_radius,
        focus_distance: positive("focus_distance", to_target)?,
        motion,
        shutter,
        place: table.place(),
    };
    table.finish()?;
    Ok(camera)
}

/// Returns the camera's transform, its distance to the target, and its keyframes; those of the first keyframe if it
/// moves.
fn standing_or_moving(table: &Table<'_>) -> Result<(DAffine3, f64, Vec<Keyframe>)> {
    let Some(motion) = table.optional("motion") else {
        let (to_world, to_target) = placement(table)?;
        return Ok((to_world, to_target, vec![]));
    };
    if let Some(other) = present(table, &["eye", "target", "up", "transform"]) {
        let message = format!(
            "expected either motion, or the placement of a static camera, but `{other}` is given too"
        );
        return Err(motion.error(message));
    }
    let keys = keys(&motion, placement)?;
    let (first, to_target) = keys[0];
    let keys = keys.into_iter().map(|(key, _)| key).collect();
    Ok((first.transform, to_target, keys))
}

/// Returns the first of these keys that the table has.
fn present(table: &Table<'_>, keys: &[&'static str]) -> Option<&'static str> {
    keys.iter().copied().find(|key| table.has(key))
}

/// Returns the camera's transform and its distance to the target.
fn placement(table: &Table<'_>) -> Result<(DAffine3, f64)> {
    match table.optional("transform") {
        Some(value) => {
            if let Some(other) = present(table, &["eye", "target", "up"]) {
                let message = format!(
                    "expected either transform, or eye and target, but `{other}` is given too"
                );
                return Err(value.error(message));
            }
            Ok((rigid(&value)?, 1.0))
        }
        None => {
            let eye = table.required("eye")?.vec3()?;
            let target = table.required("target")?;
            let up = table.optional("up").map_or(Ok(DVec3::Y), |up| up.vec3())?;
            let towards = target.vec3()?;
            let placed = look_at(eye, towards, up).ok_or_else(|| {
                target.error(
                    "eye and target are the same point, or up is along the line between them",
                )
            })?;
            Ok((placed, eye.distance(towards)))
        }
    }
}

/// Reads a camera's transform, which must be rigid.
fn rigid(value: &Value<'_>) -> Result<DAffine3> {
    let placed = transform(value, "the camera")?;
    if is_rotation(&placed.matrix3) {
        Ok(placed)
    } else {
        Err(value.error(
            "expected rotations and translations only: a camera cannot be stretched, and `mirrored = true` mirrors its image",
        ))
    }
}
