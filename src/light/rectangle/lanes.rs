//! Rectangle lights in SIMD lanes: one for each receiver of a block.
//!
//! Measure: densities per steradian, times the probability of selecting the light.
//! Range: receivers that are not near; [`RectangleLight::sample`] has to sample for the others.
//! Source: the formulas of `rectangle.rs`. Tested in `tests/lights/lanes.rs`.

use super::{Choice, Rectangle, RectangleLight, RectanglePoint};
use crate::light::lanes::{End, LaneSample, LightContextLanes, LightSampleLanes};
use crate::light::types::{Emission, Receiver};
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3, load, store, vectorised};
use crate::math::vec::{LaneVec3, Vec2};

/// A rectangle light for each lane.
#[repr(align(64))]
#[derive(Debug)]
pub struct RectangleLanes {
    vectors: [Lanes3; 6],
    numbers: [Lanes<f32>; 2],
    two_sided: Lanes<u32>,
}

impl Default for RectangleLanes {
    fn default() -> Self {
        Self {
            vectors: [[[0.0; LANES]; 3]; 6],
            numbers: [[0.0; LANES]; 2],
            two_sided: [0; LANES],
        }
    }
}

impl RectangleLanes {
    /// Sets the light of a lane.
    #[inline]
    pub fn set(&mut self, lane: usize, light: &RectangleLight) {
        let it = &light.rectangle;
        let radiance = LaneVec3::from_array(it.emission.radiance.into());
        let vectors = [
            it.corner,
            it.edges[0],
            it.edges[1],
            it.normal,
            it.error,
            radiance,
        ];
        for (to, vector) in self.vectors.iter_mut().zip(vectors) {
            store(to, lane, vector);
        }
        for (to, number) in self.numbers.iter_mut().zip([it.over_radius2, it.pdf_area]) {
            to[lane] = number;
        }
        self.two_sided[lane] = u32::from(it.emission.two_sided);
    }

    /// The rectangle of a lane.
    #[inline(always)]
    fn get(&self, lane: usize) -> Rectangle {
        let [corner, edge_u, edge_v, normal, error, radiance] = &self.vectors;
        let [over_radius2, pdf_area] = &self.numbers;
        Rectangle {
            corner: load(corner, lane),
            edges: [load(edge_u, lane), load(edge_v, lane)],
            normal: load(normal, lane),
            error: load(error, lane),
            emission: Emission {
                radiance: load(radiance, lane),
                two_sided: self.two_sided[lane] != 0,
            },
            over_radius2: over_radius2[lane],
            pdf_area: pdf_area[lane],
        }
    }

    /// Samples a point on the light of each lane of `mask` for its receiver. Returns the lanes whose receiver is so near
    /// that [`RectangleLight::sample`] has to do it.
    #[inline]
    pub fn sample(
        &self,
        mask: &ActiveLanes<LANES>,
        context: &LightContextLanes,
        receivers: &Receiver<Lanes3>,
        samples: &mut LightSampleLanes,
    ) -> ActiveLanes<LANES> {
        sample_lanes(self, mask, context, receivers, samples)
    }
}

vectorised! {
    /// [`RectangleLanes::sample`].
    fn sample_lanes(
        lights: &RectangleLanes,
        mask: &ActiveLanes<LANES>,
        context: &LightContextLanes,
        receivers: &Receiver<Lanes3>,
        samples: &mut LightSampleLanes,
    ) -> ActiveLanes<LANES> {
        let mut near = ActiveLanes::NONE;
        for lane in 0..LANES {
            let light = lights.get(lane);
            let receiver = receivers.get(lane);
            let Choice { is_near, density } = light.choice(&receiver);
            let u = Vec2::new(context.u[0][lane], context.u[1][lane]);
            let RectanglePoint { position, wi, cos, pdf } = light.sample(receiver.p, density, u);
            let is_in_mask = mask.has(lane);
            near.set(lane, is_near & is_in_mask);
            let sample = LaneSample {
                end: if pdf.is_finite() { End::Surface } else { End::None },
                wi,
                radiance: light.emission.towards(cos),
                pdf: context.pmf[lane] * pdf,
                p: position,
                error: light.error,
                normal: light.normal,
            };
            samples.set_if(is_in_mask, lane, &sample);
        }
        near
    }
}
