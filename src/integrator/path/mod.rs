//! Path tracing: with next event estimation, multiple importance sampling and Russian roulette, or by any simpler
//! [`Technique`](super::technique::Technique) of the course.
//!
//! The radiance along a ray is the sum over paths x_0 x_1 ... x_k from the eye to a light,
//!
//!   L = sum_k  beta_k [ w_bsdf Le(x_k) + w_light f(x_k) |cos| Le(y) V(x_k, y) / p_light(y) ],
//!   beta_k = prod_{j<k} f(x_j) |cos| / p_bsdf / q_j,
//!
//! where each way of reaching a light is weighted by the power heuristic of both densities (other techniques: by 0 or 1),
//! and q_j is the probability of surviving the roulette. Where a coin decides, with probability p, that the path ends with
//! what its surface emits, that is divided by p and all that comes later by 1 - p. Delta lobes cannot be found by light
//! sampling, nor can the constant environment, which is not a light that one samples: there w_bsdf = 1. Delta lights
//! cannot be found by scattering: there w_light = 1.
//!
//! The integrator is compiled for the effects `E`; with others it gives the same numbers.
//!
//! Measure: radiance; densities per steradian.
//! Range: any scene that calls for no effect beyond `E`; without a bounce limit a path ends by absorption, by leaving, or
//! by roulette.
//! Source: Kajiya 1986; Veach 1997, sections 8.3, 9.2 and 10.4.1. Tested in `battery/`,
//! `tests/scattering/furnace.rs`, `tests/rendering/effects.rs` and `tests/rendering/integrators.rs`.

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

/// The path integrator's choices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PathIntegrator<C = Weighted, K = Traced> {
    /// How it finds light.
    pub technique: C,
    /// What it knows of indirect light.
    pub indirect: K,
    /// Scattering events at most; `None` does not limit them.
    pub max_bounces: Option<u32>,
    /// When paths end by chance.
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
    /// Follows paths side by side to their ends, given what is found on their rays.
    ///
    /// Each stage is a loop over all of them that does little: a processor works at several of its turns at once.
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

    /// Follows one path, without looking for lights, to the first surface of which `find` yields anything, and returns that.
    /// Whatever lights a path looks for, it goes the same way.
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

/// Paths that are followed side by side, all of which have scattered as often.
pub struct Paths<'a, E: Effects, S, O: ?Sized> {
    /// Where they lie.
    pub scene: &'a Scene,
    /// Whose they are.
    pub samples: &'a mut [Sample],
    /// As those of the samples.
    pub samplers: &'a mut [S],
    /// As those of the samples.
    pub states: &'a mut [PathState<E>],
    /// Memory.
    pub queues: &'a mut PathQueues,
    /// Who watches.
    pub observer: &'a mut O,
    /// Scattering events before.
    pub bounce: u32,
}

impl<E: Effects, S, O: PathObserver + ?Sized> Paths<'_, E, S, O> {
    /// Traces the rays to lights, and then those of the paths that go on.
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
