//! `etendue battery`: hard cases with exact answers, reported as tables, JSON and a page.
//!
//! Measure: that of `battery/report.rs`.
//! Range: all cases, or those of the given rows. The report is written also after Ctrl-C, with the cases done so far.
//! Source: docs/hard-cases.md. Tested in `cli/tests/command/battery.rs`.

use super::args::{BatteryArguments, ProgressMode};
use super::durations::format_duration;
use super::output::{ConsoleObserver, time_left};
use super::report::battery::{html, json, summary, tables};
use super::{Outcome, command_line, print};
use etendue::internals::image::atomic::{check_creatable, make_folder, write_text};
use etendue::internals::render::RenderObserver;
use etendue::internals::render::settings::available_threads;
use etendue::{Error, Result};
use etendue_lab::battery::case::{Case, Effort};
use etendue_lab::battery::report::{BatteryReport, CaseReport};
use etendue_lab::battery::{BatteryObserver, BatterySettings, cases, run as run_cases};
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

pub fn run(arguments: &BatteryArguments) -> Result<Outcome> {
    let mode = match arguments.quiet {
        true => ProgressMode::None,
        false => arguments.progress,
    };
    let settings = settings(arguments);
    let chosen = chosen(cases(settings.effort), &arguments.rows)?;
    let files = BatteryFiles::new(&arguments.out, command(&settings, arguments.seed.is_some()))?;
    let console = ConsoleObserver::new(mode)?;
    let start = Instant::now();
    let report = run_cases(
        &chosen,
        &settings,
        &BatteryProgress {
            console: &console,
            start,
        },
    );
    console.finish();
    let report = report?;
    files.write(&report)?;
    if arguments.json {
        print(json::of_report(&report, &files.command).as_bytes())?;
    } else {
        print(tables::markdown(&report, &files.command).as_bytes())?;
    }
    if !arguments.quiet {
        let (json, html) = (files.json.display(), files.html.display());
        let time = format_duration(start.elapsed());
        say!("{json}, {html}: {} after {time}", summary(&report));
    }
    Ok(match (report.complete, report.all_passed()) {
        (false, _) => Outcome::Interrupted,
        (true, true) => Outcome::Done,
        (true, false) => Outcome::Failed,
    })
}

fn settings(arguments: &BatteryArguments) -> BatterySettings {
    let effort = match arguments.full {
        true => Effort::Full,
        false => Effort::Quick,
    };
    let tracing = &arguments.tracing;
    BatterySettings {
        backend: tracing.backend,
        precision: tracing.precision,
        quality: tracing.quality,
        threads: tracing.threads.map_or_else(available_threads, usize::from),
        seed: arguments.seed.unwrap_or_else(|| match effort {
            Effort::Quick => 0,
            Effort::Full => seconds_since_1970(),
        }),
        effort,
        // Cases that are known to fail are run only if their rows are given explicitly.
        known_failures: !arguments.rows.is_empty(),
    }
}

/// Returns a seed that differs between runs: the seconds since 1970.
fn seconds_since_1970() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |since| since.as_secs())
}

/// Returns the command that repeats the run, with `--seed` added if it was chosen by time.
fn command(settings: &BatterySettings, has_seed: bool) -> String {
    let seed = match settings.effort {
        Effort::Full if !has_seed => format!(" --seed {}", settings.seed),
        _ => String::new(),
    };
    command_line() + &seed
}

/// Returns the cases of the given rows, or all cases if no row is given.
fn chosen(mut cases: Vec<Case>, rows: &[u32]) -> Result<Vec<Case>> {
    let mut known: Vec<u32> = cases.iter().map(|case| case.row).collect();
    known.sort_unstable();
    known.dedup();
    if let Some(row) = rows.iter().find(|row| !known.contains(row)) {
        let known: Vec<String> = known.iter().map(u32::to_string).collect();
        return Err(Error::usage(format!(
            "no case of row {row}; the rows with cases are {}",
            known.join(", ")
        )));
    }
    cases.retain(|case| rows.is_empty() || rows.contains(&case.row));
    Ok(cases)
}

/// The output files of a battery, and the command that measured it.
struct BatteryFiles {
    json: PathBuf,
    html: PathBuf,
    command: String,
}

impl BatteryFiles {
    /// Creates the folder, and checks that both files can be written before anything is measured.
    fn new(folder: &Path, command: String) -> Result<Self> {
        make_folder(folder)?;
        let files = Self {
            json: folder.join("battery.json"),
            html: folder.join("battery.html"),
            command,
        };
        check_creatable(&files.json)?;
        check_creatable(&files.html)?;
        Ok(files)
    }

    fn write(&self, report: &BatteryReport) -> Result<()> {
        write_text(&self.json, &json::of_report(report, &self.command))?;
        write_text(&self.html, &html::of_report(report, &self.command))
    }
}

/// Shows progress and forwards Ctrl-C.
struct BatteryProgress<'a> {
    console: &'a ConsoleObserver,
    start: Instant,
}

impl BatteryObserver for BatteryProgress<'_> {
    fn progress(&self, fraction: f64, done: &CaseReport) {
        self.console.show(fraction, || {
            let left = time_left(fraction, self.start.elapsed());
            let left = left.map_or(String::new(), |left| format!(", {left} left"));
            format!("row {}{left}", done.row)
        });
    }

    fn is_cancelled(&self) -> bool {
        self.console.is_cancelled()
    }
}
