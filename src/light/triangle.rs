//! A triangle light, sampled by area for far receivers and by solid angle for near ones.
//!
//! Measure: densities per steradian.
//! Range: any receiver off the triangle's plane. Beyond [`FAR`] radii, and on the side that does not emit, the point is
//! sampled by area; nearer by solid angle, in single precision where [`ClearTriangle`] allows it, else in double; and by
//! area again below [`spherical_triangle::MIN_SOLID_ANGLE`].
//! Source: `sampling/clear_triangle.rs`, `sampling/spherical_triangle.rs`. Tested in `tests/lights/light.rs`
//! and `tests/lights/lanes.rs`.

use super::lanes::{LaneSample, LightContextLanes, LightSampleLanes, ShadowRayEndKind};
use super::types::{Emission, LightSample, ShadowRayEnd};
use crate::geometry::mesh::{greatest_error, triangle_point};
use crate::geometry::surface::SurfacePoint;
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3, load, store, vectorised};
use crate::math::measure::{PdfArea, PdfSolidAngle};
use crate::math::vec::{DVec3, LaneVec3, Vec2, Vec3};
use crate::sampling::clear_triangle::ClearTriangle;
use crate::sampling::{spherical_triangle, warp};

/// The distance of the centroid, in radii, beyond which points are sampled by area.
///
/// Solid angle sampling removes the variance of 1 / r^3 over the triangle. Along any axis the variance of position is at
/// most 1/8 of the squared radius, so that the variance of 1 / r^3 is below 9/8 (radius / distance)^2 of the squared mean
/// to first order: 1.2 % for a triangle seen along its plane, zero for one seen from the front.
pub const FAR: f32 = 10.0;

/// An emitting triangle.
#[derive(Debug, Clone, Copy)]
pub struct TriangleLight {
    triangle: Triangle,
    emission: Emission,
}

/// The parameters of a light for sampling in single precision.
#[derive(Debug, Clone, Copy)]
struct Triangle {
    vertices: [LaneVec3; 3],
    normal: LaneVec3,
    /// Bound of the rounding error of every point.
    error: LaneVec3,
    emission: Emission<LaneVec3>,
    area: f32,
    /// The squared distance of [`FAR`] radii.
    far2: f32,
    /// The cross product of the edges from the first vertex.
    cross: DVec3,
}

/// The sampling method for a receiver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Method {
    /// Sampling by area: the receiver is behind the triangle or far away.
    Area,
    /// Sampling by solid angle, in single precision.
    Clear,
    /// Sampling by solid angle, in double precision.
    Skew,
}

impl TriangleLight {
    /// Creates a light from the vertices of a triangle.
    pub fn new(vertices: [Vec3; 3], emission: Emission) -> Self {
        let [a, b, c] = vertices.map(|v| v.as_dvec3());
        let cross = (b - a).cross(c - a);
        let centroid = (a + b + c) / 3.0;
        let distances2 = [a, b, c].map(|v| v.distance_squared(centroid));
        let radius2 = distances2.into_iter().fold(0.0, f64::max) as f32;
        let triangle = Triangle {
            vertices: vertices.map(LaneVec3::from),
            normal: triangle_point(vertices, [0.0; 2]).ng.into(),
            error: greatest_error(vertices).into(),
            emission: emission.in_lanes(),
            area: (0.5 * cross.length()) as f32,
            far2: FAR * FAR * radius2,
            cross,
        };
        Self { triangle, emission }
    }

    /// The vertices.
    pub fn vertices(&self) -> [Vec3; 3] {
        self.triangle.vertices.map(Vec3::from)
    }

    /// The unit normal of the side that emits.
    pub fn normal(&self) -> Vec3 {
        self.triangle.normal.into()
    }

    /// Radiant power in normalised units.
    pub fn power(&self) -> f64 {
        self.emission.power(f64::from(self.triangle.area))
    }

    /// The emission of the surface.
    pub fn emission(&self) -> Emission {
        self.emission
    }

    /// Samples a point uniformly by area; returns it with its barycentric coordinates.
    pub fn point(&self, u: Vec2) -> (SurfacePoint, [f32; 2]) {
        let b = warp::sample_triangle_uniform(u).to_array();
        (self.surface(self.triangle.at(b).into()), b)
    }

    /// The density of [`point`](Self::point).
    #[inline]
    pub fn pdf_area(&self) -> PdfArea {
        self.triangle.pdf_area()
    }

    /// Samples a point on the light for the receiver `p`.
    #[inline]
    pub fn sample(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let (method, clear) = self.triangle.method(p.into());
        match method {
            Method::Area => self.sample_by_area(p, u),
            Method::Clear => {
                let pdf = 1.0 / clear.solid_angle();
                self.light_sample(p, clear.sample(u), |_, _| pdf)
            }
            Method::Skew => self.sample_skew(p, u),
        }
    }

