//! `etendue bench`: a comparison of the backends, as tables, JSON and a page.
//!
//! Measure: that of `bench/report.rs`.
//! Range: scenes that load, and the benchmark's own scenes. Results are written part by part, so that they survive
//! Ctrl-C.
//! Source: docs/bench.md. Tested in `cli/tests/command/bench.rs`.

mod scenes;

use super::args::{BenchArguments, ProgressMode};
use super::durations::format_duration;
use super::output::ConsoleObserver;
use super::report::bench::{html, json, tables};
use super::report::measurement::MeasurementObserver;
use super::{Outcome, command_line, print};
use etendue::Result;
use etendue::internals::accel::Backend;
use etendue::internals::image::atomic::{check_creatable, make_folder, write_text};
use etendue::internals::render::settings::available_threads;
use etendue_lab::bench::report::BenchReport;
use etendue_lab::bench::settings::{BenchObserver, BenchSettings};
use etendue_lab::bench::target::BenchTarget;
use std::path::PathBuf;
use std::time::Instant;

pub fn run(arguments: &BenchArguments) -> Result<Outcome> {
    let start = Instant::now();
    let mode = match arguments.quiet {
        true => ProgressMode::None,
        false => arguments.progress,
    };
    let console = ConsoleObserver::new(mode)?;
    let note = |text: &str| {
        if !arguments.quiet {
            say!("note: {text}");
        }
    };
    let scenes = scenes::given(&arguments.scenes, arguments.fidelity, &note)?;
    for text in scenes.iter().flat_map(|given| &given.scene.notes) {
        note(&text.to_string());
    }
    let files = BenchFiles::new(arguments)?;
    let observer = WrittenBench {
        measurement: MeasurementObserver::new(&console),
        files: &files,
    };
    let report = etendue_lab::bench::run(&scenes, &settings(arguments), &observer);
    console.finish();
    let report = report?;
    observer.measurement.result()?;

    let page = html::of_report(&report, &files.command);
    write_text(&files.html, &page)?;
    if arguments.json {
        print(json::of_report(&report, &files.command).as_bytes())?;
    } else {
        print(tables::markdown(&report, &files.command).as_bytes())?;
    }
    if !arguments.quiet {
        let (json, html) = (files.json.display(), files.html.display());
        let time = format_duration(start.elapsed());
        let end = if report.complete {
            "done"
        } else {
            "interrupted"
        };
        say!("{json}, {html}: {end} after {time}");
    }
    Ok(match report.complete {
        true => Outcome::Done,
        false => Outcome::Interrupted,
    })
}

fn settings(arguments: &BenchArguments) -> BenchSettings {
    let wanted = &arguments.backends;
    let backends = Backend::ALL.iter().copied();
    let backends: Vec<Backend> = backends
        .filter(|backend| wanted.is_empty() || wanted.contains(backend))
        .collect();
    BenchSettings {
        threads: arguments
            .threads
            .map_or_else(available_threads, usize::from),
        rounds: arguments.rounds as usize,
        rays: arguments.rays as usize,
        targets: BenchTarget::all(&backends),
        precision: arguments.precision,
        render_seconds: arguments.render_time.as_secs_f64(),
        compared_rays: arguments.compare as usize,
        segments: arguments.segments,
        ..BenchSettings::default()
    }
}

/// The output files of a benchmark, and the command that measured it.
struct BenchFiles {
    json: PathBuf,
    html: PathBuf,
    command: String,
}

impl BenchFiles {
    /// Creates the folder, and checks that both files can be written before anything is measured.
    fn new(arguments: &BenchArguments) -> Result<Self> {
        let folder = &arguments.out;
        make_folder(folder)?;
        let files = Self {
            json: folder.join("bench.json"),
            html: folder.join("bench.html"),
            command: command_line(),
        };
        check_creatable(&files.json)?;
        check_creatable(&files.html)?;
        Ok(files)
    }
}

/// Writes the results so far to the report's JSON file.
struct WrittenBench<'a> {
    measurement: MeasurementObserver<'a>,
    files: &'a BenchFiles,
}

impl BenchObserver for WrittenBench<'_> {
    fn progress(&self, fraction: f64, what: &str) {
        self.measurement.show(fraction, what);
    }

    fn is_cancelled(&self) -> bool {
        self.measurement.is_cancelled()
    }

    fn report(&self, report: &BenchReport) {
        let json = json::of_report(report, &self.files.command);
        self.measurement.write(&self.files.json, &json);
    }
}
