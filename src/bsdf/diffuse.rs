//! The Lambertian BSDF: equal reflected radiance in all directions.
//!
//! Measure: f per steradian; the albedo is `reflectance`.
//! Range: `reflectance` in [0, 1]; scatters on the side of `wo` only, on both sides alike.
//! Source: f = rho / pi, with cosine-weighted sampling (Malley). Tested in `tests/scattering/bsdf.rs` and
//! `tests/scattering/furnace.rs`.

use super::types::{BsdfSample, BsdfSampleInput, BsdfValue, Lobe, is_same_side};
use crate::math::{
    measure::PdfSolidAngle,
    rgb::Rgb,
    vec::{Vec3, Vector},
};
use crate::planted::planted;
use crate::sampling::warp::pdf_hemisphere_cosine;
use std::f32::consts::FRAC_1_PI;

/// A Lambertian surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Diffuse<V = Vec3> {
    reflectance: Rgb<V>,
}

impl<V: Vector> Diffuse<V> {
    /// Creates a Lambertian surface that reflects the fraction `reflectance` of incident light.
    #[inline]
    pub fn new(reflectance: Rgb<V>) -> Self {
        Self { reflectance }
    }

    /// The albedo.
    #[inline]
    pub fn reflectance(&self) -> Rgb<V> {
        self.reflectance
    }

    /// Evaluates f = rho / pi on the side of `wo`.
    #[inline(always)]
    pub fn eval(&self, wo: V, wi: V) -> BsdfValue<V> {
        let reflects = if is_same_side(wo, wi) { 1.0 } else { 0.0 };
        BsdfValue {
            f: self.reflectance * (reflects * FRAC_1_PI),
            pdf: PdfSolidAngle(reflects * pdf_hemisphere_cosine(wi.z().abs())),
        }
    }

    /// Samples a cosine-weighted direction; the weight is the albedo.
    #[inline]
    pub fn sample(&self, wo: V, input: &BsdfSampleInput) -> Option<BsdfSample<V>> {
        (wo.z() != 0.0).then(|| self.sample_cosine(wo, input.cosine_direction.into()))
    }

    /// The sample for a cosine-weighted direction on the upper hemisphere, flipped to the side of `wo`, which is not
    /// tangential. Free of branches.
    #[inline(always)]
    pub fn sample_cosine(&self, wo: V, cosine_direction: V) -> BsdfSample<V> {
        let [x, y, z] = cosine_direction.into();
        let pdf = pdf_hemisphere_cosine(z);
        BsdfSample {
            wi: V::new(x, y, z.copysign(wo.z())),
            weight: planted!(
                "one-percent-of-albedo",
                self.reflectance * 0.99,
                self.reflectance
            ),
            pdf: Some(PdfSolidAngle(pdf)),
            lobe: Lobe::Diffuse,
        }
    }
}
