//! A running render: passes over all tiles, estimates of the error between them, and checkpoints.
//!
//! Every pass takes each pixel from one sample index to the next, or as far as an adaptive render assigns samples to
//! it. Since a sample is a pure function of seed, pixel and index, and each pixel's samples are added in order, the
//! image is the same for any number of threads, size of tiles and division into passes.
//!
//! Measure: samples per pixel, seconds.
//! Range: valid settings.
//! Source: docs/architecture.md. Tested in `tests/rendering/determinism.rs` and `tests/rendering/state.rs`.

use super::adaptive::allocation::Allocation;
use super::adaptive::{SampleAllocation, SampleAllocator};
use super::budget::{ForecastInput, PassPlanner};
use super::predicted::Predicted;
use super::progress::{Progress, RenderObserver};
use super::sample_range::SampleRange;
use super::sample_wavefront::CameraRaySource;
use super::settings::{Adaptive, Budget, RenderSettings, SamplerKind};
use super::tally::Tally;
use super::tile::{PassJob, SampleSource};
use super::timers::{Checkpoints, Estimates};
use super::{CONFIDENCE, RenderInput, Rendered, cache_prepass, dispatch, metropolis};
use crate::film::batches::BATCHES;
use crate::film::filter::Filter;
use crate::film::{Film, Tile};
use crate::integrator::irradiance_cache::IrradianceCache;
use crate::integrator::kind::IntegratorKind;
use crate::planted::planted;
use crate::sampler::{Batches, hash};
use crate::scene::Scene;
use rayon::iter::ParallelIterator;
use std::cmp::Reverse;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// The state of a running render.
pub(super) struct Run<'a> {
    scene: &'a Scene,
    filter: &'a Filter,
    settings: &'a RenderSettings,
    observer: &'a dyn RenderObserver,
    start: Instant,
    /// The rendering time before this run.
    before: Duration,
    /// The index of the first sample.
    first: u64,
    samples: AtomicU64,
    cancelled: AtomicBool,
}

/// The state of the error that is shown during a render.
#[derive(Debug, Clone, Copy, Default)]
struct DisplayedError {
    rel_rmse: Option<f64>,
    predicted: Option<Predicted>,
}

impl<'a> Run<'a> {
    /// A run that continues a render.
    pub(super) fn new(
        input: &RenderInput<'a>,
        settings: &'a RenderSettings,
        observer: &'a dyn RenderObserver,
        rendered: &Rendered,
    ) -> Self {
        Self {
            scene: input.scene,
            filter: input.filter,
            settings,
            observer,
            start: Instant::now(),
            before: rendered.elapsed,
            first: rendered.first,
            samples: AtomicU64::new(rendered.film.sample_count()),
            cancelled: AtomicBool::new(false),
        }
    }

