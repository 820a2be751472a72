//! The radiance of emitting shapes of a pbrt file, from their power where that is given.
//!
//! Measure: watts, world units, radiance.
//! Range: shapes with an area. Triangles of different areas become shapes of their own, up to 256.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt/statements.rs`.

use super::builder::Builder;
use super::light::AreaLight;
use super::params::Parameters;
use crate::error::Result;
use crate::math::functions::cbrt;
use crate::math::vec::{DAffine3, DVec3};
use crate::scene::description::{
    ColourDescription, GeometryDescription, MeshDescription, ShapeDescription,
};
use std::f64::consts::PI;
use std::sync::Arc;

/// The relative difference between areas that are taken as equal.
const AREA_TOLERANCE: f64 = 1e-4;

/// The most triangles that get a radiance of their own.
const MAX_SEPARATE: usize = 256;

impl Builder {
    /// Adds a shape that emits; where power is given, its radiance follows from its area.
    /// # Errors
    /// If the radiance is not finite.
    pub fn emitting(
        &mut self,
        mut shape: ShapeDescription,
        light: &AreaLight,
        params: &Parameters,
    ) -> Result<()> {
        let Some(power) = light.power else {
            shape.emission = Some(light.emission.clone());
            self.library.contents.shapes.push(shape);
            return Ok(());
        };
        let sides = if light.is_two_sided { 2.0 } else { 1.0 };
        let over = |area: f64| power / (sides * PI * area * light.mean);
        let start = shape
            .motion
            .first()
            .map_or(DAffine3::IDENTITY, |key| key.transform);
        let placed = start * shape.transform;
        let mesh = match &shape.geometry {
            GeometryDescription::Mesh(mesh) => Arc::clone(mesh),
            round => {
                let area = area_of_round(round, &placed);
                shape.emission = Some(scaled(&light.emission, over(area), params)?);
                self.library.contents.shapes.push(shape);
                return Ok(());
            }
        };
        // In pbrt every triangle is a shape and has the power.
        let areas: Vec<f64> = mesh
            .indices
            .iter()
            .map(|t| area(&mesh, t, &placed))
            .collect();
        let mean = areas.iter().sum::<f64>() / areas.len() as f64;
        if areas
            .iter()
            .all(|area| (area - mean).abs() <= AREA_TOLERANCE * mean)
        {
            shape.emission = Some(scaled(&light.emission, over(mean), params)?);
            self.library.contents.shapes.push(shape);
            return Ok(());
        }
        if areas.len() > MAX_SEPARATE {
            let what = "the power of each triangle became the same radiance of all";
            self.library.approximated(&params.place, what);
            shape.emission = Some(scaled(&light.emission, over(mean), params)?);
            self.library.contents.shapes.push(shape);
            return Ok(());
        }
        for (triangle, area) in mesh
            .indices
            .iter()
            .zip(areas)
            .filter(|(_, area)| *area > 0.0)
        {
            self.library.contents.shapes.push(ShapeDescription {
                geometry: GeometryDescription::Mesh(Arc::new(alone(&mesh, triangle))),
                emission: Some(scaled(&light.emission, over(area), params)?),
                ..shape.clone()
            });
        }
        Ok(())
    }
}

/// The area of a sphere or disk under a transform.
fn area_of_round(geometry: &GeometryDescription, placed: &DAffine3) -> f64 {
    let scale = cbrt(placed.matrix3.determinant().abs());
    match geometry {
        GeometryDescription::Sphere { radius, .. } => 4.0 * PI * (scale * radius).powi(2),
        GeometryDescription::Disk { radius, .. } => PI * (scale * radius).powi(2),
        _ => 0.0,
    }
}

fn area(mesh: &MeshDescription, triangle: &[u32; 3], placed: &DAffine3) -> f64 {
    let [a, b, c] = triangle.map(|i| placed.transform_point3(mesh.positions[i as usize]));
    0.5 * (b - a).cross(c - a).length()
}

/// One triangle of a mesh, with vertices of its own.
fn alone(mesh: &MeshDescription, triangle: &[u32; 3]) -> MeshDescription {
    let corners = triangle.map(|i| i as usize);
    let of = |values: &[DVec3]| {
        corners
            .iter()
            .filter_map(|&i| values.get(i).copied())
            .collect()
    };
    MeshDescription {
        positions: of(&mesh.positions),
        normals: of(&mesh.normals),
        uvs: corners
            .iter()
            .filter_map(|&i| mesh.uvs.get(i).copied())
            .collect(),
        indices: vec![[0, 1, 2]],
    }
}

fn scaled(
    emission: &ColourDescription,
    factor: f64,
    params: &Parameters,
) -> Result<ColourDescription> {
    let by = factor as f32;
    let scaled: ColourDescription = match emission {
        ColourDescription::Constant(colour) => (by * *colour).into(),
        ColourDescription::Texture(texture) => {
            ColourDescription::Texture(Arc::new(texture.scaled(by)))
        }
    };
    if by.is_finite() && scaled.brightest().is_finite() {
        Ok(scaled)
    } else {
        Err(params.error("expected an area and a power of light that give finite radiance"))
    }
}
