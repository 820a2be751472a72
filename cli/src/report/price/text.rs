//! A price on a terminal of 80 columns: one table of errors and times, the sources of the error, cheaper ways, advice.
//!
//! Measure: stated at each number.
//! Range: any report; what was not measured is left out.
//! Source: none needed. Tested in `cli/tests/command/price.rs` and below.

use crate::recommendation::{advice, sentence};
use crate::report::study::tables::path_class;
use crate::report::study::wording::{percent, rough, seconds, seconds_interval};
use crate::report::table::{Table, numbers, words, wrapped};
use etendue_lab::price::answers::PriceRow;
use etendue_lab::price::cheaper::Cheaper;
use etendue_lab::price::report::PriceReport;
use etendue_lab::study::answer::Answer;
use etendue_lab::study::bootstrap::Ranged;
use etendue_lab::study::error_sources::ObjectShare;

/// The width of a line.
const WIDTH: usize = 80;

/// The number of objects and classes of paths that are told of each kind, and the least share of the variance.
const MAX_NAMED: usize = 3;
const MIN_VARIANCE: f64 = 0.02;

/// The longest name of an object.
const MAX_NAME: usize = 34;

/// Returns the whole text.
pub fn of_report(report: &PriceReport) -> String {
    let (width, height) = report.full_size;
    let mut text = wrapped(
        &format!(
            "{}: {width} x {height} pixels, {} with {}, {} threads",
            report.scene, report.integrator, report.sampler, report.threads
        ),
        WIDTH,
    );
    if let Some(recommendation) = &report.recommendation {
        text += &wrapped(&sentence(recommendation), WIDTH);
    }
    for bias in &report.bias {
        text += &wrapped(&format!("biased by {bias}"), WIDTH);
    }
    text.push('\n');
    text += &answers(report);
    text += &sources(report);
    text += &cheaper(report);
    for line in advice_on(report).iter().chain(&report.notes) {
        text += &wrapped(&format!("- {line}"), WIDTH);
    }
    text
}

/// Returns the table of errors, times and samples, with the reasons of its gaps.
fn answers(report: &PriceReport) -> String {
    if report.answers.is_empty() {
        return String::new();
    }
    let table = table(
        vec![
            numbers("error"),
            numbers("time"),
            numbers("samples"),
            words("95 % interval"),
        ],
        report.answers.iter().map(row).collect(),
    );
    let mut text = table.grid() + "\n";
    let mut reasons: Vec<&String> = Vec::new();
    for row in &report.answers {
        if let Answer::Unknown(reason) = &row.time
            && !reasons.contains(&reason)
        {
            text += &wrapped(&format!("unknown: {reason}."), WIDTH);
            reasons.push(reason);
        }
    }
    let error = report.rel_rmse.map_or("-".to_owned(), percent);
    let at = match report.size == report.full_size {
        true => String::new(),
        false => format!(" of {} x {} pixels", report.size.0, report.size.1),
    };
    text += &wrapped(
        &format!(
            "What `render --integrator {} --error` takes, by {} samples{at} with an error of {error}; ≈ is beyond.",
            report.integrator, report.spp
        ),
        WIDTH,
    );
    text + "\n"
}

fn row(row: &PriceRow) -> Vec<String> {
    let (time, interval) = match &row.time {
        Answer::Measured(range) => (seconds(range.value), seconds_interval(range)),
        Answer::Law(range) => (
            format!("≈ {}", seconds(range.value)),
            seconds_interval(range),
        ),
        Answer::AtOnce(time) => (format!("< {}", seconds(*time)), String::new()),
        Answer::Exact(time) => (seconds(*time), "exact: no noise".to_owned()),
        Answer::Never(_) => ("never".to_owned(), String::new()),
        Answer::Unknown(_) => ("unknown".to_owned(), String::new()),
    };
    let samples = row.spp.map_or("-".to_owned(), |spp| format!("{spp:.0}"));
    vec![percent(row.error), time, samples, interval]
}

/// Returns the table of the sources of the error.
fn sources(report: &PriceReport) -> String {
    let Some(error_sources) = &report.error_sources else {
        return String::new();
    };
    let mut paths: Vec<_> = error_sources.paths.classes.iter().collect();
    paths.sort_by(|a, b| b.variance.total_cmp(&a.variance));
    let paths = paths
        .into_iter()
        .filter(|it| it.variance >= MIN_VARIANCE)
        .take(MAX_NAMED);
    let mut rows: Vec<Vec<String>> = paths
        .map(|it| {
            let name = path_class(it.bounces, it.found);
            source("paths", &name, it.variance, it.variance_error, it.energy)
        })
        .collect();
    for (what, all) in [
        ("material", &error_sources.materials),
        ("light", &error_sources.lights),
    ] {
        let largest = all
            .iter()
            .filter(|it| it.variance >= MIN_VARIANCE)
            .take(MAX_NAMED);
        rows.extend(largest.map(|it: &ObjectShare| {
            source(
                what,
                &shortened(&it.name),
                it.variance,
                it.variance_error,
                it.energy,
            )
        }));
    }
    let head = vec![
        words("where the error"),
        words("comes from"),
        numbers("of the error²"),
        numbers("of the light"),
    ];
    table(head, rows).grid() + "\n"
}

fn source(what: &str, name: &str, variance: f64, error: f64, energy: f64) -> Vec<String> {
    // Of an image of a single part, the uncertainty is not known.
    let share = match error.is_nan() {
        true => format!("{:.0} %", 100.0 * variance),
        false => format!("{:.0} ± {:.0} %", 100.0 * variance, 200.0 * error),
    };
    vec![what.to_owned(), name.to_owned(), share, percent(energy)]
}