    /// Renders passes until the budget is used up.
    pub(super) fn all_passes(self, budget: Budget, rendered: &mut Rendered) {
        let settings = self.settings;
        self.fill_cache(rendered);
        let mut planner = self.planner(budget, rendered);
        let known = rendered.allocation.clone();
        let mut allocator = SampleAllocator::new(settings, rendered.is_pilot, known);
        let pixels = settings.window.pixel_count();
        let firsts = allocator.counts(pixels, self.first);
        let mut shown = DisplayedError::default();
        let mut checkpoints = Checkpoints::new(self.observer.checkpoint_interval(), self.start);
        let mut estimates = Estimates::new(self.start);
        let mut is_reached = false;
        // The state that a render continues from may be a whole pilot.
        if planner.spp() > 0 && self.may_end_pilot(&planner) {
            let used = self.budget_fraction(&planner);
            allocator.pass_done(&rendered.film, planner.spp(), used);
        }
        while let Some(samples) = planner.next_pass(self.start.elapsed(), checkpoints.remaining()) {
            let samples = match allocator.is_in_pilot() {
                true => samples.min(left_of_pilot(settings.budget, planner.spp())),
                false => samples,
            };
            let film = &mut rendered.film;
            let level = self.first + planner.spp();
            let allocate = allocator.allocate(film, &firsts, level..level + samples);
            if allocate == SampleAllocation::Nothing {
                is_reached = true;
                break;
            }
            let tally = self.pass(
                film,
                rendered.cache.as_ref(),
                (allocate, &firsts),
                samples,
                &planner,
                shown,
            );
            rendered.rays += tally.rays;
            rendered.rejected.merge(tally.rejected);
            if self.is_cancelled() {
                break;
            }
            planner.pass_done(samples);
            self.observer.pass(film);
            let may_end_pilot = self.may_end_pilot(&planner);
            let is_shown = self.observer.shows_error() && estimates.are_due();
            if planner.is_estimate_due() || is_shown {
                let begun = Instant::now();
                self.estimate(film, &mut planner, &allocator, &mut shown);
                estimates.made(begun);
            }
            if may_end_pilot {
                allocator.pass_done(film, planner.spp(), self.budget_fraction(&planner));
            }
            if checkpoints.is_due() {
                self.record(rendered, &planner, &allocator);
                self.observer.checkpoint(rendered);
                checkpoints.made();
            }
        }
        self.record(rendered, &planner, &allocator);
        rendered.cancelled = self.cancelled.into_inner();
        // Where another limit ends the render between two estimates, the error may be small enough already.
        rendered.reached = is_reached
            || planner.is_reached()
            || (!rendered.cancelled && planner.target().is_some_and(|it| rendered.meets(it)));
        rendered.predicted = shown.predicted;
    }

    /// The planner of the passes that follow those of a render.
    fn planner(&self, mut budget: Budget, rendered: &Rendered) -> PassPlanner {
        let settings = self.settings;
        let step = match budget.error {
            Some(_) => BATCHES,
            None => settings.spp_step(),
        };
        if settings.adaptive == Adaptive::Greedy {
            // The error target is for each pixel, not for the image.
            budget.error = None;
        }
        let forecast_input = ForecastInput {
            pixels: settings.window.pixel_count(),
            in_steps: settings.sampler == SamplerKind::Sobol,
        };
        let error_records = rendered.error_records.clone();
        PassPlanner::new(budget, step, forecast_input)
            .in_rounds(rendered.is_shard)
            .resumed_from(rendered.spp, error_records)
            .restored(rendered.planner, rendered.elapsed)
    }

    /// Whether a pilot may end after the samples so far. Checkpoints end passes early: a pilot ends after counts that do not
    /// depend on these, unless time decides.
    fn may_end_pilot(&self, planner: &PassPlanner) -> bool {
        let budget = self.settings.budget;
        budget.time.is_some()
            || planner.is_estimate_due()
            || planner.spp() >= budget.pilot() && budget.error.is_none()
    }

    /// The share of the budget that is used up. A pilot is a share of the render's own samples, also where it is rendered in
    /// several parts.
    fn budget_fraction(&self, planner: &PassPlanner) -> f64 {
        match self.settings.budget.only_samples() {
            Some(spp) => planner.spp() as f64 / spp as f64,
            None => planner.fraction(planner.spp() as f64, self.start.elapsed()),
        }
    }

    /// Estimates the error for display and, if it is due, for the planner.
    fn estimate(
        &self,
        film: &Film,
        planner: &mut PassPlanner,
        allocator: &SampleAllocator,
        shown: &mut DisplayedError,
    ) {
        let target = planner.target();
        let confidence = target.map_or(CONFIDENCE, |target| target.confidence);
        let estimate = film.error(confidence);
        if planner.is_estimate_due() {
            planner.record_error(estimate, self.of_whole(allocator));
        }
        let pilots = shown.predicted.filter(|predicted| !predicted.is_rough);
        shown.predicted = pilots.or(Predicted::by(planner, self.start.elapsed()));
        shown.rel_rmse = estimate.map(|error| error.rel_rmse);
    }

