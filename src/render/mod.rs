//! Rendering: passes over tiles on all threads, until the budget is used up.
//!
//! Every pass takes each pixel from one sample index to the next. Since a sample is a pure function of seed, pixel and
//! index, and each pixel's samples are added in order, the picture is the same for any number of threads, size of tiles
//! and division into passes.
//!
//! Measure: samples per pixel, seconds.
//! Range: settings that [`RenderSettings::validate`] lets through.
//! Source: docs/architecture.md. Tested in `tests/determinism.rs` and `tests/command.rs`.

pub mod budget;
mod camera_rays;
mod dispatch;
mod observed;
pub mod replay;
pub mod settings;
mod tile;

use crate::error::{Error, Result};
use crate::film::Film;
use crate::film::filter::Filter;
use crate::integrator::RayCounts;
use crate::integrator::observer::Unobserved;
use crate::planted::planted;
use crate::scene::Scene;
use budget::PassPlanner;
pub use dispatch::kernel;
pub use observed::observe_tile;
use rayon::prelude::*;
use settings::RenderSettings;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tile::TileJob;
pub use tile::{NonFiniteSample, Rejected};

/// How far a render has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Samples taken, over all pixels.
    pub samples: u64,
    /// Samples per pixel that are complete.
    pub spp: u64,
    /// Time since the rendering began.
    pub elapsed: Duration,
    /// The share of the budget that is used up, in [0, 1].
    pub fraction: f64,
    /// Estimated root of relMSE, once it can be told.
    pub rel_rmse: Option<f64>,
}

/// Is told how a render goes on, from any of its threads, and can end it.
pub trait RenderObserver: Sync {
    /// After every tile.
    fn progress(&self, _progress: &Progress) {}
    /// Whether the render should stop as soon as it can; the samples so far are kept.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// Nobody watches.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unwatched;

impl RenderObserver for Unwatched {}

/// A finished render.
#[derive(Debug)]
pub struct Rendered {
    /// The sums of all pixels.
    pub film: Film,
    /// Complete samples per pixel; some tiles have more after an interruption.
    pub spp: u64,
    /// Time that the rendering took.
    pub elapsed: Duration,
    /// Rays traced.
    pub rays: RayCounts,
    /// Samples that were not finite.
    pub rejected: Rejected,
    /// Whether the observer ended it.
    pub cancelled: bool,
}

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
    let kernel = dispatch::kernel(scene, settings);
    let compiled = dispatch::kernels(settings.integrator);
    if !compiled.contains(&kernel) {
        let compiled: Vec<&str> = compiled.iter().map(|kernel| kernel.name()).collect();
        return Err(Error::usage(format!(
            "the integrator {} has no kernel {}, only {}",
            settings.integrator.name(),
            kernel.name(),
            compiled.join(" and ")
        )));
    }
    if !kernel.effects().contains(scene.effects) {
        let lacking = scene.effects.iter().filter(|&e| !kernel.effects().has(e));
        let lacking: Vec<&str> = lacking.map(|effect| effect.name()).collect();
        return Err(Error::usage(format!(
            "the kernel {} lacks effects of the scene: {}",
            kernel.name(),
            lacking.join(", ")
        )));
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(settings.threads)
        .build()
        .map_err(|error| Error::render("cannot start the threads").because(error))?;
    let run = Run {
        scene,
        filter,
        settings,
        observer,
        start: Instant::now(),
        samples: AtomicU64::new(0),
        cancelled: AtomicBool::new(false),
        totals: Mutex::default(),
    };
    Ok(pool.install(|| run.all_passes()))
}

/// How often the error is estimated while the render goes on.
const TIME_BETWEEN_LOOKS: Duration = Duration::from_secs(2);

/// What a render holds while it goes on.
struct Run<'a> {
    scene: &'a Scene,
    filter: &'a Filter,
    settings: &'a RenderSettings,
    observer: &'a dyn RenderObserver,
    start: Instant,
    samples: AtomicU64,
    cancelled: AtomicBool,
    totals: Mutex<Totals>,
}

#[derive(Default)]
struct Totals {
    rays: RayCounts,
    rejected: Rejected,
}

impl Run<'_> {
    fn all_passes(self) -> Rendered {
        let mut film = Film::new(self.settings.window, self.settings.tile_size);
        let mut planner = PassPlanner::new(self.settings.budget);
        let mut error = None;
        let mut last_look = self.start;
        while let Some(samples) = planner.next_pass(self.start.elapsed()) {
            film.tiles_mut().par_iter_mut().for_each(|tile| {
                if self.is_cancelled() {
                    return;
                }
                let first = planted!("passes-repeat-samples", 0, planner.spp());
                let range = first..first + samples;
                let (pixels, scene) = (tile.window.pixel_count(), self.scene);
                let job = TileJob {
                    scene,
                    filter: self.filter,
                    tile,
                    range,
                    observer: &mut Unobserved,
                };
                let outcome = dispatch::dispatch(scene, self.settings, job);
                let mut totals = self
                    .totals
                    .lock()
                    .expect("no thread panics while it holds this");
                totals.rays += outcome.rays;
                totals.rejected.merge(outcome.rejected);
                drop(totals);
                self.report(&planner, pixels * samples, error);
            });
            if self.is_cancelled() {
                break;
            }
            planner.pass_done(samples);
            // It takes one thread's time, and nobody reads it more often.
            if last_look.elapsed() > TIME_BETWEEN_LOOKS {
                error = film.error().map(|error| error.rel_rmse);
                last_look = Instant::now();
            }
        }
        let totals = self
            .totals
            .into_inner()
            .expect("no thread panics while it holds this");
        Rendered {
            spp: planner.spp(),
            elapsed: self.start.elapsed(),
            rays: totals.rays,
            rejected: totals.rejected,
            cancelled: self.cancelled.into_inner(),
            film,
        }
    }

    /// Asks the observer once and for all.
    fn is_cancelled(&self) -> bool {
        if !self.cancelled.load(Ordering::Relaxed) && self.observer.is_cancelled() {
            self.cancelled.store(true, Ordering::Relaxed);
        }
        self.cancelled.load(Ordering::Relaxed)
    }

    fn report(&self, planner: &PassPlanner, new_samples: u64, rel_rmse: Option<f64>) {
        let samples = self.samples.fetch_add(new_samples, Ordering::Relaxed) + new_samples;
        let elapsed = self.start.elapsed();
        let per_pixel = samples as f64 / self.settings.window.pixel_count() as f64;
        self.observer.progress(&Progress {
            samples,
            spp: planner.spp(),
            elapsed,
            fraction: planner.fraction(per_pixel, elapsed),
            rel_rmse,
        });
    }
}
