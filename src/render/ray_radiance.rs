//! Radiance along the caller's own rays, estimated as along camera rays.
//!
//! Measure: rays in normalised units; radiance.
//! Range: any rays and samples; samples that are not finite are counted and left out of the sums.
//! Source: none needed. Tested in `tests/rendering/session.rs`.

use super::dispatch::{self, IntegratorJob};
use super::settings::RenderSettings;
use crate::effects::Effects;
use crate::film::batches::BATCHES;
use crate::film::pixel::PixelSums;
use crate::integrator::observer::NullPathObserver;
use crate::integrator::path::WAVEFRONT_SIZE;
use crate::integrator::{CameraRay, Integrator, SampleLanes};
use crate::math::lanes::{ActiveLanes, LANES};
use crate::math::rgb::Rgb;
use crate::sampler::{AnySampler, Batches, Sampler};
use crate::scene::Scene;
use rayon::prelude::*;

/// The radiance along one ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayRadiance {
    /// The mean of the samples.
    pub mean: Rgb,
    /// The standard error of the mean in each channel, with three degrees of freedom; `None` for fewer than four
    /// samples.
    pub standard_error: Option<Rgb>,
    /// The number of samples that were not finite.
    pub rejected: u64,
}

/// Estimates the radiance along each ray by `spp` samples, on rayon's current threads. The random numbers of the ray
/// with index i are those of the pixel i of a single row. In place of an irradiance cache, paths are traced.
pub fn along_rays(
    scene: &Scene,
    settings: &RenderSettings,
    rays: &[CameraRay],
    spp: u64,
) -> Vec<RayRadiance> {
    let job = RayRadianceJob {
        scene,
        rays,
        spp,
        sampler: dispatch::sampler(settings, Batches::new(BATCHES)),
    };
    dispatch::dispatch(scene, settings, None, job)
}

struct RayRadianceJob<'a> {
    scene: &'a Scene,
    rays: &'a [CameraRay],
    spp: u64,
    sampler: AnySampler,
}

impl IntegratorJob for RayRadianceJob<'_> {
    type Output = Vec<RayRadiance>;

    fn run<E: Effects, I: Integrator>(self, integrator: I) -> Vec<RayRadiance> {
        let rays = self.rays.par_iter().enumerate();
        rays.map_init(RayScratch::<E, I>::default, |scratch, (index, ray)| {
            self.one(index as u32, ray, integrator, scratch)
        })
        .collect()
    }
}

/// The memory of a thread, which it keeps from ray to ray.
struct RayScratch<'a, E: Effects, I: Integrator> {
    samplers: Vec<AnySampler>,
    samples: Vec<SampleLanes>,
    of_integrator: I::Scratch<'a, E>,
}

impl<E: Effects, I: Integrator> Default for RayScratch<'_, E, I> {
    fn default() -> Self {
        Self {
            samplers: Vec::with_capacity(WAVEFRONT_SIZE),
            samples: vec![SampleLanes::default(); WAVEFRONT_SIZE / LANES],
            of_integrator: I::Scratch::default(),
        }
    }
}

impl<'a> RayRadianceJob<'a> {
    fn one<E: Effects, I: Integrator>(
        &self,
        place: u32,
        ray: &CameraRay,
        integrator: I,
        scratch: &mut RayScratch<'a, E, I>,
    ) -> RayRadiance {
        let hit = self.scene.accel.intersect(&ray.ray, ray.time, None);
        let mut sums = PixelSums::default();
        let mut rejected = 0;
        let RayScratch {
            samplers,
            samples,
            of_integrator,
        } = scratch;
        for first in (0..self.spp).step_by(WAVEFRONT_SIZE) {
            let indices = first..self.spp.min(first + WAVEFRONT_SIZE as u64);
            samplers.clear();
            for samples in samples.iter_mut() {
                samples.active = ActiveLanes::NONE;
            }
            for index in indices.clone() {
                let mut sampler = self.sampler.clone();
                sampler.start([place, 0], index);
                let path = samplers.len();
                samples[path / LANES].add(path % LANES, ray, hit);
                samplers.push(sampler);
            }
            integrator.radiances::<E, _, _>(
                self.scene,
                samplers,
                samples,
                of_integrator,
                &mut NullPathObserver,
            );
            for (path, index) in indices.enumerate() {
                let radiance = samples[path / LANES].estimate(path % LANES).radiance;
                if !radiance.is_finite() {
                    rejected += 1;
                    continue;
                }
                sums.add(index, radiance);
            }
        }
        let single = |channels: [f64; 3]| Rgb::from(channels.map(|x| x as f32));
        let n = self.spp as f64;
        let variance = sums.batch_means(self.spp).variance();
        let variance = variance.filter(|_| self.spp >= BATCHES);
        RayRadiance {
            mean: single(sums.mean(self.spp)),
            standard_error: variance.map(|it| single(it.map(|it| (it / n).sqrt()))),
            rejected,
        }
    }
}
