//! A rectangle that emits, sampled by solid angle.
//!
//! Measure: densities per steradian.
//! Range: edges at right angles (others are two triangles); any receiver off the plane; below
//! [`spherical_rectangle::SMALLEST`] the point is chosen by area.
//! Source: `sampling/spherical_rectangle.rs`. Tested in `tests/light.rs`.

use super::types::{Emission, LightEnd, LightSample};
use crate::geometry::surface::SurfacePoint;
use crate::math::measure::{PdfArea, PdfSolidAngle};
use crate::math::robust::{gamma, never_zero};
use crate::math::vec::{DVec3, Vec2, Vec3};
use crate::sampling::spherical_rectangle::{self, SphericalRectangle};

/// An emitting rectangle.
#[derive(Debug, Clone, Copy)]
pub struct RectangleLight {
    corner: Vec3,
    edges: [Vec3; 2],
    /// Unit vectors along the edges.
    axes: [DVec3; 2],
    lengths: [f64; 2],
    normal: Vec3,
    emission: Emission,
}

impl RectangleLight {
    /// A light at `corner` along two edges at right angles; its normal is edge_u x edge_v.
    pub fn new(corner: Vec3, edges: [Vec3; 2], emission: Emission) -> Self {
        let [u, v] = edges.map(|e| e.as_dvec3());
        // Rounded vertices are not quite at right angles; the frame of the sampling is.
        let x = u.normalize();
        let normal = u.cross(v).normalize();
        let y = normal.cross(x);
        Self {
            corner,
            edges,
            axes: [x, y],
            lengths: [u.length(), v.length()],
            normal: normal.as_vec3(),
            emission,
        }
    }

    /// Radiant power in normalised units.
    pub fn power(&self) -> f64 {
        self.emission.power(self.lengths[0] * self.lengths[1])
    }

    /// A point that lights `p`.
    #[inline]
    pub fn sample(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let seen = self.seen_from(p)?;
        let s = if seen.solid_angle() >= spherical_rectangle::SMALLEST {
            seen.sample(u)
        } else {
            u.to_array().map(f64::from)
        };
        // In double precision: on a huge rectangle, single-precision fractions would jump past a near receiver.
        let [along_u, along_v] = [0, 1].map(|i| s[i] * self.edges[i].as_dvec3());
        let position = (self.corner.as_dvec3() + along_u + along_v).as_vec3();
        let towards = position - p;
        let wi = towards.normalize();
        let cos = -wi.dot(self.normal);
        let rounding = gamma(9) * (self.corner.abs() + self.edges[0].abs() + self.edges[1].abs());
        let point = SurfacePoint {
            p: position,
            error: never_zero(rounding, self.lengths[0].max(self.lengths[1]) as f32),
            ng: self.normal,
            ns: self.normal,
        };
        Some(LightSample {
            wi,
            radiance: self.emission.towards(cos),
            pdf: Some(self.density(seen.solid_angle(), towards.length_squared(), cos)?),
            end: LightEnd::Surface(point, [0.0; 2]),
        })
    }

    /// The density with which [`sample`](Self::sample) finds, from `p`, the point at squared distance `distance2`
    /// whose normal has cosine `cos` with the direction back.
    #[inline]
    pub fn pdf(&self, p: Vec3, distance2: f32, cos: f32) -> Option<PdfSolidAngle> {
        self.density(self.seen_from(p)?.solid_angle(), distance2, cos)
    }

    #[inline]
    fn seen_from(&self, p: Vec3) -> Option<SphericalRectangle> {
        let corner = self.corner.as_dvec3() - p.as_dvec3();
        SphericalRectangle::new(corner, self.axes, self.lengths)
    }

    #[inline]
    fn density(&self, omega: f64, distance2: f32, cos: f32) -> Option<PdfSolidAngle> {
        if omega >= spherical_rectangle::SMALLEST {
            Some(PdfSolidAngle((1.0 / omega) as f32))
        } else {
            let area = self.lengths[0] * self.lengths[1];
            PdfArea((1.0 / area) as f32).to_solid_angle(distance2, cos)
        }
    }
}
