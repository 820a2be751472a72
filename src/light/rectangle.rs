//! A rectangle light, sampled by solid angle for near receivers and approximately so for farther ones.
//!
//! Measure: densities per steradian.
//! Range: edges at right angles (others are two triangles); any receiver off the plane. Beyond [`CLEAR`] radii the point is
//! sampled with a density per area that is linear along each edge, beyond [`FAR`] radii and on the side that does not emit
//! by area, and else by solid angle, or by area again below [`spherical_rectangle::SMALLEST`].
//! Source: `sampling/linear.rs`, `sampling/spherical_rectangle.rs`. Tested in `tests/lights/light.rs`
//! and `tests/lights/lanes.rs`.

use super::types::{Emission, LightSample, LightSampleContext, ShadowRayEnd};
use crate::geometry::surface::SurfacePoint;
use crate::math::lanes::{LANES, Lanes, each_lane, vectorised};
use crate::math::measure::{PdfArea, PdfSolidAngle};
use crate::math::robust::{gamma, never_zero};
use crate::math::vec::{DVec3, LaneVec3, Vec2, Vec3};
use crate::sampling::linear::LinearSquare;
use crate::sampling::spherical_rectangle::{self, SphericalRectangle};

/// The distance of the centre, in radii (half diagonals), beyond which points are sampled with a density linear along
/// each edge.
///
/// A uniform density of directions is a density of points in proportion to 1 / r^3. The error of the linear density adds
/// a variance of 1.2 % of the squared mean here, averaged over directions of view and shapes, less than 0.2 % at 4 radii
/// and 0.005 % at 10. Sampling by area would add 17 %, 6 % and 1 %. Tested in `tests/lights/light.rs`.
pub const CLEAR: f32 = 2.5;

/// The distance, in radii, beyond which points are sampled by area, which adds a variance of 0.01 % on average.
pub const FAR: f32 = 100.0;

