//! Runs a whole study: the cost of renders, two references, all renders in turn, then images and the sources of time
//! and variance.
//!
//! Measure: as in the report.
//! Range: a budget that is enough for three levels of samples with four seeds for every variant; a smaller one is a
//! usage error that states a sufficient budget. A cancelled study reports its results so far.
//! Source: docs/accuracy.md, "The study". Tested in `lab/tests/reports/study.rs`.

use super::compared_renders::ComparedRenders;
use super::fit::TimeLaw;
use super::prepared_scene::PreparedScene;
use super::reference::References;
use super::report::{StudyReport, VariantStudy};
use super::runner::{Purpose, Runner, seed_for};
use super::schedule::{COST_SOURCES, Schedule};
use super::settings::{StudyClock, StudyObserver, StudySettings};
use super::variant::Variant;
use etendue::Result;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::scene::description::SceneDescription;
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
    let mut clock = StudyClock::new(start, observer, settings);
    let (prepared, settings) = resolved(description, settings, &mut clock)?;
    let mut study = Study::new(description, full_size, &settings, prepared);
    let finished = study.all(&mut clock)?;
    Ok(study.ended(finished, &clock))
}

/// Prepares the scene for all variants, and replaces all that pilots choose in their settings.
///
/// # Errors
/// A scene that is not valid, or a pilot that fails.
pub(super) fn resolved(
    description: &SceneDescription,
    settings: &StudySettings,
    clock: &mut StudyClock<'_>,
) -> Result<(PreparedScene, StudySettings)> {
    clock.begin("preparing the scene");
    let options = settings.variants.iter().map(|variant| variant.options);
    let prepared = PreparedScene::new(description, [settings.options].into_iter().chain(options))?;
    let mut settings = settings.clone();
    for variant in &mut settings.variants {
        let Variant {
            settings, options, ..
        } = variant;
        *settings = prepared.resolve_auto(settings, *options, clock)?.settings;
    }
    let reference = RenderSettings {
        integrator: settings.reference,
        light_paths: settings.reference_light_paths,
        threads: settings.options.threads,
        ..RenderSettings::new(prepared.size(), 1)
    };
    let reference = prepared.resolve_auto(&reference, settings.options, clock)?;
    settings.reference_light_paths = reference.settings.light_paths;
    Ok((prepared, settings))
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
        error_record: None,
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

impl<'a> Study<'a> {
    /// A study of a prepared scene, with an empty report.
    pub(super) fn new(
        description: &SceneDescription,
        full_size: (u32, u32),
        settings: &'a StudySettings,
        prepared: PreparedScene,
    ) -> Self {
        Self {
            description: description.clone(),
            settings,
            report: blank(description, full_size, settings, &prepared),
            prepared: Rc::new(prepared),
        }
    }

    /// The report of a study that has ended, `None` as its outcome if it was cancelled.
    pub(super) fn ended(mut self, outcome: Option<()>, clock: &StudyClock<'_>) -> StudyReport {
        self.report.complete = outcome.is_some();
        self.publish(clock);
        self.report
    }

    fn all(&mut self, clock: &mut StudyClock<'_>) -> Result<Option<()>> {
        clock.begin("measuring the cost of renders");
        let Some((costs, schedule)) = self.plan(clock)? else {
            return Ok(None);
        };
        let laws = costs.laws;
        if self.scaling(&laws, clock)?.is_none() {
            return Ok(None);
        }
        clock.begin("rendering two references");
        let Some(renders) = self.reference_renders(schedule.reference_spp, 0, clock)? else {
            return Ok(None);
        };
        let references = self.references(&[renders])?;
        self.publish(clock);
        let reserve = self.reserve(&laws, &schedule);
        self.report.schedule = Some(schedule.clone());
        clock.begin("rendering all levels in turn");
        let (settings, prepared) = (self.settings, Rc::clone(&self.prepared));
        let mut runner = Runner::new(settings, &prepared, clock, &schedule, 0);
        let mut compared = ComparedRenders::new(&references, &schedule);
        let mut left_out = 0;
        for tasks in schedule.blocks(order(settings)) {
            for task in tasks {
                if runner.is_late(task, &laws, reserve) {
                    left_out += 1;
                    continue;
                }
                let Some(render) = runner.render(task, reserve)? else {
                    return Ok(None);
                };
                compared.take(render, &mut self.report);
            }
            self.publish(clock);
        }
        if left_out > 0 {
            self.report.warn(format!(
                "{left_out} renders were left out: the machine was slower than predicted by the warm-up"
            ));
        }
        self.after_levels(compared, &references, &laws, clock)
    }

    /// Everything after the renders of all levels: tiles, images, error bars, and the sources of time and variance.
    pub(super) fn after_levels(
        &mut self,
        compared: ComparedRenders<'_>,
        references: &References,
        laws: &[TimeLaw],
        clock: &mut StudyClock<'_>,
    ) -> Result<Option<()>> {
        self.tiles(references, &compared);
        self.show_images(references, &compared)?;
        drop(compared);
        clock.begin("error bars");
        if self.bars(references, clock)?.is_none() {
            return Ok(None);
        }
        self.publish(clock);
        clock.begin("breakdown of time and variance");
        self.cost_sources(references, laws, clock)
    }

    pub(super) fn publish(&mut self, clock: &StudyClock<'_>) {
        self.report.seconds = clock.elapsed();
        clock.report(&self.report);
    }

    /// Seconds that are reserved for the steps after the levels: renders with error bars of a quarter of the samples of
    /// the longest, and the sources of time and variance.
    fn reserve(&self, laws: &[TimeLaw], schedule: &Schedule) -> f64 {
        let longest = |(law, seeds): (&TimeLaw, &Vec<u64>)| law.at((seeds.len() as f64).exp2());
        let longest: f64 = laws.iter().zip(&schedule.seeds).map(longest).sum();
        COST_SOURCES * self.settings.budget + 0.2 * longest
    }
}

/// The seed of the order of renders.
pub(super) fn order(settings: &StudySettings) -> u64 {
    seed_for(settings.seed, Purpose::Order, [0; 3])
}
