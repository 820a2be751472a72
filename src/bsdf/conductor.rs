//! The conductor BSDF: GGX microfacets with Fresnel reflectance, and compensation for multiple scattering between them.
//!
//! f = F D G2 / (4 cos_o cos_i) + F_ms (1 - E_o) (1 - E_i) / (pi (1 - E_mean)): without absorption the albedo is 1.
//! A tint is a factor of F.
//!
//! Measure: f per steradian.
//! Range: `eta` above 0 and `k` at least 0, relative to the medium outside; roughness in [0, 1], a delta below 0.01.
//! Both sides scatter alike.
//! Source: Heitz 2014 for single scattering; Kulla and Conty 2017 for the compensation, with F_ms of Jakob et al. 2014.
//! Tested in `tests/scattering/bsdf.rs` and `tests/scattering/furnace.rs`. `principled/lanes.rs` has the rough ones in lanes.

use super::albedo::{AlbedoRow, RowPlace, SingleScatter};
use super::fresnel;
use super::microfacet::Ggx;
use super::types::{BsdfSample, BsdfValue, Lobe, effects_of_lobes, facing_up};
use crate::effects::EffectSet;
use crate::math::{
    measure::PdfSolidAngle,
    rgb::Rgb,
    vec::{Vec2, Vec3},
};
use crate::planted::planted;

/// A metal surface.
#[derive(Debug, Clone, Copy)]
pub struct Conductor {
    pub(super) eta: Rgb,
    pub(super) k: Rgb,
    pub(super) tint: Rgb,
    facets: Option<Ggx>,
    pub(super) albedo: AlbedoRow,
    /// F_ms, the colour of multiple scattering.
    pub(super) f_ms: Rgb,
}

/// The refractive indices of metals, eta and k, at 630, 532 and 465 nm, interpolated in measured data.
///
/// Johnson and Christy 1972 (noble metals) and 1974 (transition metals), Hagemann, Gudat and Kunz 1974 (aluminium),
/// Weaver, Olson and Lynch 1975 (tungsten), as collected by refractiveindex.info in the public domain.
pub const PRESETS: &[(&str, Rgb, Rgb)] = &[
    (
        "gold",
        Rgb::new(0.19, 0.54, 1.33),
        Rgb::new(3.40, 2.23, 1.87),
    ),
    (
        "silver",
        Rgb::new(0.06, 0.05, 0.05),
        Rgb::new(4.25, 3.43, 2.80),
    ),
    (
        "copper",
        Rgb::new(0.28, 1.12, 1.25),
        Rgb::new(3.37, 2.60, 2.46),
    ),
    (
        "aluminium",
        Rgb::new(1.36, 0.92, 0.69),
        Rgb::new(7.38, 6.31, 5.57),
    ),
    (
        "iron",
        Rgb::new(2.89, 2.90, 2.65),
        Rgb::new(3.06, 2.92, 2.81),
    ),
    (
        "chromium",
        Rgb::new(3.15, 3.03, 2.46),
        Rgb::new(3.31, 3.33, 3.21),
    ),
    (
        "nickel",
        Rgb::new(1.99, 1.88, 1.76),
        Rgb::new(4.09, 3.50, 3.05),
    ),
    (
        "titanium",
        Rgb::new(2.70, 2.48, 2.31),
        Rgb::new(3.76, 3.35, 3.08),
    ),
    (
        "tungsten",
        Rgb::new(3.62, 3.50, 3.33),
        Rgb::new(2.91, 2.72, 2.57),
    ),
];

/// Returns the indices (eta, k) of a metal by its name.
pub fn preset(name: &str) -> Option<(Rgb, Rgb)> {
    let found = PRESETS.iter().find(|(known, _, _)| *known == name);
    found.map(|&(_, eta, k)| (eta, k))
}

impl Conductor {
    /// Creates a metal of index `eta` + i `k`. Integrates the Fresnel reflectance: call it once per material, not per hit.
    pub fn new(eta: Rgb, k: Rgb, roughness: f32) -> Self {
        let facets = Ggx::from_roughness(roughness);
        let albedo = AlbedoRow::of(facets);
        let f_ms = multiple_scattering_colour(fresnel::conductor_mean(eta, k), albedo.mean());
        Self {
            eta,
            k,
            tint: Rgb::WHITE,
            facets,
            albedo,
            f_ms,
        }
    }