/// An emitting rectangle.
#[derive(Debug, Clone, Copy)]
pub struct RectangleLight {
    corner: LaneVec3,
    edges: [LaneVec3; 2],
    normal: LaneVec3,
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

/// The sampling method for a receiver.
struct Choice {
    /// Whether to sample by solid angle; else with the density.
    is_near: bool,
    /// Density in fractions of the edges.
    density: LinearSquare,
}

/// A sampled point on the light for a receiver.
struct RectanglePoint {
    position: LaneVec3,
    /// Unit vector towards it.
    wi: LaneVec3,
    /// Cosine between the light's normal and the direction to the receiver.
    cos: f32,
    /// Density per steradian; not finite where there is no sample.
    pdf: f32,
}

impl RectangleLight {
    /// Creates a light at `corner` along two edges at right angles; its normal is edge_u x edge_v.
    pub fn new(corner: Vec3, edges: [Vec3; 2], emission: Emission) -> Self {
        let [u, v] = edges.map(|e| e.as_dvec3());
        // The edges of rounded vertices are not exactly at right angles; the sampling frame is.
        let x = u.normalize();
        let normal = u.cross(v).normalize();
        let y = normal.cross(x);
        let lengths = [u.length(), v.length()];
        let rounding = gamma(9) * (corner.abs() + edges[0].abs() + edges[1].abs());
        let lengths2 = lengths.map(|length| length * length);
        let radius2 = 0.25 * (lengths2[0] + lengths2[1]);
        Self {
            corner: corner.into(),
            edges: edges.map(LaneVec3::from),
            normal: normal.as_vec3(),
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

    /// The emission of the surface.
    pub fn emission(&self) -> Emission {
        self.emission
    }

    /// Samples a point uniformly by area.
    pub fn point(&self, u: Vec2) -> SurfacePoint {
        self.surface(self.at(u).into())
    }

    /// The density of [`point`](Self::point).
    pub fn pdf_area(&self) -> PdfArea {
        PdfArea(self.pdf_area)
    }

    /// Samples a point on the light for the receiver `p`.
    #[inline]
    pub fn sample(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let choice = self.choice(self.corner - LaneVec3::from(p));
        if choice.is_near {
            return self.sample_near(p, u);
        }
        self.told(&self.find(p.into(), choice.density, u))
    }

    /// Samples a point on the light for each context, and appends the samples in order.
    ///
    /// # Panics
    ///
    /// If there are more than [`LANES`] contexts.
    #[inline]
    pub fn sample_each(
        &self,
        questions: &[LightSampleContext],
        samples: &mut Vec<Option<LightSample>>,
    ) {
        let mut asked = [[0.0; LANES]; 5];
        for (lane, LightSampleContext { p, u, .. }) in questions.iter().enumerate() {
            let numbers = [p.x, p.y, p.z, u.x, u.y];
            for (asked, number) in asked.iter_mut().zip(numbers) {
                asked[lane] = number;
            }
        }
        let mut found = [[0.0; LANES]; 9];
        find_lanes(self, &asked, &mut found);
        for (lane, LightSampleContext { p, u, .. }) in questions.iter().enumerate() {
            let [x, y, z, wi_x, wi_y, wi_z, cos, pdf, is_near] =
                found.each_ref().map(|of| of[lane]);
            if is_near > 0.0 {
                samples.push(self.sample_near(*p, *u));
            } else {
                let (position, wi) = (Vec3::new(x, y, z), Vec3::new(wi_x, wi_y, wi_z));
                samples.push(self.sample_at(position, wi, cos, pdf));
            }
        }
    }

    /// Samples a point uniformly by area.
    pub fn sample_by_area(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        self.told(&self.find(p.into(), LinearSquare::UNIFORM, u))
    }

    /// Samples a point for the receiver `p` with a density in fractions of the edges. Free of branches.
    #[inline(always)]
    fn find(&self, p: LaneVec3, density: LinearSquare, u: Vec2) -> RectanglePoint {
        let at = density.sample(u);
        let position = self.at(at);
        self.found(p, position, |distance2, cos| {
            self.per_steradian(density.pdf(at), distance2, cos)
        })
    }

    /// The point at the given fractions of the edges.
    #[inline(always)]
    fn at(&self, shares: Vec2) -> LaneVec3 {
        self.corner + shares.x * self.edges[0] + shares.y * self.edges[1]
    }

    /// The density of [`sample`](Self::sample) for the receiver `p` at the point at `towards` from it whose normal has
    /// cosine `cos` with the direction to the receiver.
    #[inline]
    pub fn pdf(&self, p: Vec3, towards: Vec3, cos: f32) -> Option<PdfSolidAngle> {
        let distance2 = towards.length_squared();
        let corner = self.corner - LaneVec3::from(p);
        let choice = self.choice(corner);
        if choice.is_near {
            return self.pdf_near(p, distance2, cos);
        }
        let from_corner = LaneVec3::from(towards) - corner;
        let along = Vec2::new(
            from_corner.dot(self.edges[0]),
            from_corner.dot(self.edges[1]),
        );
        let pdf = self.per_steradian(choice.density.pdf(self.over_edges2 * along), distance2, cos);
        pdf.is_finite().then_some(PdfSolidAngle(pdf))
    }

    /// The sampling method for a receiver, given the corner relative to it. It depends on nothing else, so that
    /// [`sample`](Self::sample) and [`pdf`](Self::pdf) use the same density. Free of branches.
    #[inline(always)]
    fn choice(&self, corner: LaneVec3) -> Choice {
        let is_behind = self.emission.is_dark_behind() & (corner.dot(self.normal) > 0.0);
        let center = corner + 0.5 * (self.edges[0] + self.edges[1]);
        let distance2 = self.over_radius2 * center.length_squared();
        let is_uniform = is_behind | (distance2 > FAR * FAR);
        // 1 / r^3 at the midpoint of each edge, from r^2 = |center|^2 + |edge|^2 / 4 +- center . edge.
        let along =
            self.over_radius2 * Vec2::new(center.dot(self.edges[0]), center.dot(self.edges[1]));
        let far = self.half_edges2 + Vec2::splat(distance2);
        let weight = |r2: f32| {
            let over_r2 = 1.0 / r2;
            if is_uniform {
                1.0
            } else {
                over_r2 * over_r2.sqrt()
            }
        };
        let weights = |r2: Vec2| Vec2::new(weight(r2.x), weight(r2.y));
        Choice {
            is_near: !is_behind & (distance2 < CLEAR * CLEAR),
            density: LinearSquare::new(weights(far - along), weights(far + along)),
        }
    }

    /// Converts a density in fractions of the edges to one per steradian; infinite for a rectangle seen edge-on.
    #[inline(always)]
    fn per_steradian(&self, of_shares: f32, distance2: f32, cos: f32) -> f32 {
        let pdf = PdfArea(of_shares * self.pdf_area).to_solid_angle(distance2, cos);
        pdf.map_or(f32::INFINITY, |pdf| pdf.0)
    }

    #[cold]
    fn sample_near(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let seen = self.seen_from(p)?;
        let s = if seen.solid_angle() >= spherical_rectangle::SMALLEST {
            seen.sample(u)
        } else {
            u.to_array().map(f64::from)
        };
        // In double precision: on a huge rectangle, single-precision fractions are too coarse for a near receiver.
        let [along_u, along_v] = [0, 1].map(|i| s[i] * self.edges[i].as_dvec3());
        let position = (self.corner.as_dvec3() + along_u + along_v).as_vec3();
        self.told(&self.found(p.into(), position, |distance2, cos| {
            self.of_angle(&seen, distance2, cos)
        }))
    }

    #[cold]
    fn pdf_near(&self, p: Vec3, distance2: f32, cos: f32) -> Option<PdfSolidAngle> {
        let pdf = self.of_angle(&self.seen_from(p)?, distance2, cos);
        pdf.is_finite().then_some(PdfSolidAngle(pdf))
    }

    fn seen_from(&self, p: Vec3) -> Option<SphericalRectangle> {
        let corner = self.corner.as_dvec3() - p.as_dvec3();
        SphericalRectangle::new(corner, self.axes, self.lengths)
    }

    fn of_angle(&self, seen: &SphericalRectangle, distance2: f32, cos: f32) -> f32 {
        if seen.solid_angle() >= spherical_rectangle::SMALLEST {
            (1.0 / seen.solid_angle()) as f32
        } else {
            self.per_steradian(1.0, distance2, cos)
        }
    }

    /// Builds the sampled point at `position`; its density is a function of squared distance and cosine.
    #[inline(always)]
    fn found(
        &self,
        p: LaneVec3,
        position: LaneVec3,
        density: impl FnOnce(f32, f32) -> f32,
    ) -> RectanglePoint {
        let towards = position - p;
        let distance2 = towards.length_squared();
        let wi = towards * (1.0 / distance2.sqrt());
        let cos = -wi.dot(self.normal);
        RectanglePoint {
            position,
            wi,
            cos,
            pdf: density(distance2, cos),
        }
    }

    #[inline]
    fn told(&self, found: &RectanglePoint) -> Option<LightSample> {
        self.sample_at(found.position.into(), found.wi.into(), found.cos, found.pdf)
    }

    /// Builds the sample, if its density is finite.
    #[inline(always)]
    fn sample_at(&self, position: Vec3, wi: Vec3, cos: f32, pdf: f32) -> Option<LightSample> {
        pdf.is_finite().then(|| LightSample {
            wi,
            radiance: self.emission.towards(cos),
            pdf: Some(PdfSolidAngle(pdf)),
            end: ShadowRayEnd::Surface(self.surface(position), [0.0; 2]),
        })
    }

    #[inline]
    fn surface(&self, p: Vec3) -> SurfacePoint {
        SurfacePoint {
            p,
            error: self.error,
            ng: self.normal.into(),
            ns: self.normal.into(),
        }
    }
}

vectorised! {
    /// [`RectangleLight::find`] for each lane, from a receiver and two random numbers. The last result is 1 where the point
    /// is to be sampled by solid angle instead, else 0.
    fn find_lanes(light: &RectangleLight, asked: &[Lanes<f32>; 5], found: &mut [Lanes<f32>; 9]) {
        each_lane(asked, found, |[x, y, z, u, v]| {
            let p = LaneVec3::new(x, y, z);
            let Choice { is_near, density } = light.choice(light.corner - p);
            let RectanglePoint { position, wi, cos, pdf } = light.find(p, density, Vec2::new(u, v));
            let is_near = if is_near { 1.0 } else { 0.0 };
            [position.x, position.y, position.z, wi.x, wi.y, wi.z, cos, pdf, is_near]
        });
    }
}
