//! Dispatch, the one place where settings become types: the integrator and the kernel that run. Samplers are values, as
//! numbers are drawn for many paths at once.
//!
//! `path` is compiled for every kernel, every other integrator for two, to limit the number of instances: the first, and
//! the one with all effects.
//!
//! Measure: none.
//! Range: every combination of settings.
//! Source: none needed. Tested in `tests/rendering/determinism.rs` and `tests/rendering/integrators.rs`.

use super::settings::{LightPathRule, RenderSettings, SamplerKind};
use crate::effects::kernel::{KernelJob, types};
use crate::effects::{Effect, Effects, Kernel};
use crate::error::{Error, Result};
use crate::integrator::Integrator;
use crate::integrator::ambient_occlusion::AmbientOcclusion;
use crate::integrator::bidirectional::Bidirectional;
use crate::integrator::indirect::{Indirect, Uncached};
use crate::integrator::irradiance_cache::{Cached, IrradianceCache};
use crate::integrator::kind::IntegratorKind;
use crate::integrator::light_paths::LightPaths;
use crate::integrator::path::PathIntegrator;
use crate::integrator::reuse::PathReuse;
use crate::integrator::technique::{Technique, Weighted};
use crate::sampler::{AnySampler, Batches, Independent, Sobol, Stratified};
use crate::scene::Scene;

/// The kernels that an integrator is compiled for.
pub fn kernels(integrator: IntegratorKind) -> &'static [Kernel] {
    match integrator {
        IntegratorKind::Path => Kernel::ALL,
        _ => &[Kernel::Matte, Kernel::Everything],
    }
}

/// The kernel that renders a scene.
pub fn kernel(scene: &Scene, settings: &RenderSettings) -> Kernel {
    let compiled = kernels(settings.integrator).iter().copied();
    settings
        .kernel
        .unwrap_or_else(|| Kernel::smallest_of(compiled, settings.effects(scene.effects)))
}

/// Checks that a scene can be rendered with these settings.
///
/// # Errors
/// A kernel that the integrator lacks, or that lacks an effect of the scene; a cache for a scene with motion; `auto`,
/// which has to be replaced before.
pub fn check(scene: &Scene, settings: &RenderSettings) -> Result<()> {
    if settings.integrator == IntegratorKind::Auto {
        return Err(Error::usage(
            "auto selects one of several integrators: name one here, such as path",
        ));
    }
    let kernel = kernel(scene, settings);
    let compiled = kernels(settings.integrator);
    if !compiled.contains(&kernel) {
        let compiled: Vec<&str> = compiled.iter().map(|kernel| kernel.name()).collect();
        return Err(Error::usage(format!(
            "the integrator {} has no kernel {}, only {}",
            settings.integrator.name(),
            kernel.name(),
            compiled.join(" and ")
        )));
    }
    let effects = settings.effects(scene.effects);
    if !kernel.effects().contains(effects) {
        let lacking = effects.iter().filter(|&e| !kernel.effects().has(e));
        let lacking: Vec<&str> = lacking.map(|effect| effect.name()).collect();
        return Err(Error::usage(format!(
            "the kernel {} lacks effects of the scene: {}",
            kernel.name(),
            lacking.join(", ")
        )));
    }
    if let Some(effect) = prevents_reuse(scene).filter(|_| settings.reuse().is_on()) {
        return Err(Error::usage(format!(
            "pixels cannot share paths in a scene with {}: use --reuse off",
            effect.name()
        )));
    }
    if settings.integrator == IntegratorKind::IrradianceCache && scene.effects.has(Effect::Motion) {
        return Err(Error::usage(
            "the records of an irradiance cache are valid for one time only, and this scene moves while the shutter is \
             open: use --integrator path, or shutter = [0, 0] in the scene's [camera]",
        ));
    }
    Ok(())
}

/// The effect of a scene, if there is one, by which pixels cannot share paths.
pub fn prevents_reuse(scene: &Scene) -> Option<Effect> {
    let effects = [Effect::Motion, Effect::Alpha];
    effects.into_iter().find(|&it| scene.effects.has(it))
}

/// A job for an integrator and a kernel that are known only at run time.
pub trait IntegratorJob {
    /// The result.
    type Output;
    /// Runs the job with an integrator for the effects `E`.
    fn run<E: Effects, I: Integrator>(self, integrator: I) -> Self::Output;
}

/// Runs a job with the integrator and the kernel of the settings. `cache` is the result of their cache prepass.
pub fn dispatch<D: IntegratorJob>(
    scene: &Scene,
    settings: &RenderSettings,
    cache: Option<&IrradianceCache>,
    job: D,
) -> D::Output {
    match settings.integrator {
        // The unit tests need no more than two kernels, and compile in less time with these alone.
        #[cfg(not(test))]
        IntegratorKind::Path => kernel(scene, settings).run(With(job, path_with_all(settings))),
        _ => dispatch_to_matte_or_everything(scene, settings, cache, job),
    }
}