    /// Fills the irradiance cache of a render that uses one, and has none yet.
    pub(super) fn fill_cache(&self, rendered: &mut Rendered) {
        if rendered.cache.is_some() {
            return;
        }
        let keep_going = |share, records| {
            self.observer.cache_prepass(share, records);
            !self.is_cancelled()
        };
        let (cache, rays) =
            cache_prepass::cache_prepass(self.scene, self.filter, self.settings, &keep_going);
        rendered.rays += rays;
        // An incomplete cache would give another image.
        rendered.cache = cache.filter(|_| !self.is_cancelled());
    }

    /// Records the complete passes in the state of the render.
    fn record(&self, rendered: &mut Rendered, planner: &PassPlanner, allocator: &SampleAllocator) {
        let settings = self.settings;
        rendered.spp = match settings.adaptive {
            Adaptive::Greedy => rendered.film.sample_count() / settings.window.pixel_count(),
            Adaptive::Off | Adaptive::TwoPhase => planner.spp(),
        };
        let of_whole = self.of_whole(allocator);
        rendered.equivalent_spp = of_whole.map(|it| it.equivalent_spp(planner.spp()));
        rendered.allocation = allocator.allocation().cloned();
        rendered.is_uneven = settings.adaptive == Adaptive::TwoPhase
            && self.is_ahead(&rendered.film, allocator, planner.spp());
        rendered.elapsed = self.before + self.start.elapsed();
        rendered.error_records = planner.error_records().to_vec();
        rendered.planner = Some(planner.state());
    }

