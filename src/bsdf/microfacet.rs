//! The isotropic GGX microfacet distribution with Smith's masking-shadowing function.
//!
//! Measure: densities per steradian, of the microfacet normal `m` or of the reflected direction, as stated at each item.
//! Range: alpha in [[`SMOOTH_ALPHA`], 1]; below, the surface is treated as smooth and its BSDFs use delta lobes.
//! Directions and `m` are in the upper hemisphere (z > 0); callers mirror those below.
//! Source: Walter et al. 2007; Heitz 2014 (JCGT 3-2), "Understanding the Masking-Shadowing Function"; Dupuy and Benyoub
//! 2023, "Sampling Visible GGX Normals with Spherical Caps". Tested in `tests/scattering/bsdf.rs` and
//! `tests/scattering/furnace.rs`.

use crate::math::trig::sin_cos_turns;
use crate::math::vec::{Vec2, Vec3, Vector};
use crate::planted::planted;
use std::f32::consts::FRAC_1_PI;

/// The alpha below which a surface is treated as smooth: its lobe, 1e-4 rad wide, is at the resolution of `f32` directions.
pub const SMOOTH_ALPHA: f32 = 1e-4;

/// The terms of microfacet reflection for a pair of directions, at their half vector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReflectionTerms {
    /// The cosine between either direction and the half vector: half the length of wo + wi. This form is exactly
    /// symmetric in wo and wi, and accurate also at grazing angles, where wo.m cancels.
    pub cos: f32,
    /// D V, which times the Fresnel reflectance is f: V = G2(wo, wi) / (4 cos_o cos_i) with the height-correlated
    /// G2 = 1 / (1 + Lambda_o + Lambda_i). Heitz 2014 eq. 99.
    pub d_v: f32,
    /// The density of [`Ggx::sample_reflection`] per steradian.
    pub pdf: f32,
}

/// A GGX distribution of a given roughness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ggx {
    alpha: f32,
    alpha2: f32,
}

impl Ggx {
    /// Creates the distribution whose slopes have the scale `alpha`.
    #[inline]
    pub fn new(alpha: f32) -> Self {
        Self {
            alpha,
            alpha2: alpha * alpha,
        }
    }

    /// Creates the distribution of a perceptual roughness in [0, 1], alpha = roughness^2; `None` for a smooth surface.
    #[inline]
    pub fn from_roughness(roughness: f32) -> Option<Self> {
        let alpha = roughness * roughness;
        (alpha >= SMOOTH_ALPHA).then(|| Self::new(alpha.min(1.0)))
    }

    /// The scale alpha of the slopes.
    #[inline]
    pub fn alpha(&self) -> f32 {
        self.alpha
    }

    /// D(m), the area of microfacets per unit of surface area and steradian. Walter et al. eq. 33.
    ///
    /// cos^2 alpha^2 + sin^2 from the components does not cancel, unlike cos^2 (alpha^2 - 1) + 1.
    #[inline]
    pub fn d(&self, m: Vec3) -> f32 {
        let sin2 = m.x * m.x + m.y * m.y;
        let t = m.z * m.z * self.alpha2 + sin2;
        FRAC_1_PI * self.alpha2 / (t * t)
    }

    /// cos sqrt(1 + alpha^2 tan^2) = cos (1 + 2 Lambda(w)), Heitz 2014 eq. 72: G1 and G2 are functions of this and of cos.
    #[inline(always)]
    fn stretched_cos<V: Vector>(&self, w: V) -> f32 {
        let [x, y, z] = w.into();
        (z * z + self.alpha2 * (x * x + y * y)).sqrt()
    }

    /// G1(w) / cos with G1(w) = 1 / (1 + Lambda(w)), the fraction of microfacets visible from `w`; finite also where `w` is
    /// tangential. Heitz 2014 eq. 43.
    #[inline]
    pub fn g1_over_cos(&self, w: Vec3) -> f32 {
        2.0 / (w.z + self.stretched_cos(w))
    }

