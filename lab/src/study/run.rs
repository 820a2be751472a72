//! Runs a whole study: the cost of renders, two references, all renders in turn, then images and the sources of time
//! and variance.
//!
//! Measure: as in the report.
//! Range: a budget that is enough for three levels of samples with four seeds for every variant; a smaller one is a
//! usage error that states a sufficient budget. A cancelled study reports its results so far.
//! Source: docs/accuracy.md, "The study". Tested in `lab/tests/reports/study.rs`.

use super::fit::TimeLaw;
use super::prepared_scene::{PreparedScene, Shot};
use super::reference::References;
use super::report::{LevelReport, ReferenceReport, StudyReport, VariantStudy};
use super::runner::{Ended, Purpose, Runner, luminance, seed_for};
use super::schedule::{ANATOMY, Schedule};
use super::settings::{StudyObserver, StudySettings, Watch};
use super::variant::Variant;
use etendue::internals::render::settings::{RenderSettings, SamplerKind};
use etendue::internals::scene::description::SceneDescription;
use etendue::{Error, Result};
use std::time::Duration;

/// Maximum number of bytes of images that are kept.
const MOST_MEMORY: u64 = 4 << 30;

/// The share of the budget for measuring the cost of renders, and its maximum in seconds, over all variants.
const WARM_UP: (f64, f64) = (0.04, 8.0);

/// Studies the scene in the size of its description; `full_size` is the size in the scene file.
///
/// # Errors
/// A budget too small, a scene that is black or not valid, or a render that fails.
pub fn run(
    description: &SceneDescription,
    full_size: (u32, u32),
    settings: &StudySettings,
    observer: &dyn StudyObserver,
) -> Result<StudyReport> {
    let mut watch = Watch::new(observer, settings);
    watch.begin("preparing the scene");
    let options = settings.variants.iter().map(|variant| variant.options);
    let prepared = PreparedScene::new(description, [settings.options].into_iter().chain(options))?;
    let mut study = Study {
        description,
        settings,
        prepared: &prepared,
        report: blank(description, full_size, settings, &prepared),
    };
    let finished = study.all(&mut watch)?;
    study.report.complete = finished.is_some();
    study.report.seconds = watch.elapsed();
    watch.report(&study.report);
    Ok(study.report)
}

/// An empty report.
fn blank(
    description: &SceneDescription,
    full_size: (u32, u32),
    settings: &StudySettings,
    prepared: &PreparedScene,
) -> StudyReport {
    let of_variant = |variant: &Variant| VariantStudy {
        variant: variant.report(variant.settings.bias(prepared.effects())),
        warm_up: TimeLaw {
            start: f64::NAN,
            sample: f64::NAN,
        },
        build: prepared
            .builds
            .iter()
            .find(|(options, _)| *options == variant.options)
            .map_or(f64::NAN, |(_, seconds)| *seconds),
        levels: Vec::new(),
        repeated: 0,
        disturbed: 0,
        bars: None,
        tile_p_values: Vec::new(),
        paths: None,
        bounces: Vec::new(),
    };
    StudyReport {
        version: env!("CARGO_PKG_VERSION"),
        scene: description.file.display().to_string(),
        full_size,
        size: description.film.size,
        threads: settings.options.threads,
        seed: settings.seed,
        budget: settings.budget,
        warnings: description
            .notes
            .iter()
            .map(ToString::to_string)
            .chain(prepared.notes.iter().cloned())
            .collect(),
        variants: settings.variants.iter().map(of_variant).collect(),
        ..StudyReport::default()
    }
}

/// A running study. Each step returns `None` if it was cancelled.
pub(super) struct Study<'a> {
    pub(super) description: &'a SceneDescription,
    pub(super) settings: &'a StudySettings,
    pub(super) prepared: &'a PreparedScene,
    pub(super) report: StudyReport,
}

