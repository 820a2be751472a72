//! A battery as tables: the six cases beside the results of other renderers, and all cases by subject.
//!
//! Measure: as stated in the report.
//! Range: any report, also of an interrupted battery.
//! Source: docs/hard-cases.md. Tested in `cli/tests/command/battery.rs`.

use crate::durations::format_duration;
use crate::report::table::{Table, numbers, words};
use etendue_lab::battery::case::{Effort, Peers};
use etendue_lab::battery::claim::Relation;
use etendue_lab::battery::report::{BatteryReport, CaseReport};
use etendue_lab::battery::{CaseGroup, SUBJECTS};
use etendue_lab::verdict::Verdict;
use std::time::Duration;

/// Describes the machine and the settings of a battery in a sentence.
pub fn conditions(report: &BatteryReport) -> String {
    let machine = &report.machine;
    let effort = match report.effort {
        Effort::Quick => "quick",
        Effort::Full => "full",
    };
    let parts = [
        format!("etendue {}", report.version),
        format!("{} ({})", report.backend, report.precision),
        machine.embree.clone(),
        machine.processor.clone(),
        machine.system.clone(),
        format!("{} threads", report.threads),
        format!("{effort}, seed {}", report.seed),
    ];
    let parts: Vec<String> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    parts.join("; ")
}

/// Returns all tables as Markdown.
pub fn markdown(report: &BatteryReport, command: &str) -> String {
    let tables = all(report);
    let tables: String = tables.iter().map(|table| table.markdown(3)).collect();
    format!("`{command}`\n\n{}.\n\n{tables}", conditions(report))
}

/// Returns all tables that have rows.
pub fn all(report: &BatteryReport) -> Vec<Table> {
    let mut tables = vec![peers(report)];
    let of_subject = |subject: &CaseGroup| {
        let cases = report.results.iter();
        let cases: Vec<_> = cases.filter(|case| case.subject == subject.name).collect();
        cases_table(subject, &cases)
    };
    tables.extend(SUBJECTS.iter().map(of_subject));
    tables.push(left_out(report));
    tables.retain(|table| !table.rows.is_empty());
    tables
}

/// Formats Etendue's number, in bold if it is wrong.
fn ours(case: &CaseReport) -> String {
    let number = number(case.ours);
    match case.verdict {
        Verdict::Passed => number,
        _ => format!("**{number}**"),
    }
}

/// Returns the table of the six cases, with the published results of other renderers.
fn peers(report: &BatteryReport) -> Table {
    let row = |case: &CaseReport, peers: Peers| {
        let cells = [&case.name, &number(case.claim.exact), &ours(case)];
        let others = [peers.mitsuba, peers.cycles, peers.luxcore];
        let cells = cells.into_iter().cloned();
        cells.chain(others.map(str::to_owned)).collect()
    };
    let cases = report.results.iter();
    let rows = cases.filter_map(|case| case.peers.map(|peers| row(case, peers)));
    Table {
        title: "Comparison with other renderers".to_owned(),
        caption: "A light of 2 x 2 and radiance 1 over a floor of 2 x 2 and albedo 1/2, unless the case says otherwise: \
               the radiance at the centre of the floor under direct light. `ok` is correct within the noise, `-` was \
               not run."
            .to_owned(),
        head: vec![
            words("case"),
            numbers("exact"),
            numbers("Etendue"),
            numbers("Mitsuba 3.9.1"),
            numbers("Cycles 5.0.1"),
            numbers("LuxCore 2.11.2"),
        ],
        rows: rows.collect(),
    }
}

fn cases_table(subject: &CaseGroup, cases: &[&CaseReport]) -> Table {
    let row = |case: &&CaseReport| {
        let at_most = match case.claim.relation {
            Relation::Equal => "",
            Relation::AtMost => "at most ",
        };
        let limit = case.claim.power_limit.map_or("-".to_owned(), small);
        let verdict = case.verdict.name();
        vec![
            case.row.to_string(),
            case.name.clone(),
            format!("{at_most}{}", number(case.claim.exact)),
            number(case.ours),
            small(case.error),
            case.standard_error.map_or("-".to_owned(), small),
            limit,
            case.failure
                .as_ref()
                .map_or(verdict.to_owned(), |why| format!("{verdict}: {why}")),
            format_duration(Duration::from_secs_f64(case.seconds)),
        ]
    };
    Table {
        title: subject.name.to_owned(),
        caption: subject.caption.to_owned(),
        head: vec![
            numbers("row"),
            words("case"),
            numbers("exact"),
            numbers("ours"),
            numbers("error"),
            numbers("standard error"),
            numbers("its limit"),
            words("verdict"),
            numbers("time"),
        ],
        rows: cases.iter().map(row).collect(),
    }
}

fn left_out(report: &BatteryReport) -> Table {
    let rows = report.left_out.iter();
    Table {
        title: "Left out".to_owned(),
        caption:
            "Cases that this backend is known to fail, and the reason. They run if their row is named."
                .to_owned(),
        head: vec![numbers("row"), words("case"), words("why")],
        rows: rows
            .map(|case| vec![case.row.to_string(), case.name.clone(), case.why.to_owned()])
            .collect(),
    }
}

/// Formats a number with seven digits, the precision of single floats.
fn number(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 || x.fract() == 0.0 && size < 1e7 {
        format!("{x}")
    } else if (1e-3..1e7).contains(&size) {
        let decimals = (6.0 - size.log10().floor()).max(0.0) as usize;
        format!("{x:.decimals$}")
    } else {
        format!("{x:.6e}")
    }
}

/// Formats a number that should be small with two digits.
fn small(x: f64) -> String {
    if x == 0.0 {
        "0".to_owned()
    } else {
        format!("{x:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_formatted_to_significant_digits() {
        for (x, text) in [
            (0.0, "0"),
            (2.0, "2"),
            (0.277_063_12, "0.2770631"),
            (999.954_872_1, "999.9549"),
            (2.353_096_1e-6, "2.353096e-6"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(number(x), text);
        }
        assert_eq!(
            (small(-1.26e-5), small(0.0)),
            ("-1.3e-5".into(), "0".into())
        );
    }
}
