//! An integrator with the scene that it estimates, for a kernel.
//!
//! Measure: as the integrator's.
//! Range: as the integrator's.
//! Source: none needed.

use crate::effects::Effects;
use crate::integrator::light_paths::LightPathSplats;
use crate::integrator::{Integrator, SampleLanes};
use crate::sampler::AnySampler;
use crate::scene::Scene;

/// An integrator that estimates samples of a scene, with its scratch.
pub struct Estimator<'a, E: Effects, I: Integrator> {
    /// The scene.
    pub scene: &'a Scene,
    /// The integrator.
    pub integrator: I,
    /// Memory that is kept from sample to sample.
    pub scratch: I::Scratch<'a, E>,
}

impl<'a, E: Effects, I: Integrator> Estimator<'a, E, I> {
    /// Creates an estimator with an empty scratch.
    pub fn new(scene: &'a Scene, integrator: I) -> Self {
        Self {
            scene,
            integrator,
            scratch: I::Scratch::default(),
        }
    }

    /// Traces a light path for each active lane of the samples, as [`Integrator::trace_light_paths`].
    pub fn trace_light_paths(
        &mut self,
        samplers: &mut [AnySampler],
        samples: &mut [SampleLanes],
        splats: &mut LightPathSplats<'_>,
    ) {
        let Self {
            scene,
            integrator,
            scratch,
        } = self;
        integrator.trace_light_paths::<E, _>(scene, samplers, samples, scratch, splats);
    }
}
