//! What every light answers.
//!
//! Measure: radiance in W m^-2 sr^-1, densities per steradian at the receiving point, lengths in normalised units.
//! Range: any receiving point; one that cannot be lit gets no sample.
//! Source: Veach 1997, section 8.2; Pharr, Jakob, Humphreys, "Light Interface". Tested in `tests/lights/light.rs`.

use crate::geometry::surface::SurfacePoint;
use crate::math::measure::{PdfArea, PdfSolidAngle, Pmf};
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3};

/// A direction from which a light shines on a given receiver.
#[derive(Debug, Clone, Copy)]
pub struct LightSample {
    /// Unit vector from the receiver towards the light.
    pub wi: Vec3,
    /// Radiance that arrives from there. Of a delta light: irradiance at right angles to `wi`.
    pub radiance: Rgb,
    /// Density of `wi`; `None` for a delta light, which nothing else finds.
    pub pdf: Option<PdfSolidAngle>,
    /// Where a shadow ray has to end.
    pub end: ShadowRayEnd,
}

impl LightSample {
    /// Lets its density, or the irradiance of a delta light, include the probability with which its light is chosen.
    #[inline]
    pub fn is_chosen_with(&mut self, pmf: Pmf) {
        match &mut self.pdf {
            Some(pdf) => *pdf = pmf * *pdf,
            None => self.radiance *= 1.0 / pmf.0,
        }
    }
}

/// A place that looks for light.
#[derive(Debug, Clone, Copy)]
pub struct LightSampleContext {
    /// The light, which is chosen.
    pub light: u32,
    /// The probability of choosing it.
    pub pmf: Pmf,
    /// Where the light is looked for.
    pub p: Vec3,
    /// When.
    pub time: f32,
    /// The numbers that choose a point on the light.
    pub u: Vec2,
}

/// How a point on a light is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PointRule {
    /// By the solid angle under which the light is seen, as nearly as it pays.
    #[default]
    SolidAngle,
    /// Uniformly by area, wherever the light is a surface.
    Area,
}

/// What is at the light's end of a shadow ray.
#[derive(Debug, Clone, Copy)]
pub enum ShadowRayEnd {
    /// A point of a shape, and its barycentric coordinates on a triangle.
    Surface(SurfacePoint, [f32; 2]),
    /// A point in free space, in normalised units.
    Point(Vec3),
    /// Nothing: the light is beyond the scene.
    Infinity,
}

/// A ray of light as it leaves its light.
#[derive(Debug, Clone, Copy)]
pub struct EmissionSample {
    /// Where it leaves. Light from beyond the scene comes from nowhere.
    pub end: ShadowRayEnd,
    /// A point that it passes: that of `end`, or one before the whole scene.
    pub origin: Vec3,
    /// Unit vector along which it travels.
    pub direction: Vec3,
    /// Radiance. Of a point or spot light: radiant intensity; of a distant one: irradiance at right angles.
    pub radiance: Rgb,
    /// How it was found.
    pub pdf: EmissionPdf,
}

/// The densities with which light sampling finds a ray, the choice of the light left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EmissionPdf {
    /// Of the point on the light; for light from beyond the scene, of the point on a disk across the ray. `None` for a
    /// point, which is always the same.
    pub position: Option<PdfArea>,
    /// Of the direction; `None` for a distant light, which has but one.
    pub direction: Option<PdfSolidAngle>,
}

/// A sphere around everything that a ray can meet, in normalised units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundingSphere {
    /// Centre.
    pub center: Vec3,
    /// Radius.
    pub radius: f32,
}

/// What a surface emits, and on which side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Emission {
    /// Radiance.
    pub radiance: Rgb,
    /// Whether the back emits as well.
    pub two_sided: bool,
}

impl Emission {
    /// Radiance towards a direction whose cosine with the geometric normal is `cos`.
    #[inline]
    pub fn towards(&self, cos: f32) -> Rgb {
        if cos > 0.0 || (self.two_sided && cos < 0.0) {
            self.radiance
        } else {
            Rgb::BLACK
        }
    }

    /// Whether nothing shines on the back: points chosen there are black, whatever their density.
    #[inline]
    pub fn is_dark_behind(&self) -> bool {
        !self.two_sided
    }

    /// Radiant power of a flat or convex emitter of this area: pi A L for each side that emits.
    pub fn power(&self, area: f64) -> f64 {
        f64::from(self.sides()) * std::f64::consts::PI * area * f64::from(self.radiance.luminance())
    }

    /// How many of its sides emit.
    pub fn sides(&self) -> f32 {
        if self.two_sided { 2.0 } else { 1.0 }
    }
}
