//! A rectangle that emits, sampled by solid angle from near by and nearly so from farther off.
//!
//! Measure: densities per steradian.
//! Range: edges at right angles (others are two triangles); any receiver off the plane. Beyond [`CLEAR`] radii the point is
//! chosen with a density per area that is linear along each edge, beyond [`FAR`] radii and on the dark side by area, and
//! else by solid angle, or by area again below [`spherical_rectangle::SMALLEST`].
//! Source: `sampling/linear.rs`, `sampling/spherical_rectangle.rs`. Tested in `tests/lights/light.rs`.

use super::types::{Emission, LightEnd, LightSample};
use crate::geometry::surface::SurfacePoint;
use crate::math::measure::{PdfArea, PdfSolidAngle};
use crate::math::robust::{gamma, never_zero};
use crate::math::vec::{DVec3, Vec2, Vec3, Vec4};
use crate::sampling::linear::LinearSquare;
use crate::sampling::spherical_rectangle::{self, SphericalRectangle};

/// The distance of the centre, in radii (half diagonals), from which on points are chosen with a density linear along each
/// edge.
///
/// A uniform density of directions is one of points in proportion to 1 / r^3. What the linear one misses of it adds a
/// variance of 1.2 % of the squared mean here, averaged over directions of view and shapes, less than 0.2 % at 4 radii and
/// 0.005 % at 10. By area alone it would be 17 %, 6 % and 1 %. `tests/lights/light.rs` holds it to this.
pub const CLEAR: f32 = 2.5;

