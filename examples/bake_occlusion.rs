//! Bakes ambient occlusion to the vertices of a model: the share of the sky that each of them sees, as grey values of a Wavefront
//! OBJ.
//!
//! `cargo run --release --example bake_occlusion -- model.obj baked.obj`

use etendue::description::{GeometryDescription, MeshDescription, ShapeDescription};
use etendue::vec::DVec3;
use etendue::{Error, QueryRay, Result, Session, sample_hemisphere_cosine, tracing};
use std::fmt::Write;
use std::path::Path;

/// Directions a vertex, on a grid over their square.
const SIDE: u32 = 16;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [model, out] = arguments.as_slice() else {
        return Err(Error::usage("usage: bake_occlusion MODEL.obj OUT.obj"));
    };
    let session = Session::load(Path::new(model), tracing())?;
    let mut text = String::new();
    let mut first = 1;
    for shape in &session.description().shapes {
        if let GeometryDescription::Mesh(mesh) = &shape.geometry {
            bake(&session, shape, mesh, first, &mut text)?;
            first += mesh.positions.len();
        }
    }
    std::fs::write(out, text).map_err(|error| Error::io("cannot write", Path::new(out), error))
}

/// Appends a mesh whose vertices have colours; `first` is the number of its first vertex.
fn bake(
    session: &Session,
    shape: &ShapeDescription,
    mesh: &MeshDescription,
    first: usize,
    text: &mut String,
) -> Result<()> {
    let transform = shape.transform;
    let positions: Vec<DVec3> = mesh
        .positions
        .iter()
        .map(|&p| transform.transform_point3(p))
        .collect();
    // Of all triangles about a vertex, each by its area.
    let mut normals = vec![DVec3::ZERO; positions.len()];
    for triangle in &mesh.indices {
        let [a, b, c] = triangle.map(|index| positions[index as usize]);
        for index in triangle {
            normals[*index as usize] += (b - a).cross(c - a);
        }
    }
    for (&position, &normal) in positions.iter().zip(&normals) {
        let share = match normal.try_normalize() {
            Some(normal) => visible(session, position, normal)?,
            None => 0.0,
        };
        let DVec3 { x, y, z } = position;
        writeln!(text, "v {x} {y} {z} {share} {share} {share}").expect("a string takes all");
    }
    for triangle in &mesh.indices {
        let [a, b, c] = triangle.map(|index| first + index as usize);
        writeln!(text, "f {a} {b} {c}").expect("a string takes all");
    }
    Ok(())
}

/// The share of the sky, weighted by the cosine, that a point sees on the side of its normal.
fn visible(session: &Session, position: DVec3, normal: DVec3) -> Result<f64> {
    let (side, up) = normal.any_orthonormal_pair();
    let mut free = 0;
    for i in 0..SIDE {
        for j in 0..SIDE {
            let middle = |index: u32| (index as f32 + 0.5) / SIDE as f32;
            let w = sample_hemisphere_cosine([middle(i), middle(j)].into()).as_dvec3();
            // A vertex lies on its triangles: they are left behind first.
            let size = 1e-4 * position.length().max(1.0);
            let ray = QueryRay::new(
                position + size * normal,
                w.x * side + w.y * up + w.z * normal,
            );
            free += u32::from(!session.occluded(&ray)?);
        }
    }
    Ok(f64::from(free) / f64::from(SIDE * SIDE))
}
