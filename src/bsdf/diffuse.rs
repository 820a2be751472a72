//! The Lambertian BSDF: equal reflected radiance in all directions.
//!
//! Measure: f per steradian; the albedo is `reflectance`.
//! Range: `reflectance` in [0, 1]; scatters on the side of `wo` only, on both sides alike.
//! Source: f = rho / pi, with cosine-weighted sampling (Malley). Tested in `tests/scattering/bsdf.rs` and
//! `tests/scattering/furnace.rs`.

use super::types::{BsdfSample, BsdfSampleInput, BsdfValue, Lobe, facing_up};
use crate::math::{measure::PdfSolidAngle, rgb::Rgb, vec::Vec3};
use crate::planted::planted;
use crate::sampling::warp::pdf_hemisphere_cosine;
use std::f32::consts::FRAC_1_PI;

/// A Lambertian surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Diffuse {
    reflectance: Rgb,
}

impl Diffuse {
    /// Creates a Lambertian surface that reflects the fraction `reflectance` of incident light.
    #[inline]
    pub fn new(reflectance: Rgb) -> Self {
        Self { reflectance }
    }

    /// The albedo.
    #[inline]
    pub fn reflectance(&self) -> Rgb {
        self.reflectance
    }

    /// Evaluates f = rho / pi on the side of `wo`.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfValue {
        facing_up(wo, wi).map_or_else(BsdfValue::default, |(_, wi)| BsdfValue {
            f: FRAC_1_PI * self.reflectance,
            pdf: PdfSolidAngle(pdf_hemisphere_cosine(wi.z)),
        })
    }

    /// Samples a cosine-weighted direction; the weight is the albedo.
    #[inline]
    pub fn sample(&self, wo: Vec3, numbers: &BsdfSampleInput) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let mut wi = numbers.by_cosine;
        let pdf = pdf_hemisphere_cosine(wi.z);
        wi.z = wi.z.copysign(wo.z);
        Some(BsdfSample {
            wi,
            weight: planted!(
                "one-percent-of-albedo",
                0.99 * self.reflectance,
                self.reflectance
            ),
            pdf: Some(PdfSolidAngle(pdf)),
            lobe: Lobe::Diffuse,
        })
    }
}
