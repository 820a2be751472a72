//! Integrators: estimators of the radiance that arrives along a camera ray.
//!
//! An integrator estimates one sample or a wavefront of samples at a time. It does not depend on pixels, passes or
//! threads.

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
use crate::math::vec::Vector;
use crate::sampler::Sampler;
use crate::scene::Scene;
use observer::PathObserver;
use path::PathMemory;

/// A ray from the camera into the scene.
#[derive(Debug, Clone, Copy, Default)]
pub struct CameraRay {
    /// The ray.
    pub ray: Ray,
    /// The time, from 0 to 1 while the shutter is open.
    pub time: f32,
}

/// A sample: its camera ray, the hit on it and the estimated radiance.
#[derive(Debug, Clone)]
pub struct Sample {
    /// The camera ray.
    pub camera_ray: CameraRay,
    /// The closest hit, if there is one: first on the camera ray, then on each extension ray of a wavefront.
    pub found: Option<Hit>,
    /// The estimated radiance along the camera ray.
    pub radiance: Rgb,
    /// The rays traced for the sample.
    pub rays: RayCounts,
}

impl Sample {
    /// A sample whose camera ray has not been traced yet.
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

/// An estimator of radiance, for one sample or for a wavefront of samples.
pub trait Integrator: Copy + Send + Sync {
    /// Whether the integrator estimates a wavefront faster than one sample after the other.
    const SIDE_BY_SIDE: bool = false;

    /// Estimates the radiance of several samples. Each value is exactly the one that the sample would have by itself.
    /// The samplers are in the order of the samples.
    fn radiances<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        scene: &Scene,
        samplers: &mut [S],
        samples: &mut [Sample],
        _memory: &mut PathMemory<E>,
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

    /// Returns one estimate of the radiance along a camera ray, given the closest hit on it: camera rays are traced in
    /// packets.
    fn radiance<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        scene: &Scene,
        sampler: &mut S,
        camera_ray: &CameraRay,
        found: Option<Hit>,
        rays: &mut RayCounts,
        observer: &mut O,
    ) -> Rgb;

    /// Returns one estimate of the radiance along a camera ray, as [`Self::radiance`]. An integrator that contributes
    /// to other places on the film adds splats; the default adds none.
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

/// The number of rays traced, by kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RayCounts {
    /// Camera rays.
    pub camera: u64,
    /// Rays from a scattering event or a light, for the closest hit.
    pub closest: u64,
    /// Shadow rays to a light or along a connection, for visibility.
    pub shadow: u64,
}

impl RayCounts {
    /// The number of rays of all kinds.
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

/// The rule of Russian roulette, by which paths end at random.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Roulette {
    /// No roulette: a path ends only by absorption, by the bounce limit or, where there is one, by the coin of the
    /// integrator's technique.
    None,
    /// The survival probability follows the weight of the last BSDF sample: what the surface reflected.
    Albedo,
    /// The survival probability follows the path throughput.
    #[default]
    Throughput,
}

impl Roulette {
    /// Every rule.
    pub const ALL: &'static [Self] = &[Self::None, Self::Albedo, Self::Throughput];

    /// The name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Albedo => "albedo",
            Self::Throughput => "throughput",
        }
    }

    /// Returns the survival probability of a path after scattering event number `bounce`, which multiplied its
    /// throughput by `weight` and left it at `beta`.
    ///
    /// A path that loses no energy would never end in a closed scene: from event `PATIENCE` on, the probability is at
    /// most `LONG_RUN`.
    // Comparisons in place of a match, which the compiler would not vectorise.
    #[inline(always)]
    pub fn survival<V: Vector>(self, bounce: u32, weight: Rgb<V>, beta: Rgb<V>) -> f32 {
        const PATIENCE: u32 = 32;
        const LONG_RUN: f32 = 0.99;
        let [by_albedo, by_throughput] = [weight.max_channel(), beta.max_channel()];
        let share = if self == Self::Albedo {
            by_albedo
        } else {
            by_throughput
        };
        let limit = if bounce < PATIENCE { 1.0 } else { LONG_RUN };
        if self == Self::None {
            1.0
        } else {
            share.min(limit)
        }
    }
}
