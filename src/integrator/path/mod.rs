//! Path tracing with next event estimation, multiple importance sampling and Russian roulette, or by any simpler
//! [`Technique`](super::technique::Technique) of the course.
//!
//! The radiance along a ray is the sum over paths x_0 x_1 ... x_k from the camera to a light,
//!
//!   L = sum_k  beta_k [ w_bsdf Le(x_k) + w_light f(x_k) |cos| Le(y) V(x_k, y) / p_light(y) ],
//!   beta_k = prod_{j<k} f(x_j) |cos| / p_bsdf / q_j,
//!
//! where y is a sampled point on a light, the two ways of reaching a light are weighted by the power heuristic of their
//! densities (other techniques: by 0 or 1), and q_j is the survival probability of Russian roulette. Where a coin ends
//! the path with its surface's emission with probability p, the emission is divided by p and all later contributions by
//! 1 - p. Light sampling finds nothing by way of a delta lobe, nor the constant environment, which is not a light that
//! is sampled: there w_bsdf = 1. Scattered rays cannot hit delta lights: there w_light = 1.
//!
//! The integrator is compiled for the effects `E`; kernels for other effects give the same numbers.
//!
//! Measure: radiance; densities per steradian.
//! Range: any scene that needs no effect beyond `E`; without a bounce limit a path ends by absorption, by leaving the
//! scene, or by roulette.
//! Source: Kajiya 1986; Veach 1997, sections 8.3, 9.2 and 10.4.1. Tested in `battery/`, `tests/scattering/furnace.rs`,
//! `tests/rendering/effects.rs` and `tests/rendering/integrators.rs`.

mod course;
mod direct_light;
mod emission;
pub mod queues;
mod scattering;
mod shading_context;
mod state;

pub use state::PathState;

use super::indirect::{Indirect, Traced};
use super::observer::{PathObserver, Unobserved};
use super::technique::{TechniqueSource, Weighted};
use super::{CameraRay, Integrator, RayCounts, Roulette, Sample};
use crate::accel::Hit;
use crate::bsdf::Bsdf;
use crate::effects::Effects;
use crate::math::lanes::LANES;
use crate::math::rgb::Rgb;
use crate::sampler::Sampler;
use crate::scene::Scene;
use crate::scene::interaction::Interaction;
use queues::PathQueues;
use shading_context::{Bsdfs, ShadingContext};
use std::slice;

/// The path integrator and its settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PathIntegrator<C = Weighted, K = Traced> {
    /// The technique by which light is found.
    pub technique: C,
    /// The source of indirect light.
    pub indirect: K,
    /// The largest number of scattering events; `None` for no limit.
    pub max_bounces: Option<u32>,
    /// The rule of Russian roulette.
    pub roulette: Roulette,
}

impl<C: TechniqueSource, K: Indirect> Integrator for PathIntegrator<C, K> {
    const SIDE_BY_SIDE: bool = true;

