//! A sphere light, sampled uniformly in the cone of directions that it subtends.
//!
//! Measure: densities per steradian.
//! Range: receivers outside at any distance; for receivers inside the whole sphere of directions is sampled.
//! Source: Pharr, Jakob, Humphreys, "Sampling Spheres"; 1 - cos = s^2 / (1 + sqrt(1 - s^2)) does not cancel for small
//! cones. Tested in `tests/lights/light.rs`.

use super::types::{Emission, LightSample, ShadowRayEnd};
use crate::geometry::sphere::Sphere;
use crate::geometry::surface::SurfacePoint;
use crate::math::frame::Frame;
use crate::math::measure::{PdfArea, PdfSolidAngle};
use crate::math::vec::{Vec2, Vec3};
use crate::planted::planted;
use crate::sampling::warp;
use std::f64::consts::PI;

/// An emitting sphere.
#[derive(Debug, Clone, Copy)]
pub struct SphereLight {
    sphere: Sphere,
    emission: Emission,
}

/// The directions that the sphere subtends at a receiver.
enum VisibleCap {
    /// Receiver outside: unit vector to the centre, sine squared of the cone's half angle, one minus its cosine.
    Cone {
        axis: Vec3,
        sin2: f32,
        one_minus_cos: f32,
    },
    /// Receiver inside.
    Inside,
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
        let normal = match view {
            VisibleCap::Cone {
                axis,
                sin2,
                one_minus_cos,
            } => {
                let w = warp::sample_cone_uniform(u, one_minus_cos);
                // The normal where the sampled direction hits the near side.
                let sin2_theta = (w.x * w.x + w.y * w.y).min(sin2);
                let root = w.z * (1.0 - sin2_theta / sin2).max(0.0).sqrt();
                let cos_alpha = (sin2_theta / sin2.sqrt() + root).clamp(-1.0, 1.0);
                let sin_alpha = (1.0 - cos_alpha * cos_alpha).sqrt();
                let around = Vec2::new(w.x, w.y).normalize_or_zero();
                let local = Vec3::new(sin_alpha * around.x, sin_alpha * around.y, -cos_alpha);
                Frame::from_normal(axis).to_world(local)
            }
            VisibleCap::Inside => {
                let w = warp::sample_sphere_uniform(u);
                let from_center = p - self.sphere.center;
                let b = w.dot(from_center);
                let r2 = self.sphere.radius * self.sphere.radius;
                let t = -b + (b * b + r2 - from_center.length_squared()).max(0.0).sqrt();
                (from_center + t * w).normalize()
            }
        };
        let point = self.sphere.surface_along(normal);
        let wi = (point.p - p).normalize();
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

    /// The density of [`sample`](Self::sample) for the receiver `p`, at any visible point.
    #[inline]
    pub fn pdf(&self, p: Vec3) -> PdfSolidAngle {
        self.view(p).density()
    }

    #[inline]
    fn view(&self, p: Vec3) -> VisibleCap {
        let to_center = self.sphere.center.as_dvec3() - p.as_dvec3();
        let radius = f64::from(self.sphere.radius);
        let sin2 = radius * radius / to_center.length_squared();
        if sin2 < 1.0 {
            VisibleCap::Cone {
                axis: to_center.normalize().as_vec3a(),
                sin2: sin2 as f32,
                one_minus_cos: planted!(
                    "cone-cancels",
                    1.0 - (1.0 - sin2 as f32).sqrt(),
                    (sin2 / (1.0 + (1.0 - sin2).sqrt())) as f32
                ),
            }
        } else {
            VisibleCap::Inside
        }
    }
}

impl VisibleCap {
    #[inline]
    fn density(&self) -> PdfSolidAngle {
        PdfSolidAngle(match self {
            Self::Cone { one_minus_cos, .. } => warp::pdf_cone_uniform(*one_minus_cos),
            Self::Inside => warp::PDF_SPHERE_UNIFORM,
        })
    }
}
