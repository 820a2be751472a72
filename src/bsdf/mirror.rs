//! A perfect mirror.
//!
//! Measure: a delta lobe, which has no density.
//! Range: `reflectance` in [0, 1]; both sides reflect alike.
//! Source: the law of reflection. Tested in `tests/scattering/bsdf.rs` and `tests/scattering/furnace.rs`.

use super::types::{BsdfSample, BsdfValue, Lobe};
use crate::math::{rgb::Rgb, vec::Vec3};

/// A mirror of constant reflectance, without Fresnel equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mirror {
    reflectance: Rgb,
}

impl Mirror {
    /// Creates a mirror that reflects the fraction `reflectance` of incident light, at every angle.
    #[inline]
    pub fn new(reflectance: Rgb) -> Self {
        Self { reflectance }
    }

    /// Returns zero: a delta lobe cannot be evaluated.
    #[inline]
    pub fn eval(&self) -> BsdfValue {
        BsdfValue::default()
    }

    /// Samples the mirror direction.
    #[inline]
    pub fn sample(&self, wo: Vec3) -> Option<BsdfSample> {
        (wo.z != 0.0).then(|| BsdfSample {
            wi: Vec3::new(-wo.x, -wo.y, wo.z),
            weight: self.reflectance,
            pdf: None,
            lobe: Lobe::SpecularReflection,
        })
    }
}
