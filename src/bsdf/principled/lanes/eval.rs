//! Sampling and evaluation of the BSDFs of sixteen lanes.
//!
//! Measure: as in `lanes.rs`.
//! Range: as in `lanes.rs`.
//! Source: as in `lanes.rs`. Tested in `tests/scattering/lanes.rs`.

use super::super::super::albedo::{AlbedoTable, SingleScatter};
use super::super::super::fresnel::conductor_rgb;
use super::super::super::microfacet::Ggx;
use super::super::super::types::is_same_side;
use super::super::opaque::LobeProbabilities;
use super::{PrincipledLanes, SampledLanes};
use crate::math::lanes::{LANES, Lanes, Lanes3, load, store, vectorised};
use crate::math::rgb::Rgb;
use crate::math::vec::{LaneVec3, Vec2};

vectorised! {
    /// Computes the [`LobeProbabilities`] of each lane.
    pub(super) fn bind(table: &AlbedoTable, lanes: &mut PrincipledLanes) {
        for lane in 0..LANES {
            let wo: LaneVec3 = load(&lanes.wo, lane);
            let o = table.at(lanes.place(lane), wo.z.abs());
            let probabilities = lanes.probabilities_for(lane, o);
            lanes.facets[lane] = probabilities.facets;
            lanes.multiple[lane] = probabilities.metal_ms;
            lanes.diffuse[lane] = probabilities.base;
            lanes.loss[lane] = o.loss;
            lanes.schlick[lane] = o.schlick;
        }
    }
}

vectorised! {
    /// Samples the diffuse base or the microfacets of each lane.
    pub(super) fn sample(
        lanes: &PrincipledLanes,
        numbers: &Lanes3,
        cosine_direction: &Lanes3,
        sampled: &mut SampledLanes,
    ) {
        for lane in 0..LANES {
            let wo: LaneVec3 = load(&lanes.wo, lane);
            let up = LaneVec3::new(wo.x, wo.y, wo.z.abs());
            let [u, v, u_lobe]: [f32; 3] = load(numbers, lane);
            let (diffuse, multiple) = (lanes.diffuse[lane], lanes.multiple[lane]);
            let mirrored: LaneVec3 = Ggx::new(lanes.alpha[lane]).sample_reflection(up, Vec2::new(u, v));
            let cosine: LaneVec3 = load(cosine_direction, lane);
            let is_diffuse = u_lobe < diffuse;
            let is_multiple = !is_diffuse & (u_lobe < diffuse + multiple);
            store(&mut sampled.wi, lane, if is_diffuse { cosine } else { mirrored });
            sampled.is_diffuse[lane] = u32::from(is_diffuse);
            sampled.is_multiple[lane] = u32::from(is_multiple);
        }
    }
}

vectorised! {
    /// Evaluates the BSDF of each lane.
    pub(super) fn eval<const BOTH_WAYS: bool>(
        table: &AlbedoTable,
        lanes: &PrincipledLanes,
        wi: &Lanes3,
        f: &mut Lanes3,
        pdf: &mut Lanes<f32>,
        reverse_pdf: &mut Lanes<f32>,
    ) {
        for lane in 0..LANES {
            let lobes = lanes.lobes(lane);
            let value = lanes.eval_lane::<BOTH_WAYS>(table, lane, wi, |cos| lobes.schlick(cos));
            value.store(lane, f, pdf, reverse_pdf);
        }
    }
}

vectorised! {
    /// Evaluates the BSDF of each lane, any of which may be a conductor.
    pub(super) fn eval_with_conductors<const BOTH_WAYS: bool>(
        table: &AlbedoTable,
        lanes: &PrincipledLanes,
        wi: &Lanes3,
        f: &mut Lanes3,
        pdf: &mut Lanes<f32>,
        reverse_pdf: &mut Lanes<f32>,
    ) {
        for lane in 0..LANES {
            let lobes = lanes.lobes(lane);
            let (eta, k): (Rgb<LaneVec3>, Rgb<LaneVec3>) =
                (load(&lanes.eta, lane), load(&lanes.k, lane));
            let is_conductor = lanes.is_conductor[lane] != 0;
            let value = lanes.eval_lane::<BOTH_WAYS>(table, lane, wi, |cos| {
                let metal = lobes.f0 * conductor_rgb(cos, eta, k);
                let other = lobes.schlick(cos);
                if is_conductor { metal } else { other }
            });
            value.store(lane, f, pdf, reverse_pdf);
        }
    }
}

/// The value of the BSDF of a lane, its density, and that of the reverse direction.
struct LaneValue {
    f: [f32; 3],
    pdf: f32,
    reverse_pdf: f32,
}

impl LaneValue {
    #[inline(always)]
    fn store(
        self,
        lane: usize,
        f: &mut Lanes3,
        pdf: &mut Lanes<f32>,
        reverse_pdf: &mut Lanes<f32>,
    ) {
        let [r, g, b] = self.f;
        (f[0][lane], f[1][lane], f[2][lane]) = (r, g, b);
        pdf[lane] = self.pdf;
        reverse_pdf[lane] = self.reverse_pdf;
    }
}

impl PrincipledLanes {
    /// The probabilities of sampling the lobes of a lane, given the single scattering towards `wo`.
    #[inline(always)]
    fn probabilities_for(&self, lane: usize, o: SingleScatter) -> LobeProbabilities {
        let of_lobes = self.lobes(lane).lobe_probabilities(o, 0.0);
        let is_conductor = self.is_conductor[lane] != 0;
        LobeProbabilities {
            facets: if is_conductor {
                1.0 - o.loss
            } else {
                of_lobes.facets
            },
            metal_ms: if is_conductor {
                o.loss
            } else {
                of_lobes.metal_ms
            },
            base: if is_conductor { 0.0 } else { of_lobes.base },
            ..of_lobes
        }
    }

    /// Evaluates the BSDF of a lane, given the reflectance of its microfacets by the cosine, and the density of sampling `wo`
    /// from `wi`, which is 0 unless it is wanted. Free of branches.
    #[inline(always)]
    fn eval_lane<const BOTH_WAYS: bool>(
        &self,
        table: &AlbedoTable,
        lane: usize,
        wi: &Lanes3,
        reflectance: impl FnOnce(f32) -> Rgb<LaneVec3>,
    ) -> LaneValue {
        let (wo, wi): (LaneVec3, LaneVec3) = (load(&self.wo, lane), load(wi, lane));
        let up = |w: LaneVec3| LaneVec3::new(w.x, w.y, w.z.abs());
        let i = table.at(self.place(lane), wi.z.abs());
        let probabilities = self.lobe_probabilities(lane);
        let lobes = self.lobes(lane);
        let value = lobes.eval(up(wo), up(wi), &probabilities, i, true, reflectance);
        let reverse_pdf = if BOTH_WAYS {
            let probabilities = self.probabilities_for(lane, i);
            let black = |_| Rgb::from([0.0; 3]);
            let reversed = lobes.eval(up(wi), up(wo), &probabilities, i, true, black);
            reversed.pdf.0
        } else {
            0.0
        };
        let reflects = is_same_side(wo, wi);
        let or_zero = |value: f32| if reflects { value } else { 0.0 };
        let [r, g, b] = value.f.into();
        LaneValue {
            f: [r, g, b].map(or_zero),
            pdf: or_zero(value.pdf.0),
            reverse_pdf: or_zero(reverse_pdf),
        }
    }
}
