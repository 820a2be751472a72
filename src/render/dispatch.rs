//! The one place where settings become types: which kernel runs.
//!
//! Measure: none.
//! Range: every combination of settings.
//! Source: none needed. Tested in `tests/determinism.rs`.

use super::settings::{IntegratorKind, RenderSettings, SamplerKind};
use crate::effects::kernel::KernelJob;
use crate::effects::{Effects, Kernel};
use crate::integrator::path::PathIntegrator;
use crate::sampler::{Independent, Sampler, Sobol, Stratified};
use crate::scene::Scene;

/// The integrator that the settings ask for.
pub fn integrator(settings: &RenderSettings) -> PathIntegrator {
    match settings.integrator {
        IntegratorKind::Path => PathIntegrator {
            max_bounces: settings.max_bounces,
            roulette: settings.roulette,
        },
    }
}

/// The kernel that renders a scene.
pub fn kernel(scene: &Scene, settings: &RenderSettings) -> Kernel {
    settings
        .kernel
        .unwrap_or_else(|| Kernel::smallest_for(scene.effects))
}

/// Something to do with a kernel and a sampler that are known only when running.
pub trait Dispatched {
    /// What it yields.
    type Output;
    /// Does it for the effects `E`, with the numbers of `sampler`.
    fn run<E: Effects, S: Sampler>(self, sampler: S) -> Self::Output;
}

/// Does something with the kernel and the sampler of the settings.
pub fn dispatch<D: Dispatched>(scene: &Scene, settings: &RenderSettings, job: D) -> D::Output {
    let kernel = kernel(scene, settings);
    let seed = settings.seed;
    match settings.sampler {
        SamplerKind::Independent => kernel.run(With(job, Independent::new(seed))),
        SamplerKind::Stratified => {
            kernel.run(With(job, Stratified::new(seed, settings.budget.spp)))
        }
        SamplerKind::Sobol => kernel.run(With(job, Sobol::new(seed))),
    }
}

/// A job whose sampler is known and whose kernel is not.
struct With<D, S>(D, S);

impl<D: Dispatched, S: Sampler> KernelJob for With<D, S> {
    type Output = D::Output;
    fn run<E: Effects>(self) -> D::Output {
        self.0.run::<E, S>(self.1)
    }
}
