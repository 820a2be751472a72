//! The dielectric BSDF, as of glass or water: reflection and refraction at a smooth or rough surface, or at both sides of
//! a thin pane.
//!
//! Measure: f per steradian; refraction carries the factor (n_o / n_i)^2 of radiance.
//! Range: `ior` above 0, inside over outside; at exactly 1 the surface is invisible whatever its roughness. Where the
//! refracted lobe is narrower than f32 directions resolve (alpha or alpha |ior - 1| below 1e-4), both lobes are deltas.
//! Rough glass models single scattering and loses the light that microfacets shadow: at index 1.5, from outside along the
//! normal, 0.1 % at alpha 0.1 and 11 % at alpha 1, up to 58 % at grazing angles; `tests/scattering/furnace.rs` prints the
//! losses.
//! Source: Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces"; a thin pane: Stokes 1862, "On the
//! Intensity of the Light Reflected from or Transmitted through a Pile of Plates". Tested in `tests/scattering/bsdf.rs` and
//! `tests/scattering/furnace.rs`.

use super::fresnel::{self, Interface};
use super::microfacet::{Ggx, SMOOTH_ALPHA};
use super::types::{BsdfSample, BsdfValue, Lobe};
use crate::math::{
    measure::PdfSolidAngle,
    rgb::Rgb,
    vec::{Vec2, Vec3, reflect},
};
use crate::planted::planted;

/// The interface between two dielectric media.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dielectric {
    ior: f32,
    tint: Rgb,
    facets: Option<Ggx>,
    /// Whether the surface is a pane that light leaves in the direction in which it came.
    is_thin: bool,
}

/// The interface as seen from the side of `wo`, which is mirrored to the upper side.
struct InterfaceSide {
    /// +1 if `wo` is outside, -1 if it is inside.
    sign: f32,
    /// Index of the medium that `wo` is in.
    n_o: f32,
    /// Index of the other medium.
    n_t: f32,
}

impl Dielectric {
    /// Creates a surface of index `ior`, inside over outside; `tint` multiplies refracted light.
    #[inline]
    pub fn new(ior: f32, roughness: f32, tint: Rgb) -> Self {
        let facets = Ggx::from_roughness(roughness)
            .filter(|ggx| ggx.alpha() * (ior - 1.0).abs() >= SMOOTH_ALPHA);
        Self {
            ior,
            tint,
            facets,
            is_thin: false,
        }
    }

    /// Creates a smooth pane of index `ior` and no thickness, with air on both sides; `tint` multiplies transmitted light.
    #[inline]
    pub fn thin(ior: f32, tint: Rgb) -> Self {
        Self {
            is_thin: true,
            ..Self::new(ior, 0.0, tint)
        }
    }

    /// Returns the surface with another tint.
    #[inline]
    pub fn tinted(&self, tint: Rgb) -> Self {
        Self { tint, ..*self }
    }

    /// Refractive index, inside over outside; 1 for a pane, whose two sides are outside.
    #[inline]
    pub fn ior(&self) -> f32 {
        if self.is_thin { 1.0 } else { self.ior }
    }

    /// Whether both lobes are deltas.
    #[inline]
    pub fn is_delta(&self) -> bool {
        self.facets.is_none()
    }

