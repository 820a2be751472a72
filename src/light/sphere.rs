//! A sphere light, sampled uniformly in the cone of directions that it subtends.
//!
//! Measure: densities per steradian.
//! Range: receivers outside at any distance; for receivers inside the whole sphere of directions is sampled.
//! Source: Pharr, Jakob, Humphreys, "Sampling Spheres"; 1 - cos = s^2 / (1 + sqrt(1 - s^2)) does not cancel for small
//! cones. Tested in `tests/lights/light.rs` and `tests/lights/lanes.rs`.

use super::lanes::{LaneSample, LightContextLanes, LightSampleLanes, ShadowRayEndKind};
use super::types::{Emission, LightSample, ShadowRayEnd};
use crate::geometry::sphere::{Sphere, surface_along};
use crate::geometry::surface::SurfacePoint;
use crate::math::frame::Frame;
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3, load, store, vectorised};
use crate::math::measure::{PdfArea, PdfSolidAngle};
use crate::math::vec::{LaneVec3, Vec2, Vec3, Vector};
use crate::planted::planted;
use crate::sampling::warp;
use std::f64::consts::PI;

/// An emitting sphere.
#[derive(Debug, Clone, Copy)]
pub struct SphereLight {
    sphere: Sphere,
    emission: Emission,
}

/// The cone of directions that a sphere subtends at a receiver outside: the unit vector to the centre, the square of the sine
/// of its half angle, and one minus its cosine.
#[derive(Debug, Clone, Copy)]
struct Cone<V = Vec3> {
    axis: V,
    sin2: f32,
    one_minus_cos: f32,
}

/// The directions that a sphere subtends at a receiver.
enum VisibleCap {
    /// The receiver is outside.
    Cone(Cone),
    /// The receiver is inside.
    Inside,
}

/// A bound of the cosine between the direction to a point at the rim of the near side and its normal, as a rounding error e of
/// the normal changes a cosine there by up to sqrt(2 e).
const RIM: f32 = 1e-3;

impl<V: Vector> Cone<V> {
    /// The cone of a sphere of this radius, and whether the receiver is outside: else it is not defined. Free of branches.
    #[inline(always)]
    fn new(to_center: [f64; 3], radius: f64) -> (bool, Self) {
        let [x, y, z] = to_center;
        let length2 = x * x + y * y + z * z;
        let sin2 = radius * radius / length2;
        let reciprocal = 1.0 / length2.sqrt();
        let cone = Self {
            axis: V::new(
                (x * reciprocal) as f32,
                (y * reciprocal) as f32,
                (z * reciprocal) as f32,
            ),
            sin2: sin2 as f32,
            one_minus_cos: planted!(
                "cone-cancels",
                1.0 - (1.0 - sin2 as f32).sqrt(),
                (sin2 / (1.0 + (1.0 - sin2).sqrt())) as f32
            ),
        };
        (sin2 < 1.0, cone)
    }

    /// The normal of the sphere where a direction that is uniformly distributed in the cone hits its near side. Free of
    /// branches.
    #[inline(always)]
    fn sample_normal(&self, u: Vec2) -> V {
        let w: V = warp::sample_cone_uniform(u, self.one_minus_cos);
        let [x, y, z] = w.into();
        let length2 = x * x + y * y;
        let sin2_theta = length2.min(self.sin2);
        let root = z * (1.0 - sin2_theta / self.sin2).max(0.0).sqrt();
        let cos_alpha = (sin2_theta / self.sin2.sqrt() + root).clamp(-1.0, 1.0);
        let sin_alpha = (1.0 - cos_alpha * cos_alpha).sqrt();
        let reciprocal = 1.0 / length2.sqrt();
        let scale = if reciprocal.is_finite() {
            reciprocal
        } else {
            0.0
        };
        let local = V::new(sin_alpha * (x * scale), sin_alpha * (y * scale), -cos_alpha);
        Frame::from_normal(self.axis).to_world(local)
    }

    #[inline(always)]
    fn density(&self) -> f32 {
        warp::pdf_cone_uniform(self.one_minus_cos)
    }
}

/// The point of a sphere with this normal, and the unit vector to it from a receiver outside.
#[inline(always)]
fn point_and_direction<V: Vector>(center: V, radius: f32, normal: V, p: V) -> (SurfacePoint<V>, V) {
    let point = surface_along(center, radius, normal);
    let wi = (point.p - p).normalize_or(-normal);
    (point, wi)
}

impl SphereLight {
    /// Creates a light from a sphere.
    pub fn new(sphere: Sphere, emission: Emission) -> Self {
        Self { sphere, emission }
    }

    /// The sphere.
    pub fn sphere(&self) -> &Sphere {
        &self.sphere
    }

    /// Radiant power in normalised units.
    pub fn power(&self) -> f64 {
        self.emission.power(self.area())
    }

    /// The emission of the surface.
    pub fn emission(&self) -> Emission {
        self.emission
    }

    /// Samples a point uniformly by area.
    pub fn point(&self, u: Vec2) -> SurfacePoint {
        self.sphere.surface_along(warp::sample_sphere_uniform(u))
    }

    /// The density of [`point`](Self::point).
    pub fn pdf_area(&self) -> PdfArea {
        PdfArea((1.0 / self.area()) as f32)
    }

