//! `etendue study`: error against time for several ways to render a scene, as tables, JSON, CSV and a page.
//!
//! Measure: that of `study/report.rs` and `study/summary.rs`.
//! Range: any scene that loads. Results are written after each round, so that they survive Ctrl-C or a kill.
//! Source: docs/accuracy.md, "The study". Tested in `cli/tests/command/study.rs`.

mod shards;

use super::args::StudyArguments;
use super::durations::format_duration;
use super::output::ConsoleObserver;
use super::plan::Cancelling;
use super::report::measurement::MeasurementObserver;
use super::report::study::{Findings, csv, html, json, tables};
use super::{Outcome, command_line, print};
use etendue::internals::image::atomic::{check_creatable, make_folder, write_text};
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::auto::Recommendation;
use etendue::internals::render::options::{RenderOptions, refuse_endless};
use etendue::internals::render::settings::{LightPathRule, RenderSettings, SamplerKind};
use etendue::internals::scene::description::SceneDescription;
use etendue::internals::session::Session;
use etendue::{Error, Result};
use etendue_lab::bench::machine::machine;
use etendue_lab::bench::report::Machine;
use etendue_lab::study::report::StudyReport;
use etendue_lab::study::settings::{StudyObserver, StudySettings};
use etendue_lab::study::summary::summaries;
use etendue_lab::study::variant::{SettingValue, Variant};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The minimum interval between two writes of unfinished results.
const BETWEEN_WRITES: Duration = Duration::from_secs(5);

pub fn run(arguments: &StudyArguments) -> Result<Outcome> {
    let start = Instant::now();
    let console = ConsoleObserver::new(arguments.measurement.progress_mode())?;
    let mut description = arguments.measurement.scene.load()?;
    let full_size = description.film.size;
    description.film.size = arguments.size.unwrap_or(full_size);
    let settings = settings(arguments, &description)?;
    let studied = shards::Studied {
        description: &description,
        full_size,
        settings: &settings,
        folder: &arguments.out,
        is_quiet: arguments.measurement.quiet,
        start,
    };
    if arguments.shards.is_some() {
        return studied.plan(&console);
    }
    if let Some(shard) = arguments.shard {
        return studied.render(shard, &console);
    }
    let merged = match arguments.merge {
        true => Some(studied.parts(arguments.partial)?),
        false => None,
    };
    // The pilot is part of the study.
    let recommendation = recommendation(&settings, &description, &console)?;
    let files = StudyFiles::new(arguments, recommendation)?;
    let observer = WrittenStudy {
        measurement: MeasurementObserver::new(&console),
        files: &files,
        last: Mutex::new(Instant::now()),
    };
    let report = match merged {
        Some((plan, parts)) => studied.merge(&plan, parts, &observer),
        None => etendue_lab::study::run(&description, full_size, &settings, start, &observer),
    };
    console.finish();
    let report = report.inspect_err(|_| files.remove_if_empty())?;
    observer.measurement.result()?;

    let findings = files.findings(&report);
    write_text(&files.json, &json::of_findings(&findings))?;
    write_text(&files.csv, &csv::of_report(&report))?;
    write_text(&files.html, &html::of_findings(&findings))?;
    write_text(&files.markdown, &tables::markdown(&findings))?;
    if arguments.measurement.json {
        print(json::of_findings(&findings).as_bytes())?;
    } else {
        print(tables::answers_in_words(&findings).as_bytes())?;
    }
    if !arguments.measurement.quiet {
        for warning in &report.warnings {
            say!("note: {warning}");
        }
        let end = if report.complete {
            "done"
        } else {
            "interrupted"
        };
        let time = format_duration(start.elapsed());
        say!("{}: {end} after {time}", files.html.display());
    }
    Ok(match report.complete {
        true => Outcome::Done,
        false => Outcome::Interrupted,
    })
}

/// The integrator that `auto` selects, if several are compared.
fn recommendation(
    settings: &StudySettings,
    description: &SceneDescription,
    console: &ConsoleObserver,
) -> Result<Option<Recommendation>> {
    let mut kinds = settings
        .variants
        .iter()
        .map(|variant| variant.settings.integrator);
    let first = kinds.next();
    if kinds.all(|kind| Some(kind) == first) {
        return Ok(None);
    }
    let session = Session::new(description.clone(), settings.options)?;
    session
        .recommend(&RenderOptions::default(), &Cancelling(console))
        .map(Some)
}

