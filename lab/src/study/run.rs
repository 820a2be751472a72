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
use super::report::{ReferenceReport, StudyReport, VariantStudy};
use super::runner::{Ended, Purpose, Runner, luminance, seed_for};
use super::schedule::{ANATOMY, Schedule};
use super::settings::{StudyObserver, StudySettings, Watch};
use super::variant::Variant;
use etendue::internals::render::settings::{RenderSettings, SamplerKind};
use etendue::internals::scene::description::SceneDescription;
use etendue::{Error, Result};
use std::rc::Rc;
use std::time::Instant;

/// Studies the scene in the size of its description, or in a smaller one if the settings allow it; `full_size` is the
/// size in the scene file. The budget is that of the time since `start`.
///
/// # Errors
/// A budget too small, a scene that is black or not valid, or a render that fails.
pub fn run(
    description: &SceneDescription,
    full_size: (u32, u32),
    settings: &StudySettings,
    start: Instant,
    observer: &dyn StudyObserver,
) -> Result<StudyReport> {
    let mut watch = Watch::new(start, observer, settings);
    watch.begin("preparing the scene");
    let options = settings.variants.iter().map(|variant| variant.options);
    let prepared = PreparedScene::new(description, [settings.options].into_iter().chain(options))?;
    let mut settings = settings.clone();
    for variant in &mut settings.variants {
        let Variant {
            settings, options, ..
        } = variant;
        *settings = prepared.settle(settings, *options, &watch)?.settings;
    }
    let settings = &settings;
    let mut study = Study {
        description: description.clone(),
        settings,
        report: blank(description, full_size, settings, &prepared),
        prepared: Rc::new(prepared),
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
        own_size: None,
        build: prepared
            .builds
            .iter()
            .find(|(options, _)| *options == variant.options)
            .map_or(f64::NAN, |(_, seconds)| *seconds),
        levels: Vec::new(),
        repeated: 0,
        disturbed: 0,
        look: None,
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
    pub(super) description: SceneDescription,
    pub(super) settings: &'a StudySettings,
    pub(super) prepared: Rc<PreparedScene>,
    pub(super) report: StudyReport,
}

impl Study<'_> {
    fn all(&mut self, watch: &mut Watch<'_>) -> Result<Option<()>> {
        watch.begin("measuring the cost of renders");
        let Some((costs, schedule)) = self.plan(watch)? else {
            return Ok(None);
        };
        let laws = costs.laws;
        if self.scaling(&laws, watch)?.is_none() {
            return Ok(None);
        }
        watch.begin("rendering two references");
        let Some(references) = self.references(schedule.reference_spp, watch)? else {
            return Ok(None);
        };
        self.publish(watch);
        let reserve = self.reserve(&laws, &schedule);
        self.report.schedule = Some(schedule.clone());
        watch.begin("rendering all levels in turn");
        let (settings, prepared) = (self.settings, Rc::clone(&self.prepared));
        let mut runner = Runner::new(settings, &prepared, watch, &references, &laws, &schedule);
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
        self.show_images(&references, &runner)?;
        drop(runner);
        watch.begin("error bars");
        if self.bars(&references, watch)?.is_none() {
            return Ok(None);
        }
        self.publish(watch);
        watch.begin("breakdown of time and variance");
        self.anatomy(&references, &laws, watch)
    }

    pub(super) fn publish(&mut self, watch: &Watch<'_>) {
        self.report.seconds = watch.elapsed();
        watch.report(&self.report);
    }

    /// The variant that renders the references, with Sobol' points where the integrator supports them.
    pub(super) fn reference_variant(&self) -> Variant {
        let settings = RenderSettings {
            integrator: self.settings.reference,
            sampler: SamplerKind::Sobol,
            occlusion_distance: None,
            threads: self.settings.options.threads,
            ..RenderSettings::new(self.prepared.size(), 1)
        };
        Variant::new(settings, self.settings.options)
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
        self.report.images.reference = Some(references.mean().clone());
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

    /// Seconds that are reserved for the steps after the levels: renders with error bars of a quarter of the samples of
    /// the longest, and the anatomy.
    fn reserve(&self, laws: &[TimeLaw], schedule: &Schedule) -> f64 {
        let longest = |(law, seeds): (&TimeLaw, &Vec<u64>)| law.at((seeds.len() as f64).exp2());
        let longest: f64 = laws.iter().zip(&schedule.seeds).map(longest).sum();
        ANATOMY * self.settings.budget + 0.2 * longest
    }
}
