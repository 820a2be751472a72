//! Cameras of glTF.
//!
//! Measure: the file's units; angles in radians.
//! Range: perspective cameras; an orthographic one becomes a perspective one from far away.
//! Source: glTF 2.0, chapter 3.10. Tested in `tests/loading/gltf.rs`.

use super::buffers::Asset;
use crate::error::Result;
use crate::math::functions::tan;
use crate::math::transform::orientation;
use crate::math::vec::{DAffine3, DVec3};
use crate::scene::description::{CameraDescription, FilmDescription, Note, NoteKind, Place};
use gltf::camera::Projection;

/// The longer side of the image, in pixels, where a camera gives its proportions.
const LONGER_SIDE: f64 = 768.0;

/// The field of view, in degrees, that stands for parallel projection.
const NEARLY_PARALLEL: f64 = 1.0;

/// Returns the camera of a node, and the film if the camera gives its proportions.
///
/// # Errors
/// If it has no valid field of view.
pub fn camera(
    asset: &Asset<'_>,
    camera: &gltf::Camera<'_>,
    to_world: &DAffine3,
    notes: &mut Vec<Note>,
) -> Result<(CameraDescription, Option<FilmDescription>)> {
    let wrong = |message: &str| asset.error(format!("cameras[{}]", camera.index()), message);
    let place = Place::of_file(asset.path);
    // A node may scale its camera, which changes nothing.
    let back = to_world.transform_vector3(DVec3::Z);
    let up = to_world.transform_vector3(DVec3::Y);
    let matrix3 = orientation(back, up).ok_or_else(|| wrong("its node flattens the camera"))?;
    let mut to_world = DAffine3 {
        matrix3,
        translation: to_world.translation,
    };
    let (fov, aspect) = match camera.projection() {
        Projection::Perspective(view) => {
            let fov = f64::from(view.yfov());
            if !(fov > 0.0 && fov < std::f64::consts::PI) {
                return Err(wrong("expected a field of view above 0 and below pi"));
            }
            (fov, view.aspect_ratio().map(f64::from))
        }
        Projection::Orthographic(view) => {
            let (x, y) = (f64::from(view.xmag()), f64::from(view.ymag()));
            if !(x > 0.0 && y > 0.0 && x.is_finite() && y.is_finite()) {
                return Err(wrong("expected a width and a height above 0"));
            }
            let fov = NEARLY_PARALLEL.to_radians();
            to_world.translation += y / tan(0.5 * fov) * to_world.matrix3.z_axis;
            notes.push(Note::at(
                place.clone(),
                NoteKind::Approximation,
                format!(
                    "the orthographic camera {} became a perspective one from far away, which also sees what is behind the original",
                    camera.index()
                ),
            ));
            (fov, Some(x / y))
        }
    };
    let film = aspect.filter(|it| *it > 0.0).map(|aspect| {
        let side = |share: f64| (LONGER_SIDE * share.min(1.0)).round().max(1.0) as u32;
        FilmDescription {
            size: (side(aspect), side(1.0 / aspect)),
            ..FilmDescription::default()
        }
    });
    let pinhole = CameraDescription {
        place,
        ..CameraDescription::pinhole(to_world, fov)
    };
    Ok((pinhole, film))
}
