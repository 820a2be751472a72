//! Light samples in SIMD lanes.
//!
//! Measure: as in [`LightSample`].
//! Range: all of its kinds.
//! Source: none needed. Tested in `tests/lights/lanes.rs`.

use super::types::{LightSample, ShadowRayEnd};
use crate::geometry::surface::SurfacePoint;
use crate::math::lanes::{LANES, Lanes, Lanes3, load, store};
use crate::math::measure::PdfSolidAngle;
use crate::math::rgb::Rgb;
use crate::math::vec::{LaneVec3, Vec3, Vector};

/// The inputs of light sampling for each lane, besides the receiving point.
#[repr(align(64))]
#[derive(Debug, Clone, Default)]
pub struct LightContextLanes {
    /// The selected lights.
    pub light: Lanes<u32>,
    /// The probabilities of selecting them.
    pub pmf: Lanes<f32>,
    /// The random numbers: two for the point on the light, two for the selection of the light.
    pub u: [Lanes<f32>; 4],
    /// The times of the shutter.
    pub time: Lanes<f32>,
}

/// The end of a lane's shadow ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum ShadowRayEndKind {
    /// No sample.
    None,
    /// [`ShadowRayEnd::Surface`].
    Surface,
    /// [`ShadowRayEnd::Point`].
    Point,
    /// [`ShadowRayEnd::Infinity`].
    Infinity,
}

/// A light sample for each lane.
#[repr(align(64))]
#[derive(Debug, Clone)]
pub struct LightSampleLanes {
    /// The kinds of ends, as numbers of [`ShadowRayEndKind`].
    pub end: Lanes<u32>,
    /// Unit vectors towards the light.
    pub wi: Lanes3,
    /// Radiance that arrives along `wi`, or the irradiance of a delta light.
    pub radiance: Lanes3,
    /// Densities of `wi`; infinite for a delta light.
    pub pdf: Lanes<f32>,
    /// The points on surfaces, or in free space.
    pub p: Lanes3,
    /// Bounds of the rounding error of points on surfaces.
    pub error: Lanes3,
    /// Normals at points on surfaces.
    pub normal: Lanes3,
}

impl Default for LightSampleLanes {
    fn default() -> Self {
        let zero = [[0.0; LANES]; 3];
        Self {
            end: [ShadowRayEndKind::None as u32; LANES],
            wi: zero,
            radiance: zero,
            pdf: [0.0; LANES],
            p: zero,
            error: zero,
            normal: zero,
        }
    }
}

/// Sets the vector of a lane if `condition`. Free of branches.
#[inline(always)]
fn store_if(condition: bool, to: &mut Lanes3, lane: usize, value: LaneVec3) {
    let kept: LaneVec3 = load(to, lane);
    store(to, lane, if condition { value } else { kept });
}

/// A sample in the form of a loop over lanes: on a surface, or none.
pub struct LaneSample {
    /// [`ShadowRayEndKind::Surface`] or [`ShadowRayEndKind::None`].
    pub end: ShadowRayEndKind,
    /// Unit vector towards the light.
    pub wi: LaneVec3,
    /// Radiance that arrives along `wi`.
    pub radiance: Rgb<LaneVec3>,
    /// Density of `wi`, with the probability of selecting the light.
    pub pdf: f32,
    /// The point on the light.
    pub p: LaneVec3,
    /// Bound of its rounding error.
    pub error: LaneVec3,
    /// The normal at the point.
    pub normal: LaneVec3,
}

impl LightSampleLanes {
    /// Sets the sample of a lane, on a surface, if `condition`. Free of branches.
    #[inline(always)]
    pub fn set_if(&mut self, condition: bool, lane: usize, sample: &LaneSample) {
        let end = sample.end as u32;
        self.end[lane] = if condition { end } else { self.end[lane] };
        self.pdf[lane] = if condition {
            sample.pdf
        } else {
            self.pdf[lane]
        };
        let radiance: [f32; 3] = sample.radiance.into();
        store_if(condition, &mut self.wi, lane, sample.wi);
        store_if(condition, &mut self.radiance, lane, radiance.into());
        store_if(condition, &mut self.p, lane, sample.p);
        store_if(condition, &mut self.error, lane, sample.error);
        store_if(condition, &mut self.normal, lane, sample.normal);
    }

    /// Sets the sample of a lane, without the barycentric coordinates of its point.
    #[inline]
    pub fn set(&mut self, lane: usize, sample: Option<&LightSample>) {
        let Some(sample) = sample else {
            self.end[lane] = ShadowRayEndKind::None as u32;
            return;
        };
        store(&mut self.wi, lane, sample.wi);
        store(&mut self.radiance, lane, sample.radiance);
        self.pdf[lane] = sample.pdf.map_or(f32::INFINITY, |pdf| pdf.0);
        self.end[lane] = match &sample.end {
            ShadowRayEnd::Surface(point, _) => {
                store(&mut self.p, lane, point.p);
                store(&mut self.error, lane, point.error);
                store(&mut self.normal, lane, point.ng);
                ShadowRayEndKind::Surface
            }
            ShadowRayEnd::Point(p) => {
                store(&mut self.p, lane, *p);
                ShadowRayEndKind::Point
            }
            ShadowRayEnd::Infinity => ShadowRayEndKind::Infinity,
        } as u32;
    }

    /// The point of a lane's sample on a surface.
    #[inline(always)]
    pub fn surface<V: Vector>(&self, lane: usize) -> SurfacePoint<V> {
        let ng = load(&self.normal, lane);
        SurfacePoint {
            p: load(&self.p, lane),
            error: load(&self.error, lane),
            ng,
            ns: ng,
        }
    }

    /// Whether a lane has a sample.
    #[inline(always)]
    pub fn is_sampled(&self, lane: usize) -> bool {
        self.end[lane] != ShadowRayEndKind::None as u32
    }

    /// The sample of a lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Option<LightSample> {
        let end = match self.end[lane] {
            end if end == ShadowRayEndKind::Surface as u32 => {
                ShadowRayEnd::Surface(self.surface(lane), [0.0; 2])
            }
            end if end == ShadowRayEndKind::Point as u32 => {
                ShadowRayEnd::Point(load(&self.p, lane))
            }
            end if end == ShadowRayEndKind::Infinity as u32 => ShadowRayEnd::Infinity,
            _ => return None,
        };
        let pdf = self.pdf[lane];
        Some(LightSample {
            wi: load::<Vec3>(&self.wi, lane),
            radiance: load::<Rgb>(&self.radiance, lane),
            pdf: (pdf < f32::INFINITY).then_some(PdfSolidAngle(pdf)),
            end,
        })
    }
}
