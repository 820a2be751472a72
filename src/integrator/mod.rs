//! Integrators: estimators of the radiance that arrives along a camera ray.
//!
//! An integrator estimates one sample or a wavefront of samples at a time. It does not depend on pixels, passes or
//! threads.
//!
//! Measure: radiance; splats as in `film/splats.rs`.
//! Range: any scene that needs no effect beyond the kernel's. Estimates that are not finite are returned as they are.
//! Source: named in each integrator's file. Tested in `tests/rendering/integrators.rs`.

pub mod ambient_occlusion;
pub mod bidirectional;
pub mod indirect;
pub mod irradiance_cache;
pub mod kind;
pub mod light_paths;
pub mod observer;
pub mod path;
pub mod reuse;
pub mod roulette;
pub mod technique;

use crate::accel::Hit;
use crate::accel::lanes::RayHitLanes;
use crate::effects::Effects;
use crate::film::splats::SplatList;
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3, load, store};
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::sampler::Sampler;
use crate::scene::Scene;
use light_paths::{LightPathSplats, LightPaths};
use observer::PathObserver;
use reuse::PathReuse;
pub use roulette::Roulette;
use serde::{Deserialize, Serialize};

/// A ray from the camera into the scene.
#[derive(Debug, Clone, Copy, Default)]
pub struct CameraRay {
    /// The ray.
    pub ray: Ray,
    /// The time, from 0 to 1 while the shutter is open.
    pub time: f32,
}

/// Sixteen samples, one per lane.
#[derive(Debug, Clone)]
pub struct SampleLanes {
    /// The lanes with a sample.
    pub active: ActiveLanes<LANES>,
    /// The camera rays, and the closest hits on them.
    pub packet: RayHitLanes<LANES>,
    /// The `t_max` of the camera rays, which hits overwrite in the packet; finite only for rays of a caller.
    t_max: Lanes<f32>,
    /// The estimated radiance along the camera rays.
    radiance: Lanes3,
    /// The rays traced for the samples beside the camera rays: for the closest hit, and shadow rays.
    closest_rays: Lanes<u32>,
    shadow_rays: Lanes<u32>,
}

impl Default for SampleLanes {
    fn default() -> Self {
        Self {
            active: ActiveLanes::NONE,
            packet: RayHitLanes::default(),
            t_max: [f32::INFINITY; LANES],
            radiance: [[0.0; LANES]; 3],
            closest_rays: [0; LANES],
            shadow_rays: [0; LANES],
        }
    }
}

impl SampleLanes {
    /// Adds a sample in a lane, given its camera ray and the hit on it.
    pub fn add(&mut self, lane: usize, camera_ray: &CameraRay, hit: Option<Hit>) {
        self.active.set(lane, true);
        self.packet.rays.set(lane, &camera_ray.ray);
        self.packet.rays.time[lane] = camera_ray.time;
        self.packet.set_hit(lane, hit);
        self.t_max[lane] = camera_ray.ray.t_max;
    }

    /// The camera ray of a lane, and the hit on it.
    #[inline]
    pub fn camera_ray(&self, lane: usize) -> (CameraRay, Option<Hit>) {
        let (ray, time) = self.packet.ray(lane);
        let t_max = self.t_max[lane];
        let ray = Ray { t_max, ..ray };
        (CameraRay { ray, time }, self.packet.hit(lane))
    }

    /// The `t_max` of the camera ray of a lane.
    #[inline]
    pub fn t_max(&self, lane: usize) -> f32 {
        self.t_max[lane]
    }

    /// The estimate of a lane.
    #[inline(always)]
    pub fn estimate(&self, lane: usize) -> SampleEstimate {
        SampleEstimate {
            radiance: load(&self.radiance, lane),
            rays: RayCounts {
                camera: 1,
                closest: u64::from(self.closest_rays[lane]),
                shadow: u64::from(self.shadow_rays[lane]),
            },
        }
    }

    /// Sets the estimate of a lane, given its rays beside the camera ray.
    #[inline(always)]
    pub fn set_estimate(
        &mut self,
        lane: usize,
        radiance: Rgb,
        closest_rays: u32,
        shadow_rays: u32,
    ) {
        store(&mut self.radiance, lane, radiance);
        self.closest_rays[lane] = closest_rays;
        self.shadow_rays[lane] = shadow_rays;
    }

    /// Counts further rays of a lane.
    pub fn count_rays(&mut self, lane: usize, rays: RayCounts) {
        self.closest_rays[lane] += rays.closest as u32;
        self.shadow_rays[lane] += rays.shadow as u32;
    }
}

