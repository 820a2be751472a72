//! Rendering: `render` prepares a render by its settings, `resume` takes its samples until the budget is used up (`run.rs`).
//!
//! Measure: samples per pixel, seconds.
//! Range: settings that [`RenderSettings::validate`] lets through.
//! Source: docs/architecture.md. Tested in `tests/rendering/determinism.rs` and `cli/tests/command/render.rs`.

pub mod adaptive;
pub mod auto;
pub mod budget;
pub mod cache_prepass;
pub mod convergence;
mod dispatch;
mod estimator;
pub mod first_hit;
mod gain_sums;
mod light_wavefront;
mod metropolis;
mod observed;
pub mod options;
pub mod path_strategies;
mod pixel_block;
mod predicted;
mod progress;
pub mod ray_radiance;
mod rendered;
pub mod replay;
mod run;
mod sample_range;
mod sample_wavefront;
pub mod settings;
pub mod strategies;
mod tally;
mod threads;
mod tile;
mod timers;

use crate::error::{Error, Result};
use crate::film::Film;
use crate::film::filter::Filter;
use crate::integrator::kind::IntegratorKind;
use crate::scene::Scene;
pub use dispatch::{check, kernel};
pub use observed::observe_tile;
pub use predicted::Predicted;
pub use progress::{NullRenderObserver, Progress, RenderObserver};
pub use rendered::{Price, Rendered};
use run::Run;
use settings::{Adaptive, Budget, RenderSettings};
use std::time::Instant;
pub use tally::{NonFiniteSample, Rejected};
pub use threads::Threads;

/// The default confidence of the error's upper bound.
pub const CONFIDENCE: f64 = 0.95;

/// Renders a scene.
///
/// # Errors
/// Settings out of their range, a kernel that lacks an effect of the scene, or threads that cannot be started.
pub fn render(
    scene: &Scene,
    filter: &Filter,
    size: (u32, u32),
    settings: &RenderSettings,
    observer: &dyn RenderObserver,
) -> Result<Rendered> {
    settings.validate(size)?;
    let input = RenderInput {
        scene,
        filter,
        size,
    };
    let threads = Threads::new(settings.threads)?;
    let settings = auto::resolve_auto(&input, &threads, settings, observer)?.settings;
    let mut rendered = Rendered::empty(&settings, filter);
    resume(
        &input,
        &threads,
        &settings,
        settings.budget,
        &mut rendered,
        observer,
    )?;
    check_is_lit(&settings, &rendered)?;
    Ok(rendered)
}

/// The input of a render.
#[derive(Debug, Clone, Copy)]
pub struct RenderInput<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The reconstruction filter.
    pub filter: &'a Filter,
    /// The image's width and height.
    pub size: (u32, u32),
}

/// Continues a render until `until` is met in place of the settings' own budget: samples per pixel count from the first
/// sample, time from now. The image is bit for bit that of a render with as many samples at once; but strata stay those
/// of the settings' own budget, and Markov chains that were interrupted begin anew.
///
/// # Errors
/// The errors of [`render`]; and a greedy adaptive render that has begun and is not complete. What was rendered stays.
pub fn resume(
    input: &RenderInput<'_>,
    threads: &Threads,
    settings: &RenderSettings,
    until: Budget,
    rendered: &mut Rendered,
    observer: &dyn RenderObserver,
) -> Result<()> {
    let budgeted = RenderSettings {
        budget: until,
        ..settings.clone()
    };
    budgeted.validate(input.size)?;
    check(input.scene, settings)?;
    if settings.adaptive == Adaptive::Greedy && rendered.film.sample_count() > 0 {
        if is_complete(until, rendered) {
            return Ok(());
        }
        return Err(Error::usage(
            "a greedy adaptive render cannot be continued: start another one with a larger budget",
        ));
    }
    let run = Run::new(input, settings, observer, rendered);
    threads.run(|| run.all_passes(until, rendered));
    Ok(())
}

/// Fills the irradiance cache of a render that uses one, and has none yet. If the observer cancels that, there is none.
///
/// # Errors
/// The errors of [`check`].
pub fn fill_cache(
    input: &RenderInput<'_>,
    threads: &Threads,
    settings: &RenderSettings,
    rendered: &mut Rendered,
    observer: &dyn RenderObserver,
) -> Result<()> {
    check(input.scene, settings)?;
    let start = Instant::now();
    let run = Run::new(input, settings, observer, rendered);
    threads.run(|| run.fill_cache(rendered));
    rendered.elapsed += start.elapsed();
    Ok(())
}

/// Checks that the Markov chains of a whole render found light. Those of a shard may find none where others do.
///
/// # Errors
/// A render by Markov chains that has ended and is black.
pub fn check_is_lit(settings: &RenderSettings, rendered: &Rendered) -> Result<()> {
    match rendered.cancelled {
        true => Ok(()),
        false => check_found_light(settings.integrator.name(), &rendered.film),
    }
}

/// Checks that the Markov chains of a whole render by the integrator of this name found light.
///
/// # Errors
/// As [`check_is_lit`].
pub fn check_found_light(integrator: &str, film: &Film) -> Result<()> {
    if integrator == IntegratorKind::Metropolis.name() && film.mean() == [0.0; 3] {
        return Err(Error::render(
            "no bootstrap path of the Markov chains found any light: is there a light, and can it reach what the camera sees? Other integrators find rare light more easily: try --integrator path",
        ));
    }
    Ok(())
}

/// Whether a greedy adaptive render was not interrupted, and has the samples or the error of this budget.
fn is_complete(until: Budget, rendered: &Rendered) -> bool {
    let has_samples = until.spp.is_some_and(|spp| rendered.spp >= spp);
    !rendered.cancelled && (has_samples || (until.error.is_some() && rendered.reached))
}
