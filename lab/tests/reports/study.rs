//! Tests of whole studies of a small room: detected bias, measured efficiency, the report, and interruption.

use crate::common::room::{LAMP, room, with_mirrored_point_light};
use etendue::ErrorKind;
use etendue::internals::accel::{AccelOptions, Backend, Precision};
use etendue::internals::film::filter::FilterSampling;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::settings::{LightPathRule, RenderSettings, SamplerKind};
use etendue::internals::scene::description::{FilmDescription, SceneDescription};
use etendue_lab::study::answer::Answer;
use etendue_lab::study::report::StudyReport;
use etendue_lab::study::run;
use etendue_lab::study::schedule::Schedule;
use etendue_lab::study::settings::{NullStudyObserver, StudyObserver, StudySettings};
use etendue_lab::study::summary::{Summary, summaries};
use etendue_lab::study::variance::LightFoundBy;
use etendue_lab::study::variant::{SettingValue, Variant};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

pub fn scene() -> SceneDescription {
    room(LAMP)
}

pub fn settings(
    choices: &[SettingValue],
    budget: f64,
    schedule: Option<Schedule>,
) -> StudySettings {
    let options = AccelOptions {
        backend: Backend::ALL[0],
        precision: Precision::Robust,
        quality: None,
        threads: 2,
    };
    let base = Variant::new(RenderSettings::new((16, 16), 1), options);
    StudySettings {
        reference_light_paths: LightPathRule::Auto,
        budget,
        seed: 5,
        reference: IntegratorKind::Path,
        options,
        variants: Variant::all(&base, choices),
        may_shrink: false,
        for_threads: None,
        schedule,
        shards: 1,
    }
}

pub fn study(settings: &StudySettings) -> StudyReport {
    study_of(&scene(), settings)
}

fn study_of(description: &SceneDescription, settings: &StudySettings) -> StudyReport {
    run(
        description,
        (64, 64),
        settings,
        Instant::now(),
        &NullStudyObserver,
    )
    .expect("a valid study")
}

/// A fixed schedule, with which the images depend only on the seed.
fn fixed(variants: usize) -> Schedule {
    Schedule {
        reference_spp: 1024,
        seeds: vec![vec![8, 8, 8, 8, 8, 4]; variants],
    }
}

fn of<'a>(all: &'a [(usize, Summary)], name: &str) -> &'a Summary {
    let found = all.iter().find(|(_, summary)| summary.name == name);
    &found.unwrap_or_else(|| panic!("no {name}")).1
}

#[test]
fn study_detects_bias_and_ranks_integrators_by_efficiency() {
    let integrators = [
        IntegratorKind::Path,
        IntegratorKind::Bsdf,
        IntegratorKind::DirectDirectional,
    ];
    let choices = integrators.map(SettingValue::Integrator);
    let mut settings = settings(&choices, 8.0, Some(fixed(3)));
    for variant in &mut settings.variants {
        variant.settings.sampler = SamplerKind::Independent;
    }
    let report = study(&settings);
    assert!(report.complete, "{:?}", report.warnings);
    let all = summaries(&report);
    let [path, bsdf, direct] = integrators.map(|kind| of(&all, kind.name()));

    for right in [path, bsdf] {
        assert!(!right.bias.is_found, "{}: {:?}", right.name, right.bias);
        let [off, margin] = right.bias.light;
        assert!(off.abs() < 3.0 * margin && margin < 0.2, "{:?}", right.bias);
        // With independent samples relMSE falls as 1 / spp, within the uncertainty of 8 seeds.
        let slope = right.slope.expect("six levels").b;
        assert!(
            (slope.value - 1.0).abs() < 0.15,
            "{}: {slope:?}",
            right.name
        );
        // Without bias relMSE is all variance, up to the noise of the references and of the estimates.
        let last = right.levels.last().expect("levels");
        let ratio = last.variance.value / last.rel_mse.value;
        assert!((ratio - 1.0).abs() < 0.2, "{}: {ratio}", right.name);
    }
    assert!(
        direct.bias.is_square_found && direct.bias.p < 1e-5,
        "{:?}",
        direct.bias
    );
    // Light that scatters more than once is a large part of this room's light.
    assert!(direct.bias.light[0] < -0.2, "{:?}", direct.bias);
    assert!(direct.bias.squared.value.sqrt() > 0.1);
    assert!(!report.variants[2].variant.bias.is_empty());

    // Compared at equal sample counts, which do not depend on timing. Sampling the light has less variance than hitting
    // it by BSDF sampling.
    let error = |summary: &Summary| summary.levels.last().expect("levels").rel_mse.value;
    assert!(error(bsdf) > 10.0 * error(path));
    assert!(bsdf.efficiency.value < path.efficiency.value);
    assert!(bsdf.ratio.value < 1.0 && path.ratio.value == 1.0);
    assert!(matches!(path.tenth, Answer::Law(_)), "{:?}", path.tenth);
    let biased_much = direct.bias.squared.value > 0.01 * error(direct);
    assert_eq!(matches!(direct.tenth, Answer::Never(_)), biased_much);

    // Without bias the p-values of tiles are uniform in [0, 1]; with this bias all are small.
    let below = |index: usize| {
        let all: &[f64] = &report.variants[index].tile_p_values;
        all.iter().filter(|&&p| p < 0.05).count() as f64 / all.len() as f64
    };
    assert!(
        below(0) <= 0.75 && below(2) == 1.0,
        "{} {}",
        below(0),
        below(2)
    );
}