/// The estimate of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleEstimate {
    /// The radiance along the camera ray.
    pub radiance: Rgb,
    /// The rays traced for it.
    pub rays: RayCounts,
}

/// An estimator of radiance, for one sample or for a wavefront of samples.
pub trait Integrator: Copy + Send + Sync {
    /// Whether the integrator estimates a wavefront faster than one sample after the other.
    const IS_WAVEFRONT: bool = false;

    /// Memory that is kept from sample to sample, for a kernel and a scene. No estimate depends on what others left in it.
    type Scratch<'a, E: Effects>: Default;

    /// Estimates the radiance of several samples. Each value is exactly the one that the sample would have by itself,
    /// unless pixels share paths ([`Self::reuse`]). There is a sampler for each lane, in order.
    fn radiances<'a, E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        scene: &'a Scene,
        samplers: &mut [S],
        samples: &mut [SampleLanes],
        scratch: &mut Self::Scratch<'a, E>,
        observer: &mut O,
    ) {
        for (samplers, samples) in samplers.chunks_mut(LANES).zip(samples) {
            for lane in samples.active.each() {
                let (camera_ray, hit) = samples.camera_ray(lane);
                let sampler = &mut samplers[lane];
                let mut rays = RayCounts::default();
                let radiance = self.radiance::<E, S, O>(
                    scene,
                    sampler,
                    &camera_ray,
                    hit,
                    &mut rays,
                    scratch,
                    observer,
                );
                samples.set_estimate(lane, radiance, rays.closest as u32, rays.shadow as u32);
            }
        }
    }

    /// Returns one estimate of the radiance along a camera ray, given the closest hit on it: camera rays are traced in
    /// packets.
    #[expect(
        clippy::too_many_arguments,
        reason = "a sample, and all that it reports to"
    )]
    fn radiance<'a, E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        scene: &'a Scene,
        sampler: &mut S,
        camera_ray: &CameraRay,
        hit: Option<Hit>,
        rays: &mut RayCounts,
        scratch: &mut Self::Scratch<'a, E>,
        observer: &mut O,
    ) -> Rgb;

    /// Returns one estimate of the radiance along a camera ray, as [`Self::radiance`]. An integrator that contributes
    /// to other places on the film adds splats; the default adds none.
    #[expect(
        clippy::too_many_arguments,
        reason = "a sample, and all that it reports to"
    )]
    #[inline]
    fn radiance_and_splats<'a, E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        scene: &'a Scene,
        sampler: &mut S,
        camera_ray: &CameraRay,
        hit: Option<Hit>,
        rays: &mut RayCounts,
        scratch: &mut Self::Scratch<'a, E>,
        observer: &mut O,
        _splats: &mut SplatList<'_>,
    ) -> Rgb {
        self.radiance::<E, S, O>(scene, sampler, camera_ray, hit, rays, scratch, observer)
    }

    /// The number of pixels that share their paths; above one, the samples of a packet have to be estimated together.
    #[inline]
    fn reuse(&self) -> PathReuse {
        PathReuse::Off
    }

    /// The light paths that are traced beside the camera paths.
    #[inline]
    fn light_paths(&self) -> LightPaths {
        LightPaths::NONE
    }

    /// Traces a light path for each active lane of the samples, at its time, and stores the counts of their rays. There is a
    /// sampler for each lane, in order. Not called for an integrator without light paths.
    fn trace_light_paths<'a, E: Effects, S: Sampler>(
        &self,
        _scene: &'a Scene,
        _samplers: &mut [S],
        _samples: &mut [SampleLanes],
        _scratch: &mut Self::Scratch<'a, E>,
        _splats: &mut LightPathSplats<'_>,
    ) {
    }
}

/// The number of rays traced, by kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct RayCounts {
    /// Camera rays.
    pub camera: u64,
    /// Rays from a scattering event or a light, for the closest hit.
    pub closest: u64,
    /// Shadow rays to a light or along a connection, for visibility.
    pub shadow: u64,
}

impl RayCounts {
    /// The number of rays of all kinds; the largest number if there are more.
    pub fn total(&self) -> u64 {
        let both = self.camera.saturating_add(self.closest);
        both.saturating_add(self.shadow)
    }

    /// The rays of two parts together; of each kind the largest number if there are more.
    pub fn saturating_add(self, other: Self) -> Self {
        Self {
            camera: self.camera.saturating_add(other.camera),
            closest: self.closest.saturating_add(other.closest),
            shadow: self.shadow.saturating_add(other.shadow),
        }
    }
}

impl std::ops::AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.camera += other.camera;
        self.closest += other.closest;
        self.shadow += other.shadow;
    }
}
