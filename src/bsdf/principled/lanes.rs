//! Rough opaque BSDFs in SIMD lanes: principled ones, and conductors, which are principled ones of metal alone whose
//! microfacets reflect by the Fresnel equations.
//!
//! Measure: f per steradian.
//! Range: directions anywhere on the sphere.
//! Source: as in [`Principled`] and [`Conductor`]; both ways give the same bits: tested in `tests/scattering/lanes.rs`.

mod eval;

use super::super::albedo::{RowPlace, SingleScatter, table};
use super::super::conductor::Conductor;
use super::super::microfacet::Ggx;
use super::Principled;
use super::opaque::{LobeProbabilities, OpaqueLobes};
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3, load, store};
use crate::math::rgb::Rgb;
use crate::math::vec::{LaneVec3, Vec2, Vec3};
use std::borrow::Cow;

const ZERO: Lanes<f32> = [0.0; LANES];

/// A BSDF for each lane, bound to a direction.
#[repr(align(64))]
#[derive(Debug, Clone, Copy)]
pub struct PrincipledLanes {
    /// The places in the table of albedos.
    first: Lanes<u32>,
    t: Lanes<f32>,
    alpha: Lanes<f32>,
    f0: Lanes3,
    f90: Lanes<f32>,
    metal_ms: Lanes3,
    base: Lanes3,
    coat_f0: Lanes<f32>,
    base_scale: Lanes<f32>,
    multiple_scale: Lanes<f32>,
    pdf_scale: Lanes<f32>,
    /// Whether the BSDF is a conductor, whose tint is `f0`, and whether any is.
    is_conductor: Lanes<u32>,
    has_conductors: bool,
    eta: Lanes3,
    k: Lanes3,
    wo: Lanes3,
    /// The [`LobeProbabilities`] for `wo`.
    facets: Lanes<f32>,
    multiple: Lanes<f32>,
    diffuse: Lanes<f32>,
    loss: Lanes<f32>,
    schlick: Lanes<f32>,
}

impl Default for PrincipledLanes {
    fn default() -> Self {
        Self {
            first: [0; LANES],
            t: ZERO,
            alpha: [1.0; LANES],
            f0: [ZERO; 3],
            f90: ZERO,
            metal_ms: [ZERO; 3],
            base: [ZERO; 3],
            coat_f0: ZERO,
            base_scale: ZERO,
            multiple_scale: ZERO,
            pdf_scale: ZERO,
            is_conductor: [0; LANES],
            has_conductors: false,
            eta: [[1.0; LANES]; 3],
            k: [ZERO; 3],
            wo: [ZERO; 3],
            facets: ZERO,
            multiple: ZERO,
            diffuse: ZERO,
            loss: ZERO,
            schlick: ZERO,
        }
    }
}

/// The direction that a lane has sampled, before it is weighted.
#[derive(Debug, Clone, Copy)]
pub struct SampledLanes {
    /// The directions in the upper hemisphere, or below it where the sample is lost.
    pub wi: Lanes3,
    /// Whether the direction is that of the diffuse base.
    pub is_diffuse: Lanes<u32>,
    /// Whether the direction has yet to be sampled by multiple scattering.
    pub is_multiple: Lanes<u32>,
}

impl Default for SampledLanes {
    fn default() -> Self {
        Self {
            wi: [ZERO; 3],
            is_diffuse: [0; LANES],
            is_multiple: [0; LANES],
        }
    }
}

/// A rough opaque BSDF.
#[derive(Debug, Clone)]
pub enum RoughBsdf<'a> {
    /// A principled BSDF.
    Principled(Cow<'a, Principled>),
    /// A metal.
    Conductor(&'a Conductor),
}

impl RoughBsdf<'_> {
    /// Samples a direction by the multiple scattering of the metal.
    #[inline]
    pub fn sample_multiple(&self, u: Vec2) -> Vec3 {
        match self {
            Self::Principled(bsdf) => bsdf.sample_multiple(u),
            Self::Conductor(bsdf) => bsdf.sample_multiple(u),
        }
    }
}

impl PrincipledLanes {
    /// Removes all BSDFs, before those of other surfaces are set.
    #[inline]
    pub fn clear(&mut self) {
        self.has_conductors = false;
    }

    /// Sets the BSDF of a lane.
    #[inline]
    pub fn set(&mut self, lane: usize, bsdf: &RoughBsdf<'_>, place: RowPlace) {
        (self.first[lane], self.t[lane]) = (place.first, place.t);
        self.alpha[lane] = place.alpha;
        match bsdf {
            RoughBsdf::Principled(bsdf) => self.set_principled(lane, bsdf),
            RoughBsdf::Conductor(bsdf) => self.set_conductor(lane, bsdf),
        }
    }

    #[inline]
    fn set_conductor(&mut self, lane: usize, bsdf: &Conductor) {
        self.is_conductor[lane] = 1;
        self.has_conductors = true;
        store(&mut self.eta, lane, bsdf.eta);
        store(&mut self.k, lane, bsdf.k);
        store(&mut self.f0, lane, bsdf.tint);
        store(&mut self.metal_ms, lane, bsdf.f_ms);
        store(&mut self.base, lane, Rgb::BLACK);
        (self.f90[lane], self.coat_f0[lane], self.base_scale[lane]) = (1.0, 0.0, 0.0);
        (self.multiple_scale[lane], self.pdf_scale[lane]) = bsdf.albedo.scales();
    }

