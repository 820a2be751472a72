//! The light paths beside the camera paths of a tile, which are traced when there are enough of them for a wavefront.
//!
//! Measure: as in `integrator/light_paths`.
//! Range: any samples.
//! Source: docs/architecture.md, "The life of a sample". Tested in `tests/rendering/light_paths.rs`.

use super::estimator::Estimator;
use crate::effects::Effects;
use crate::integrator::light_paths::LightPathSplats;
use crate::integrator::path::WAVEFRONT_SIZE;
use crate::integrator::{Integrator, RayCounts, SampleLanes};
use crate::math::lanes::LANES;
use crate::sampler::AnySampler;

/// The camera sample that a light path belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleOrigin {
    /// The pixel of the sample.
    pub pixel: [u32; 2],
    /// The index of the sample in its pixel.
    pub sample: u64,
}

/// Light paths that have not been traced yet. The memory is kept.
#[derive(Debug, Default)]
pub struct LightWavefront {
    /// The light paths, sixteen to an element, with their times.
    paths: Vec<SampleLanes>,
    /// The sampler of each light path.
    samplers: Vec<AnySampler>,
    /// The camera sample of each light path.
    origins: Vec<SampleOrigin>,
}

impl LightWavefront {
    /// Removes all light paths.
    pub fn clear(&mut self) {
        self.paths.clear();
        self.samplers.clear();
        self.origins.clear();
    }

    /// Whether there are enough light paths for a wavefront.
    pub fn is_full(&self) -> bool {
        self.origins.len() >= WAVEFRONT_SIZE
    }

    /// Adds a light path, given the sampler of its camera sample.
    pub fn add(&mut self, origin: SampleOrigin, time: f32, sampler: AnySampler) {
        let lane = self.origins.len() % LANES;
        if lane == 0 {
            self.paths.push(SampleLanes::default());
        }
        if let Some(paths) = self.paths.last_mut() {
            paths.active.set(lane, true);
            paths.packet.rays.time[lane] = time;
        }
        self.samplers.push(sampler);
        self.origins.push(origin);
    }

    /// Traces the light paths. The sample index of their splats is the light path's ([`Self::origin`]).
    pub fn trace<E: Effects, I: Integrator>(
        &mut self,
        estimator: &mut Estimator<'_, E, I>,
        splats: &mut LightPathSplats<'_>,
    ) {
        estimator.trace_light_paths(&mut self.samplers, &mut self.paths, splats);
    }

    /// The camera sample of a light path.
    pub fn origin(&self, path: u32) -> SampleOrigin {
        self.origins[path as usize]
    }

    /// The camera sample of each light path, and the rays that were traced for it.
    pub fn ray_counts(&self) -> impl Iterator<Item = (SampleOrigin, RayCounts)> {
        let of_path = |(path, &origin): (usize, &SampleOrigin)| {
            let rays = self.paths[path / LANES].estimate(path % LANES).rays;
            (origin, RayCounts { camera: 0, ..rays })
        };
        self.origins.iter().enumerate().map(of_path)
    }
}
