//! The tables of a whole benchmark, each with a sentence that explains it.
//!
//! Measure: stated in each sentence.
//! Range: any report; a table whose part is not measured yet has no rows.
//! Source: none needed. Tested in `cli/tests/command/bench.rs` and below.

use super::compare::{self, Mean, reference};
use super::scene_tables;
use super::wording::{count, digits, ratio};
use crate::report::table::{Table, numbers, words};
use etendue_lab::bench::report::{BenchReport, Machine};
use etendue_lab::bench::target::BenchTarget;

/// Returns the table of the machine.
pub fn machine(report: &BenchReport) -> Table {
    let mut rows = machine_rows(&report.machine, report.version);
    rows.extend([
        vec![
            "threads of the benchmark".to_owned(),
            report.threads.to_string(),
        ],
        vec![
            "runs per number".to_owned(),
            format!("{} ({} of building)", report.rounds, report.build_rounds),
        ],
    ]);
    Table {
        title: "The machine".to_owned(),
        caption: "The machine of all measurements. Times of another machine differ, and so may their ratios."
            .to_owned(),
        head: vec![words("what"), words("which")],
        rows,
    }
}

/// Returns the rows of a table for a machine and a program version.
pub fn machine_rows(machine: &Machine, version: &str) -> Vec<Vec<String>> {
    let or_unknown = |text: &str, otherwise: &str| match text {
        "" => otherwise.to_owned(),
        text => text.to_owned(),
    };
    let rows = [
        ("etendue", version.to_owned()),
        ("processor", or_unknown(&machine.processor, "unknown")),
        ("available processors", machine.processors.to_string()),
        ("system", machine.system.clone()),
        ("Embree", or_unknown(&machine.embree, "not in this build")),
    ];
    rows.map(|(what, which)| vec![what.to_owned(), which])
        .to_vec()
}

/// Returns the table of the ratio of each backend in each scene.
pub fn summary(report: &BenchReport) -> Table {
    let contenders = compare::contenders(&report.scenes);
    let row = |name: &str, means: &[Mean]| {
        let cells = contenders.iter().map(|contender| {
            let mean = means.iter().find(|mean| mean.contender == *contender);
            ratio(mean.and_then(|mean| mean.times_reference))
        });
        [name.to_owned()].into_iter().chain(cells).collect()
    };
    let measured = report
        .scenes
        .iter()
        .filter(|scene| !scene.traces.is_empty());
    let mut rows: Vec<Vec<String>> = measured
        .map(|scene| row(&scene.name, &compare::means(scene)))
        .collect();
    if rows.len() > 1 {
        rows.push(row("all scenes", &compare::overall(report)));
    }
    let reference = reference(report);
    let names = contenders.iter().map(|contender| numbers(contender.name()));
    Table {
        title: "Summary".to_owned(),
        caption: format!(
            "Time of each backend over that of {reference} for the same rays, each in its fastest configuration: the \
             geometric mean over the kinds of rays of a scene. Lower is better; {reference} is 1.00."
        ),
        head: [words("scene")].into_iter().chain(names).collect(),
        rows,
    }
}

/// Returns the table of leaks out of closed meshes, summed over the meshes.
pub fn leaks(report: &BenchReport) -> Table {
    let mut aims: Vec<&str> = Vec::new();
    let mut targets: Vec<BenchTarget> = Vec::new();
    for leak in &report.leaks {
        if !aims.contains(&leak.aim.as_str()) {
            aims.push(&leak.aim);
        }
        if !targets.contains(&leak.target) {
            targets.push(leak.target);
        }
    }
    let row = |target: &BenchTarget| {
        let cells = aims.iter().map(|aim| {
            let all = report.leaks.iter();
            let own = all.filter(|leak| leak.target == *target && leak.aim == *aim);
            let (leaked, segments) = own.fold((0, 0), |(leaked, segments), leak| {
                (leaked + leak.leaks, segments + leak.segments)
            });
            format!("{} ({})", rate(leaked, segments), count(leaked))
        });
        [target.name()].into_iter().chain(cells).collect()
    };
    let names = aims.iter().map(|aim| numbers(format!("aim: {aim}")));
    Table {
        title: "Leaks".to_owned(),
        caption: "Segments from the inside of closed meshes to the outside that hit nothing, per million (and their \
               number), by what they were aimed at: lower is better, and the exact number is 0. All meshes are taken \
               together; bench.json has each of them."
            .to_owned(),
        head: [words("structure")].into_iter().chain(names).collect(),
        rows: targets.iter().map(row).collect(),
    }
}

fn rate(leaks: u64, segments: u64) -> String {
    match segments {
        0 => "-".to_owned(),
        _ => digits(1e6 * leaks as f64 / segments as f64),
    }
}

/// Returns all tables as Markdown, with the command that measured them.
pub fn markdown(report: &BenchReport, command: &str) -> String {
    let mut text = format!("# The bench\n\nMeasured by `{command}`");
    text += if report.complete {
        ".\n\n"
    } else {
        ", which was interrupted: what was not measured is left out.\n\n"
    };
    text += &machine(report).markdown(2);
    for scene in &report.scenes {
        text += &scene_tables::scene(scene).markdown(2);
        for table in scene_tables::measured(report, scene) {
            text += &table.markdown(3);
        }
    }
    for table in [leaks(report), summary(report)] {
        if !table.rows.is_empty() {
            text += &table.markdown(2);
        }
    }
    text.trim_end().to_owned() + "\n"
}

#[cfg(test)]
mod tests {
    use super::super::sample::report;
    use super::*;

    #[test]
    fn table_rows_have_as_many_cells_as_columns() {
        let report = report();
        for table in [machine(&report), summary(&report), leaks(&report)] {
            assert!(!table.rows.is_empty(), "{}", table.title);
            assert!(
                table.rows.iter().all(|row| row.len() == table.head.len()),
                "{table:?}"
            );
        }
        assert_eq!(leaks(&report).rows[0][1..], ["1.50 (3)"]);
        assert_eq!(summary(&report).rows, [["a <box>", "1.00", "1.00"]]);
    }

    #[test]
    fn markdown_names_its_command_and_ends_with_the_summary() {
        let mut report = report();
        let text = markdown(&report, "etendue bench box");
        assert!(
            text.starts_with("# The bench\n\nMeasured by `etendue bench box`.\n"),
            "{text}"
        );
        let headings: Vec<_> = text
            .lines()
            .filter(|line| line.starts_with("## "))
            .collect();
        assert_eq!(
            headings,
            ["## The machine", "## a <box>", "## Leaks", "## Summary"]
        );
        report.complete = false;
        assert!(markdown(&report, "it").contains("interrupted"));
    }
}