    #[inline]
    fn set_principled(&mut self, lane: usize, bsdf: &Principled) {
        let lobes = &bsdf.opaque;
        self.is_conductor[lane] = 0;
        store(&mut self.f0, lane, lobes.f0);
        self.f90[lane] = lobes.f90;
        store(&mut self.metal_ms, lane, lobes.metal_ms);
        store(&mut self.base, lane, lobes.base);
        self.coat_f0[lane] = lobes.coat_f0;
        self.base_scale[lane] = lobes.base_scale;
        self.multiple_scale[lane] = lobes.multiple_scale;
        self.pdf_scale[lane] = lobes.pdf_scale;
    }

    /// The BSDF of a lane in all lanes, not bound to any direction.
    pub fn repeated(&self, lane: usize) -> Self {
        let one = |lanes: &Lanes<f32>| [lanes[lane]; LANES];
        let three = |lanes: &Lanes3| lanes.each_ref().map(one);
        Self {
            first: [self.first[lane]; LANES],
            t: one(&self.t),
            alpha: one(&self.alpha),
            f0: three(&self.f0),
            f90: one(&self.f90),
            metal_ms: three(&self.metal_ms),
            base: three(&self.base),
            coat_f0: one(&self.coat_f0),
            base_scale: one(&self.base_scale),
            multiple_scale: one(&self.multiple_scale),
            pdf_scale: one(&self.pdf_scale),
            is_conductor: [self.is_conductor[lane]; LANES],
            has_conductors: self.is_conductor[lane] != 0,
            eta: three(&self.eta),
            k: three(&self.k),
            ..Self::default()
        }
    }

    /// The roughness parameter of a lane's microfacets.
    pub fn alpha(&self, lane: usize) -> f32 {
        self.alpha[lane]
    }

    /// Whether a lane has a diffuse base.
    pub fn has_base(&self, lane: usize) -> bool {
        load::<Rgb>(&self.base, lane).max_channel() > 0.0
    }

    /// Whether a lane reflects any light.
    pub fn reflects(&self, lane: usize) -> bool {
        let of_facets = load::<Rgb>(&self.f0, lane).max_channel();
        let is_dielectric = self.is_conductor[lane] == 0 && self.f90[lane] > 0.0;
        self.has_base(lane) || of_facets > 0.0 || is_dielectric
    }

    #[inline(always)]
    fn lobes(&self, lane: usize) -> OpaqueLobes<LaneVec3> {
        OpaqueLobes {
            ggx: Ggx::new(self.alpha[lane]),
            f0: load(&self.f0, lane),
            f90: self.f90[lane],
            metal_ms: load(&self.metal_ms, lane),
            base: load(&self.base, lane),
            coat_f0: self.coat_f0[lane],
            base_scale: self.base_scale[lane],
            multiple_scale: self.multiple_scale[lane],
            pdf_scale: self.pdf_scale[lane],
        }
    }

    #[inline(always)]
    fn place(&self, lane: usize) -> RowPlace {
        RowPlace {
            first: self.first[lane],
            t: self.t[lane],
            alpha: self.alpha[lane],
        }
    }

    #[inline(always)]
    fn lobe_probabilities(&self, lane: usize) -> LobeProbabilities {
        LobeProbabilities {
            facets: self.facets[lane],
            metal_ms: self.multiple[lane],
            base: self.diffuse[lane],
            glass: 0.0,
            o: SingleScatter {
                loss: self.loss[lane],
                schlick: self.schlick[lane],
            },
        }
    }

    /// Binds the BSDFs to the directions `wo`.
    pub fn bind(&mut self, wo: &Lanes3) {
        self.wo = *wo;
        eval::bind(table(), self);
    }

    /// Samples a direction for each of the active lanes by `numbers`, two for the direction and one for the lobe;
    /// `cosine_direction` are the cosine-weighted directions of the former. `sample_multiple` samples the multiple
    /// scattering of a lane.
    pub fn sample(
        &self,
        active: &ActiveLanes<LANES>,
        numbers: &[Lanes<f32>; 3],
        cosine_direction: &Lanes3,
        sample_multiple: impl Fn(usize, Vec2) -> Vec3,
        sampled: &mut SampledLanes,
    ) {
        eval::sample(self, numbers, cosine_direction, sampled);
        // Metal that is sampled by its multiple scattering is rare.
        for lane in active.and(|lane| sampled.is_multiple[lane] != 0).each() {
            let u = Vec2::new(numbers[0][lane], numbers[1][lane]);
            store(&mut sampled.wi, lane, sample_multiple(lane, u));
        }
    }

    /// Evaluates the BSDFs at the directions `wi`: f without the cosine, and the density of sampling.
    pub fn eval(&self, wi: &Lanes3, f: &mut Lanes3, pdf: &mut Lanes<f32>) {
        let reverse_pdf = &mut ZERO.clone();
        if self.has_conductors {
            eval::eval_with_conductors::<false>(table(), self, wi, f, pdf, reverse_pdf);
        } else {
            eval::eval::<false>(table(), self, wi, f, pdf, reverse_pdf);
        }
    }

    /// Evaluates the BSDFs as [`eval`](Self::eval), and the densities of sampling `wo` if they were bound to `wi`, which
    /// takes no further look-up of albedos.
    pub fn eval_both_ways(
        &self,
        wi: &Lanes3,
        f: &mut Lanes3,
        pdf: &mut Lanes<f32>,
        reverse_pdf: &mut Lanes<f32>,
    ) {
        if self.has_conductors {
            eval::eval_with_conductors::<true>(table(), self, wi, f, pdf, reverse_pdf);
        } else {
            eval::eval::<true>(table(), self, wi, f, pdf, reverse_pdf);
        }
    }
}