/// Shortens a name, so that a row fits.
fn shortened(name: &str) -> String {
    match name.chars().count() > MAX_NAME {
        true => name.chars().take(MAX_NAME - 1).chain(['…']).collect(),
        false => name.to_owned(),
    }
}

/// Returns the table of cheaper ways, with what each leaves out below it.
fn cheaper(report: &PriceReport) -> String {
    if report.cheaper.is_empty() {
        return String::new();
    }
    let row = |it: &Cheaper| {
        let gain = it.gain.map_or("unknown".to_owned(), |gain| {
            format!(
                "{} ({} to {})",
                rough(gain.value),
                rough(gain.low),
                rough(gain.high)
            )
        });
        vec![it.flags.clone(), gain]
    };
    let head = vec![
        words("what would make it cheaper"),
        numbers("times as fast"),
    ];
    let mut text = table(head, report.cheaper.iter().map(row).collect()).grid();
    for it in &report.cheaper {
        let facts: Vec<&str> = [&it.bias, &it.note]
            .into_iter()
            .flatten()
            .map(String::as_str)
            .collect();
        if !facts.is_empty() {
            text += &wrapped(&format!("  {} {}", it.flags, facts.join("; ")), WIDTH);
        }
    }
    text + "\n"
}

/// Returns the advice: on the integrator, and on what is cheaper without bias.
pub fn advice_on(report: &PriceReport) -> Vec<String> {
    let of_flag = |it: &Cheaper| it.flags.strip_prefix("--integrator ").map(str::to_owned);
    let others: Vec<(String, Ranged)> = report
        .cheaper
        .iter()
        .filter_map(|it| Some((of_flag(it)?, it.gain?)))
        .collect();
    let gains: Vec<(&str, Ranged)> = others
        .iter()
        .map(|(name, gain)| (name.as_str(), *gain))
        .collect();
    let mut all = Vec::new();
    if !report.cheaper.is_empty() {
        all.push(advice(
            report.integrator,
            &gains,
            report.recommendation.as_ref(),
        ));
    }
    let is_other = |it: &&Cheaper| of_flag(it).is_none() && it.is_sure();
    all.extend(report.cheaper.iter().filter(is_other).map(|it| {
        let gain = it.gain.map_or(f64::NAN, |gain| gain.value);
        match &it.bias {
            None => format!("{}: {} times as fast", it.flags, rough(gain)),
            Some(bias) => format!(
                "{}: {} times as fast, but biased: {bias}",
                it.flags,
                rough(gain)
            ),
        }
    }));
    all
}

fn table(head: Vec<(String, crate::report::table::Alignment)>, rows: Vec<Vec<String>>) -> Table {
    Table {
        title: String::new(),
        caption: String::new(),
        head,
        rows,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_lab::study::variance::{ClassShare, LightFoundBy, PathShares};

    fn report() -> PriceReport {
        let range = |value: f64| Ranged {
            value,
            low: 0.9 * value,
            high: 1.1 * value,
        };
        let class = ClassShare {
            bounces: 2,
            found: LightFoundBy::LightSampling,
            variance: 0.41,
            variance_error: 0.02,
            energy: 0.11,
        };
        let named = |name: &str| ObjectShare {
            name: name.to_owned(),
            variance: 0.9,
            variance_error: 0.01,
            energy: 0.8,
        };
        let way = |flags: &str, gain: f64, bias: Option<&str>| Cheaper {
            flags: flags.to_owned(),
            gain: Some(range(gain)),
            bias: bias.map(str::to_owned),
            note: None,
        };
        let reason = "rare bright paths dominate the error, and the samples so far cannot tell how many were missed";
        let answer = |error: f64, time: Answer| PriceRow {
            error,
            spp: Some(1e9),
            time,
        };
        PriceReport {
            version: "1.2.3",
            scene: "a/rather/long/folder/of/scenes/with/one/scene/in/it/that/is/named/box.toml"
                .to_owned(),
            full_size: (1920, 1080),
            size: (960, 540),
            threads: 2,
            integrator: "path",
            sampler: "sobol",
            recommendation: None,
            budget: 30.0,
            seconds: 30.0,
            spp: 256,
            rel_rmse: Some(0.123),
            doubt: None,
            pace: 1.0,
            answers: vec![
                answer(0.1, Answer::Measured(range(123.4))),
                answer(0.01, Answer::Law(range(1.234e9))),
                answer(0.001, Answer::Unknown(reason.to_owned())),
            ],
            error_sources: Some(etendue_lab::study::error_sources::ErrorSources {
                paths: PathShares {
                    spp: 8,
                    variance: 1.0,
                    unexplained: 0.0,
                    classes: vec![class],
                },
                materials: vec![named(&"long name ".repeat(9))],
                lights: vec![named("lamp")],
            }),
            cheaper: vec![
                way("--integrator bdpt", 0.5, None),
                way("--precision fast", 1.3, None),
                way(
                    "--max-bounces 4",
                    1.5,
                    Some("leaves out about 2.34 % of the light"),
                ),
            ],
            bias: vec![],
            notes: vec!["a note".to_owned()],
            complete: true,
        }
    }

    #[test]
    fn price_text_fits_terminal_width_and_is_complete() {
        let text = of_report(&report());
        for line in text.lines() {
            assert!(line.chars().count() <= WIDTH, "{line}");
        }
        for words in [
            "10 %",
            "≈ ",
            "unknown: rare bright paths",
            "2, light sampled",
            "41 ± 4 %",
            "lamp",
            "--integrator bdpt",
            "0.5 (0.45 to 0.55)",
            "--precision fast: 1.3 times as fast",
            "but biased: leaves out",
            "- a note",
            "no other integrator is faster than path",
        ] {
            assert!(text.contains(words), "no {words} in {text}");
        }
    }
}