#[test]
fn error_bars_cover_the_reference_and_path_shares_sum_to_one() {
    let choices = [IntegratorKind::Path, IntegratorKind::Bsdf].map(SettingValue::Integrator);
    let mut settings = settings(&choices, 20.0, Some(fixed(2)));
    settings.schedule = Some(Schedule {
        reference_spp: 4096,
        seeds: vec![[vec![8; 8], vec![4]].concat(), vec![8, 8, 4]],
    });
    for variant in &mut settings.variants {
        variant.settings.sampler = SamplerKind::Independent;
    }
    let report = study(&settings);
    let bars = report.variants[0].bars.as_ref().expect("bars");
    assert_eq!(bars.spp, 64);
    assert!(bars.reference_share < 0.05, "{}", bars.reference_share);
    let ninety_five = bars.coverage.iter().find(|c| c.confidence == 0.95);
    let ninety_five = ninety_five.expect("the level of 95 % is reported");
    let held = ninety_five.trusted.held + ninety_five.flagged.held;
    let count = ninety_five.trusted.count + ninety_five.flagged.count;
    // About 200 pixels with correlated channels: 88 % is four standard deviations below 95 %.
    assert!(
        count > 600 && held as f64 > 0.88 * count as f64,
        "{ninety_five:?}"
    );
    assert_eq!(
        bars.z.iter().sum::<u64>() + bars.z_flagged.iter().sum::<u64>(),
        count
    );

    for (study, found) in report
        .variants
        .iter()
        .zip([LightFoundBy::LightSampling, LightFoundBy::Scattering])
    {
        let paths = study.paths.as_ref().expect("shares of paths");
        assert!(paths.unexplained.abs() < 1e-6, "{paths:?}");
        let light: f64 = paths.classes.iter().map(|class| class.energy).sum();
        assert!((light - 1.0).abs() < 1e-9);
        // `path` finds most of its light by sampling lights, `bsdf` none.
        let share = |found: LightFoundBy| {
            let classes = paths.classes.iter().filter(|class| class.found == found);
            classes.map(|class| class.energy).sum::<f64>()
        };
        let other = match found {
            LightFoundBy::Scattering => LightFoundBy::LightSampling,
            _ => LightFoundBy::Scattering,
        };
        assert!(share(found) > share(other), "{paths:?}");
    }
    let bsdf = report.variants[1].paths.as_ref().expect("shares of paths");
    assert!(
        bsdf.classes
            .iter()
            .all(|class| class.found != LightFoundBy::LightSampling)
    );
    // Paths with one bounce carry more light than those with two, and all lengths together carry all of it.
    let bounces = &report.variants[0].bounces;
    let light: f64 = bounces.iter().map(|bounce| bounce.energy).sum();
    assert!(
        (light - 1.0).abs() < 1e-9 && bounces[1].energy > bounces[2].energy,
        "{bounces:?}"
    );
}

