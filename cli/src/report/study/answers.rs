//! The answers of a study: how long each variant takes to an error, as tables.
//!
//! Measure: seconds at the scene's own size; errors as roots of relMSE.
//! Range: any findings; no cell is empty: where there is no time, the cell says so and the caption has the reason.
//! Source: none needed. Tested in `cli/tests/command/study.rs` and below.

use super::Findings;
use super::wording::{answer, percent, ranged, rough, seconds, seconds_interval};
use crate::report::table::{Table, numbers, words};
use etendue_lab::study::answer::Answer;
use etendue_lab::study::summary::{Summary, TARGETS};

/// Returns the table with a row for each variant and a column for each error.
pub fn side_by_side(findings: &Findings<'_>) -> Table {
    let heads = TARGETS.map(|target| numbers(percent(target)));
    let row = |(_, summary): &(usize, Summary)| {
        let cells = summary.answers.iter().map(|(_, it)| answer(it));
        [summary.name.clone()].into_iter().chain(cells).collect()
    };
    Table {
        title: TITLE.to_owned(),
        caption: caption(findings),
        head: [words("variant")].into_iter().chain(heads).collect(),
        rows: findings.summaries.iter().map(row).collect(),
    }
}

const TITLE: &str = "Time to an error";

/// Returns the table with a row for each variant and error, which fits a terminal.
pub fn one_by_one(findings: &Findings<'_>) -> Table {
    let same = |it: &Answer| it.clone();
    long(findings, TITLE.to_owned(), caption(findings), same)
}

/// Returns the table for another number of threads; `None` if none was requested.
pub fn for_threads(findings: &Findings<'_>) -> Option<Table> {
    let scaling = findings.report.scaling.as_ref()?;
    let title = format!("{TITLE} on {} threads", scaling.threads);
    let caption = format!(
        "Predicted for processors like this one's: from one thread to {} the time fell as if {} of it were not divided among threads; so {} threads take {} times as long as {}. That they do not wait for memory is not known.",
        scaling.measured,
        ranged(&scaling.serial, percent),
        scaling.threads,
        ranged(&scaling.factor, rough),
        scaling.measured
    );
    let scaled = |it: &Answer| match it.scaled(&scaling.factor) {
        Answer::Measured(range) => Answer::Law(range),
        other => other,
    };
    Some(long(findings, title, caption, scaled))
}

fn long(
    findings: &Findings<'_>,
    title: String,
    caption: String,
    of: impl Fn(&Answer) -> Answer,
) -> Table {
    let rows = findings.summaries.iter().flat_map(|(_, summary)| {
        summary.answers.iter().map(|(target, it)| {
            let it = of(it);
            let time = match it.seconds() {
                Some(time) => seconds(time),
                None => answer(&it),
            };
            let (mark, interval) = match &it {
                Answer::Measured(range) => ("", seconds_interval(range)),
                Answer::Law(range) => ("≈ ", seconds_interval(range)),
                Answer::AtOnce(_) => ("< ", String::new()),
                Answer::Exact(_) => ("", "exact: no noise".to_owned()),
                Answer::Never(bias) => ("", format!("its bias is {}", percent(*bias))),
                Answer::Unknown(_) => ("", "see above".to_owned()),
            };
            vec![
                summary.name.clone(),
                percent(*target),
                format!("{mark}{time}"),
                interval,
            ]
        })
    });
    Table {
        title,
        caption,
        head: vec![
            words("variant"),
            numbers("error"),
            numbers("time"),
            words("95 % interval"),
        ],
        rows: rows.collect(),
    }
}

fn caption(findings: &Findings<'_>) -> String {
    let report = findings.report;
    let (width, height) = report.full_size;
    let size = match report.size == report.full_size {
        true => String::new(),
        false => format!(
            ", converted from renders of {} × {}",
            report.size.0, report.size.1
        ),
    };
    let mut caption = format!(
        "For {width} × {height} pixels on {} threads{size}, from the first sample on, with intervals of 95 %, whose upper ends include what `render --error` takes to be sure of the error. Less is better. `≈` is beyond what was measured, by the law of the error so far; `never` is below the variant's bias.",
        report.threads
    );
    let mut all = findings.summaries.iter().flat_map(|(_, it)| &it.answers);
    if all.any(|(_, it)| matches!(it, Answer::AtOnce(_))) {
        caption +=
            " `<` is the time of the shortest renders; `render --error` takes at least 24 samples.";
    }
    for (_, summary) in &findings.summaries {
        let reasons = summary.answers.iter().filter_map(|(target, it)| match it {
            Answer::Unknown(reason) => Some((*target, reason)),
            _ => None,
        });
        let mut told: Vec<&String> = Vec::new();
        for (target, reason) in reasons {
            if !told.contains(&reason) {
                caption += &format!(" `{}` from {} on: {reason}.", summary.name, percent(target));
                told.push(reason);
            }
        }
    }
    caption
}

#[cfg(test)]
mod tests {
    use super::super::sample::{findings, report};
    use super::*;

    #[test]
    fn answer_tables_have_no_empty_cells_and_give_reasons() {
        let report = report();
        let mut found = findings(&report);
        let reason = "it is not known why".to_owned();
        found.summaries[0].1.answers[4].1 = Answer::Unknown(reason.clone());
        for table in [side_by_side(&found), one_by_one(&found)] {
            assert!(
                table
                    .caption
                    .contains(&format!("`path, sobol` from 0.1 % on: {reason}."))
            );
            let cells: Vec<&String> = table.rows.iter().flat_map(|row| &row[..3]).collect();
            assert!(
                cells
                    .iter()
                    .all(|cell| !cell.is_empty() && !cell.contains('>')),
                "{cells:?}"
            );
        }
        // The biased variant has an error of 14 % that no time reduces.
        let rows = side_by_side(&found).rows;
        assert!(rows[1][2..].iter().all(|cell| cell == "never"), "{rows:?}");
        assert!(rows[0][3].starts_with('≈'), "{rows:?}");
    }
}
