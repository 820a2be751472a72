//! A rectangle light, sampled by solid angle for near receivers and approximately so for farther ones.
//!
//! Measure: densities per steradian.
//! Range: edges at right angles (others are two triangles); any receiver off the plane. Beyond [`CLEAR`] radii the point is
//! sampled with a density per area that is linear along each edge, beyond [`FAR`] radii and on the side that does not emit
//! by area, and else by solid angle, or by area again below [`spherical_rectangle::MIN_SOLID_ANGLE`].
//! Source: `sampling/linear.rs`, `sampling/spherical_rectangle.rs`. Tested in `tests/lights/light.rs`
//! and `tests/lights/lanes.rs`.

use super::lanes::{LaneSample, LightContextLanes, LightSampleLanes, ShadowRayEndKind};
use super::types::{Emission, LightSample, ShadowRayEnd};
use crate::geometry::surface::SurfacePoint;
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3, load, store, vectorised};
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
    rectangle: Rectangle,
    emission: Emission,
    /// One over the squared length of each edge.
    over_edges2: Vec2,
    /// Unit vectors along the edges.
    axes: [DVec3; 2],
    lengths: [f64; 2],
}

/// The parameters of a light for sampling in single precision.
#[derive(Debug, Clone, Copy)]
struct Rectangle {
    corner: LaneVec3,
    edges: [LaneVec3; 2],
    normal: LaneVec3,
    /// Bound of the rounding error of every point.
    error: LaneVec3,
    emission: Emission<LaneVec3>,
    over_radius2: f32,
    /// The squares of half the edges, in squared radii.
    half_edges2: Vec2,
    /// One over the area.
    pdf_area: f32,
}

