//! Shapes of revolution cut into triangles: spheres, disks and cylinders, or parts of them.
//!
//! Measure: unit shapes about the z axis; angles in radians.
//! Range: a sphere is cut into 32 x 16 fields, other shapes into 64 around their axis. Angles above a full turn count as
//! one.
//! Source: none needed. Tested in `tests/loading/pbrt/` and `tests/loading/mitsuba_shapes.rs`.

use crate::math::functions::{acos, sin_cos};
use crate::math::vec::{DVec2, DVec3};
use crate::scene::description::MeshDescription;
use std::f64::consts::TAU;

/// Fields of a cut sphere around its axis and from pole to pole; fields of other round shapes around their axis.
const SPHERE_FIELDS: [u32; 2] = [32, 16];
const AROUND: u32 = 64;

/// The triangles of a grid of so many fields, row by row.
pub fn fields([columns, rows]: [u32; 2]) -> impl Iterator<Item = [u32; 3]> {
    let corners = move |x: u32, y: u32| {
        let at = |x, y| y * (columns + 1) + x;
        let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
        [[a, b, c], [a, c, d]]
    };
    (0..rows).flat_map(move |y| (0..columns).flat_map(move |x| corners(x, y)))
}

/// A shape of revolution about z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Round {
    /// A unit sphere, from and to heights in [-1, 1].
    Sphere { from: f64, to: f64 },
    /// A unit disk in the plane z = 0, without what is closer to its centre than `inner`.
    Disk { inner: f64 },
    /// A unit cylinder from z = 0 to 1.
    Cylinder,
}

/// Cuts a part of a round shape, through an angle in radians, into triangles with normals. Texture
/// coordinates are u around the axis and v along the profile, as in pbrt and Mitsuba.
pub fn round(shape: Round, angle: f64) -> MeshDescription {
    let size = match shape {
        Round::Sphere { .. } => SPHERE_FIELDS,
        _ => [AROUND, 1],
    };
    let [columns, rows] = size;
    let mut mesh = MeshDescription::default();
    for y in 0..=rows {
        for x in 0..=columns {
            let (u, v) = (
                f64::from(x) / f64::from(columns),
                f64::from(y) / f64::from(rows),
            );
            let (sin, cos) = sin_cos(u * angle.min(TAU));
            let ((radius, z), (across, up)) = profile(shape, v);
            mesh.positions
                .push(DVec3::new(radius * cos, radius * sin, z));
            mesh.normals
                .push(DVec3::new(across * cos, across * sin, up));
            mesh.uvs.push(DVec2::new(u, v));
        }
    }
    let positions = &mesh.positions;
    let has_area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| positions[i as usize]);
        (b - a).cross(c - a).length() > 1e-12
    };
    let triangles = fields(size).filter(has_area).collect();
    mesh.indices = triangles;
    mesh
}

/// Radius and height, and the normal across and along the axis, at a height v of the texture.
fn profile(shape: Round, v: f64) -> ((f64, f64), (f64, f64)) {
    match shape {
        Round::Sphere { from, to } => {
            let [low, high] = [from, to].map(|z| acos(z.clamp(-1.0, 1.0)));
            let (sin, cos) = sin_cos(low + v * (high - low));
            ((sin, cos), (sin, cos))
        }
        Round::Disk { inner } => ((1.0 - v * (1.0 - inner), 0.0), (0.0, 1.0)),
        Round::Cylinder => ((1.0, v), (1.0, 0.0)),
    }
}