#[test]
fn report_is_reproducible_and_records_every_run() {
    let settings = settings(&[], 4.0, Some(fixed(1)));
    let (one, two) = (study(&settings), study(&settings));
    let errors = |report: &StudyReport| {
        let levels = report.variants[0].levels.iter();
        levels.map(|level| level.gram.clone()).collect::<Vec<_>>()
    };
    // The images are the same, in whatever order and time they were rendered.
    assert_eq!(errors(&one), errors(&two));
    let levels = &one.variants[0].levels;
    assert_eq!(
        levels.iter().map(|l| l.runs.len()).collect::<Vec<_>>(),
        [8, 8, 8, 8, 8, 4]
    );
    for level in levels {
        let of_runs: Vec<f64> = level.runs.iter().map(|run| run.rel_mse).collect();
        assert_eq!(of_runs, level.gram.squared_errors());
        assert!(
            level
                .runs
                .iter()
                .all(|run| run.seconds.wall > 0.0 && run.trimmed <= run.rel_mse)
        );
        let mut seeds: Vec<u64> = level.runs.iter().map(|run| run.seed).collect();
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), level.runs.len());
    }
    assert_eq!(one.images.at_times.len(), 1);
    // Renders of this length are far from 10 s: those are shown that take nearly the time that is named.
    let after = &one.images.at_times[0];
    let own_time = summaries(&one)[0].1.own_time;
    let ratio = own_time.at(after.shown[0].spp as f64) / after.seconds;
    assert!((0.5..2.0).contains(&ratio), "{ratio}");
    assert_eq!(one.images.at_times[0].shown[0].errors.len(), 256);
}

#[test]
fn insufficient_budget_error_names_a_sufficient_budget() {
    let mut scene = scene();
    scene.film.size = (512, 512);
    let mut settings = settings(&[], 0.05, None);
    settings.variants[0].settings = RenderSettings::new((512, 512), 1);
    let error = run(
        &scene,
        (512, 512),
        &settings,
        Instant::now(),
        &NullStudyObserver,
    )
    .expect_err("the budget is too small");
    assert_eq!(error.kind(), ErrorKind::Usage);
    let text = error.to_string();
    assert!(
        text.contains("too small") && text.contains("at least") && text.contains("--size"),
        "{text}"
    );
}

#[test]
fn black_scene_is_rejected() {
    let error = run(
        &room(""),
        (16, 16),
        &settings(&[], 5.0, None),
        Instant::now(),
        &NullStudyObserver,
    );
    let text = error.expect_err("there is no emitter").to_string();
    assert!(text.contains("black"), "{text}");
}

/// Cancels a study after `most` reports: the first follows the references, each further one a block.
struct Impatient {
    reports: AtomicUsize,
    most: usize,
}

impl StudyObserver for Impatient {
    fn is_cancelled(&self) -> bool {
        self.reports.load(Ordering::Relaxed) >= self.most
    }

    fn report(&self, _report: &StudyReport) {
        self.reports.fetch_add(1, Ordering::Relaxed);
    }
}

#[test]
fn cancelled_study_is_marked_incomplete_and_keeps_results() {
    let settings = settings(&[], 4.0, Some(fixed(1)));
    let ended = |most: usize| {
        let reports = AtomicUsize::new(0);
        let observer = Impatient { reports, most };
        let report =
            run(&scene(), (64, 64), &settings, Instant::now(), &observer).expect("a report");
        assert!(!report.complete);
        report
    };
    let counts = |report: &StudyReport| {
        let levels = report.variants[0].levels.iter();
        levels.map(|level| level.runs.len()).collect::<Vec<_>>()
    };
    let at_once = ended(0);
    assert!(at_once.reference.is_none() && summaries(&at_once).is_empty());
    let with_references = ended(1);
    assert!(with_references.reference.is_some());
    assert_eq!(counts(&with_references), [0; 6]);
    // Sixteen blocks have eight renders of most levels and four of the last one.
    let three_blocks = ended(4);
    assert_eq!(counts(&three_blocks), [2, 2, 2, 2, 2, 1]);
    // A level with a single render has no estimate of its error.
    assert_eq!(summaries(&three_blocks)[0].1.levels.len(), 5);
}

