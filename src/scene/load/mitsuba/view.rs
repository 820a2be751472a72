//! The camera of a Mitsuba scene without a sensor.
//!
//! Measure: world units.
//! Range: scenes with shapes, of a finite size.
//! Source: none needed; Mitsuba has no camera for such a scene. Tested in `tests/loading/mitsuba_shapes.rs`.

use super::super::bounds;
use super::super::contents::SceneContents;
use super::super::model::framed;
use super::object::XmlObject;
use crate::error::Result;
use crate::scene::description::CameraDescription;

/// Returns a camera that shows all shapes, with a note.
///
/// # Errors
/// If there are none, or they are too large.
pub fn without_sensor(
    scene: &XmlObject,
    contents: &mut SceneContents,
) -> Result<CameraDescription> {
    let bounds = bounds::of_all(contents, bounds::of_placed);
    if bounds.is_empty() {
        let why = "expected a sensor, or shapes that one can be placed before";
        return Err(scene.place.error(why));
    }
    framed(&scene.place.file, &bounds, contents)
}
