//! A rectangle that emits, sampled by solid angle from near by and nearly so from farther off.
//!
//! Measure: densities per steradian.
//! Range: edges at right angles (others are two triangles); any receiver off the plane. Beyond [`CLEAR`] radii the point is
//! chosen with a density per area that is bilinear between those of the corners, on the dark side by area, and else by
//! solid angle, or by area again below [`spherical_rectangle::SMALLEST`].
//! Source: `sampling/bilinear.rs`, `sampling/spherical_rectangle.rs`. Tested in `tests/light.rs`.

use super::types::{Emission, LightEnd, LightSample};
use crate::geometry::surface::SurfacePoint;
use crate::math::measure::{PdfArea, PdfSolidAngle};
use crate::math::robust::{gamma, never_zero};
use crate::math::vec::{DVec3, Vec2, Vec3, Vec4};
use crate::sampling::bilinear::Bilinear;
use crate::sampling::spherical_rectangle::{self, SphericalRectangle};

/// The distance of the centre, in radii (half diagonals), from which on the bilinear density serves.
///
/// A uniform density of directions is one of points in proportion to 1 / r^3. What the bilinear one misses of it adds a
/// variance of 1.1 % of the squared mean here, averaged over directions of view and shapes, less than 0.2 % at 4 radii and
/// 0.004 % at 10. By area alone it would be 17 %, 6 % and 1 %. `tests/light.rs` holds it to this.
pub const CLEAR: f32 = 2.5;

/// An emitting rectangle.
#[derive(Debug, Clone, Copy)]
pub struct RectangleLight {
    corner: Vec3,
    edges: [Vec3; 2],
    normal: Vec3,
    emission: Emission,
    /// Bound of the rounding error of every point.
    error: Vec3,
    /// One over the squared length of each edge.
    over_edges2: Vec2,
    radius2: f32,
    pdf_area: PdfArea,
    /// Unit vectors along the edges.
    axes: [DVec3; 2],
    lengths: [f64; 2],
}

/// How a receiver sees the rectangle, and so how it is sampled.
enum View {
    /// With a density over its points.
    OfPoints(Bilinear),
    /// By solid angle.
    Near(SphericalRectangle),
}

impl RectangleLight {
    /// A light at `corner` along two edges at right angles; its normal is edge_u x edge_v.
    pub fn new(corner: Vec3, edges: [Vec3; 2], emission: Emission) -> Self {
        let [u, v] = edges.map(|e| e.as_dvec3());
        // Rounded vertices are not quite at right angles; the frame of the sampling is.
        let x = u.normalize();
        let normal = u.cross(v).normalize();
        let y = normal.cross(x);
        let lengths = [u.length(), v.length()];
        let rounding = gamma(9) * (corner.abs() + edges[0].abs() + edges[1].abs());
        let lengths2 = lengths.map(|length| length * length);
        Self {
            corner,
            edges,
            normal: normal.as_vec3(),
            emission,
            error: never_zero(rounding, lengths[0].max(lengths[1]) as f32),
            over_edges2: Vec2::from(lengths2.map(|length2| (1.0 / length2) as f32)),
            radius2: (0.25 * (lengths2[0] + lengths2[1])) as f32,
            pdf_area: PdfArea((1.0 / (lengths[0] * lengths[1])) as f32),
            axes: [x, y],
            lengths,
        }
    }

    /// Radiant power in normalised units.
    pub fn power(&self) -> f64 {
        self.emission.power(self.lengths[0] * self.lengths[1])
    }

    /// A point that lights `p`.
    #[inline]
    pub fn sample(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let view = self.view(p)?;
        let (position, at) = match &view {
            View::OfPoints(density) => {
                let at = density.sample(u);
                let position = self.corner + at.x * self.edges[0] + at.y * self.edges[1];
                (position, at)
            }
            View::Near(seen) => (self.near_point(seen.sample(u)), Vec2::ZERO),
        };
        let towards = position - p;
        let wi = towards.normalize();
        let cos = -wi.dot(self.normal);
        let point = SurfacePoint {
            p: position,
            error: self.error,
            ng: self.normal,
            ns: self.normal,
        };
        Some(LightSample {
            wi,
            radiance: self.emission.towards(cos),
            pdf: Some(self.density(&view, || at, towards.length_squared(), cos)?),
            end: LightEnd::Surface(point, [0.0; 2]),
        })
    }

    /// The density with which [`sample`](Self::sample) finds, from `p`, the point at `towards` from it whose normal has
    /// cosine `cos` with the direction back.
    #[inline]
    pub fn pdf(&self, p: Vec3, towards: Vec3, cos: f32) -> Option<PdfSolidAngle> {
        let at = || {
            let from_corner = towards - (self.corner - p);
            self.over_edges2 * Vec2::from(self.edges.map(|edge| from_corner.dot(edge)))
        };
        self.density(&self.view(p)?, at, towards.length_squared(), cos)
    }

    /// A function of nothing but `p`, so that [`sample`](Self::sample) and [`pdf`](Self::pdf) speak of the same density.
    #[inline]
    fn view(&self, p: Vec3) -> Option<View> {
        let corner = self.corner - p;
        if self.emission.is_dark_behind() && corner.dot(self.normal) > 0.0 {
            return Some(View::OfPoints(Bilinear::UNIFORM));
        }
        let center = corner + 0.5 * (self.edges[0] + self.edges[1]);
        let distance2 = center.length_squared();
        if distance2 >= CLEAR * CLEAR * self.radius2 {
            return Some(View::OfPoints(self.density_of_points(center, distance2)));
        }
        self.near_view(p)
    }

    /// 1 / r^3 at the corners, from r^2 = |center|^2 + radius^2 +- center . edge_u +- center . edge_v.
    #[inline]
    fn density_of_points(&self, center: Vec3, distance2: f32) -> Bilinear {
        let scale = 1.0 / (distance2 + self.radius2);
        let [u, v] = self.edges.map(|edge| scale * center.dot(edge));
        let over_r2 = (Vec4::ONE + Vec4::new(-u - v, u - v, v - u, u + v)).recip();
        Bilinear::new((over_r2 * over_r2.sqrt()).to_array())
    }

    #[cold]
    fn near_view(&self, p: Vec3) -> Option<View> {
        let corner = self.corner.as_dvec3() - p.as_dvec3();
        let seen = SphericalRectangle::new(corner, self.axes, self.lengths)?;
        Some(if seen.solid_angle() >= spherical_rectangle::SMALLEST {
            View::Near(seen)
        } else {
            View::OfPoints(Bilinear::UNIFORM)
        })
    }

    /// The point at these shares of the edges, in double precision: on a huge rectangle, single-precision fractions would
    /// jump past a near receiver.
    fn near_point(&self, s: [f64; 2]) -> Vec3 {
        let [along_u, along_v] = [0, 1].map(|i| s[i] * self.edges[i].as_dvec3());
        (self.corner.as_dvec3() + along_u + along_v).as_vec3()
    }

    #[inline]
    fn density(
        &self,
        view: &View,
        at: impl FnOnce() -> Vec2,
        distance2: f32,
        cos: f32,
    ) -> Option<PdfSolidAngle> {
        match view {
            View::OfPoints(density) => {
                let pdf = PdfArea(density.pdf(at()) * self.pdf_area.0);
                pdf.to_solid_angle(distance2, cos)
            }
            View::Near(seen) => Some(PdfSolidAngle((1.0 / seen.solid_angle()) as f32)),
        }
    }
}
