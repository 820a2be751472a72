//! Loads a bare model, OBJ or PLY: adds a camera that frames it and, if nothing in it emits, a constant sky.
//!
//! Measure: the model's own units.
//! Range: any model with faces, up to a size of about 1e150.
//! Source: none needed. Tested in `tests/loading/scene_files.rs` and `tests/loading/ply.rs`.

use super::contents::SceneContents;
use super::wording::shown;
use super::{bounds, obj, ply, vertex_colours};
use crate::error::{Error, Result};
use crate::math::bounds::Bounds;
use crate::math::functions::sin;
use crate::math::rgb::Rgb;
use crate::math::transform::orientation;
use crate::math::vec::{DAffine3, DVec3};
use crate::scene::description::{
    CameraDescription, GeometryDescription, LightDescription, Note, NoteKind, Place,
    SceneDescription, ShapeDescription,
};
use std::path::Path;
use std::sync::Arc;

/// Vertical field of view, in degrees.
const FOV: f64 = 35.0;

/// Direction from the model to the camera: from the front, slightly from the right and from above.
const VIEW: DVec3 = DVec3::new(0.45, 0.35, 1.0);

/// Reads an OBJ model as a scene.
///
/// # Errors
/// If the file is invalid.
pub fn load_obj(path: &Path) -> Result<SceneDescription> {
    let mut contents = SceneContents::default();
    contents.shapes = obj::load(path, None, &mut contents)?;
    with_camera_and_sky(path, contents)
}

/// Reads a PLY model as a scene.
///
/// # Errors
/// If the file is invalid.
pub fn load_ply(path: &Path) -> Result<SceneDescription> {
    let model = ply::read_mesh(path)?;
    let mut contents = SceneContents::default();
    for note in model.notes {
        contents.note(note);
    }
    if let Some((name, line)) = model.texture_file {
        let place = Place::on_line(path, line);
        let text = format!("the image {} was left out", shown(&name));
        contents.note(Note::at(place, NoteKind::Omission, text));
    }
    let place = Place::of_file(path);
    let name = shown(&path.file_stem().unwrap_or_default().to_string_lossy());
    let mut mesh = model.mesh;
    let material = if model.colours.is_empty() {
        contents.default_material()
    } else {
        vertex_colours::to_material(&mut mesh, &model.colours, place.clone(), &mut contents)?
    };
    let geometry = GeometryDescription::Mesh(Arc::new(mesh));
    contents.shapes.push(ShapeDescription {
        material,
        ..ShapeDescription::new(name, place, geometry)
    });
    with_camera_and_sky(path, contents)
}

/// Adds a camera that frames the model and, if nothing in it emits, a sky.
///
/// # Errors
/// If the model is too large to be framed.
fn with_camera_and_sky(path: &Path, mut contents: SceneContents) -> Result<SceneDescription> {
    let bounds = bounds::of_all(&contents, bounds::of_placed);
    let camera = framed(path, &bounds, &mut contents)?;
    let is_lit = contents.shapes.iter().any(|shape| shape.emission.is_some());
    let lights = sky_unless(is_lit, path, &mut contents);
    Ok(SceneDescription {
        materials: contents.materials,
        shapes: contents.shapes,
        lights: lights.into_iter().collect(),
        notes: contents.notes,
        ..SceneDescription::new(path, camera)
    })
}

/// Returns a camera that frames a model with these bounds, with a note.
///
/// # Errors
/// If the model is too large to be framed.
pub fn framed(
    path: &Path,
    bounds: &Bounds,
    contents: &mut SceneContents,
) -> Result<CameraDescription> {
    let camera = frame(bounds).ok_or_else(|| {
        Error::scene("the model is too large to be framed: use a scene file").in_file(path)
    })?;
    contents.note(Note::of_scene(
        NoteKind::Decision,
        "there is no camera: the camera was placed to show everything",
    ));
    Ok(camera)
}

/// Returns a sky for a model that is not lit, with a note.
pub fn sky_unless(
    is_lit: bool,
    path: &Path,
    contents: &mut SceneContents,
) -> Option<LightDescription> {
    if is_lit {
        return None;
    }
    let place = Place::of_file(path);
    contents.note(Note::of_scene(
        NoteKind::Decision,
        "no lamp lights the model: a constant white sky was added",
    ));
    Some(LightDescription::sky(place, Rgb::WHITE))
}

/// Returns a camera that sees the bounding sphere of the box; `None` beyond the range of double precision.
fn frame(bounds: &Bounds) -> Option<CameraDescription> {
    let centre = bounds.centre();
    let radius = 0.5 * bounds.extent().length();
    // A model that is a single point.
    let radius = if radius > 0.0 { radius } else { 1.0 };
    let distance = 1.05 * radius / sin(0.5 * FOV.to_radians());
    let to_world = DAffine3 {
        matrix3: orientation(VIEW, DVec3::Y)?,
        translation: centre + distance * VIEW.normalize(),
    };
    (to_world.is_finite() && distance.is_finite()).then(|| CameraDescription {
        focus_distance: distance,
        ..CameraDescription::pinhole(to_world, FOV.to_radians())
    })
}