    /// Evaluates Walter et al. eq. 20 and 21; zero for a smooth surface.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfValue {
        let Some(ggx) = self.facets else {
            return BsdfValue::default();
        };
        if wo.z == 0.0 || wi.z == 0.0 {
            return BsdfValue::default();
        }
        let side = self.side(wo);
        let (wo, wi) = (flip(wo, side.sign), flip(wi, side.sign));
        if wi.z > 0.0 {
            side.eval_reflection(&ggx, wo, wi)
        } else {
            side.eval_refraction(&ggx, wo, wi, self.tint)
        }
    }

    /// Samples reflection with the probability of the Fresnel reflectance, else refraction.
    #[inline]
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let side = self.side(wo);
        match self.facets {
            None if self.is_thin => Some(self.sample_thin(wo, u_lobe)),
            None => Some(self.sample_smooth(&side, wo, u_lobe)),
            Some(ggx) => self.sample_rough(&side, &ggx, wo, u_lobe, u),
        }
    }

    #[inline]
    fn side(&self, wo: Vec3) -> InterfaceSide {
        let (n_o, n_t) = if wo.z > 0.0 {
            (1.0, self.ior)
        } else {
            (self.ior, 1.0)
        };
        InterfaceSide {
            sign: 1.0_f32.copysign(wo.z),
            n_o,
            n_t,
        }
    }

    #[inline]
    fn sample_smooth(&self, side: &InterfaceSide, wo: Vec3, u_lobe: f32) -> BsdfSample {
        let Interface { reflectance, cos_t } = fresnel::dielectric(wo.z.abs(), side.n_o, side.n_t);
        if u_lobe < reflectance {
            return BsdfSample {
                wi: Vec3::new(-wo.x, -wo.y, wo.z),
                weight: Rgb::WHITE,
                pdf: None,
                lobe: Lobe::SpecularReflection,
            };
        }
        let r = side.n_o / side.n_t;
        BsdfSample {
            wi: Vec3::new(-r * wo.x, -r * wo.y, -side.sign * cos_t),
            weight: planted!("eta-squared-forgotten", 1.0, r * r) * self.tint,
            pdf: None,
            lobe: Lobe::SpecularTransmission,
        }
    }

    /// Samples a pane: the sum of all reflections between its sides, with the reflectance R of one, is 2R / (1 + R)
    /// (Stokes 1862).
    #[inline]
    fn sample_thin(&self, wo: Vec3, u_lobe: f32) -> BsdfSample {
        let side = fresnel::dielectric(wo.z.abs(), 1.0, self.ior).reflectance;
        let pane = planted!("pane-of-one-side", side, 2.0 * side / (1.0 + side));
        if u_lobe < pane {
            return BsdfSample {
                wi: Vec3::new(-wo.x, -wo.y, wo.z),
                weight: Rgb::WHITE,
                pdf: None,
                lobe: Lobe::SpecularReflection,
            };
        }
        BsdfSample {
            wi: -wo,
            weight: self.tint,
            pdf: None,
            lobe: Lobe::SpecularTransmission,
        }
    }

    #[inline]
    fn sample_rough(
        &self,
        side: &InterfaceSide,
        ggx: &Ggx,
        wo: Vec3,
        u_lobe: f32,
        u: Vec2,
    ) -> Option<BsdfSample> {
        let wo = flip(wo, side.sign);
        let m = ggx.sample_visible(wo, u);
        let cos_o = wo.dot(m);
        let Interface { reflectance, cos_t } = fresnel::dielectric(cos_o, side.n_o, side.n_t);
        let (wi, value, lobe) = if u_lobe < reflectance {
            let wi = reflect(wo, m);
            if wi.z <= 0.0 {
                return None;
            }
            let value = side.eval_reflection(ggx, wo, wi);
            (wi, value, Lobe::GlossyReflection)
        } else {
            let r = side.n_o / side.n_t;
            let wi = ((r * cos_o - cos_t) * m - r * wo).normalize();
            if wi.z >= 0.0 {
                return None;
            }
            let value = side.eval_refraction(ggx, wo, wi, self.tint);
            (wi, value, Lobe::GlossyTransmission)
        };
        (value.pdf.0 > 0.0).then(|| BsdfSample {
            wi: flip(wi, side.sign),
            weight: (wi.z.abs() / value.pdf.0) * value.f,
            pdf: Some(value.pdf),
            lobe,
        })
    }
}

impl InterfaceSide {
    /// Evaluates reflection, both directions above. Walter et al. eq. 20: f = F G D / (4 cos_o cos_i).
    #[inline]
    fn eval_reflection(&self, ggx: &Ggx, wo: Vec3, wi: Vec3) -> BsdfValue {
        let facets = ggx.reflection_terms(wo, wi);
        let r = fresnel::dielectric(facets.cos, self.n_o, self.n_t).reflectance;
        BsdfValue {
            f: Rgb::grey(r * facets.d_v),
            pdf: PdfSolidAngle(r * facets.pdf),
        }
    }

    /// Evaluates refraction, `wo` above, `wi` below. Walter et al. eq. 21 with eq. 17, whose denominator
    /// n_o (o.m) + n_i (i.m) is the length of the generalised half vector, eq. 16. G is the product of both G1: heights on
    /// the two sides of the surface are uncorrelated.
    #[inline]
    fn eval_refraction(&self, ggx: &Ggx, wo: Vec3, wi: Vec3, tint: Rgb) -> BsdfValue {
        let h = self.n_o * wo + self.n_t * wi;
        let length2 = h.length_squared();
        if length2 == 0.0 {
            return BsdfValue::default();
        }
        // Oriented to the upper side, where wo is.
        let m = h * (1.0_f32.copysign(h.z) / length2.sqrt());
        let (cos_o, cos_i) = (wo.dot(m), -wi.dot(m));
        if cos_o <= 0.0 || cos_i <= 0.0 {
            return BsdfValue::default();
        }
        // From the rarer medium, which has no critical angle: symmetric in wo and wi, and accurate at grazing angles.
        let interface = if self.n_o < self.n_t {
            fresnel::dielectric(cos_o.min(1.0), self.n_o, self.n_t)
        } else {
            fresnel::dielectric(cos_i.min(1.0), self.n_t, self.n_o)
        };
        let t = 1.0 - interface.reflectance;
        let visible = t * ggx.pdf_visible(wo, m) * cos_i / length2;
        let n = planted!("refraction-jacobian", self.n_o, self.n_t);
        BsdfValue {
            // G1(i) / cos_i stays finite at grazing angles.
            f: (visible * self.n_o * self.n_o * ggx.g1_over_cos(flip(wi, -1.0))) * tint,
            pdf: PdfSolidAngle(visible * n * n),
        }
    }
}

/// Mirrors `w` through the tangent plane if `sign` is -1.
#[inline]
fn flip(w: Vec3, sign: f32) -> Vec3 {
    Vec3::new(w.x, w.y, sign * w.z)
}
