//! Lights: area lights, point and spot lights, and lights at infinity, each sampled for a given receiver; and the
//! selection among them.
//!
//! The constant environment is not a [`Light`]: no strategy samples it better than BSDF sampling, so that only scattered
//! rays find it.
//!
//! Measure: radiance, of delta lights irradiance; densities per steradian at the receiver.
//! Range: any receiver; one that cannot be lit gets no sample.
//! Source: named in each light's file. Tested in `tests/lights/`.

pub mod bounds;
pub mod caustic_targets;
pub mod disk;
pub mod distant;
pub mod emission;
pub mod environment;
pub mod lanes;
pub mod moving;
pub mod point;
pub mod rectangle;
pub mod select;
pub mod sphere;
pub mod spot;
pub mod tree;
pub mod triangle;
pub mod types;

use crate::effects::{Effects, Switch, beyond_kernel};
use crate::math::measure::PdfSolidAngle;
use crate::math::vec::{Vec2, Vec3};
use disk::DiskLight;
use distant::DistantLight;
use environment::EnvironmentMap;
use moving::MovingTriangle;
use point::PointLight;
use rectangle::RectangleLight;
use sphere::SphereLight;
use spot::SpotLight;
use std::sync::Arc;
use triangle::TriangleLight;
use types::{LightSample, LightSampling, PointRule};

/// A light.
#[derive(Debug, Clone)]
pub enum Light {
    /// One triangle of an emitting mesh.
    Triangle(TriangleLight),
    /// One triangle of an emitting mesh that moves.
    MovingTriangle(MovingTriangle),
    /// A rectangle.
    Rectangle(RectangleLight),
    /// A disk.
    Disk(DiskLight),
    /// A sphere.
    Sphere(SphereLight),
    /// A point light of uniform intensity.
    Point(PointLight),
    /// A point light restricted to a cone.
    Spot(SpotLight),
    /// Parallel light from infinity.
    Distant(DistantLight),
    /// An environment map.
    Environment(Arc<EnvironmentMap>),
}

impl Light {
    /// Radiant power in normalised units: the light's weight in light selection. For a light at infinity, the power that
    /// enters the scene's bounding sphere of radius `scene_radius`.
    pub fn power(&self, scene_radius: f64) -> f64 {
        match self {
            Self::Triangle(light) => light.power(),
            Self::MovingTriangle(light) => light.power(),
            Self::Rectangle(light) => light.power(),
            Self::Disk(light) => light.power(),
            Self::Sphere(light) => light.power(),
            Self::Point(light) => light.power(),
            Self::Spot(light) => light.power(),
            Self::Distant(light) => light.power(scene_radius),
            Self::Environment(map) => map.power(scene_radius),
        }
    }

    /// Samples a direction to the light for the receiver `p`; `None` where there is none. A kernel samples only the kinds
    /// of light that its effects include.
    #[inline]
    pub fn sample<E: Effects>(
        &self,
        rules: LightSampling,
        p: Vec3,
        time: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        match self {
            _ if rules.points == PointRule::Area && self.is_surface() => {
                self.sample_by_area::<E>(p, time, u)
            }
            Self::Triangle(light) if E::AreaLights::ON => light.sample(p, u),
            Self::MovingTriangle(light) if E::Motion::ON => light.sample(p, time, u),
            Self::Rectangle(light) if E::AreaLights::ON => light.sample(p, u),
            Self::Disk(light) if E::AreaLights::ON => light.sample(p, u),
            Self::Sphere(light) if E::AreaLights::ON => light.sample(p, u),
            Self::Point(light) if E::DeltaLights::ON => light.sample(p),
            Self::Spot(light) if E::DeltaLights::ON => light.sample(p),
            Self::Distant(light) if E::DeltaLights::ON => Some(light.sample()),
            Self::Environment(map) if E::EnvironmentMap::ON => map.sample(u, rules.environment),
            _ => beyond_kernel(),
        }
    }

    /// Whether the light is a surface.
    fn is_surface(&self) -> bool {
        match self {
            Self::Triangle(_)
            | Self::MovingTriangle(_)
            | Self::Rectangle(_)
            | Self::Disk(_)
            | Self::Sphere(_) => true,
            Self::Point(_) | Self::Spot(_) | Self::Distant(_) | Self::Environment(_) => false,
        }
    }

    /// Samples a direction to a surface for the receiver `p`, with points sampled uniformly by area.
    fn sample_by_area<E: Effects>(&self, p: Vec3, time: f32, u: Vec2) -> Option<LightSample> {
        match self {
            Self::Triangle(light) if E::AreaLights::ON => light.sample_by_area(p, u),
            Self::MovingTriangle(light) if E::Motion::ON => light.sample_by_area(p, time, u),
            Self::Rectangle(light) if E::AreaLights::ON => light.sample_by_area(p, u),
            Self::Disk(light) if E::AreaLights::ON => light.sample(p, u),
            Self::Sphere(light) if E::AreaLights::ON => light.sample_by_area(p, u),
            _ => beyond_kernel(),
        }
    }

    /// The density of [`sample`](Self::sample) for the receiver `p` at the point of this light at `towards` from it, with
    /// unit normal `normal`; `None` for a light that is not a surface.
    #[inline]
    pub fn pdf<E: Effects>(
        &self,
        p: Vec3,
        time: f32,
        towards: Vec3,
        normal: Vec3,
    ) -> Option<PdfSolidAngle> {
        if !E::AreaLights::ON {
            return None;
        }
        let distance2 = towards.length_squared();
        let cos = towards.dot(normal) / distance2.sqrt();
        match self {
            Self::Triangle(light) => light.pdf(p, distance2, cos),
            Self::MovingTriangle(light) => light.pdf(p, time, distance2, cos),
            Self::Rectangle(light) => light.pdf(p, towards, cos),
            Self::Disk(light) => light.pdf(distance2, cos),
            Self::Sphere(light) => Some(light.pdf(p, cos)),
            Self::Point(_) | Self::Spot(_) | Self::Distant(_) | Self::Environment(_) => None,
        }
    }
}
