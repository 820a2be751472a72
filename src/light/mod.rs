//! Lights: surfaces that emit, each sampled from where it is looked at, and the choice among them.
//!
//! The constant environment is not in the list: nothing samples it better than the BSDF does, so that it is found by
//! scattered rays alone.

pub mod disk;
pub mod rectangle;
pub mod select;
pub mod sphere;
pub mod triangle;
pub mod types;

use crate::effects::Effects;
use crate::math::measure::PdfSolidAngle;
use crate::math::vec::{Vec2, Vec3};
use disk::DiskLight;
use rectangle::RectangleLight;
use sphere::SphereLight;
use triangle::TriangleLight;
use types::LightSample;

/// A light.
#[derive(Debug, Clone, Copy)]
pub enum Light {
    /// One triangle of an emitting mesh.
    Triangle(TriangleLight),
    /// A rectangle.
    Rectangle(RectangleLight),
    /// A disk.
    Disk(DiskLight),
    /// A sphere.
    Sphere(SphereLight),
}

impl Light {
    /// Radiant power in normalised units: the light's weight when one is chosen.
    pub fn power(&self) -> f64 {
        match self {
            Self::Triangle(light) => light.power(),
            Self::Rectangle(light) => light.power(),
            Self::Disk(light) => light.power(),
            Self::Sphere(light) => light.power(),
        }
    }

    /// A point of the light that lights `p`; `None` where none can.
    #[inline]
    pub fn sample<E: Effects>(&self, p: Vec3, _time: f32, u: Vec2) -> Option<LightSample> {
        match self {
            Self::Triangle(light) => light.sample(p, u),
            Self::Rectangle(light) => light.sample(p, u),
            Self::Disk(light) => light.sample(p, u),
            Self::Sphere(light) => light.sample(p, u),
        }
    }

    /// The density of [`sample`](Self::sample) at `p` for the point of this light that lies at `towards` from it and
    /// has the unit normal `normal`.
    #[inline]
    pub fn pdf<E: Effects>(
        &self,
        p: Vec3,
        _time: f32,
        towards: Vec3,
        normal: Vec3,
    ) -> Option<PdfSolidAngle> {
        let distance2 = towards.length_squared();
        let cos = towards.dot(normal) / distance2.sqrt();
        match self {
            Self::Triangle(light) => light.pdf(p, distance2, cos),
            Self::Rectangle(light) => light.pdf(p, distance2, cos),
            Self::Disk(light) => light.pdf(distance2, cos),
            Self::Sphere(light) => Some(light.pdf(p)),
        }
    }
}
