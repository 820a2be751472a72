//! A triangle that emits, sampled by solid angle.
//!
//! Measure: densities per steradian.
//! Range: any receiver off the triangle's plane; below [`spherical_triangle::SMALLEST`] the point is chosen by area.
//! Source: `sampling/spherical_triangle.rs`. Tested in `tests/light.rs`.

use super::types::{Emission, LightEnd, LightSample};
use crate::geometry::mesh::triangle_point;
use crate::math::measure::{PdfArea, PdfSolidAngle};
use crate::math::vec::{Vec2, Vec3};
use crate::sampling::{spherical_triangle, warp};

/// An emitting triangle.
#[derive(Debug, Clone, Copy)]
pub struct TriangleLight {
    vertices: [Vec3; 3],
    emission: Emission,
    area: f32,
}

impl TriangleLight {
    /// A light of the given triangle.
    pub fn new(vertices: [Vec3; 3], emission: Emission) -> Self {
        let [a, b, c] = vertices.map(|v| v.as_dvec3());
        Self {
            vertices,
            emission,
            area: (0.5 * (b - a).cross(c - a).length()) as f32,
        }
    }

    /// Radiant power in normalised units.
    pub fn power(&self) -> f64 {
        self.emission.power(f64::from(self.area))
    }

    /// A point that lights `p`.
    #[inline]
    pub fn sample(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let omega = self.solid_angle(p);
        let by_angle = (omega >= spherical_triangle::SMALLEST)
            .then(|| spherical_triangle::sample(self.seen_from(p), omega, u))
            .flatten()
            .map(|b| b.map(|b| b as f32));
        let b = by_angle.unwrap_or_else(|| warp::sample_triangle_uniform(u).to_array());
        let point = triangle_point(self.vertices, b);
        let towards = point.p - p;
        let wi = towards.normalize();
        let cos = -wi.dot(point.ng);
        let pdf = density(omega, self.area, towards.length_squared(), cos)?;
        Some(LightSample {
            wi,
            radiance: self.emission.towards(cos),
            pdf: Some(pdf),
            end: LightEnd::Surface(point, b),
        })
    }

    /// The density with which [`sample`](Self::sample) finds, from `p`, the point at squared distance `distance2`
    /// whose normal has cosine `cos` with the direction back.
    #[inline]
    pub fn pdf(&self, p: Vec3, distance2: f32, cos: f32) -> Option<PdfSolidAngle> {
        density(self.solid_angle(p), self.area, distance2, cos)
    }

    #[inline]
    fn seen_from(&self, p: Vec3) -> [glam::DVec3; 3] {
        let p = p.as_dvec3();
        self.vertices.map(|v| v.as_dvec3() - p)
    }

    #[inline]
    fn solid_angle(&self, p: Vec3) -> f64 {
        spherical_triangle::solid_angle(self.seen_from(p))
    }
}

/// One over the solid angle, or the area density's equivalent where the angle is tiny.
#[inline]
fn density(omega: f64, area: f32, distance2: f32, cos: f32) -> Option<PdfSolidAngle> {
    if omega >= spherical_triangle::SMALLEST {
        Some(PdfSolidAngle((1.0 / omega) as f32))
    } else {
        PdfArea(1.0 / area).to_solid_angle(distance2, cos)
    }
}