/// Runs a job with the integrator of the settings and one of two kernels, the first and the one with all effects: for
/// rare jobs, or those whose time does not matter. All kernels give the same bits.
pub fn dispatch_to_matte_or_everything<D: IntegratorJob>(
    scene: &Scene,
    settings: &RenderSettings,
    cache: Option<&IrradianceCache>,
    job: D,
) -> D::Output {
    let kernel = kernel(scene, settings);
    match settings.integrator {
        IntegratorKind::Path => {
            run_matte_or_everything(kernel, With(job, path_with_all(settings)))
        }
        IntegratorKind::Bidirectional | IntegratorKind::Metropolis => {
            let area = settings.window.pixel_count() as f64;
            run_matte_or_everything(kernel, With(job, bidirectional(settings, area)))
        }
        IntegratorKind::AmbientOcclusion => {
            let far = settings.occlusion_distance;
            let distance = far.map_or(f32::INFINITY, |far| scene.normalisation.length(far));
            run_matte_or_everything(kernel, With(job, AmbientOcclusion { distance }))
        }
        IntegratorKind::Naive
        | IntegratorKind::EmitOrReflect
        | IntegratorKind::Bsdf
        | IntegratorKind::LightOrRest
        | IntegratorKind::NextEvent
        | IntegratorKind::IrradianceCache
        | IntegratorKind::DirectDirectional
        | IntegratorKind::DirectArea
        // `check` refuses `auto`, which stands for one of the others.
        | IntegratorKind::Auto => match cache {
            Some(cache) => {
                run_matte_or_everything(kernel, With(job, path(settings, Weighted, Cached(cache))))
            }
            None => {
                let technique = settings.integrator.technique().unwrap_or(Technique::PATH);
                run_matte_or_everything(kernel, With(job, path(settings, technique, Uncached)))
            }
        },
    }
}

/// The sampler of the settings, whose samples come in these batches.
pub fn sampler(settings: &RenderSettings, batches: Batches) -> AnySampler {
    let seed = settings.seed;
    match settings.sampler {
        SamplerKind::Independent => AnySampler::Independent(Independent::new(seed)),
        SamplerKind::Stratified => {
            let samples = settings.samples_of_strata();
            AnySampler::Stratified(Stratified::in_batches(seed, samples, batches))
        }
        SamplerKind::Sobol => AnySampler::Sobol(Sobol::new(seed).in_batches(batches)),
    }
}

/// The path tracer of these settings, with their light paths and the paths that pixels share.
pub fn path_with_all(settings: &RenderSettings) -> PathIntegrator {
    PathIntegrator {
        light_paths: LightPaths {
            share: settings.light_path_share(),
            pixels: settings.window.pixel_count(),
            caustics_only: matches!(settings.light_path_rule(), LightPathRule::Caustics(_)),
        },
        reuse: settings.reuse(),
        ..path(settings, Weighted, Uncached)
    }
}

/// The path tracer of these settings, without light paths and shared paths.
pub fn path<C, K: Indirect>(
    settings: &RenderSettings,
    technique: C,
    indirect: K,
) -> PathIntegrator<C, K> {
    PathIntegrator {
        technique,
        indirect,
        max_bounces: settings.bounce_limit(),
        roulette: settings.roulette(),
        light_choice: settings.light_choice(),
        environment_sampling: settings.environment_sampling(),
        light_paths: LightPaths::NONE,
        reuse: PathReuse::Off,
    }
}

/// The bidirectional integrator of these settings, whose samples are spread over `film_area` pixels of film.
pub fn bidirectional(settings: &RenderSettings, film_area: f64) -> Bidirectional {
    Bidirectional {
        max_bounces: settings.bounce_limit(),
        roulette: settings.roulette(),
        film_area,
        light_choice: settings.light_choice(),
    }
}

/// Runs a job that is compiled for two kernels only.
pub fn run_matte_or_everything<J: KernelJob>(kernel: Kernel, job: J) -> J::Output {
    match kernel {
        Kernel::Matte => job.run::<types::Matte>(),
        _ => job.run::<types::Everything>(),
    }
}

/// A job whose integrator is known and whose kernel is not.
struct With<D, I>(D, I);

impl<D: IntegratorJob, I: Integrator> KernelJob for With<D, I> {
    type Output = D::Output;
    fn run<E: Effects>(self) -> D::Output {
        self.0.run::<E, I>(self.1)
    }
}