/// The distance from which on points are chosen by area, for a variance of 0.01 % in the mean.
pub const FAR: f32 = 100.0;

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
    over_radius2: f32,
    /// The squares of half the edges, in squared radii.
    half_edges2: Vec2,
    /// One over the area.
    pdf_area: f32,
    /// Unit vectors along the edges.
    axes: [DVec3; 2],
    lengths: [f64; 2],
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
        let radius2 = 0.25 * (lengths2[0] + lengths2[1]);
        Self {
            corner,
            edges,
            normal: normal.as_vec3a(),
            emission,
            error: never_zero(rounding, lengths[0].max(lengths[1]) as f32),
            over_edges2: Vec2::from(lengths2.map(|length2| (1.0 / length2) as f32)),
            over_radius2: (1.0 / radius2) as f32,
            half_edges2: Vec2::from(lengths2.map(|length2| (0.25 * length2 / radius2) as f32)),
            pdf_area: (1.0 / (lengths[0] * lengths[1])) as f32,
            axes: [x, y],
            lengths,
        }
    }

    /// Radiant power in normalised units.
    pub fn power(&self) -> f64 {
        self.emission.power(self.lengths[0] * self.lengths[1])
    }

    /// What it emits.
    pub fn emission(&self) -> Emission {
        self.emission
    }

    /// A point chosen uniformly by area.
    pub fn point(&self, u: Vec2) -> SurfacePoint {
        self.surface(self.corner + u.x * self.edges[0] + u.y * self.edges[1])
    }

    /// The density of [`point`](Self::point).
    pub fn pdf_area(&self) -> PdfArea {
        PdfArea(self.pdf_area)
    }

    /// A point that lights `p`.
    #[inline]
    pub fn sample(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let Some(density) = self.density_of_points(p) else {
            return self.sample_near(p, u);
        };
        self.sample_points(p, density, u)
    }

    /// A point chosen uniformly by area.
    pub fn sample_by_area(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        self.sample_points(p, LinearSquare::UNIFORM, u)
    }

    /// A point that lights `p`, chosen with this density in shares of the edges.
    #[inline]
    fn sample_points(&self, p: Vec3, density: LinearSquare, u: Vec2) -> Option<LightSample> {
        let at = density.sample(u);
        let position = self.corner + at.x * self.edges[0] + at.y * self.edges[1];
        self.found(p, position, |distance2, cos| {
            self.per_steradian(density.pdf(at), distance2, cos)
        })
    }

    /// The density with which [`sample`](Self::sample) finds, from `p`, the point at `towards` from it whose normal has
    /// cosine `cos` with the direction back.
    #[inline]
    pub fn pdf(&self, p: Vec3, towards: Vec3, cos: f32) -> Option<PdfSolidAngle> {
        let distance2 = towards.length_squared();
        let Some(density) = self.density_of_points(p) else {
            return self.pdf_near(p, distance2, cos);
        };
        let from_corner = towards - (self.corner - p);
        let along = Vec2::new(
            from_corner.dot(self.edges[0]),
            from_corner.dot(self.edges[1]),
        );
        self.per_steradian(density.pdf(self.over_edges2 * along), distance2, cos)
    }

    /// How points are chosen, in shares of the edges; `None` where directions are. A function of nothing but `p`, so that
    /// [`sample`](Self::sample) and [`pdf`](Self::pdf) speak of the same density.
    #[inline]
    fn density_of_points(&self, p: Vec3) -> Option<LinearSquare> {
        let corner = self.corner - p;
        if self.emission.is_dark_behind() && corner.dot(self.normal) > 0.0 {
            return Some(LinearSquare::UNIFORM);
        }
        let center = corner + 0.5 * (self.edges[0] + self.edges[1]);
        let distance2 = self.over_radius2 * center.length_squared();
        if distance2 < CLEAR * CLEAR {
            return None;
        }
        if distance2 > FAR * FAR {
            return Some(LinearSquare::UNIFORM);
        }
        // 1 / r^3 in the middle of each edge, from r^2 = |center|^2 + |edge|^2 / 4 +- center . edge.
        let u = self.over_radius2 * center.dot(self.edges[0]);
        let v = self.over_radius2 * center.dot(self.edges[1]);
        let [far_u, far_v] = (self.half_edges2 + Vec2::splat(distance2)).to_array();
        let over_r2 = Vec4::new(far_u - u, far_v - v, far_u + u, far_v + v).recip();
        let weights = over_r2 * over_r2.sqrt();
        Some(LinearSquare::new(
            Vec2::new(weights.x, weights.y),
            Vec2::new(weights.z, weights.w),
        ))
    }

    /// The density per steradian of a point with this density in shares of the edges.
    #[inline]
    fn per_steradian(&self, of_shares: f32, distance2: f32, cos: f32) -> Option<PdfSolidAngle> {
        PdfArea(of_shares * self.pdf_area).to_solid_angle(distance2, cos)
    }

    #[cold]
    fn sample_near(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let seen = self.seen_from(p)?;
        let s = if seen.solid_angle() >= spherical_rectangle::SMALLEST {
            seen.sample(u)
        } else {
            u.to_array().map(f64::from)
        };
        // In double precision: on a huge rectangle, single-precision fractions would jump past a near receiver.
        let [along_u, along_v] = [0, 1].map(|i| s[i] * self.edges[i].as_dvec3());
        let position = (self.corner.as_dvec3() + along_u + along_v).as_vec3a();
        self.found(p, position, |distance2, cos| {
            self.of_angle(&seen, distance2, cos)
        })
    }

    #[cold]
    fn pdf_near(&self, p: Vec3, distance2: f32, cos: f32) -> Option<PdfSolidAngle> {
        self.of_angle(&self.seen_from(p)?, distance2, cos)
    }

    fn seen_from(&self, p: Vec3) -> Option<SphericalRectangle> {
        let corner = self.corner.as_dvec3() - p.as_dvec3();
        SphericalRectangle::new(corner, self.axes, self.lengths)
    }

    fn of_angle(
        &self,
        seen: &SphericalRectangle,
        distance2: f32,
        cos: f32,
    ) -> Option<PdfSolidAngle> {
        if seen.solid_angle() >= spherical_rectangle::SMALLEST {
            Some(PdfSolidAngle((1.0 / seen.solid_angle()) as f32))
        } else {
            self.per_steradian(1.0, distance2, cos)
        }
    }

    #[inline]
    fn surface(&self, p: Vec3) -> SurfacePoint {
        SurfacePoint {
            p,
            error: self.error,
            ng: self.normal,
            ns: self.normal,
        }
    }

    /// The sample at `position`, whose density is a function of its squared distance and its cosine.
    #[inline]
    fn found(
        &self,
        p: Vec3,
        position: Vec3,
        density: impl FnOnce(f32, f32) -> Option<PdfSolidAngle>,
    ) -> Option<LightSample> {
        let towards = position - p;
        let wi = towards.normalize();
        let cos = -wi.dot(self.normal);
        let point = self.surface(position);
        Some(LightSample {
            wi,
            radiance: self.emission.towards(cos),
            pdf: Some(density(towards.length_squared(), cos)?),
            end: LightEnd::Surface(point, [0.0; 2]),
        })
    }
}
