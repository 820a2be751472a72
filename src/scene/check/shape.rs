//! Checks shapes and instances by the rules of `load`.
//!
//! Measure: world units.
//! Range: any shape or instance, and the scene that it belongs to.
//! Source: docs/scene-format.md. Tested in `tests/loading/built_scenes.rs`.

use super::values::{colour, direction, finite, keys, length, placed, require};
use crate::error::{Error, Result};
use crate::math::vec::DVec3;
use crate::scene::description::{
    GeometryDescription, InstanceDescription, MeshDescription, SceneDescription, ShapeDescription,
};

/// Checks a shape of a scene.
///
/// # Errors
/// If the shape is invalid.
pub fn shape(shape: &ShapeDescription, scene: &SceneDescription) -> Result<()> {
    let field = |key: &str| format!("shape `{}`: {key}", shape.name);
    require(
        shape.material < scene.materials.len(),
        || field("material"),
        &format!("there are {} materials", scene.materials.len()),
    )?;
    in_group(shape.group, scene, || field("group"))?;
    placed(&shape.transform, || field("transform"))?;
    keys(&shape.motion, &shape.name)?;
    if let Some(emission) = &shape.emission {
        colour(emission, f32::MAX, || field("emission"))?;
    }
    match &shape.geometry {
        GeometryDescription::Mesh(triangles) => mesh(triangles, field),
        GeometryDescription::Sphere { center, radius } => {
            finite(*center, || field("center"))?;
            length(*radius, || field("radius"))
        }
        GeometryDescription::Rectangle {
            corner,
            edge_u,
            edge_v,
        } => {
            finite(*corner, || field("corner"))?;
            finite(*edge_u, || field("edge_u"))?;
            finite(*edge_v, || field("edge_v"))?;
            let has_area = edge_u.cross(*edge_v) != DVec3::ZERO;
            require(
                has_area,
                || field("edge_v"),
                "the edges are parallel: there is no area",
            )
        }
        GeometryDescription::Disk {
            center,
            normal,
            radius,
        } => {
            finite(*center, || field("center"))?;
            direction(*normal, || field("normal"))?;
            length(*radius, || field("radius"))
        }
        GeometryDescription::Box { min, max } => {
            finite(*min, || field("min"))?;
            finite(*max, || field("max"))?;
            let expected = "expected every coordinate of min below that of max";
            require(min.cmplt(*max).all(), || field("max"), expected)
        }
    }
}

/// Checks an instance of a scene.
///
/// # Errors
/// If the instance is invalid.
pub fn instance(instance: &InstanceDescription, scene: &SceneDescription) -> Result<()> {
    let field = |key: &str| format!("instance `{}`: {key}", instance.name);
    in_group(Some(instance.of), scene, || field("of"))?;
    in_group(instance.group, scene, || field("group"))?;
    placed(&instance.transform, || field("transform"))?;
    keys(&instance.motion, &instance.name)
}

fn mesh(mesh: &MeshDescription, field: impl Fn(&str) -> String) -> Result<()> {
    let count = mesh.positions.len();
    require(
        mesh.positions.iter().all(|p| p.is_finite()),
        || field("positions"),
        "expected finite numbers",
    )?;
    require(
        mesh.normals.is_empty() || mesh.normals.len() == count,
        || field("normals"),
        &format!("expected one for each of the {count} positions"),
    )?;
    require(
        mesh.normals.iter().all(|n| n.is_finite()),
        || field("normals"),
        "expected finite numbers",
    )?;
    require(
        mesh.uvs.is_empty() || mesh.uvs.len() == count,
        || field("uvs"),
        &format!("expected one for each of the {count} positions"),
    )?;
    require(
        mesh.uvs.iter().all(|uv| uv.as_vec2().is_finite()),
        || field("uvs"),
        "expected numbers within single precision",
    )?;
    let wrong = mesh
        .indices
        .iter()
        .flatten()
        .find(|&&i| i as usize >= count);
    match wrong {
        None => Ok(()),
        Some(index) => Err(Error::scene(format!(
            "vertex {index}, but there are {count} positions"
        ))
        .in_field(field("indices"))),
    }
}

fn in_group(
    group: Option<usize>,
    scene: &SceneDescription,
    field: impl Fn() -> String,
) -> Result<()> {
    require(
        group.is_none_or(|group| group < scene.groups.len()),
        field,
        &format!("there are {} groups", scene.groups.len()),
    )
}
