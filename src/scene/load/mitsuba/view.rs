//! The camera of a Mitsuba scene without a sensor.
//!
//! Measure: world units.
//! Range: scenes with shapes, of a finite size.
//! Source: none needed; Mitsuba has no camera for such a scene. Tested in `tests/loading/mitsuba_shapes.rs`.

use super::super::contents::Contents;
use super::super::model::framed;
use super::object::Object;
use crate::error::Result;
use crate::math::bounds::Bounds;
use crate::math::vec::DVec3;
use crate::scene::description::{CameraDescription, GeometryDescription, ShapeDescription};

/// Returns a camera that shows all shapes, with a note.
///
/// # Errors
/// If there are none, or they are too large.
pub fn without_sensor(scene: &Object, contents: &mut Contents) -> Result<CameraDescription> {
    let bounds = bounds(contents);
    if bounds.is_empty() {
        let why = "expected a sensor, or shapes that one can be placed before";
        return Err(scene.place.error(why));
    }
    framed(&scene.place.file, &bounds, contents)
}

/// The box around all shapes; of a group, around the corners of its box.
fn bounds(contents: &Contents) -> Bounds {
    let mut of_groups = vec![Bounds::default(); contents.groups.len()];
    let mut whole = Bounds::default();
    for shape in &contents.shapes {
        let around = match shape.group {
            Some(group) => &mut of_groups[group],
            None => &mut whole,
        };
        *around = around.union(bounds_of(shape));
    }
    for instance in &contents.instances {
        let Bounds { min, max } = of_groups[instance.of];
        if !of_groups[instance.of].is_empty() {
            let corners = [min.x, max.x].into_iter().flat_map(|x| {
                let yz = [min.y, max.y].map(|y| [min.z, max.z].map(|z| DVec3::new(x, y, z)));
                yz.into_iter().flatten()
            });
            whole = whole.union(Bounds::around(
                corners.map(|corner| instance.transform.transform_point3(corner)),
            ));
        }
    }
    whole
}

/// The box around a shape that is placed.
fn bounds_of(shape: &ShapeDescription) -> Bounds {
    let place = |point| shape.transform.transform_point3(point);
    let around = |centre, reach| {
        let centre = place(centre);
        Bounds::around([centre - reach, centre + reach])
    };
    match &shape.geometry {
        GeometryDescription::Mesh(mesh) => {
            let used = mesh.indices.iter().flatten();
            Bounds::around(used.map(|&i| place(mesh.positions[i as usize])))
        }
        GeometryDescription::Sphere { center, radius } => {
            let scale = shape.transform.matrix3.x_axis.length();
            around(*center, DVec3::splat(radius * scale))
        }
        GeometryDescription::Rectangle {
            corner,
            edge_u: u,
            edge_v: v,
        } => Bounds::around([*corner, corner + u, corner + v, corner + u + v].map(place)),
        // The loader makes disks of world units.
        GeometryDescription::Disk {
            center,
            normal,
            radius,
        } => {
            let normal = normal.normalize_or_zero();
            let across = (DVec3::ONE - normal * normal).max(DVec3::ZERO);
            around(*center, radius * across.map(f64::sqrt))
        }
        GeometryDescription::Box { min, max } => Bounds::around([*min, *max].map(place)),
    }
}