/// The sampling method for a receiver.
struct RectangleSampling {
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
        let rectangle = Rectangle {
            corner: corner.into(),
            edges: edges.map(LaneVec3::from),
            normal: normal.as_vec3(),
            error: never_zero(rounding, lengths[0].max(lengths[1]) as f32).into(),
            emission: emission.in_lanes(),
            over_radius2: (1.0 / radius2) as f32,
            half_edges2: Vec2::from(lengths2.map(|length2| (0.25 * length2 / radius2) as f32)),
            pdf_area: (1.0 / (lengths[0] * lengths[1])) as f32,
        };
        Self {
            rectangle,
            emission,
            over_edges2: Vec2::from(lengths2.map(|length2| (1.0 / length2) as f32)),
            axes: [x, y],
            lengths,
        }
    }

    /// The corners.
    pub fn corners(&self) -> [Vec3; 4] {
        let at = |u, v| self.rectangle.at(Vec2::new(u, v)).into();
        [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0)]
    }

    /// The unit normal of the side that emits.
    pub fn normal(&self) -> Vec3 {
        self.rectangle.normal.into()
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
        self.surface(self.rectangle.at(u).into())
    }

    /// The density of [`point`](Self::point).
    pub fn pdf_area(&self) -> PdfArea {
        PdfArea(self.rectangle.pdf_area)
    }

    /// Samples a point on the light for the receiver `p`.
    #[inline]
    pub fn sample(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let sampling = self.rectangle.sampling_for(p.into());
        if sampling.is_near {
            return self.sample_near(p, u);
        }
        self.light_sample(&self.rectangle.sample(p.into(), sampling.density, u))
    }

    /// Samples a point uniformly by area, for the receiver `p`.
    pub fn sample_by_area(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        self.light_sample(&self.rectangle.sample(p.into(), LinearSquare::UNIFORM, u))
    }

    /// The density of [`sample`](Self::sample) for the receiver `p` at the point at `towards` from it whose normal has
    /// cosine `cos` with the direction to the receiver.
    #[inline]
    pub fn pdf(&self, p: Vec3, towards: Vec3, cos: f32) -> Option<PdfSolidAngle> {
        let distance2 = towards.length_squared();
        let rectangle = &self.rectangle;
        let sampling = rectangle.sampling_for(p.into());
        if sampling.is_near {
            return self.pdf_near(p, distance2, cos);
        }
        let from_corner = LaneVec3::from(towards) - (rectangle.corner - LaneVec3::from(p));
        let along = Vec2::from(rectangle.edges.map(|edge| from_corner.dot(edge)));
        let of_shares = sampling.density.pdf(self.over_edges2 * along);
        let pdf = rectangle.per_steradian(of_shares, distance2, cos);
        pdf.is_finite().then_some(PdfSolidAngle(pdf))
    }

    #[cold]
    fn sample_near(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let spherical = self.spherical_rectangle(p)?;
        let s = if spherical.solid_angle() >= spherical_rectangle::MIN_SOLID_ANGLE {
            spherical.sample(u)
        } else {
            u.to_array().map(f64::from)
        };
        // In double precision: on a huge rectangle, single-precision fractions are too coarse for a near receiver.
        let rectangle = &self.rectangle;
        let [along_u, along_v] = [0, 1].map(|i| s[i] * rectangle.edges[i].as_dvec3());
        let position = (rectangle.corner.as_dvec3() + along_u + along_v).as_vec3();
        let point = rectangle.point(p.into(), position, |distance2, cos| {
            self.of_angle(&spherical, distance2, cos)
        });
        self.light_sample(&point)
    }

    #[cold]
    fn pdf_near(&self, p: Vec3, distance2: f32, cos: f32) -> Option<PdfSolidAngle> {
        let pdf = self.of_angle(&self.spherical_rectangle(p)?, distance2, cos);
        pdf.is_finite().then_some(PdfSolidAngle(pdf))
    }

    fn spherical_rectangle(&self, p: Vec3) -> Option<SphericalRectangle> {
        let corner = self.rectangle.corner.as_dvec3() - p.as_dvec3();
        SphericalRectangle::new(corner, self.axes, self.lengths)
    }

    fn of_angle(&self, spherical: &SphericalRectangle, distance2: f32, cos: f32) -> f32 {
        if spherical.solid_angle() >= spherical_rectangle::MIN_SOLID_ANGLE {
            (1.0 / spherical.solid_angle()) as f32
        } else {
            self.rectangle.per_steradian(1.0, distance2, cos)
        }
    }

    /// Builds the sample of a point, if its density is finite.
    #[inline]
    fn light_sample(&self, point: &RectanglePoint) -> Option<LightSample> {
        point.pdf.is_finite().then(|| LightSample {
            wi: point.wi.into(),
            radiance: self.emission.towards(point.cos),
            pdf: Some(PdfSolidAngle(point.pdf)),
            end: ShadowRayEnd::Surface(self.surface(point.position.into()), [0.0; 2]),
        })
    }

    #[inline]
    fn surface(&self, p: Vec3) -> SurfacePoint {
        let normal = self.rectangle.normal.into();
        SurfacePoint {
            p,
            error: self.rectangle.error.into(),
            ng: normal,
            ns: normal,
        }
    }
}

impl Rectangle {
    /// The sampling method for the receiver `p`. It depends on nothing else, so that sampling and
    /// [`RectangleLight::pdf`] use the same density. Free of branches.
    #[inline(always)]
    fn sampling_for(&self, p: LaneVec3) -> RectangleSampling {
        let corner = self.corner - p;
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
        RectangleSampling {
            is_near: !is_behind & (distance2 < CLEAR * CLEAR),
            density: LinearSquare::new(weights(far - along), weights(far + along)),
        }
    }

    /// Samples a point for the receiver `p` with a density in fractions of the edges. Free of branches.
    #[inline(always)]
    fn sample(&self, p: LaneVec3, density: LinearSquare, u: Vec2) -> RectanglePoint {
        let at = density.sample(u);
        self.point(p, self.at(at), |distance2, cos| {
            self.per_steradian(density.pdf(at), distance2, cos)
        })
    }

    /// The point at the given fractions of the edges.
    #[inline(always)]
    fn at(&self, shares: Vec2) -> LaneVec3 {
        self.corner + shares.x * self.edges[0] + shares.y * self.edges[1]
    }