fn settings(arguments: &StudyArguments, description: &SceneDescription) -> Result<StudySettings> {
    let options = arguments.measurement.tracing.options();
    let base = RenderSettings {
        threads: options.threads,
        ..RenderSettings::of_scene(description)?
    };
    let mut choices: Vec<SettingValue> = arguments.vary.iter().flat_map(|v| v.0.clone()).collect();
    if choices.is_empty() {
        // The default compares independent with Sobol' samples: few users have measured that gain on their own scene.
        choices = vec![
            SettingValue::Sampler(SamplerKind::Independent),
            SettingValue::Sampler(SamplerKind::Sobol),
        ];
    }
    let mut variants = Variant::all(&Variant::new(base, options), &choices);
    let mut left_out = None;
    variants.retain(|variant| {
        let contradiction = variant.contradiction(&choices);
        if let Some(reason) = contradiction {
            let words = format!("{} is left out: {reason}", variant.name);
            if !arguments.measurement.quiet {
                say!("note: {words}");
            }
            left_out = Some(words);
        }
        contradiction.is_none()
    });
    if let Some(words) = left_out.filter(|_| variants.is_empty()) {
        return Err(Error::usage(format!("nothing is left to study: {words}")));
    }
    for variant in &variants {
        refuse_endless(&variant.settings)?;
        if variant.settings.integrator == IntegratorKind::Auto {
            return Err(Error::usage(
                "a study compares named integrators, and auto selects one of several: give --vary integrator=path,bdpt, for example",
            ));
        }
    }
    Ok(StudySettings {
        reference_light_paths: LightPathRule::Auto,
        budget: arguments.budget.as_secs_f64(),
        seed: arguments.measurement.seed,
        reference: arguments.reference,
        options,
        variants,
        may_shrink: arguments.size.is_none() && !arguments.full_size,
        for_threads: arguments.for_threads.map(|threads| threads as usize),
        schedule: None,
        shards: arguments.shards.map_or(1, u64::from),
    })
}

/// The output files of a study, the machine, and the command that measured it.
struct StudyFiles {
    folder: PathBuf,
    json: PathBuf,
    csv: PathBuf,
    html: PathBuf,
    markdown: PathBuf,
    machine: Machine,
    command: String,
    recommendation: Option<Recommendation>,
}

impl StudyFiles {
    /// Creates the folder, and checks that all files can be written before anything is measured.
    fn new(arguments: &StudyArguments, recommendation: Option<Recommendation>) -> Result<Self> {
        let folder = &arguments.out;
        make_folder(folder)?;
        let files = Self {
            json: folder.join("study.json"),
            csv: folder.join("study.csv"),
            html: folder.join("study.html"),
            markdown: folder.join("study.md"),
            folder: folder.clone(),
            machine: machine(),
            command: command_line(),
            recommendation,
        };
        for file in [&files.json, &files.csv, &files.html, &files.markdown] {
            check_creatable(file)?;
        }
        Ok(files)
    }

    fn findings<'a>(&'a self, report: &'a StudyReport) -> Findings<'a> {
        Findings {
            report,
            summaries: summaries(report),
            machine: &self.machine,
            command: &self.command,
            recommendation: self.recommendation.as_ref(),
        }
    }

    /// Removes the folder if it is empty, so that a study that could not start leaves nothing behind.
    fn remove_if_empty(&self) {
        let _ = std::fs::remove_dir(&self.folder);
    }
}

/// Writes the results so far to the report's JSON file at intervals.
struct WrittenStudy<'a> {
    measurement: MeasurementObserver<'a>,
    files: &'a StudyFiles,
    last: Mutex<Instant>,
}

impl StudyObserver for WrittenStudy<'_> {
    fn progress(&self, fraction: f64, what: &str) {
        self.measurement.show(fraction, what);
    }

    fn is_cancelled(&self) -> bool {
        self.measurement.is_cancelled()
    }

    fn report(&self, report: &StudyReport) {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.elapsed() < BETWEEN_WRITES {
            return;
        }
        let json = json::of_findings(&self.files.findings(report));
        self.measurement.write(&self.files.json, &json);
        *last = Instant::now();
    }
}