    /// 1 - G2(wo, wi) / G1(wo): the fraction of the light reflected by the microfacets visible from `wo` that is shadowed.
    /// Accurate also where it is small.
    #[inline]
    pub fn shadowed(&self, wo: Vec3, wi: Vec3) -> f32 {
        let (so, si) = (self.stretched_cos(wo), self.stretched_cos(wi));
        // s - cos = (s^2 - cos^2) / (s + cos).
        let excess = self.alpha2 * (wi.x * wi.x + wi.y * wi.y) / (si + wi.z);
        wo.z * excess / (wi.z * so + wo.z * si)
    }

    /// Samples a microfacet normal visible from `wo`, with density [`Ggx::pdf_visible`].
    #[inline]
    pub fn sample_visible(&self, wo: Vec3, u: Vec2) -> Vec3 {
        self.visible(wo, u).normalize()
    }

    /// Samples a visible normal and reflects `wo` about it, with density [`Ggx::pdf_reflection`]. The result may lie below
    /// the surface.
    #[inline(always)]
    pub fn sample_reflection<V: Vector>(&self, wo: V, u: Vec2) -> V {
        let m = self.visible(wo, u);
        m * (2.0 * wo.dot(m) / m.length_squared()) - wo
    }

    /// Samples a visible normal, not normalised. Dupuy and Benyoub 2023, listing 3.
    #[inline(always)]
    fn visible<V: Vector>(&self, wo: V, u: Vec2) -> V {
        let stretched = V::new(self.alpha * wo.x(), self.alpha * wo.y(), wo.z());
        let [w_x, w_y, w_z] = (stretched / stretched.length()).into();
        // A point on the cap of the sphere above -w.z; `t` is its depth below the pole, which keeps 1 - z^2 exact.
        let t = u.y * (1.0 + w_z);
        let sin = (t * (2.0 - t)).max(0.0).sqrt();
        let (sin_phi, cos_phi) = sin_cos_turns(u.x);
        // z + w.z in the form that stays positive.
        let h_z = (1.0 - u.y) * (1.0 + w_z);
        V::new(
            self.alpha * (sin * cos_phi + w_x),
            self.alpha * (sin * sin_phi + w_y),
            h_z,
        )
    }

    /// Computes the reflection terms of two directions, both above the surface.
    ///
    /// D needs no unit normal: with h = wo + wi it is alpha^2 / pi (|h|^2 / (alpha^2 h_z^2 + h_x^2 + h_y^2))^2.
    #[inline(always)]
    pub fn reflection_terms<V: Vector>(&self, wo: V, wi: V) -> ReflectionTerms {
        let h = wo + wi;
        let length2 = h.length_squared();
        let [x, y, z] = h.into();
        let stretched = z * z * self.alpha2 + (x * x + y * y);
        // Both are zero where the squares of opposite, extremely grazing directions underflow: D is then zero.
        let ratio = length2 / stretched.max(f32::MIN_POSITIVE);
        let half_d = 0.5 * FRAC_1_PI * self.alpha2 * (ratio * ratio);
        let (so, si) = (self.stretched_cos(wo), self.stretched_cos(wi));
        let (cos_o, cos_i) = (wo.z(), wi.z());
        ReflectionTerms {
            cos: (0.5 * length2.sqrt()).min(1.0),
            d_v: planted!(
                "shadowing-uncorrelated",
                2.0 * half_d / ((cos_o + so) * (cos_i + si)),
                half_d / (cos_i * so + cos_o * si)
            ),
            pdf: planted!(
                "half-vector-jacobian",
                2.0 * length2.sqrt() * half_d,
                half_d
            ) / (cos_o + so),
        }
    }

    /// The density of [`Ggx::sample_visible`] per steradian of `m`: G1(wo) max(0, wo.m) D(m) / cos_o. Heitz 2014 eq. 16.
    #[inline]
    pub fn pdf_visible(&self, wo: Vec3, m: Vec3) -> f32 {
        4.0 * wo.dot(m).max(0.0) * self.pdf_reflection(wo, m)
    }

    /// The density of [`Ggx::sample_reflection`] per steradian, as a function of the normal: pdf_visible / (4 wo.m).
    #[inline]
    pub fn pdf_reflection(&self, wo: Vec3, m: Vec3) -> f32 {
        0.25 * self.d(m) * self.g1_over_cos(wo)
    }
}