    /// The density of [`sample`](Self::sample) for the receiver `p` at the point at squared distance `distance2` whose
    /// normal has cosine `cos` with the direction to the receiver.
    #[inline]
    pub fn pdf(&self, p: Vec3, distance2: f32, cos: f32) -> Option<PdfSolidAngle> {
        let (method, clear) = self.triangle.method(p.into());
        match method {
            Method::Area => self.pdf_area().to_solid_angle(distance2, cos),
            Method::Clear => Some(PdfSolidAngle(1.0 / clear.solid_angle())),
            Method::Skew => self.pdf_skew(p, distance2, cos),
        }
    }

    /// Samples a point uniformly by area, for the receiver `p`.
    #[inline]
    pub fn sample_by_area(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let b = warp::sample_triangle_uniform(u).to_array();
        self.light_sample(p, b, |distance2, cos| self.triangle.by_area(distance2, cos))
    }

    /// Samples by solid angle in double precision: the triangle is large, or seen from near its plane.
    #[cold]
    fn sample_skew(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let vertices = self.vertices_from(p);
        let omega = spherical_triangle::solid_angle(vertices);
        if omega < spherical_triangle::MIN_SOLID_ANGLE {
            return self.sample_by_area(p, u);
        }
        let b = spherical_triangle::sample(vertices, omega, u).map_or_else(
            || warp::sample_triangle_uniform(u).to_array(),
            |b| b.map(|b| b as f32),
        );
        self.light_sample(p, b, |_, _| (1.0 / omega) as f32)
    }

    #[cold]
    fn pdf_skew(&self, p: Vec3, distance2: f32, cos: f32) -> Option<PdfSolidAngle> {
        let omega = spherical_triangle::solid_angle(self.vertices_from(p));
        if omega < spherical_triangle::MIN_SOLID_ANGLE {
            return self.pdf_area().to_solid_angle(distance2, cos);
        }
        Some(PdfSolidAngle((1.0 / omega) as f32))
    }

    fn vertices_from(&self, p: Vec3) -> [DVec3; 3] {
        let vertices = self.triangle.vertices;
        vertices.map(|v| v.as_dvec3() - p.as_dvec3())
    }

    #[inline]
    fn surface(&self, p: Vec3) -> SurfacePoint {
        let normal = self.triangle.normal.into();
        SurfacePoint {
            p,
            error: self.triangle.error.into(),
            ng: normal,
            ns: normal,
        }
    }

    /// Builds the sample at the barycentric coordinates `b`, if its density is finite: a function of squared distance and
    /// cosine.
    #[inline]
    fn light_sample(
        &self,
        p: Vec3,
        b: [f32; 2],
        density: impl FnOnce(f32, f32) -> f32,
    ) -> Option<LightSample> {
        let point = self.triangle.point(p.into(), b, density);
        point.pdf.is_finite().then(|| LightSample {
            wi: point.wi.into(),
            radiance: self.emission.towards(point.cos),
            pdf: Some(PdfSolidAngle(point.pdf)),
            end: ShadowRayEnd::Surface(self.surface(point.position.into()), b),
        })
    }
}

/// A sampled point on the light for a receiver.
struct TrianglePoint {
    position: LaneVec3,
    /// Unit vector towards it.
    wi: LaneVec3,
    /// Cosine between the light's normal and the direction to the receiver.
    cos: f32,
    /// Density per steradian; not finite where there is no sample.
    pdf: f32,
}

impl Triangle {
    /// The sampling method for the receiver `p`, and the triangle seen from there, which is meaningful if it is clear. Both
    /// depend on `p` alone, so that sampling and [`TriangleLight::pdf`] use the same density. Free of branches.
    #[inline(always)]
    fn method(&self, p: LaneVec3) -> (Method, ClearTriangle) {
        let [a, b, c] = self.vertices.map(|v| v - p);
        let centroid = (a + b + c) * (1.0 / 3.0);
        let is_behind = self.emission.is_dark_behind() & (a.dot(self.normal) > 0.0);
        // |a . (ab x ac)|, in double precision to avoid cancellation near the plane.
        let triple = (self.vertices[0].as_dvec3() - p.as_dvec3()).dot(self.cross);
        let triple = triple.abs() as f32;
        let (triangle, is_clear) =
            ClearTriangle::and_whether_clear([a, b, c], triple, 2.0 * self.area);
        let method = if is_behind | (centroid.length_squared() >= self.far2) {
            Method::Area
        } else if is_clear {
            Method::Clear
        } else {
            Method::Skew
        };
        (method, triangle)
    }

