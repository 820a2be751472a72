//! The bounds of what was loaded, for a camera that shows it.
//!
//! Measure: world units.
//! Range: any shapes, as they are without motion; empty if there are none.
//! Source: none needed. Tested in `tests/loading/mitsuba_shapes.rs` and `tests/loading/scene_files.rs`.

use super::contents::SceneContents;
use crate::geometry::mesh::MIN_PER_THREAD;
use crate::math::bounds::Bounds;
use crate::math::vec::{DAffine3, DVec3};
use crate::scene::description::{GeometryDescription, ShapeDescription};
use rayon::prelude::*;

/// Returns the box around all shapes, by that of each; of an instance, around the corners of its group's box.
pub fn of_all(contents: &SceneContents, of_shape: impl Fn(&ShapeDescription) -> Bounds) -> Bounds {
    let mut of_groups = vec![Bounds::default(); contents.groups.len()];
    let mut whole = Bounds::default();
    for shape in &contents.shapes {
        let around = match shape.group {
            Some(group) => &mut of_groups[group],
            None => &mut whole,
        };
        *around = around.union(of_shape(shape));
    }
    for instance in &contents.instances {
        whole = whole.union(of_groups[instance.of].transformed(&instance.transform));
    }
    whole
}

/// Returns the box around a shape where its transform places it.
pub fn of_placed(shape: &ShapeDescription) -> Bounds {
    of_geometry(&shape.geometry, &shape.transform)
}

/// Returns the box around a transformed shape.
pub fn of_geometry(geometry: &GeometryDescription, transform: &DAffine3) -> Bounds {
    let place = |point| transform.transform_point3(point);
    let around = |centre, reach| {
        let centre = place(centre);
        Bounds::around([centre - reach, centre + reach])
    };
    match geometry {
        GeometryDescription::Mesh(mesh) => {
            let triangles = mesh.indices.par_iter().with_min_len(MIN_PER_THREAD);
            let around = |triangle: &[u32; 3]| {
                Bounds::around(triangle.map(|i| place(mesh.positions[i as usize])))
            };
            triangles.map(around).reduce(Bounds::default, Bounds::union)
        }
        GeometryDescription::Sphere { center, radius } => {
            let scale = transform.matrix3.x_axis.length();
            around(*center, DVec3::splat(radius * scale))
        }
        GeometryDescription::Rectangle {
            corner,
            edge_u: u,
            edge_v: v,
        } => Bounds::around([*corner, corner + u, corner + v, corner + u + v].map(place)),
        // The loaders that ask make disks of world units.
        GeometryDescription::Disk {
            center,
            normal,
            radius,
        } => {
            let normal = normal.normalize_or_zero();
            let across = (DVec3::ONE - normal * normal).max(DVec3::ZERO);
            around(*center, radius * across.map(f64::sqrt))
        }
        GeometryDescription::Box { min, max } => {
            let (min, max) = (*min, *max);
            Bounds { min, max }.transformed(transform)
        }
    }
}
