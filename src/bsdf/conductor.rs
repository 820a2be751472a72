//! Metal: GGX facets under Fresnel's law, with the light that bounces between facets added back.
//!
//! f = F D G2 / (4 cos_o cos_i) + F_ms (1 - E_o) (1 - E_i) / (pi (1 - E_mean)): a metal that absorbs nothing reflects all.
//!
//! Measure: f per steradian.
//! Range: `eta` above 0 and `k` at least 0, relative to the medium outside; roughness in [0, 1], a delta below 0.01.
//! Scatters from both sides alike.
//! Source: Heitz 2014 for single scattering; Kulla and Conty 2017 for the compensation, with F_ms of Jakob et al. 2014.
//! Tested in `tests/bsdf.rs`.

use super::albedo::{AlbedoRow, SingleScatter};
use super::fresnel;
use super::microfacet::Ggx;
use super::types::{BsdfSample, BsdfValue, Lobe, facing_up};
use crate::math::{
    measure::PdfSolidAngle,
    rgb::Rgb,
    vec::{Vec2, Vec3, reflect},
};
use crate::sampling::warp::{pdf_hemisphere_cosine, sample_hemisphere_cosine};

/// A metal surface.
#[derive(Debug, Clone, Copy)]
pub struct Conductor {
    eta: Rgb,
    k: Rgb,
    facets: Option<Ggx>,
    albedo: AlbedoRow,
    /// Colour of the light scattered more than once.
    f_ms: Rgb,
}

/// Indices of metals, eta and k, at about 630, 532 and 465 nm: Johnson and Christy 1972 and 1974, Rakic 1995 and 1998,
/// Palik 1985, rounded.
pub const PRESETS: &[(&str, Rgb, Rgb)] = &[];

/// The indices (eta, k) of a metal by its name.
pub fn preset(name: &str) -> Option<(Rgb, Rgb)> {
    let found = PRESETS.iter().find(|(known, _, _)| *known == name);
    found.map(|&(_, eta, k)| (eta, k))
}

impl Conductor {
    /// A metal of index `eta` + i `k`. Integrates Fresnel's law: made once per material, not per hit.
    pub fn new(eta: Rgb, k: Rgb, roughness: f32) -> Self {
        let facets = Ggx::from_roughness(roughness);
        let albedo = AlbedoRow::of(facets);
        let f_ms = multiple_scattering_colour(fresnel::conductor_mean(eta, k), albedo.mean());
        Self {
            eta,
            k,
            facets,
            albedo,
            f_ms,
        }
    }

    /// Whether the surface is smooth.
    #[inline]
    pub fn is_delta(&self) -> bool {
        self.facets.is_none()
    }

    /// Single and multiple scattering; nothing for a smooth surface.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfValue {
        match (self.facets, facing_up(wo, wi)) {
            (Some(ggx), Some((wo, wi))) => self.eval_rough(&ggx, wo, wi, self.albedo.at(wo.z)),
            _ => BsdfValue::default(),
        }
    }

    /// Mirrors about a visible normal, or by the cosine with the probability of scattering more than once.
    #[inline]
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let up = Vec3::new(wo.x, wo.y, wo.z.abs());
        let Some(ggx) = self.facets else {
            return Some(BsdfSample {
                wi: Vec3::new(-wo.x, -wo.y, wo.z),
                weight: fresnel::conductor_rgb(up.z, self.eta, self.k),
                pdf: None,
                lobe: Lobe::SpecularReflection,
            });
        };
        let o = self.albedo.at(up.z);
        let mut wi = if u_lobe < o.loss {
            sample_hemisphere_cosine(u)
        } else {
            reflect(up, ggx.sample_visible(up, u))
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

    /// Both directions above; `o` is the single scattering towards `wo`.
    #[inline]
    fn eval_rough(&self, ggx: &Ggx, wo: Vec3, wi: Vec3, o: SingleScatter) -> BsdfValue {
        let m = (wo + wi).normalize();
        let fresnel = fresnel::conductor_rgb(wo.dot(m).min(1.0), self.eta, self.k);
        let ms = self.albedo.multiple_scattering(o, self.albedo.at(wi.z));
        let pdf = (1.0 - o.loss) * ggx.pdf_mirrored(wo, m) + o.loss * pdf_hemisphere_cosine(wi.z);
        BsdfValue {
            f: (ggx.d(m) * ggx.visibility(wo, wi)) * fresnel + ms * self.f_ms,
            pdf: PdfSolidAngle(pdf),
        }
    }
}

/// The colour of light that met the facets at least twice: F^2 E / (1 - F (1 - E)), means all. Jakob et al. 2014, "A
/// Comprehensive Framework for Rendering Layered Materials", section 5.6.
#[inline]
pub fn multiple_scattering_colour(f_mean: Rgb, mean: SingleScatter) -> Rgb {
    f_mean.map(|f| f * f * (1.0 - mean.loss) / (1.0 - f * mean.loss))
}
