//! A triangle light, sampled by area for far receivers and by solid angle for near ones.
//!
//! Measure: densities per steradian.
//! Range: any receiver off the triangle's plane. Beyond [`FAR`] radii, and on the side that does not emit, the point is
//! sampled by area; nearer by solid angle, in single precision where [`ClearTriangle`] allows it, else in double; and by
//! area again below [`spherical_triangle::SMALLEST`].
//! Source: `sampling/clear_triangle.rs`, `sampling/spherical_triangle.rs`. Tested in `tests/lights/light.rs`
//! and `tests/lights/lanes.rs`.

use super::types::{Emission, LightSample, LightSampleContext, ShadowRayEnd};
use crate::geometry::mesh::{greatest_error, triangle_point};
use crate::geometry::surface::SurfacePoint;
use crate::math::lanes::{LANES, Lanes, each_lane, vectorised};
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
    vertices: [Vec3; 3],
    normal: Vec3,
    emission: Emission,
    area: f32,
    /// The squared distance of [`FAR`] radii.
    far2: f32,
    /// The cross product of the edges from the first vertex.
    cross: DVec3,
    /// Bound of the rounding error of every point.
    error: Vec3,
}

/// The sampling method for a receiver, where single precision suffices.
enum ReceiverFrame {
    /// By area: the receiver is behind the triangle or far away.
    ByArea,
    /// By solid angle, in single precision.
    Clear(ClearTriangle),
}

impl TriangleLight {
    /// Creates a light from the vertices of a triangle.
    pub fn new(vertices: [Vec3; 3], emission: Emission) -> Self {
        let [a, b, c] = vertices.map(|v| v.as_dvec3());
        let cross = (b - a).cross(c - a);
        let centroid = (a + b + c) / 3.0;
        let distances2 = [a, b, c].map(|v| v.distance_squared(centroid));
        let radius2 = distances2.into_iter().fold(0.0, f64::max) as f32;
        Self {
            vertices,
            normal: triangle_point(vertices, [0.0; 2]).ng,
            emission,
            area: (0.5 * cross.length()) as f32,
            far2: FAR * FAR * radius2,
            cross,
            error: greatest_error(vertices),
        }
    }

    /// Radiant power in normalised units.
    pub fn power(&self) -> f64 {
        self.emission.power(f64::from(self.area))
    }

    /// The emission of the surface.
    pub fn emission(&self) -> Emission {
        self.emission
    }

    /// Samples a point uniformly by area; returns it with its barycentric coordinates.
    pub fn point(&self, u: Vec2) -> (SurfacePoint, [f32; 2]) {
        let b = warp::sample_triangle_uniform(u).to_array();
        (self.surface(b), b)
    }

    /// The density of [`point`](Self::point).
    #[inline]
    pub fn pdf_area(&self) -> PdfArea {
        PdfArea(1.0 / self.area)
    }

    /// Samples a point on the light for the receiver `p`.
    #[inline]
    pub fn sample(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        match self.view(p) {
            Some(ReceiverFrame::ByArea) => self.sample_by_area(p, u),
            Some(ReceiverFrame::Clear(triangle)) => {
                let pdf = PdfSolidAngle(1.0 / triangle.solid_angle());
                self.found(p, triangle.sample(u), |_, _| Some(pdf))
            }
            None => self.sample_skew(p, u),
        }
    }

    /// Samples a point for each context on the light of its lane, and appends the samples in order.
    ///
    /// # Panics
    ///
    /// If there are more than [`LANES`] contexts.
    #[inline]
    pub fn sample_each(
        lights: &Lanes<&Self>,
        questions: &[LightSampleContext],
        samples: &mut Vec<Option<LightSample>>,
    ) {
        let mut asked = [[0.0; LANES]; 13];
        let mut is_by_area = [false; LANES];
        for (lane, LightSampleContext { p, u, .. }) in questions.iter().enumerate() {
            let light = lights[lane];
            let seen = light.vertices.map(|v| v - *p);
            is_by_area[lane] = light.is_by_area(seen);
            let [a, b, c] = seen;
            let (triple, area) = (light.triple(*p), 2.0 * light.area);
            let numbers = [
                a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, triple, area, u.x, u.y,
            ];
            for (asked, number) in asked.iter_mut().zip(numbers) {
                asked[lane] = number;
            }
        }
        let mut found = [[0.0; LANES]; 4];
        find_lanes(&asked, &mut found);
        for (lane, question) in questions.iter().enumerate() {
            let LightSampleContext { p, u, .. } = *question;
            let light = lights[lane];
            let [b1, b2, pdf, is_clear] = found.each_ref().map(|of| of[lane]);
            if is_by_area[lane] {
                samples.push(light.sample_by_area(p, u));
            } else if is_clear > 0.0 {
                samples.push(light.found(p, [b1, b2], |_, _| Some(PdfSolidAngle(pdf))));
            } else {
                samples.push(light.sample_skew(p, u));
            }
        }
    }

    /// The density of [`sample`](Self::sample) for the receiver `p` at the point at squared distance `distance2` whose
    /// normal has cosine `cos` with the direction to the receiver.
    #[inline]
    pub fn pdf(&self, p: Vec3, distance2: f32, cos: f32) -> Option<PdfSolidAngle> {
        match self.view(p) {
            Some(ReceiverFrame::ByArea) => self.pdf_by_area(distance2, cos),
            Some(ReceiverFrame::Clear(triangle)) => {
                Some(PdfSolidAngle(1.0 / triangle.solid_angle()))
            }
            None => self.pdf_skew(p, distance2, cos),
        }
    }