    fn radiance<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        scene: &Scene,
        sampler: &mut S,
        camera_ray: &CameraRay,
        found: Option<Hit>,
        rays: &mut RayCounts,
        observer: &mut O,
    ) -> Rgb {
        let mut sample = Sample::new(*camera_ray);
        sample.found = found;
        let (samplers, samples) = (slice::from_mut(sampler), slice::from_mut(&mut sample));
        let queues = &mut PathQueues::default();
        self.radiances::<E, S, O>(scene, samplers, samples, queues, observer);
        *rays += sample.rays;
        sample.radiance
    }

    fn radiances<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        scene: &Scene,
        samplers: &mut [S],
        samples: &mut [Sample],
        queues: &mut PathQueues,
        observer: &mut O,
    ) {
        let begin = |sample: &mut Sample| {
            sample.rays.camera += 1;
            let CameraRay { ray, time } = sample.camera_ray;
            PathState::<E>::new(ray, None, time)
        };
        let mut states: Vec<PathState<E>> = samples.iter_mut().map(begin).collect();
        self.follow(Paths {
            scene,
            samples,
            samplers,
            states: &mut states,
            queues,
            observer,
            bounce: 0,
        });
        for (sample, path) in samples.iter_mut().zip(states) {
            sample.radiance = path.radiance;
        }
    }
}

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Traces a wavefront of paths to their ends, given the closest hits on their first rays.
    ///
    /// Each stage (emission, shading contexts, light samples, BSDF samples, rays) is a short loop over all active
    /// paths, so that the processor overlaps several iterations.
    pub fn follow<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        mut paths: Paths<'_, E, S, O>,
    ) {
        paths.queues.begin(paths.states.len());
        let mut interactions = Vec::with_capacity(paths.states.len());
        while !paths.queues.active.is_empty() {
            interactions.clear();
            self.add_emission_and_compact(&mut paths, &mut interactions);
            let bsdfs = Bsdfs::of(paths.scene, &interactions);
            let surfaces = interactions.iter().zip(bsdfs.each());
            let shading: Vec<ShadingContext<'_>> = surfaces
                .map(|(at, bsdf)| self.shading_context(at, bsdf, paths.bounce))
                .collect();
            self.sample_direct_light(&mut paths, &interactions, &shading);
            self.scatter(&mut paths, &interactions, &shading);
            paths.trace();
            paths.bounce += 1;
        }
    }

    /// Traces one path, without light sampling, to the first surface for which `find` returns a value, and returns that
    /// value. The vertices of a path do not depend on its light samples.
    pub fn first_found<E: Effects, S: Sampler, T>(
        &self,
        scene: &Scene,
        sampler: &mut S,
        sample: &mut Sample,
        mut find: impl FnMut(&Interaction<E>, &Bsdf, u32) -> Option<T>,
    ) -> Option<T> {
        let CameraRay { ray, time } = sample.camera_ray;
        let mut state = PathState::<E>::new(ray, None, time);
        let mut paths = Paths {
            scene,
            samples: slice::from_mut(sample),
            samplers: slice::from_mut(sampler),
            states: slice::from_mut(&mut state),
            queues: &mut PathQueues::default(),
            observer: &mut Unobserved,
            bounce: 0,
        };
        paths.queues.begin(1);
        let mut interactions = Vec::with_capacity(1);
        loop {
            interactions.clear();
            self.add_emission_and_compact(&mut paths, &mut interactions);
            let at = interactions.first()?;
            let bsdf = scene.surface(at);
            if let Some(found) = find(at, &bsdf, paths.bounce) {
                return Some(found);
            }
            let shading = [self.shading_context(at, &bsdf, paths.bounce)];
            self.scatter(&mut paths, &interactions, &shading);
            paths.trace();
            paths.bounce += 1;
        }
    }
}

/// A wavefront of paths, all of which have scattered equally often.
pub struct Paths<'a, E: Effects, S, O: ?Sized> {
    /// The scene.
    pub scene: &'a Scene,
    /// The samples of the paths.
    pub samples: &'a mut [Sample],
    /// The samplers, in the order of the samples.
    pub samplers: &'a mut [S],
    /// The states of the paths, in the order of the samples.
    pub states: &'a mut [PathState<E>],
    /// The queues of the wavefront.
    pub queues: &'a mut PathQueues,
    /// The observer of the paths.
    pub observer: &'a mut O,
    /// The number of scattering events before.
    pub bounce: u32,
}

impl<E: Effects, S, O: PathObserver + ?Sized> Paths<'_, E, S, O> {
    /// Traces the queued shadow rays, and then the extension rays of the paths that continue.
    fn trace(&mut self) {
        let states = &mut *self.states;
        let shadow_rays = &mut self.queues.shadow_rays;
        shadow_rays.trace::<E, O>(self.scene, self.observer, |path_index, light| {
            states[path_index].radiance += light;
        });
        let PathQueues {
            extension_rays,
            active,
            ..
        } = &mut *self.queues;
        let mut hits = [None; LANES];
        for (rays, numbers) in extension_rays
            .packets_mut()
            .iter_mut()
            .zip(active.chunks(LANES))
        {
            self.scene.accel.intersect_packet(rays, false, &mut hits);
            for (&path_index, found) in numbers.iter().zip(&hits) {
                self.samples[path_index].found = *found;
            }
        }
        extension_rays.clear();
    }
}