    fn pdf_area(&self) -> PdfArea {
        PdfArea(1.0 / self.area)
    }

    /// The density per steradian of sampling by area; infinite for a triangle seen edge-on.
    #[inline(always)]
    fn by_area(&self, distance2: f32, cos: f32) -> f32 {
        let pdf = self.pdf_area().to_solid_angle(distance2, cos);
        pdf.map_or(f32::INFINITY, |pdf| pdf.0)
    }

    /// The point at the barycentric coordinates.
    #[inline(always)]
    fn at(&self, [u, v]: [f32; 2]) -> LaneVec3 {
        let [a, b, c] = self.vertices;
        (1.0 - u - v) * a + u * b + v * c
    }

    /// Builds the sampled point at barycentric coordinates; its density is a function of squared distance and cosine.
    #[inline(always)]
    fn point(
        &self,
        p: LaneVec3,
        b: [f32; 2],
        density: impl FnOnce(f32, f32) -> f32,
    ) -> TrianglePoint {
        let position = self.at(b);
        let towards = position - p;
        let distance2 = towards.length_squared();
        let wi = towards * (1.0 / distance2.sqrt());
        let cos = -wi.dot(self.normal);
        TrianglePoint {
            position,
            wi,
            cos,
            pdf: density(distance2, cos),
        }
    }
}

/// A triangle light for each lane.
#[repr(align(64))]
#[derive(Debug)]
pub struct TriangleLightLanes {
    vectors: [Lanes3; 6],
    area: Lanes<f32>,
    far2: Lanes<f32>,
    two_sided: Lanes<u32>,
    cross: [Lanes<f64>; 3],
}

impl Default for TriangleLightLanes {
    fn default() -> Self {
        Self {
            vectors: [[[0.0; LANES]; 3]; 6],
            area: [0.0; LANES],
            far2: [0.0; LANES],
            two_sided: [0; LANES],
            cross: [[0.0; LANES]; 3],
        }
    }
}

impl TriangleLightLanes {
    /// Sets the light of a lane.
    #[inline]
    pub fn set(&mut self, lane: usize, light: &TriangleLight) {
        let it = &light.triangle;
        let ([a, b, c], radiance) = (it.vertices, it.emission.radiance.into());
        let vectors = [a, b, c, it.normal, it.error, LaneVec3::from_array(radiance)];
        for (to, vector) in self.vectors.iter_mut().zip(vectors) {
            store(to, lane, vector);
        }
        (self.area[lane], self.far2[lane]) = (it.area, it.far2);
        self.two_sided[lane] = u32::from(it.emission.two_sided);
        for (to, number) in self.cross.iter_mut().zip(it.cross.to_array()) {
            to[lane] = number;
        }
    }

    /// The triangle of a lane.
    #[inline(always)]
    fn get(&self, lane: usize) -> Triangle {
        let [a, b, c, normal, error, radiance] = &self.vectors;
        let [x, y, z] = &self.cross;
        Triangle {
            vertices: [load(a, lane), load(b, lane), load(c, lane)],
            normal: load(normal, lane),
            error: load(error, lane),
            emission: Emission {
                radiance: load(radiance, lane),
                two_sided: self.two_sided[lane] != 0,
            },
            area: self.area[lane],
            far2: self.far2[lane],
            cross: DVec3::new(x[lane], y[lane], z[lane]),
        }
    }
}

vectorised! {
    /// Samples a point on the light of each lane of `mask` for the receiver `p`. Returns the lanes whose triangle is large or
    /// seen from near its plane, so that [`TriangleLight::sample`] has to do it.
    pub fn sample_lanes(
        lights: &TriangleLightLanes,
        mask: &ActiveLanes<LANES>,
        context: &LightContextLanes,
        p: &Lanes3,
        samples: &mut LightSampleLanes,
    ) -> ActiveLanes<LANES> {
        let mut skew = ActiveLanes::NONE;
        for lane in 0..LANES {
            let light = lights.get(lane);
            let p: LaneVec3 = load(p, lane);
            let u = Vec2::new(context.u[0][lane], context.u[1][lane]);
            let (method, clear) = light.method(p);
            let is_by_area = method == Method::Area;
            let b = if is_by_area {
                warp::sample_triangle_uniform(u).to_array()
            } else {
                clear.sample(u)
            };
            let by_angle = 1.0 / clear.solid_angle();
            let TrianglePoint { position, wi, cos, pdf } = light.point(p, b, |distance2, cos| {
                if is_by_area { light.by_area(distance2, cos) } else { by_angle }
            });
            let is_in_mask = mask.has(lane);
            skew.set(lane, (method == Method::Skew) & is_in_mask);
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
        skew
    }
}
