//! Estimators of the radiance that arrives along a camera ray.
//!
//! An integrator is handed one sample at a time, or some of them, and knows nothing of pixels, passes or threads.

pub mod ambient_occlusion;
pub mod bidirectional;
pub mod indirect;
pub mod irradiance_cache;
pub mod kind;
pub mod observer;
pub mod path;
pub mod technique;

use crate::accel::Hit;
use crate::effects::Effects;
use crate::film::splats::SplatList;
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::sampler::Sampler;
use crate::scene::Scene;
use observer::PathObserver;
use path::queues::PathQueues;

/// A ray from the camera into the scene.
#[derive(Debug, Clone, Copy, Default)]
pub struct CameraRay {
    /// The ray.
    pub ray: Ray,
    /// When, from 0 to 1 while the shutter is open.
    pub time: f32,
}

/// A sample on its way into the scene.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Where it looks.
    pub camera_ray: CameraRay,
    /// What is found on its ray: camera rays are traced side by side.
    pub found: Option<Hit>,
    /// The radiance that arrives from there, once it is estimated.
    pub radiance: Rgb,
    /// What that took.
    pub rays: RayCounts,
}

impl Sample {
    /// One whose ray is yet to be traced.
    #[inline]
    pub fn new(camera_ray: CameraRay) -> Self {
        Self {
            camera_ray,
            found: None,
            radiance: Rgb::BLACK,
            rays: RayCounts::default(),
        }
    }
}

/// An estimator, one sample at a time or several.
pub trait Integrator: Copy + Send + Sync {
    /// Whether it gains by estimating several samples at once.
    const SIDE_BY_SIDE: bool = false;

    /// Estimates the radiance of some samples, the very same as that of each by itself. Samplers are those of the samples.
    fn radiances<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        scene: &Scene,
        samplers: &mut [S],
        samples: &mut [Sample],
        _waiting: &mut PathQueues,
        observer: &mut O,
    ) {
        for (sampler, sample) in samplers.iter_mut().zip(samples) {
            let Sample {
                camera_ray,
                found,
                radiance,
                rays,
            } = sample;
            *radiance =
                self.radiance::<E, S, O>(scene, sampler, camera_ray, *found, rays, observer);
        }
    }

    /// One estimate of the radiance that arrives along a camera ray, given what is found on it: camera rays are traced
    /// side by side.
    fn radiance<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        scene: &Scene,
        sampler: &mut S,
        camera_ray: &CameraRay,
        found: Option<Hit>,
        rays: &mut RayCounts,
        observer: &mut O,
    ) -> Rgb;

    /// The same, and what the sample finds for other places of the film, for an integrator that looks there.
    #[expect(
        clippy::too_many_arguments,
        reason = "a sample, and all that it may tell of"
    )]
    #[inline]
    fn radiance_and_splats<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        scene: &Scene,
        sampler: &mut S,
        camera_ray: &CameraRay,
        found: Option<Hit>,
        rays: &mut RayCounts,
        observer: &mut O,
        _splats: &mut SplatList<'_>,
    ) -> Rgb {
        self.radiance::<E, S, O>(scene, sampler, camera_ray, found, rays, observer)
    }
}

/// How many rays were traced, by kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RayCounts {
    /// From the camera.
    pub camera: u64,
    /// From a scattering event, for the closest hit.
    pub closest: u64,
    /// To a light, for visibility.
    pub shadow: u64,
}

impl RayCounts {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.camera + self.closest + self.shadow
    }
}

impl std::ops::AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.camera += other.camera;
        self.closest += other.closest;
        self.shadow += other.shadow;
    }
}

/// When a path ends by chance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Roulette {
    /// Never: only absorption, the bounce limit and, where there is one, the integrator's coin end it.
    None,
    /// With a probability that follows what the last surface reflected.
    Albedo,
    /// With a probability that follows the path's throughput.
    #[default]
    Throughput,
}

impl Roulette {
    /// Every way.
    pub const ALL: &'static [Self] = &[Self::None, Self::Albedo, Self::Throughput];

    /// The name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Albedo => "albedo",
            Self::Throughput => "throughput",
        }
    }

    /// The probability with which a path goes on after its scattering event number `bounce`, which multiplied its
    /// throughput by `weight` and left it at `beta`.
    ///
    /// Paths that lose nothing would never end in a closed scene: after many bounces they get an upper limit.
    #[inline]
    pub fn survival(self, bounce: u32, weight: Rgb, beta: Rgb) -> f32 {
        const PATIENCE: u32 = 32;
        const LONG_RUN: f32 = 0.99;
        let share = match self {
            Self::None => return 1.0,
            Self::Albedo => weight,
            Self::Throughput => beta,
        };
        let limit = if bounce < PATIENCE { 1.0 } else { LONG_RUN };
        share.max_channel().min(limit)
    }
}
