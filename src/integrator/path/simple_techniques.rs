//! The decisions of a path at a surface by the rules of its technique: whether it ends, and in which direction it
//! continues.
//!
//! Measure: probabilities; densities per steradian.
//! Range: any technique; where it is known at compile time, nothing is compiled for the other rules.
//! Source: the path tracers of the course, see `technique.rs`. Tested in `tests/rendering/integrators.rs`.

use super::super::technique::{DirectionRule, EmissionRule, Technique};
use crate::bsdf::{BoundBsdf, BsdfSample, BsdfSampleInput, Lobe};
use crate::effects::{Effect, Effects};
use crate::math::measure::PdfSolidAngle;
use crate::math::rgb::Rgb;
use crate::sampler::{Decision, Sampler};
use crate::sampling::warp::{PDF_SPHERE_UNIFORM, sample_sphere_uniform};

/// Whether a path ends at random with a surface's emission, and the factors of both cases.
pub(super) struct Termination {
    /// Whether the path ends.
    pub(super) ends: bool,
    /// The factor of the emission: one over the probability of counting it, or 0 if it is not counted.
    pub(super) emission_factor: f32,
    /// The factor of the continuing path: one over the probability of continuing.
    pub(super) continuation_factor: f32,
}

/// Decides whether the path ends, by the technique's probability, if it has one.
#[inline(always)]
pub(super) fn sample_termination<S: Sampler>(
    technique: Technique,
    emitted: Option<Rgb>,
    sampler: &mut S,
    bounce: u32,
) -> Termination {
    let p = match technique.emission {
        EmissionRule::Always => {
            return Termination {
                ends: false,
                emission_factor: 1.0,
                continuation_factor: 1.0,
            };
        }
        EmissionRule::Termination { lit, .. } if emitted.is_some_and(|light| !light.is_black()) => {
            lit
        }
        EmissionRule::Termination { unlit, .. } => unlit,
    };
    let [u] = sampler.draw(Decision::Emission(bounce));
    let ends = u < p;
    Termination {
        ends,
        emission_factor: if ends { 1.0 / p } else { 0.0 },
        continuation_factor: 1.0 / (1.0 - p),
    }
}

/// Samples the direction in which the path continues, by the technique's rule.
#[inline(always)]
pub(super) fn sample_direction<E: Effects>(
    bound: &BoundBsdf,
    technique: Technique,
    input: &BsdfSampleInput,
) -> Option<BsdfSample> {
    match technique.directions {
        DirectionRule::Bsdf => bound.sample::<E>(input),
        DirectionRule::Uniform => sample_uniformly::<E>(bound, input),
    }
}

/// Samples a uniform direction on the viewer's side, or on both sides of a transmissive surface.
///
/// No such direction is that of a delta lobe. On a surface that has one, half of the samples are BSDF samples, which
/// count only if they are of the delta lobe.
fn sample_uniformly<E: Effects>(bound: &BoundBsdf, input: &BsdfSampleInput) -> Option<BsdfSample> {
    let bsdf = bound.bsdf();
    if bsdf.is_delta::<E>() {
        return bound.sample::<E>(input);
    }
    let u_lobe = input.lobe;
    let effects = bsdf.effects();
    let mut share = 1.0;
    if effects.has(Effect::Specular) {
        share = 0.5;
        if u_lobe < share {
            let rest = BsdfSampleInput {
                lobe: u_lobe / share,
                ..*input
            };
            let sample = bound.sample::<E>(&rest)?;
            return sample.pdf.is_none().then(|| BsdfSample {
                weight: sample.weight * (1.0 / share),
                ..sample
            });
        }
    }
    let wo = bound.wo();
    let mut wi = sample_sphere_uniform(input.u);
    let mut pdf = share * PDF_SPHERE_UNIFORM;
    if !effects.has(Effect::Transmission) {
        wi.z = wi.z.abs().copysign(wo.z);
        pdf *= 2.0;
    }
    let f = bound.eval::<E>(wi).f;
    (!f.is_black()).then(|| BsdfSample {
        wi,
        weight: f * (wi.z.abs() / pdf),
        pdf: Some(PdfSolidAngle(pdf)),
        lobe: if wi.z * wo.z < 0.0 {
            Lobe::GlossyTransmission
        } else {
            Lobe::Diffuse
        },
    })
}