    /// Converts a density in fractions of the edges to one per steradian; infinite for a rectangle seen edge-on.
    #[inline(always)]
    fn per_steradian(&self, of_shares: f32, distance2: f32, cos: f32) -> f32 {
        let pdf = PdfArea(of_shares * self.pdf_area).to_solid_angle(distance2, cos);
        pdf.map_or(f32::INFINITY, |pdf| pdf.0)
    }

    /// Builds the sampled point at `position`; its density is a function of squared distance and cosine.
    #[inline(always)]
    fn point(
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
}

/// A rectangle light for each lane.
#[repr(align(64))]
#[derive(Debug)]
pub struct RectangleLanes {
    vectors: [Lanes3; 6],
    numbers: [Lanes<f32>; 4],
    two_sided: Lanes<u32>,
}

impl Default for RectangleLanes {
    fn default() -> Self {
        Self {
            vectors: [[[0.0; LANES]; 3]; 6],
            numbers: [[0.0; LANES]; 4],
            two_sided: [0; LANES],
        }
    }
}

impl RectangleLanes {
    /// Sets the light of a lane.
    #[inline]
    pub fn set(&mut self, lane: usize, light: &RectangleLight) {
        let it = &light.rectangle;
        let radiance = LaneVec3::from_array(it.emission.radiance.into());
        let vectors = [
            it.corner,
            it.edges[0],
            it.edges[1],
            it.normal,
            it.error,
            radiance,
        ];
        for (to, vector) in self.vectors.iter_mut().zip(vectors) {
            store(to, lane, vector);
        }
        let Vec2 { x, y } = it.half_edges2;
        for (to, number) in self
            .numbers
            .iter_mut()
            .zip([it.over_radius2, it.pdf_area, x, y])
        {
            to[lane] = number;
        }
        self.two_sided[lane] = u32::from(it.emission.two_sided);
    }

    /// The rectangle of a lane.
    #[inline(always)]
    fn get(&self, lane: usize) -> Rectangle {
        let [corner, edge_u, edge_v, normal, error, radiance] = &self.vectors;
        let [over_radius2, pdf_area, x, y] = &self.numbers;
        Rectangle {
            corner: load(corner, lane),
            edges: [load(edge_u, lane), load(edge_v, lane)],
            normal: load(normal, lane),
            error: load(error, lane),
            emission: Emission {
                radiance: load(radiance, lane),
                two_sided: self.two_sided[lane] != 0,
            },
            over_radius2: over_radius2[lane],
            half_edges2: Vec2::new(x[lane], y[lane]),
            pdf_area: pdf_area[lane],
        }
    }
}

vectorised! {
    /// Samples a point on the light of each lane of `mask` for the receiver `p`. Returns the lanes whose receiver is so near
    /// that [`RectangleLight::sample`] has to do it.
    pub fn sample_lanes(
        lights: &RectangleLanes,
        mask: &ActiveLanes<LANES>,
        context: &LightContextLanes,
        p: &Lanes3,
        samples: &mut LightSampleLanes,
    ) -> ActiveLanes<LANES> {
        let mut near = ActiveLanes::NONE;
        for lane in 0..LANES {
            let light = lights.get(lane);
            let p: LaneVec3 = load(p, lane);
            let RectangleSampling { is_near, density } = light.sampling_for(p);
            let u = Vec2::new(context.u[0][lane], context.u[1][lane]);
            let RectanglePoint { position, wi, cos, pdf } = light.sample(p, density, u);
            let is_in_mask = mask.has(lane);
            near.set(lane, is_near & is_in_mask);
            let sample = LaneSample {
                end: if pdf.is_finite() { ShadowRayEndKind::Surface } else { ShadowRayEndKind::None },
                wi,
                radiance: light.emission.towards(cos),
                pdf: context.pmf[lane] * pdf,
                p: position,
                error: light.error,
                normal: light.normal,
            };
            samples.set_if(is_in_mask, lane, &sample);
        }
        near
    }
}