    /// The allocation, if the film begins at sample 0; otherwise its error is not known.
    fn of_whole<'b>(&self, allocator: &'b SampleAllocator) -> Option<&'b Allocation> {
        let allocation = allocator.allocation().filter(|_| self.first == 0);
        allocation.map(AsRef::as_ref)
    }

    /// Whether pixels have other counts than those of `spp` complete samples per pixel.
    fn is_ahead(&self, film: &Film, allocator: &SampleAllocator, spp: u64) -> bool {
        let pixels = film.window().pixel_count();
        let mut counts = allocator.counts(pixels, self.first + spp);
        for (count, first) in counts.iter_mut().zip(allocator.counts(pixels, self.first)) {
            *count = count.saturating_sub(first);
        }
        let counts = film.in_tile_order(&counts);
        let mut tiles = film.tiles().iter().zip(film.per_tile(&counts));
        tiles.any(|(tile, counts)| tile.counts.as_deref() != Some(counts))
    }

    /// Takes the samples of one pass: `samples` in every pixel, if they are distributed evenly.
    fn pass(
        &self,
        film: &mut Film,
        cache: Option<&IrradianceCache>,
        (allocate, firsts): (SampleAllocation, &[u64]),
        samples: u64,
        planner: &PassPlanner,
        shown: DisplayedError,
    ) -> Tally {
        if self.settings.integrator == IntegratorKind::Metropolis {
            return self.chains(film, samples, planner, shown);
        }
        let end = planner.spp() + samples;
        // A tile may have more samples than others, where an interrupted render continues.
        let same = |tile: &Tile| {
            let first: u64 = planted!("passes-repeat-samples", 0, tile.samples);
            SampleRange::Same(self.first + first.min(end)..self.first + end)
        };
        let each = match allocate {
            SampleAllocation::UpTo(counts) => {
                Some([firsts, &counts].map(|of_pixels| film.in_tile_order(of_pixels)))
            }
            _ => None,
        };
        let sample_range: Vec<SampleRange<'_>> = match &each {
            Some([firsts, counts]) => {
                let of_tile = |(firsts, counts)| SampleRange::Each { firsts, counts };
                let of_tiles = film.per_tile(firsts).zip(film.per_tile(counts));
                of_tiles.map(of_tile).collect()
            }
            None => film.tiles().iter().map(same).collect(),
        };
        let sampler = dispatch::sampler(self.settings, Batches::new(BATCHES));
        let filter_sampling = film.filter_sampling();
        let (all_tiles, splats) = film.tiles_and_splats();
        let mut tiles: Vec<(&mut Tile, SampleRange<'_>)> =
            all_tiles.iter_mut().zip(sample_range).collect();
        // The longest first, so that all threads finish at about the same time. Equal ones stay in their order.
        tiles.sort_by_key(|(tile, sample_range)| Reverse(sample_range.sample_count(tile)));
        let job = PassJob {
            source: SampleSource {
                rays: CameraRaySource {
                    scene: self.scene,
                    filter: self.filter,
                    filter_sampling,
                    sampler: &sampler,
                },
                splats,
                gains: None,
            },
            tiles,
            is_cancelled: &|| self.is_cancelled(),
            tile_done: &|new_samples| self.report(planner, new_samples, shown),
        };
        dispatch::dispatch(self.scene, self.settings, cache, job)
    }

    /// Runs one pass of Markov chains, with as many steps as there would be samples.
    fn chains(
        &self,
        film: &mut Film,
        samples: u64,
        planner: &PassPlanner,
        shown: DisplayedError,
    ) -> Tally {
        let (tiles, Some(splats)) = film.tiles_and_splats() else {
            return Tally::default();
        };
        let (settings, filter) = (self.settings, self.filter);
        let area = metropolis::film_area(settings.window, filter);
        let context = metropolis::ChainContext {
            scene: self.scene,
            filter,
            kernel: dispatch::kernel(self.scene, settings),
            window: settings.window,
            integrator: dispatch::bidirectional(settings, area),
            splats,
            is_cancelled: &|| self.is_cancelled(),
        };
        let pixels = settings.window.pixel_count();
        let walked = |steps| self.report(planner, steps, shown);
        // Chains belong to a round of the batches, so that passes and shards may be of any length.
        let rounds = planner.spp() / BATCHES..(planner.spp() + samples) / BATCHES;
        // After an interrupted pass, seeds that it has not used.
        let whole = planner.spp().saturating_mul(pixels);
        let begun = splats.sample_count().saturating_sub(whole);
        let seed = hash::combine(settings.seed, begun);
        let tallies = metropolis::batches().map(|batch| {
            let rounds = rounds.clone().map(|round| {
                let seed = hash::combine(seed, self.first / BATCHES + round);
                context.batch(batch, seed, pixels, &walked)
            });
            rounds.fold(Tally::default(), Tally::merged)
        });
        let tally = tallies.reduce(Tally::default, Tally::merged);
        if !self.is_cancelled() {
            for tile in tiles {
                tile.samples += samples;
            }
        }
        tally
    }

    /// Whether the render is cancelled; once the observer has said so, it is not asked again.
    fn is_cancelled(&self) -> bool {
        if !self.cancelled.load(Ordering::Relaxed) && self.observer.is_cancelled() {
            self.cancelled.store(true, Ordering::Relaxed);
        }
        self.cancelled.load(Ordering::Relaxed)
    }

    fn report(&self, planner: &PassPlanner, new_samples: u64, shown: DisplayedError) {
        let samples = self.samples.fetch_add(new_samples, Ordering::Relaxed) + new_samples;
        let elapsed = self.start.elapsed();
        let per_pixel = samples as f64 / self.settings.window.pixel_count() as f64;
        self.observer.progress(&Progress {
            samples,
            spp: planner.spp(),
            elapsed,
            fraction: planner.fraction(per_pixel, elapsed),
            rel_rmse: shown.rel_rmse,
            predicted: shown.predicted,
        });
    }
}

/// The samples per pixel that the pilot of an adaptive render still needs. Where nothing but samples limits the render,
/// its length depends on nothing else; elsewhere it ends between passes.
fn left_of_pilot(budget: Budget, spp: u64) -> u64 {
    match budget.only_samples() {
        Some(_) if spp < budget.pilot() => budget.pilot() - spp,
        _ => u64::MAX,
    }
}