    /// Returns the metal with its Fresnel reflectance multiplied by `tint`.
    pub fn tinted(self, tint: Rgb) -> Self {
        let mean = tint * fresnel::conductor_mean(self.eta, self.k);
        Self {
            tint,
            f_ms: multiple_scattering_colour(mean, self.albedo.mean()),
            ..self
        }
    }

    /// Whether the surface is smooth, so that its lobe is a delta.
    #[inline]
    pub fn is_delta(&self) -> bool {
        self.facets.is_none()
    }

    /// The effects that a kernel needs for this BSDF.
    pub fn effects(&self) -> EffectSet {
        effects_of_lobes(self.is_delta())
    }

    /// The place in the table of albedos, if the surface is rough, so that its BSDF can be evaluated in lanes.
    #[inline]
    pub fn place_in_lanes(&self) -> Option<RowPlace> {
        self.albedo.place()
    }

    /// Samples a direction by multiple scattering.
    #[inline]
    pub fn sample_multiple(&self, u: Vec2) -> Vec3 {
        self.albedo.sample_multiple(u)
    }

    /// Evaluates single and multiple scattering; zero for a smooth surface.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfValue {
        match (self.facets, facing_up(wo, wi)) {
            (Some(ggx), Some((wo, wi))) => self.eval_rough(&ggx, wo, wi, self.albedo.at(wo.z)),
            _ => BsdfValue::default(),
        }
    }

    /// Samples the multiple scattering lobe with the probability of the loss, else a reflection about a visible normal.
    #[inline]
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let up = Vec3::new(wo.x, wo.y, wo.z.abs());
        let Some(ggx) = self.facets else {
            return Some(BsdfSample {
                wi: Vec3::new(-wo.x, -wo.y, wo.z),
                weight: self.tint * fresnel::conductor_rgb(up.z, self.eta, self.k),
                pdf: None,
                lobe: Lobe::SpecularReflection,
            });
        };
        let o = self.albedo.at(up.z);
        let mut wi = if u_lobe < o.loss {
            self.sample_multiple(u)
        } else {
            ggx.sample_reflection(up, u)
        };
        if wi.z <= 0.0 {
            return None;
        }
        let value = self.eval_rough(&ggx, up, wi, o);
        let weight = (wi.z / value.pdf.0) * value.f;
        wi.z = wi.z.copysign(wo.z);
        Some(BsdfSample {
            wi,
            weight,
            pdf: Some(value.pdf),
            lobe: Lobe::GlossyReflection,
        })
    }

    /// Evaluates a rough surface, both directions above it; `o` is the single scattering towards `wo`.
    #[inline]
    fn eval_rough(&self, ggx: &Ggx, wo: Vec3, wi: Vec3, o: SingleScatter) -> BsdfValue {
        let facets = ggx.reflection_terms(wo, wi);
        let fresnel = self.tint * fresnel::conductor_rgb(facets.cos, self.eta, self.k);
        let ms = self.albedo.multiple_scattering(o, self.albedo.at(wi.z));
        let pdf = (1.0 - o.loss) * facets.pdf + o.loss * self.albedo.pdf_multiple(wi.z);
        BsdfValue {
            f: facets.d_v * fresnel + ms * self.f_ms,
            pdf: PdfSolidAngle(pdf),
        }
    }
}

/// The colour of light that hit microfacets at least twice: F^2 E / (1 - F (1 - E)), all of them means. Jakob et al.
/// 2014, "A Comprehensive Framework for Rendering Layered Materials", section 5.6.
#[inline]
pub fn multiple_scattering_colour(f_mean: Rgb, mean: SingleScatter) -> Rgb {
    f_mean.map(|f| {
        f * planted!("facets-met-but-once", 1.0, f) * (1.0 - mean.loss) / (1.0 - f * mean.loss)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiple_scattering_colour_matches_the_geometric_series() {
        let colour = Rgb::new(0.2, 0.7, 0.99);
        let loss = 0.3;
        let mean = SingleScatter { loss, schlick: 0.0 };
        // After each hit of a microfacet the fraction `loss` hits another one; after two or more hits the rest escapes.
        let mut sum = Rgb::BLACK;
        let mut remaining = loss * colour;
        for _ in 0..1000 {
            remaining *= colour;
            sum += (1.0 - loss) * remaining;
            remaining = loss * remaining;
        }
        let ratio = (loss * multiple_scattering_colour(colour, mean)).to_array();
        for (got, want) in ratio.into_iter().zip(sum.to_array()) {
            assert!((got / want - 1.0).abs() < 1e-5, "{got} {want}");
        }
    }
}
