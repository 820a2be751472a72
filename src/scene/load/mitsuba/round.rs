//! The disks, spheres and cylinders of a Mitsuba scene.
//!
//! Measure: world units.
//! Range: disks and spheres stay round; cylinders, elliptic disks and spheres turned inside out are cut into triangles,
//! with a note.
//! Source: Mitsuba 3 documentation, "Shapes". Tested in `tests/loading/mitsuba.rs` and
//! `tests/loading/mitsuba_shapes.rs`.

use super::super::contents::SceneContents;
use super::super::revolution::{self, Round};
use super::material::MitsubaMaterial;
use super::mesh::{MeshOptions, finished};
use super::object::XmlObject;
use crate::error::Result;
use crate::math::vec::{DAffine3, DMat3, DVec3};
use crate::scene::description::{GeometryDescription, MeshDescription, NoteKind};
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::sync::Arc;

/// The meshes of cylinders, which equal ones share.
pub type Cylinders = HashMap<String, Arc<MeshDescription>>;

/// A cylinder without its ends, and what is applied to it before the shape's transform.
///
/// # Errors
/// If it has no radius or no length.
pub fn cylinder(
    shape: &XmlObject,
    options: &MeshOptions,
    known: &mut Cylinders,
    contents: &mut SceneContents,
) -> Result<(GeometryDescription, DAffine3)> {
    let from = shape.vector("p0")?.unwrap_or(DVec3::ZERO);
    let to = shape.vector("p1")?.unwrap_or(DVec3::Z);
    let radius = shape.number_where("radius", 1.0, "a number above 0", |x| x > 0.0)?;
    let axis = (to - from).try_normalize();
    let axis = axis.ok_or_else(|| shape.error_at("p1", "expected another point than `p0`"))?;
    let text = "a cylinder was cut into triangles";
    contents.note(shape.note(NoteKind::Approximation, text));
    let options = MeshOptions {
        // It has normals, so that the transform has no effect on the mesh.
        to_world: DMat3::IDENTITY,
        face_normals: false,
        ..*options
    };
    let mesh = known
        .entry(format!("{options:?}"))
        .or_insert_with(|| Arc::new(finished(revolution::round(Round::Cylinder, TAU), &options)));
    let (x, y) = axis.any_orthonormal_pair();
    let placed = DAffine3 {
        matrix3: DMat3::from_cols(radius * x, radius * y, to - from),
        translation: from,
    };
    Ok((GeometryDescription::Mesh(Arc::clone(mesh)), placed))
}

/// The options of a round shape that is cut whole. It has normals, so that the transform has no effect on the mesh.
fn whole(flip: bool, surface: &MitsubaMaterial) -> MeshOptions {
    MeshOptions {
        flip,
        to_uv: surface.to_uv,
        to_world: DMat3::IDENTITY,
        face_normals: false,
        flip_v: true,
    }
}

/// Notes that the texture coordinates of a round shape differ.
fn note_uvs(shape: &XmlObject, contents: &mut SceneContents) {
    let text = "textures lie differently on it";
    contents.note(shape.note(NoteKind::Approximation, text));
}

/// A disk in the world.
///
/// # Errors
/// If the transform makes it a line or a point.
pub fn disk(
    shape: &XmlObject,
    to_world: DAffine3,
    flip: bool,
    surface: &MitsubaMaterial,
    contents: &mut SceneContents,
) -> Result<(GeometryDescription, DAffine3)> {
    if surface.to_uv.is_some() {
        note_uvs(shape, contents);
    }
    let axes = to_world.matrix3;
    let (x, y) = (axes.x_axis, axes.y_axis);
    let radius = x.length();
    let is_round =
        (y.length() - radius).abs() < 1e-5 * radius && x.dot(y).abs() < 1e-5 * radius * radius;
    let upright = if (axes.determinant() < 0.0) == flip {
        x.cross(y)
    } else {
        -x.cross(y)
    };
    if upright == DVec3::ZERO {
        return Err(shape.error_at(
            "to_world",
            "expected a transform that keeps the disk's area",
        ));
    }
    if !is_round {
        let text = "an elliptic disk was cut into triangles";
        contents.note(shape.note(NoteKind::Approximation, text));
        let options = whole(flip, surface);
        let mesh = finished(revolution::round(Round::Disk { inner: 0.0 }, TAU), &options);
        return Ok((GeometryDescription::Mesh(Arc::new(mesh)), to_world));
    }
    let geometry = GeometryDescription::Disk {
        center: to_world.translation,
        normal: upright,
        radius,
    };
    Ok((geometry, DAffine3::IDENTITY))
}

/// A sphere in the world.
///
/// # Errors
/// If the transform makes it an ellipsoid, or its radius is not above 0.
pub fn sphere(
    shape: &XmlObject,
    to_world: DAffine3,
    flip: bool,
    surface: &MitsubaMaterial,
    contents: &mut SceneContents,
) -> Result<(GeometryDescription, DAffine3)> {
    let center = shape.vector("center")?.unwrap_or(DVec3::ZERO);
    let radius = shape.number_where("radius", 1.0, "a number above 0", |x| x > 0.0)?;
    let axes = to_world.matrix3;
    let lengths = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::length);
    let scale = lengths[0];
    let turned = axes * (1.0 / scale);
    let error = turned * turned.transpose() - DMat3::IDENTITY;
    if !error.to_cols_array().into_iter().all(|x| x.abs() < 1e-4) {
        return Err(shape.error_at(
            "to_world",
            "expected a transform that scales the sphere uniformly",
        ));
    }
    // Exporters write single precision, and numbers of few digits.
    let x = turned.x_axis.normalize();
    let y = (turned.y_axis - turned.y_axis.dot(x) * x).normalize();
    let turned = DMat3::from_cols(x, y, x.cross(y) * turned.determinant().signum());
    // Mitsuba decides by the sign of the transform's determinant.
    if flip != (turned.determinant() < 0.0) {
        let text = "a sphere turned inside out was cut into triangles";
        contents.note(shape.note(NoteKind::Approximation, text));
        let options = whole(true, surface);
        let poles = Round::Sphere {
            from: -1.0,
            to: 1.0,
        };
        let mesh = finished(revolution::round(poles, TAU), &options);
        let placed = to_world
            * DAffine3::from_translation(center)
            * DAffine3::from_scale(DVec3::splat(radius));
        return Ok((GeometryDescription::Mesh(Arc::new(mesh)), placed));
    }
    if surface
        .to_uv
        .is_some_and(|to_uv| to_uv != Default::default())
    {
        note_uvs(shape, contents);
    }
    // Mitsuba's sphere has its poles along z, ours along y.
    let poles = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Y);
    let geometry = GeometryDescription::Sphere {
        center: DVec3::ZERO,
        radius: radius * scale,
    };
    let transform = DAffine3 {
        matrix3: turned * poles,
        translation: to_world.transform_point3(center),
    };
    Ok((geometry, transform))
}