    /// Samples a point on the light for the receiver `p`.
    #[inline]
    pub fn sample(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let view = self.view(p);
        let normal = match &view {
            VisibleCap::Cone(cone) => cone.sample_normal(u),
            VisibleCap::Inside => {
                let w = warp::sample_sphere_uniform(u);
                let from_center = p - self.sphere.center;
                let b = w.dot(from_center);
                let r2 = self.sphere.radius * self.sphere.radius;
                let t = -b + (b * b + r2 - from_center.length_squared()).max(0.0).sqrt();
                (from_center + t * w).normalize()
            }
        };
        let (point, wi) = point_and_direction(self.sphere.center, self.sphere.radius, normal, p);
        Some(LightSample {
            wi,
            radiance: self.emission.towards(-wi.dot(normal)),
            pdf: Some(view.density()),
            end: ShadowRayEnd::Surface(point, [0.0; 2]),
        })
    }

    /// Samples a point uniformly by area, on the near side or on the far one.
    pub fn sample_by_area(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let normal = warp::sample_sphere_uniform(u);
        let point = self.sphere.surface_along(normal);
        let towards = point.p - p;
        let wi = towards.normalize();
        let cos = -wi.dot(normal);
        Some(LightSample {
            wi,
            radiance: self.emission.towards(cos),
            pdf: Some(
                self.pdf_area()
                    .to_solid_angle(towards.length_squared(), cos)?,
            ),
            end: ShadowRayEnd::Surface(point, [0.0; 2]),
        })
    }

    fn area(&self) -> f64 {
        let radius = f64::from(self.sphere.radius);
        4.0 * PI * radius * radius
    }

    /// The density of [`sample`](Self::sample) for the receiver `p`, at a point whose normal has this cosine with the
    /// direction to it. From outside the near side alone is sampled, whose normals are turned to the receiver.
    #[inline]
    pub fn pdf(&self, p: Vec3, cos: f32) -> PdfSolidAngle {
        match self.view(p) {
            VisibleCap::Cone(_) if cos > RIM => PdfSolidAngle(0.0),
            view => view.density(),
        }
    }

    #[inline]
    fn view(&self, p: Vec3) -> VisibleCap {
        let to_center = self.sphere.center.as_dvec3() - p.as_dvec3();
        let (is_outside, cone) = Cone::new(to_center.to_array(), self.sphere.radius.into());
        match is_outside {
            true => VisibleCap::Cone(cone),
            false => VisibleCap::Inside,
        }
    }
}

impl VisibleCap {
    #[inline]
    fn density(&self) -> PdfSolidAngle {
        PdfSolidAngle(match self {
            Self::Cone(cone) => cone.density(),
            Self::Inside => warp::PDF_SPHERE_UNIFORM,
        })
    }
}

/// A sphere light for each lane.
#[repr(align(64))]
#[derive(Debug)]
pub struct SphereLanes {
    center: Lanes3,
    radius: Lanes<f32>,
    radiance: Lanes3,
    two_sided: Lanes<u32>,
}

impl Default for SphereLanes {
    fn default() -> Self {
        let zero = [0.0; LANES];
        Self {
            center: [zero; 3],
            radius: zero,
            radiance: [zero; 3],
            two_sided: [0; LANES],
        }
    }
}

impl SphereLanes {
    /// Sets the light of a lane.
    #[inline]
    pub fn set(&mut self, lane: usize, light: &SphereLight) {
        store(&mut self.center, lane, light.sphere.center);
        self.radius[lane] = light.sphere.radius;
        store(&mut self.radiance, lane, light.emission.radiance);
        self.two_sided[lane] = u32::from(light.emission.two_sided);
    }
}

vectorised! {
    /// Samples a point on the light of each lane of `mask` for the receiver `p`. Returns the lanes whose receiver is inside, so
    /// that [`SphereLight::sample`] has to do it.
    pub fn sample_lanes(
        lights: &SphereLanes,
        mask: &ActiveLanes<LANES>,
        context: &LightContextLanes,
        p: &Lanes3,
        samples: &mut LightSampleLanes,
    ) -> ActiveLanes<LANES> {
        let mut inside = ActiveLanes::NONE;
        for lane in 0..LANES {
            let (center, p): (LaneVec3, LaneVec3) = (load(&lights.center, lane), load(p, lane));
            let radius = lights.radius[lane];
            let u = Vec2::new(context.u[0][lane], context.u[1][lane]);
            let to_center = [
                f64::from(center.x) - f64::from(p.x),
                f64::from(center.y) - f64::from(p.y),
                f64::from(center.z) - f64::from(p.z),
            ];
            let (is_outside, cone) = Cone::<LaneVec3>::new(to_center, f64::from(radius));
            let normal = cone.sample_normal(u);
            let (point, wi) = point_and_direction(center, radius, normal, p);
            let emission: Emission<LaneVec3> = Emission {
                radiance: load(&lights.radiance, lane),
                two_sided: lights.two_sided[lane] != 0,
            };
            let is_in_mask = mask.has(lane);
            inside.set(lane, !is_outside & is_in_mask);
            let sample = LaneSample {
                end: ShadowRayEndKind::Surface,
                wi,
                radiance: emission.towards(-wi.dot(normal)),
                pdf: context.pmf[lane] * cone.density(),
                p: point.p,
                error: point.error,
                normal,
            };
            samples.set_if(is_in_mask, lane, &sample);
        }
        inside
    }
}