    /// The sampling method for the receiver `p`; `None` where double precision is needed. It depends on `p` alone, so that
    /// [`sample`](Self::sample) and [`pdf`](Self::pdf) use the same density.
    #[inline]
    fn view(&self, p: Vec3) -> Option<ReceiverFrame> {
        let seen = self.vertices.map(|v| v - p);
        if self.is_by_area(seen) {
            return Some(ReceiverFrame::ByArea);
        }
        let vertices = seen.map(LaneVec3::from);
        ClearTriangle::new(vertices, self.triple(p), 2.0 * self.area).map(ReceiverFrame::Clear)
    }

    /// Whether the receiver is behind the triangle or far away, given the vertices relative to the receiver.
    #[inline]
    fn is_by_area(&self, [a, b, c]: [Vec3; 3]) -> bool {
        let centroid = (a + b + c) * (1.0 / 3.0);
        let is_behind = self.emission.is_dark_behind() && a.dot(self.normal) > 0.0;
        is_behind || centroid.length_squared() >= self.far2
    }

    /// |a . (ab x ac)| with vertices relative to `p`.
    #[inline]
    fn triple(&self, p: Vec3) -> f32 {
        // In double precision, to avoid cancellation near the plane.
        let triple = (self.vertices[0].as_dvec3() - p.as_dvec3()).dot(self.cross);
        triple.abs() as f32
    }

    /// Samples a point uniformly by area, for the receiver `p`.
    #[inline]
    pub fn sample_by_area(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let b = warp::sample_triangle_uniform(u).to_array();
        self.found(p, b, |distance2, cos| self.pdf_by_area(distance2, cos))
    }

    #[inline]
    fn pdf_by_area(&self, distance2: f32, cos: f32) -> Option<PdfSolidAngle> {
        self.pdf_area().to_solid_angle(distance2, cos)
    }

    /// Samples by solid angle in double precision: the triangle is large, or seen from near its plane.
    #[cold]
    fn sample_skew(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let vertices = self.seen_from(p);
        let omega = spherical_triangle::solid_angle(vertices);
        if omega < spherical_triangle::SMALLEST {
            return self.sample_by_area(p, u);
        }
        let b = spherical_triangle::sample(vertices, omega, u).map_or_else(
            || warp::sample_triangle_uniform(u).to_array(),
            |b| b.map(|b| b as f32),
        );
        self.found(p, b, |_, _| Some(PdfSolidAngle((1.0 / omega) as f32)))
    }

    #[cold]
    fn pdf_skew(&self, p: Vec3, distance2: f32, cos: f32) -> Option<PdfSolidAngle> {
        let omega = spherical_triangle::solid_angle(self.seen_from(p));
        if omega < spherical_triangle::SMALLEST {
            return self.pdf_by_area(distance2, cos);
        }
        Some(PdfSolidAngle((1.0 / omega) as f32))
    }

    fn seen_from(&self, p: Vec3) -> [DVec3; 3] {
        self.vertices.map(|v| v.as_dvec3() - p.as_dvec3())
    }

    /// The point at the barycentric coordinates `b`.
    #[inline]
    fn surface(&self, b: [f32; 2]) -> SurfacePoint {
        let [u, v] = b;
        let [a, b, c] = self.vertices;
        SurfacePoint {
            p: (1.0 - u - v) * a + u * b + v * c,
            error: self.error,
            ng: self.normal,
            ns: self.normal,
        }
    }

    /// Builds the sample at the barycentric coordinates `b`; its density is a function of squared distance and cosine.
    #[inline]
    fn found(
        &self,
        p: Vec3,
        b: [f32; 2],
        density: impl FnOnce(f32, f32) -> Option<PdfSolidAngle>,
    ) -> Option<LightSample> {
        let point = self.surface(b);
        let towards = point.p - p;
        let wi = towards.normalize();
        let cos = -wi.dot(self.normal);
        Some(LightSample {
            wi,
            radiance: self.emission.towards(cos),
            pdf: Some(density(towards.length_squared(), cos)?),
            end: ShadowRayEnd::Surface(point, b),
        })
    }
}

vectorised! {
    /// Samples barycentric coordinates for each lane; returns them with the density, and 1 if the triangle is clear, else 0.
    /// The inputs are the vertices relative to the receiver, the triple product, twice the area and two random numbers.
    fn find_lanes(asked: &[Lanes<f32>; 13], found: &mut [Lanes<f32>; 4]) {
        each_lane(asked, found, |[a_x, a_y, a_z, b_x, b_y, b_z, c_x, c_y, c_z, triple, area, u, v]| {
            let (a, b) = (LaneVec3::new(a_x, a_y, a_z), LaneVec3::new(b_x, b_y, b_z));
            let vertices = [a, b, LaneVec3::new(c_x, c_y, c_z)];
            let (triangle, is_clear) = ClearTriangle::and_whether_clear(vertices, triple, area);
            let [b1, b2] = triangle.sample(Vec2::new(u, v));
            [b1, b2, 1.0 / triangle.solid_angle(), if is_clear { 1.0 } else { 0.0 }]
        });
    }
}
