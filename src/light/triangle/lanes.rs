//! Triangle lights in SIMD lanes: one for each receiver of a block.
//!
//! Measure: densities per steradian, times the probability of selecting the light.
//! Range: triangles that are far, or clear as `sampling/clear_triangle.rs` says; [`TriangleLight::sample`] has to sample the
//! others.
//! Source: the formulas of `triangle.rs`. Tested in `tests/lights/lanes.rs`.

use super::{Method, Triangle, TriangleLight, TrianglePoint};
use crate::light::lanes::{End, LaneSample, LightContextLanes, LightSampleLanes};
use crate::light::types::{Emission, Receiver};
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3, load, store, vectorised};
use crate::math::vec::{DVec3, LaneVec3, Vec2};
use crate::sampling::warp;

/// A triangle light for each lane.
#[repr(align(64))]
#[derive(Debug)]
pub struct TriangleLanes {
    vectors: [Lanes3; 6],
    area: Lanes<f32>,
    far2: Lanes<f32>,
    two_sided: Lanes<u32>,
    cross: [Lanes<f64>; 3],
}

impl Default for TriangleLanes {
    fn default() -> Self {
        Self {
            vectors: [[[0.0; LANES]; 3]; 6],
            area: [0.0; LANES],
            far2: [0.0; LANES],
            two_sided: [0; LANES],
            cross: [[0.0; LANES]; 3],
        }
    }
}

impl TriangleLanes {
    /// Sets the light of a lane.
    #[inline]
    pub fn set(&mut self, lane: usize, light: &TriangleLight) {
        let it = &light.triangle;
        let ([a, b, c], radiance) = (it.vertices, it.emission.radiance.into());
        let vectors = [a, b, c, it.normal, it.error, LaneVec3::from_array(radiance)];
        for (to, vector) in self.vectors.iter_mut().zip(vectors) {
            store(to, lane, vector);
        }
        (self.area[lane], self.far2[lane]) = (it.area, it.far2);
        self.two_sided[lane] = u32::from(it.emission.two_sided);
        for (to, number) in self.cross.iter_mut().zip(it.cross.to_array()) {
            to[lane] = number;
        }
    }

    /// The triangle of a lane.
    #[inline(always)]
    fn get(&self, lane: usize) -> Triangle {
        let [a, b, c, normal, error, radiance] = &self.vectors;
        let [x, y, z] = &self.cross;
        Triangle {
            vertices: [load(a, lane), load(b, lane), load(c, lane)],
            normal: load(normal, lane),
            error: load(error, lane),
            emission: Emission {
                radiance: load(radiance, lane),
                two_sided: self.two_sided[lane] != 0,
            },
            area: self.area[lane],
            far2: self.far2[lane],
            cross: DVec3::new(x[lane], y[lane], z[lane]),
        }
    }

    /// Samples a point on the light of each lane of `mask` for its receiver. Returns the lanes whose triangle is large or
    /// seen from near its plane, so that [`TriangleLight::sample`] has to do it.
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
    /// [`TriangleLanes::sample`].
    fn sample_lanes(
        lights: &TriangleLanes,
        mask: &ActiveLanes<LANES>,
        context: &LightContextLanes,
        receivers: &Receiver<Lanes3>,
        samples: &mut LightSampleLanes,
    ) -> ActiveLanes<LANES> {
        let mut skew = ActiveLanes::NONE;
        for lane in 0..LANES {
            let light = lights.get(lane);
            let receiver = receivers.get(lane);
            let u = Vec2::new(context.u[0][lane], context.u[1][lane]);
            let (method, clear) = light.method(receiver.p);
            let density = light.density(&receiver);
            let warped = density.sample(u);
            let is_by_area = method == Method::Area;
            let b = if is_by_area {
                warp::sample_triangle_uniform(u).to_array()
            } else {
                clear.sample(warped)
            };
            let by_angle = density.pdf(warped) / clear.solid_angle();
            let TrianglePoint { position, wi, cos, pdf } = light.point(receiver.p, b, |distance2, cos| {
                if is_by_area { light.by_area(distance2, cos) } else { by_angle }
            });
            let is_in_mask = mask.has(lane);
            skew.set(lane, (method == Method::Skew) & is_in_mask);
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
        skew
    }
}
