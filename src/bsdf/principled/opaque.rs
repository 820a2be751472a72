//! The lobes of the principled model that scatter to one side: metal, and a coat over a diffuse base.
//!
//! Measure: f per steradian.
//! Range: directions in the upper hemisphere; any vector type, so that paths are scattered alone or in SIMD lanes.
//! Source: as in [`Principled`](super::Principled).

use super::super::albedo::{SingleScatter, multiple_scattering, pdf_multiple};
use super::super::fresnel::schlick_weight;
use super::super::microfacet::Ggx;
use super::super::types::BsdfValue;
use crate::math::measure::PdfSolidAngle;
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec3, Vector};
use crate::planted::planted;
use crate::sampling::warp::pdf_hemisphere_cosine;

/// The lobes at a point of a surface.
#[derive(Debug, Clone, Copy)]
pub struct OpaqueLobes<V = Vec3> {
    /// The distribution of the microfacets of metal and coat, if the surface is rough.
    pub ggx: Ggx,
    /// Reflectance of the microfacets at normal incidence, metal and coat together.
    pub f0: Rgb<V>,
    /// Reflectance of the microfacets at grazing angles: the fraction of the surface that is not glass.
    pub f90: f32,
    /// Colour of the metal's multiple scattering.
    pub metal_ms: Rgb<V>,
    /// Colour of the diffuse base.
    pub base: Rgb<V>,
    /// Reflectance of the coat alone at normal incidence.
    pub coat_f0: f32,
    /// 1 / (pi (1 - S_mean)).
    pub base_scale: f32,
    /// The factors of [`AlbedoRow::scales`](super::super::albedo::AlbedoRow::scales).
    pub multiple_scale: f32,
    /// The factor of the density of multiple scattering.
    pub pdf_scale: f32,
}

/// The probabilities of sampling each lobe for a given `wo`, which sum to one.
#[derive(Debug, Clone, Copy)]
pub struct LobeProbabilities {
    /// The microfacets.
    pub facets: f32,
    /// Multiple scattering of the metal.
    pub metal_ms: f32,
    /// The diffuse base.
    pub base: f32,
    /// The glass.
    pub glass: f32,
    /// The single scattering towards `wo`, kept for evaluation.
    pub o: SingleScatter,
}

impl<V: Vector> OpaqueLobes<V> {
    /// Computes each lobe's share of the albedo by the brightest channel, given the single scattering towards `wo` and
    /// the share of glass.
    #[inline(always)]
    pub fn lobe_probabilities(&self, o: SingleScatter, glass_share: f32) -> LobeProbabilities {
        let facets = o.reflected(self.f0.max_channel(), self.f90);
        let through = 1.0 - o.reflected(self.coat_f0, 1.0);
        let base = self.base.max_channel() * through;
        let metal_ms = self.metal_ms.max_channel() * o.loss;
        let sum = facets + base + metal_ms + glass_share;
        let scale = 1.0 / sum.max(f32::MIN_POSITIVE);
        LobeProbabilities {
            facets: facets * scale,
            metal_ms: metal_ms * scale,
            base: base * scale,
            glass: glass_share * scale,
            o,
        }
    }

    /// Evaluates all lobes except deltas, given the single scattering towards `wi` and the reflectance of the microfacets by
    /// the cosine. A smooth surface has microfacets that are deltas. Free of branches if `is_rough` is constant.
    #[inline(always)]
    pub fn eval(
        &self,
        wo: V,
        wi: V,
        probabilities: &LobeProbabilities,
        i: SingleScatter,
        is_rough: bool,
        reflectance: impl FnOnce(f32) -> Rgb<V>,
    ) -> BsdfValue<V> {
        let o = probabilities.o;
        let through = |s: SingleScatter| (1.0 - s.reflected(self.coat_f0, 1.0)).max(0.0);
        let base = self.base_scale * through(o) * through(i);
        let ms = multiple_scattering(o, i, self.multiple_scale);
        let mut f = self.base * base + self.metal_ms * ms;
        let mut pdf = probabilities.base * pdf_hemisphere_cosine(wi.z());
        if is_rough {
            let facets = self.ggx.reflection_terms(wo, wi);
            f += reflectance(facets.cos) * facets.d_v;
            let metal_ms = planted!("lobe-left-out-of-pdf", 0.0, probabilities.metal_ms);
            let alpha = self.ggx.alpha();
            let of_multiple = pdf_multiple(wi.z(), alpha * alpha, self.pdf_scale);
            pdf += probabilities.facets * facets.pdf + metal_ms * of_multiple;
        }
        BsdfValue {
            f,
            pdf: PdfSolidAngle(pdf),
        }
    }

    /// The reflectance of the microfacets by Schlick's approximation.
    #[inline(always)]
    pub fn schlick(&self, cos: f32) -> Rgb<V> {
        let f90 = Rgb::from([self.f90; 3]);
        self.f0 + (f90 - self.f0) * schlick_weight(cos)
    }
}
