//! The types that all lights share: samples, their contexts and emission.
//!
//! Measure: radiance in W m^-2 sr^-1, densities per steradian at the receiving point, lengths in normalised units.
//! Range: any receiving point; one that cannot be lit gets no sample.
//! Source: Veach 1997, section 8.2; Pharr, Jakob, Humphreys, "Light Interface". Tested in `tests/lights/light.rs`.

use crate::geometry::surface::SurfacePoint;
use crate::math::measure::{PdfArea, PdfSolidAngle, Pmf};
use crate::math::rgb::Rgb;
use crate::math::vec::{LaneVec3, Vec3, Vector};
use serde::Serialize;

/// A sampled direction from a receiver to a light.
#[derive(Debug, Clone, Copy)]
pub struct LightSample {
    /// Unit vector from the receiver towards the light.
    pub wi: Vec3,
    /// Radiance that arrives along `wi`. For a delta light: irradiance perpendicular to `wi`.
    pub radiance: Rgb,
    /// Density of `wi`; `None` for a delta light, which no other strategy samples.
    pub pdf: Option<PdfSolidAngle>,
    /// The end of the shadow ray.
    pub end: ShadowRayEnd,
}

impl LightSample {
    /// Multiplies the density by the probability of selecting the light, or divides a delta light's irradiance by it.
    #[inline]
    pub fn multiply_pdf_by(&mut self, pmf: Pmf) {
        match &mut self.pdf {
            Some(pdf) => *pdf = pmf * *pdf,
            None => self.radiance *= 1.0 / pmf.0,
        }
    }
}

/// The measure in which points on a light are sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PointRule {
    /// Uniformly by solid angle, or approximately so where the exact density is not worth its cost.
    #[default]
    SolidAngle,
    /// Uniformly by area, wherever the light is a surface.
    Area,
}

/// The rule by which one of several lights is selected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize)]
pub enum LightChoice {
    /// Probabilities in proportion to an estimate of the irradiance that each light would cause at the receiver if
    /// nothing occluded it.
    #[default]
    Contribution,
    /// Probabilities in proportion to power, for all receivers alike.
    Power,
}

impl LightChoice {
    /// Every rule.
    pub const ALL: &'static [Self] = &[Self::Contribution, Self::Power];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Contribution => "contribution",
            Self::Power => "power",
        }
    }
}

/// The density of directions to an environment map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EnvironmentSampling {
    /// A density in proportion to radiance, for light sampling alone as well.
    #[default]
    Radiance,
    /// A density in proportion to the radiance above the mean: zero elsewhere, where BSDF sampling has to find the light.
    Compensated,
}

/// The rules of light sampling.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LightSampling {
    /// The selection of a light.
    pub choice: LightChoice,
    /// The points on it.
    pub points: PointRule,
    /// The directions to an environment map.
    pub environment: EnvironmentSampling,
}

/// A point that receives light.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Receiver<V = Vec3> {
    /// The point.
    pub p: V,
    /// The shading normal on the side that reflects; zero where light from both sides is scattered.
    pub normal: V,
}

impl Receiver {
    /// A point that scatters light from all directions.
    pub fn isotropic(p: Vec3) -> Self {
        Self {
            p,
            normal: Vec3::ZERO,
        }
    }
}

/// The end of a shadow ray at the light.
#[derive(Debug, Clone, Copy)]
pub enum ShadowRayEnd {
    /// A point of a shape, and its barycentric coordinates on a triangle.
    Surface(SurfacePoint, [f32; 2]),
    /// A point in free space, in normalised units.
    Point(Vec3),
    /// No point: the light is at infinity.
    Infinity,
}

/// A sampled ray of emitted light.
#[derive(Debug, Clone, Copy)]
pub struct EmissionSample {
    /// The point on the light that the ray leaves, or infinity.
    pub end: ShadowRayEnd,
    /// Origin of the ray: the point of `end`, or for a light at infinity a point in front of the whole scene.
    pub origin: Vec3,
    /// Unit vector along the ray.
    pub direction: Vec3,
    /// Radiance. For a point or spot light: radiant intensity; for a distant light: irradiance perpendicular to the ray.
    pub radiance: Rgb,
    /// Densities of the ray.
    pub pdf: EmissionPdf,
}

/// The densities of emission sampling at a ray, without the probability of selecting the light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EmissionPdf {
    /// Density of the point on the light; for a light at infinity, of the point on a disk perpendicular to the ray. `None`
    /// for a point or spot light, which has only one point.
    pub position: Option<PdfArea>,
    /// Density of the direction; `None` for a distant light, which has only one.
    pub direction: Option<PdfSolidAngle>,
}

impl EmissionPdf {
    /// Whether another ray can hit the light: it has more than one point and more than one direction.
    pub fn can_be_hit(&self) -> bool {
        self.position.is_some() && self.direction.is_some()
    }
}

/// A sphere around everything that a ray can hit, in normalised units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundingSphere {
    /// Centre.
    pub center: Vec3,
    /// Radius.
    pub radius: f32,
}

/// The radiance that a surface emits, and the sides that emit it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Emission<V = Vec3> {
    /// Radiance.
    pub radiance: Rgb<V>,
    /// Whether the back emits as well.
    pub two_sided: bool,
}

impl<V: Vector> Emission<V> {
    /// Radiance towards a direction whose cosine with the geometric normal is `cos`.
    #[inline(always)]
    pub fn towards(&self, cos: f32) -> Rgb<V> {
        if (cos > 0.0) | (self.two_sided & (cos < 0.0)) {
            self.radiance
        } else {
            Rgb::from([0.0; 3])
        }
    }

    /// Whether the back does not emit: samples for receivers behind are black, whatever their density.
    #[inline(always)]
    pub fn is_dark_behind(&self) -> bool {
        !self.two_sided
    }
}

impl Emission {
    /// The emission with the type of vector for loops over lanes.
    pub fn in_lanes(&self) -> Emission<LaneVec3> {
        Emission {
            radiance: Rgb::from(self.radiance.to_array()),
            two_sided: self.two_sided,
        }
    }

    /// Radiant power of a flat or convex emitter of this area: pi A L for each side that emits.
    pub fn power(&self, area: f64) -> f64 {
        f64::from(self.sides()) * std::f64::consts::PI * area * f64::from(self.radiance.luminance())
    }

    /// The number of sides that emit.
    pub fn sides(&self) -> f32 {
        if self.two_sided { 2.0 } else { 1.0 }
    }
}