impl Study<'_> {
    fn all(&mut self, watch: &mut Watch<'_>) -> Result<Option<()>> {
        watch.begin("measuring the cost of renders");
        let Some((laws, reference_law)) = self.warm_up(watch)? else {
            return Ok(None);
        };
        let schedule = self.schedule(&laws, reference_law, watch)?;
        watch.begin("rendering two references");
        let Some(references) = self.references(schedule.reference_spp, watch)? else {
            return Ok(None);
        };
        self.tell(watch);
        let reserve = self.reserve(&laws, &schedule);
        self.report.schedule = Some(schedule.clone());
        watch.begin("rendering all levels in turn");
        let (settings, prepared) = (self.settings, self.prepared);
        let mut runner = Runner::new(
            settings,
            prepared,
            watch,
            &references,
            &laws,
            &schedule.doublings,
        );
        let order = seed_for(settings.seed, Purpose::Order, [0; 3]);
        let mut left_out = 0;
        for tasks in schedule.blocks(order) {
            match runner.block(&tasks, reserve, &mut self.report)? {
                Ended::Whole => {}
                Ended::OutOfTime(count) => left_out += count,
                Ended::Cancelled => return Ok(None),
            }
            self.report.seconds = watch.elapsed();
            watch.report(&self.report);
        }
        if left_out > 0 {
            self.report.warn(format!(
                "{left_out} renders were left out: the machine was slower than predicted by the warm-up"
            ));
        }
        self.tiles(&references, &runner);
        drop(runner);
        watch.begin("error bars and pictures");
        let looked = self.bars(&references, watch)?;
        if looked.is_none() || self.pictures(&references, watch)?.is_none() {
            return Ok(None);
        }
        self.tell(watch);
        watch.begin("breakdown of time and variance");
        self.anatomy(&references, &laws, watch)
    }

    pub(super) fn tell(&mut self, watch: &Watch<'_>) {
        self.report.seconds = watch.elapsed();
        watch.report(&self.report);
    }

    /// The variant that renders the references, with Sobol' points where the integrator supports them.
    fn reference_variant(&self) -> Variant {
        let settings = RenderSettings {
            integrator: self.settings.reference,
            sampler: SamplerKind::Sobol,
            occlusion_distance: None,
            threads: self.settings.options.threads,
            ..RenderSettings::new(self.prepared.size(), 1)
        };
        Variant::new(settings, self.settings.options)
    }

    /// Measures the cost of each variant and of the reference, in units of the minimum number of samples of each. The
    /// first render of each warms up the caches and is discarded.
    fn warm_up(&mut self, watch: &Watch<'_>) -> Result<Option<(Vec<TimeLaw>, TimeLaw)>> {
        let reference = self.reference_variant();
        let variants = self.settings.variants.iter().chain([&reference]);
        let share = WARM_UP.0 * self.settings.budget;
        let each = share.min(WARM_UP.1) / (self.settings.variants.len() + 1) as f64;
        let mut laws = Vec::new();
        for (index, variant) in variants.enumerate() {
            let mut points = Vec::new();
            let least = variant.settings.least_samples();
            let (mut times, mut spent) = (1, 0.0);
            loop {
                let number = points.len() as u64;
                let seed = seed_for(
                    self.settings.seed,
                    Purpose::WarmUp,
                    [index as u64, number, 0],
                );
                let settings = self.prepared.settings(variant, times * least, seed);
                let Some(shot) = self.prepared.render(variant, &settings, watch)? else {
                    return Ok(None);
                };
                points.push([times as f64, shot.seconds.wall]);
                spent += shot.seconds.wall;
                // The next render takes about twice as long.
                if points.len() > 2 && 2.0 * shot.seconds.wall + spent > each {
                    break;
                }
                if points.len() > 1 {
                    times *= 2;
                }
            }
            let law = TimeLaw::of(&points[1..]).ok_or_else(|| Error::render("no time passed"))?;
            if let Some(study) = self.report.variants.get_mut(index) {
                study.warm_up = TimeLaw {
                    sample: law.sample / least as f64,
                    ..law
                };
            }
            laws.push(law);
        }
        let reference = laws.pop().expect("the reference is the last");
        Ok(Some((laws, reference)))
    }

    fn schedule(
        &mut self,
        laws: &[TimeLaw],
        reference: TimeLaw,
        watch: &Watch<'_>,
    ) -> Result<Schedule> {
        let (width, height) = self.prepared.size();
        let schedule = match &self.settings.schedule {
            Some(given) => Ok(given.clone()),
            None => Schedule::fit(laws, reference, watch.left()),
        };
        let schedule = schedule.map_err(|enough| {
            let enough = Duration::from_secs_f64((1.1 * enough + watch.elapsed()).ceil());
            Error::usage(format!(
                "a budget of {} s is too small: {} variants of {width} x {height} pixels take at least {} s; give more by --budget, a smaller picture by --size, or vary less",
                self.settings.budget,
                laws.len(),
                enough.as_secs()
            ))
        })?;
        let bytes = schedule.renders() * u64::from(width) * u64::from(height) * 12;
        if bytes > MOST_MEMORY {
            return Err(Error::usage(format!(
                "{} pictures of {width} x {height} pixels take {:.1} GB of memory; give a smaller picture by --size, or a smaller budget",
                schedule.renders(),
                bytes as f64 / 1e9
            )));
        }
        let variants = self.report.variants.iter_mut().zip(&self.settings.variants);
        for ((study, variant), &k) in variants.zip(&schedule.doublings) {
            let least = variant.settings.least_samples();
            let level = |level: u32| LevelReport {
                spp: least << level,
                ..LevelReport::default()
            };
            study.levels = (0..=k).map(level).collect();
        }
        Ok(schedule)
    }

    fn references(&mut self, spp: u64, watch: &Watch<'_>) -> Result<Option<References>> {
        let variant = self.reference_variant();
        let spp = spp * variant.settings.least_samples();
        let mut shots: Vec<(u64, Shot)> = Vec::new();
        for index in 0..2 {
            let seed = seed_for(self.settings.seed, Purpose::Reference, [index, 0, 0]);
            let settings = self.prepared.settings(&variant, spp, seed);
            let Some(shot) = self.prepared.render(&variant, &settings, watch)? else {
                return Ok(None);
            };
            shots.push((seed, shot));
        }
        let [one, two] = [0, 1].map(|index| shots[index].1.film.develop());
        let luminances = [luminance(&one), luminance(&two)];
        let references = References::new(one, two).ok_or_else(|| {
            Error::render("the references are black: relative errors are undefined")
        })?;
        self.report.pictures.reference = Some(references.mean().clone());
        self.report.reference = Some(ReferenceReport {
            integrator: variant.settings.integrator.name(),
            sampler: variant.settings.sampler.name(),
            spp,
            seconds: [0, 1].map(|index| shots[index].1.seconds),
            seeds: [0, 1].map(|index| shots[index].0),
            luminances,
            luminance_error: references.luminance_error(),
            noise: references.noise(),
        });
        Ok(Some(references))
    }

    /// Seconds that are reserved for the steps after the levels.
    fn reserve(&self, laws: &[TimeLaw], schedule: &Schedule) -> f64 {
        let longest = |(law, &k): (&TimeLaw, &u32)| law.at(f64::from(k).exp2());
        let longest: f64 = laws.iter().zip(&schedule.doublings).map(longest).sum();
        ANATOMY * self.settings.budget + 2.5 * longest
    }
}