#[test]
fn every_target_error_has_a_time_estimate() {
    let choices = [SamplerKind::Independent, SamplerKind::Sobol].map(SettingValue::Sampler);
    let report = study(&settings(&choices, 8.0, Some(fixed(2))));
    for (_, summary) in summaries(&report) {
        assert_eq!(summary.answers.len(), 5);
        let times: Vec<f64> = summary
            .answers
            .iter()
            .filter_map(|(_, it)| it.seconds())
            .collect();
        assert_eq!(times.len(), 5, "{:?}", summary.answers);
        assert!(times.windows(2).all(|pair| pair[0] <= pair[1]), "{times:?}");
        // A third of the error takes about ten times the samples of independent ones, never more by the law.
        let samples =
            |index: usize| (times[index] - summary.own_time.start) / summary.own_time.sample;
        let ratio = samples(4) / samples(3);
        assert!((3.0..12.0).contains(&ratio), "{ratio}");
    }
}

/// The choice of the size and the conversion of times are tested without a clock in `lab/src/study/planning.rs` and
/// `own_size.rs`. On a busy machine this study may end with the error that its budget is too small, or without renders.
#[test]
fn short_budget_shrinks_the_image_with_a_warning() {
    let mut scene = scene();
    scene.film.size = (640, 480);
    let settings = StudySettings {
        may_shrink: true,
        ..settings(&[], 6.0, None)
    };
    let report = match run(
        &scene,
        (640, 480),
        &settings,
        Instant::now(),
        &NullStudyObserver,
    ) {
        Ok(report) => report,
        Err(error) => return assert!(error.to_string().contains("too small"), "{error}"),
    };
    assert_eq!(report.full_size, (640, 480));
    assert!(report.size.0 < 640, "{:?}", report.size);
    assert!(
        report.warnings.iter().any(|it| it.contains("own size")),
        "{:?}",
        report.warnings
    );
    // Times are converted to the scene's own size.
    assert!(report.variants.iter().all(|it| it.own_size.is_some()));
}

/// Camera paths alone miss the caustics of point lights: were the references of camera paths, the variant that has them would
/// be called biased.
#[test]
fn references_have_the_caustics_of_point_lights() {
    let description = with_mirrored_point_light();
    let rules = [LightPathRule::Auto, LightPathRule::OFF];
    let choices = rules.map(SettingValue::LightPaths);
    let settings = settings(&choices, 8.0, Some(fixed(2)));
    let report = study_of(&description, &settings);
    let all = summaries(&report);
    let [auto, none] = [0, 1].map(|index| &all[index].1.bias);
    assert!(!auto.is_found, "{auto:?}");
    assert!(none.is_found && none.light[0] < 0.0, "{none:?}");
}

/// With a sample in one pixel alone, references would have several times the noise of as many samples that are splatted.
#[test]
fn references_are_as_accurate_as_splatted_renders() {
    let schedule = Schedule {
        reference_spp: 32,
        seeds: vec![vec![8; 6]],
    };
    let sobol = [SettingValue::Sampler(SamplerKind::Sobol)];
    let mut settings = settings(&sobol, 8.0, Some(schedule));
    settings.variants[0].settings.filter_sampling = FilterSampling::Splatting;
    let mut description = scene();
    description.film.filter = FilmDescription::default().filter;
    let report = study_of(&description, &settings);
    let all = summaries(&report);
    let level = all[0].1.levels.last().expect("levels");
    let reference = report.reference.expect("references");
    assert_eq!([level.spp, reference.spp], [32, 32]);
    let ratio = reference.noise.rel_mse / level.variance.value;
    assert!((0.5..1.5).contains(&ratio), "{ratio}");
}
