//! `etendue price`: what accuracy costs in a scene, within half a minute, as a table or JSON.
//!
//! Measure: as in `lab/src/price/report.rs`.
//! Range: any scene that loads. After Ctrl-C the results so far are printed.
//! Source: docs/accuracy.md, "The price". Tested in `cli/tests/command/price.rs`.

use super::args::PriceArguments;
use super::durations::format_duration;
use super::output::ConsoleObserver;
use super::report::price::{json, text};
use super::{Outcome, command_line, print};
use etendue::Result;
use etendue::internals::render::RenderObserver;
use etendue_lab::bench::machine::machine;
use etendue_lab::price;
use etendue_lab::price::report::PriceSettings;
use etendue_lab::study::settings::StudyObserver;
use std::time::Instant;

pub fn run(arguments: &PriceArguments) -> Result<Outcome> {
    let start = Instant::now();
    let console = ConsoleObserver::new(arguments.measurement.progress_mode())?;
    let mut description = arguments.measurement.scene.load()?;
    if let Some(size) = arguments.size {
        description.film.size = size;
    }
    let settings = PriceSettings {
        budget: arguments.budget.as_secs_f64(),
        integrator: Some(arguments.integrator),
        seed: arguments.measurement.seed,
        options: arguments.measurement.tracing.options(),
    };
    let measured = price::run(&description, &settings, start, &PriceProgress(&console));
    console.finish();
    let report = measured?;
    if arguments.measurement.json {
        print(json::of_report(&report, &command_line(), &machine()).as_bytes())?;
    } else {
        print(text::of_report(&report).as_bytes())?;
    }
    if report.complete {
        return Ok(Outcome::Done);
    }
    if !arguments.measurement.quiet {
        let what = match report.answers.is_empty() {
            true => "before the errors were measured",
            false => "the answers are those of a shorter render",
        };
        say!(
            "interrupted after {}: {what}",
            format_duration(start.elapsed())
        );
    }
    Ok(Outcome::Interrupted)
}

/// Shows the progress, and forwards Ctrl-C.
struct PriceProgress<'a>(&'a ConsoleObserver);

impl StudyObserver for PriceProgress<'_> {
    fn progress(&self, fraction: f64, what: &str) {
        self.0.show(fraction, || what.to_owned());
    }

    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}
