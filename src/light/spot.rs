//! A spot light: a point light restricted to a cone with a soft edge.
//!
//! The intensity at the angle theta from the axis is I s(t), where t goes from 0 at the cone's edge to 1 where the
//! penumbra begins, linearly in cos theta, and s(t) = t^2 (3 - 2 t). As s is 1/2 on average, the power is
//!
//!   2 pi I (1 - (cos(cone) + cos(cone - penumbra)) / 2).
//!
//! Measure: radiant intensity in W/sr on a scene in normalised units, as of a point light; angles in radians.
//! Range: cones in (0, pi] with a penumbra in [0, cone]; narrow cones lose no digits.
//! Source: the inverse square law; the cubic Hermite step. Tested in `tests/lights/light.rs`.

use super::point::PointLight;
use super::types::LightSample;
use crate::math::frame::Frame;
use crate::math::functions::sin;
use crate::math::measure::PdfSolidAngle;
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3};
use crate::sampling::warp;

/// A spot light.
#[derive(Debug, Clone, Copy)]
pub struct SpotLight {
    point: PointLight,
    axis: Vec3,
    /// 1 - cos of the angles to the cone's edge and to where the penumbra begins: without cancellation.
    edge: f64,
    full: f64,
}

impl SpotLight {
    /// Creates a light at a position, with a unit vector along its axis and the radiant intensity there, in normalised
    /// units. The angle from the axis to the edge is `cone`; over the last `penumbra` of it the intensity falls off.
    pub fn new(position: Vec3, axis: Vec3, intensity: Rgb, cone: f64, penumbra: f64) -> Self {
        let one_minus_cos = |angle: f64| 2.0 * sin(0.5 * angle).powi(2);
        Self {
            point: PointLight::new(position, intensity),
            axis,
            edge: one_minus_cos(cone),
            full: one_minus_cos(cone - penumbra),
        }
    }

    /// Radiant power in normalised units: that of the point light times the mean of both cones' fractions of the sphere.
    pub fn power(&self) -> f64 {
        self.point.power() * (self.edge + self.full) / 4.0
    }

    /// The unit vector along the axis.
    pub fn axis(&self) -> Vec3 {
        self.axis
    }

    /// The cosine of the angle from the axis to the edge.
    pub fn cos_edge(&self) -> f32 {
        (1.0 - self.edge) as f32
    }

    /// The luminance of the intensity along the axis.
    pub fn greatest_intensity(&self) -> f64 {
        f64::from(self.point.intensity().luminance())
    }

    /// Position of the light.
    pub fn position(&self) -> Vec3 {
        self.point.position()
    }

    /// Samples a direction in the cone, uniformly by solid angle.
    pub fn direction(&self, u: Vec2) -> Vec3 {
        let local = warp::sample_cone_uniform(u, self.edge as f32);
        Frame::from_normal(self.axis).to_world(local)
    }

    /// The density of [`direction`](Self::direction).
    pub fn pdf_direction(&self, direction: Vec3) -> PdfSolidAngle {
        PdfSolidAngle(if self.off_axis(-direction) <= self.edge {
            warp::pdf_cone_uniform(self.edge as f32)
        } else {
            0.0
        })
    }

    /// Radiant intensity along a unit vector away from the light.
    pub fn intensity(&self, direction: Vec3) -> Rgb {
        self.point.intensity() * self.falloff(self.off_axis(-direction)) as f32
    }

    /// Samples the direction to the light for the receiver `p`, a delta.
    #[inline]
    pub fn sample(&self, p: Vec3) -> Option<LightSample> {
        let mut sample = self.point.sample(p)?;
        let share = self.falloff(self.off_axis(sample.wi));
        sample.radiance *= share as f32;
        (share > 0.0).then_some(sample)
    }

    /// One minus the cosine between the axis and -`wi`.
    #[inline]
    fn off_axis(&self, wi: Vec3) -> f64 {
        // |a + b|^2 / 2 = 1 + cos(a, b) = 1 - cos(a, -b) for unit vectors.
        let from_axis = 0.5 * (self.axis.as_dvec3() + wi.as_dvec3()).length_squared();
        // Rounding must not exceed the largest value, 2.
        from_axis.min(2.0)
    }

    /// The fraction of the intensity where one minus the cosine with the axis is `from_axis`.
    #[inline]
    fn falloff(&self, from_axis: f64) -> f64 {
        if from_axis <= self.full {
            return 1.0;
        }
        if from_axis >= self.edge {
            return 0.0;
        }
        let t = (self.edge - from_axis) / (self.edge - self.full);
        t * t * (3.0 - 2.0 * t)
    }
}
