//! The tables of one scene of a benchmark, each with a sentence that explains it.
//!
//! Measure: stated in each sentence.
//! Range: any report; a table whose part was not measured has no rows.
//! Source: none needed. Tested in `cli/tests/command/bench.rs` and below.

use super::compare::{self, reference};
use super::wording::{count, digits, megabytes, of_things, ratio, spread, way};
use crate::report::table::{Table, numbers, words};
use etendue::internals::accel::{Backend, Precision};
use etendue::internals::integrator::observer::RayKind;
use etendue_lab::bench::report::{
    AgreementReport, BenchReport, OverheadReport, SceneReport, TraceReport,
};
use etendue_lab::bench::target::TracingMode;

/// Describes the spread of the numbers.
fn runs(rounds: usize) -> String {
    format!("median (minimum to maximum) of {rounds} interleaved runs")
}

/// Returns the table of the recorded rays, with the size of the scene.
pub fn scene(scene: &SceneReport) -> Table {
    let rows = scene.rays.iter().map(|rays| {
        vec![
            rays.kind.name().to_owned(),
            digits(rays.per_sample),
            count(rays.recorded as u64),
        ]
    });
    let mut caption = match scene.description.as_str() {
        "" => String::new(),
        text => format!("{} ", sentence(text)),
    };
    caption += &of_things(scene.primitives, "primitive", "primitives");
    caption += ". The table has the mean number of rays per sample of its render, by kind, and how many of them were \
             recorded and traced again.";
    Table {
        title: scene.name.clone(),
        caption,
        head: vec![words("rays"), numbers("per sample"), numbers("recorded")],
        rows: rows.collect(),
    }
}

/// Returns the text with exactly one full stop at its end.
fn sentence(text: &str) -> String {
    format!("{}.", text.trim_end_matches('.'))
}

/// Returns the table of build times and sizes.
pub fn builds(report: &BenchReport, scene: &SceneReport) -> Table {
    let rows = scene.builds.iter().map(|build| {
        vec![
            build.target.name(),
            build.threads.to_string(),
            spread(&build.seconds, 1e3),
            megabytes(build.bytes),
            build
                .nodes
                .map_or("-".to_owned(), |nodes| count(nodes as u64)),
        ]
    });
    Table {
        title: "Building".to_owned(),
        caption: format!(
            "Milliseconds to build each structure, and its size: lower is better. Times are the {}; a dash means that \
             the library does not report it. obvhs builds the same structure for both precisions, which is listed \
             once.",
            runs(report.build_rounds)
        ),
        head: vec![
            words("structure"),
            numbers("threads"),
            numbers("ms"),
            numbers("MB"),
            numbers("nodes"),
        ],
        rows: rows.collect(),
    }
}

/// Returns the table of tracing times, each backend in its fastest configuration.
pub fn rays(report: &BenchReport, scene: &SceneReport) -> Table {
    let reference = reference(report);
    let rows = compare::fastest(scene).into_iter().map(|fastest| {
        vec![
            fastest.trace.kind.name().to_owned(),
            fastest.contender.name(),
            way(&fastest.trace.variant),
            spread(&fastest.trace.nanoseconds, 1.0),
            digits(fastest.trace.millions_per_second()),
            ratio(fastest.times_reference),
        ]
    });
    Table {
        title: "Tracing".to_owned(),
        caption: format!(
            "Nanoseconds per ray on one core, each backend in its fastest configuration for this kind of rays: lower is \
             better. They are the {}. `Mrays/s` is millions of rays per second and core (higher is better), `ratio` the \
             time over that of {reference} in its fastest configuration.",
            runs(report.rounds)
        ),
        head: vec![
            words("rays"),
            words("backend"),
            words("fastest configuration"),
            numbers("ns"),
            numbers("Mrays/s"),
            numbers("ratio"),
        ],
        rows: rows.collect(),
    }
}

/// Returns the table of obvhs with its own loops, beside ours over the same layout.
pub fn obvhs_itself(report: &BenchReport, scene: &SceneReport) -> Table {
    let rows = scene.obvhs_itself.iter().map(|theirs| {
        let ours = scene.traces.iter().filter(|trace| {
            let target = trace.variant.target;
            trace.kind == theirs.kind
                && target.backend == theirs.layout
                && target.precision == Precision::Fast
        });
        let ours = ours.map(|trace| trace.nanoseconds.median);
        let ours = ours.min_by(f64::total_cmp).filter(|&ours| ours > 0.0);
        let theirs_median = theirs.nanoseconds.median;
        vec![
            theirs.kind.name().to_owned(),
            theirs.layout.name().to_owned(),
            if theirs.is_split { "split" } else { "whole" }.to_owned(),
            spread(&theirs.nanoseconds, 1.0),
            ours.map_or("-".to_owned(), digits),
            ratio(ours.map(|ours| theirs_median / ours)),
        ]
    });
    Table {
        title: "obvhs itself".to_owned(),
        caption: format!(
            "Nanoseconds per ray on one core by obvhs's own traversal and triangle test over its own trees, as its users \
             call it, with triangles whole or split by its builder: lower is better. They are the {}. `ours` is the \
             traversal of Etendue over the same layout in fast precision, which unlike that of obvhs bounds rounding \
             errors; `ratio` is the time of obvhs itself over that.",
            runs(report.rounds)
        ),
        head: vec![
            words("rays"),
            words("layout"),
            words("triangles"),
            numbers("ns"),
            numbers("ours"),
            numbers("ratio"),
        ],
        rows: rows.collect(),
    }
}

/// Returns the table of all configurations of the reference backend.
pub fn variants(report: &BenchReport, scene: &SceneReport) -> Table {
    let backend = compare::backends([scene]).first().copied();
    let kinds: Vec<RayKind> = scene.rays.iter().map(|rays| rays.kind).collect();
    let rows = ways(scene, backend).into_iter().map(|variant| {
        let traces: Vec<Option<&TraceReport>> = kinds
            .iter()
            .map(|&kind| trace_of(scene, kind, variant))
            .collect();
        let medians = traces
            .iter()
            .map(|trace| trace.map_or("-".to_owned(), |trace| digits(trace.nanoseconds.median)));
        let spreads = traces.iter().flatten().map(|trace| {
            let times = trace.nanoseconds;
            (times.max - times.min) / times.median
        });
        // Times below the clock resolution give NaN, which `max` ignores.
        let widest = spreads.fold(0.0, f64::max);
        [way(&variant)]
            .into_iter()
            .chain(medians)
            .chain([format!("{:.0} %", 100.0 * widest)])
            .collect()
    });
    let name = backend.map_or("the first backend", Backend::name);
    let names = kinds.iter().map(|kind| numbers(kind.name()));
    Table {
        title: format!("All configurations of {name}"),
        caption: format!(
            "Nanoseconds per ray on one core, by precision, quality of the structure and packets (their width, and \
             whether they are marked as coherent): lower is better. They are medians of {} interleaved runs; \
             `spread` is the largest distance from minimum to maximum in the row, over the median.",
            report.rounds
        ),
        head: [words("configuration")]
            .into_iter()
            .chain(names)
            .chain([numbers("spread")])
            .collect(),
        rows: rows.collect(),
    }
}

/// Returns the configurations in which a backend traced, in the order of the report.
pub fn ways(scene: &SceneReport, backend: Option<Backend>) -> Vec<TracingMode> {
    let mut ways = Vec::new();
    for trace in &scene.traces {
        let own = Some(trace.variant.target.backend) == backend;
        if own && !ways.contains(&trace.variant) {
            ways.push(trace.variant);
        }
    }
    ways
}

/// Returns the result of a kind of rays in one configuration.
pub fn trace_of(scene: &SceneReport, kind: RayKind, variant: TracingMode) -> Option<&TraceReport> {
    let mut traces = scene.traces.iter();
    traces.find(|trace| trace.kind == kind && trace.variant == variant)
}

/// Returns the table of the agreement between the hits of the backends.
pub fn agreement(scene: &SceneReport) -> Table {
    let rows = scene.agreement.iter().map(|agreement| {
        let numbers = [
            agreement.rays,
            agreement.identical,
            agreement.ties,
            agreement.edges,
            agreement.real,
        ];
        [agreement.target.name(), agreement.reference.name()]
            .into_iter()
            .chain(numbers.map(count))
            .chain([verdict(agreement).to_owned()])
            .collect()
    });
    let mut caption = "Hits of each structure compared with those of another, ray by ray. `ties` hit another primitive at \
                    the same distance, `edges` passed within rounding of an edge or of an end of the ray: rounding \
                    explains both. `real` counts the differences that rounding does not explain, and has to be 0."
        .to_owned();
    for agreement in &scene.agreement {
        if let Some(first) = &agreement.first_real {
            let (one, other) = (agreement.target.name(), agreement.reference.name());
            caption += &format!(" The first of {one} against {other}: {}", sentence(first));
        }
    }
    let counts = ["rays", "identical", "ties", "edges", "real"].map(numbers);
    Table {
        title: "Agreement".to_owned(),
        caption,
        head: [words("structure"), words("against")]
            .into_iter()
            .chain(counts)
            .chain([words("verdict")])
            .collect(),
        rows: rows.collect(),
    }
}

fn verdict(agreement: &AgreementReport) -> &'static str {
    match agreement.real {
        0 => "agree",
        _ => "DIFFER",
    }
}

/// Returns the table of the Etendue render compared with the floor.
pub fn overhead(report: &BenchReport, overhead: &OverheadReport) -> Table {
    let total: f64 = overhead.parts.iter().map(|part| part.nanoseconds).sum();
    let rows = overhead.parts.iter().map(|part| {
        vec![
            part.part.to_owned(),
            digits(part.nanoseconds),
            format!("{:.1} %", 100.0 * part.nanoseconds / total),
        ]
    });
    let whole = vec![
        "whole sample".to_owned(),
        digits(total),
        "100.0 %".to_owned(),
    ];
    Table {
        title: "Render by Etendue".to_owned(),
        caption: format!(
            "The render takes {} times as long as its floor (lower is better; 1 cannot be beaten): {} ns per sample on \
             one core over {} ns, the time of its rays alone, each kind in the fastest configuration of {}. Pixels share \
             no paths, and there are no light paths. Numbers are the {}, with {} spp and `{}`. {} are {} times as fast \
             as one. Before the first sample: {} ms of loading, {} ms of building. The table breaks down the time of a \
             sample, in nanoseconds on one core.",
            spread(&overhead.factor, 1.0),
            spread(&overhead.sample, 1.0),
            digits(overhead.floor),
            floor_backend(overhead),
            runs(report.rounds),
            overhead.spp,
            overhead.target.name(),
            of_things(report.threads, "thread", "threads"),
            digits(overhead.speedup(report.threads)),
            digits(overhead.load * 1e3),
            digits(overhead.build * 1e3),
        ),
        head: vec![words("part"), numbers("ns per sample"), numbers("share")],
        rows: rows.chain([whole]).collect(),
    }
}

/// Returns the name of the backend that defines the floor.
fn floor_backend(overhead: &OverheadReport) -> &'static str {
    let best = overhead.best.first();
    best.map_or("Embree", |trace| trace.variant.target.backend.name())
}

/// Returns the tables of a scene that have rows.
pub fn measured(report: &BenchReport, scene: &SceneReport) -> Vec<Table> {
    let overhead = scene.overhead.as_ref().map(|found| overhead(report, found));
    let mut tables = vec![
        builds(report, scene),
        rays(report, scene),
        variants(report, scene),
        obvhs_itself(report, scene),
        agreement(scene),
    ];
    tables.extend(overhead);
    tables.retain(|table| !table.rows.is_empty());
    tables
}

#[cfg(test)]
mod tests {
    use super::super::sample::report;
    use super::*;

    /// Returns the cells of the row that starts with `begins`.
    fn row<'a>(table: &'a Table, begins: &[&str]) -> &'a [String] {
        let found = table
            .rows
            .iter()
            .find(|row| row.iter().zip(begins).all(|(a, b)| a == b));
        found.unwrap_or_else(|| panic!("no {begins:?} in {table:?}"))
    }

    #[test]
    fn table_rows_have_as_many_cells_as_columns() {
        let report = report();
        let mut tables = measured(&report, &report.scenes[0]);
        assert_eq!(tables.len(), 6);
        tables.push(scene(&report.scenes[0]));
        for table in tables {
            assert!(!table.rows.is_empty(), "{}", table.title);
            assert!(
                table.rows.iter().all(|row| row.len() == table.head.len()),
                "{table:?}"
            );
        }
    }

    #[test]
    fn table_numbers_match_the_report() {
        let report = report();
        let scene = &report.scenes[0];
        let [first, second] = [Backend::ALL[0].name(), Backend::ALL[1].name()];
        let way = "fast high, single";
        let expected = ["shadow", second, way, "20.0 (18.0 to 22.0)", "50.0", "0.50"];
        assert_eq!(row(&rays(&report, scene), &expected[..2]), expected);
        let robust = ["robust high, single", "80.0", "-", "20 %"];
        assert_eq!(row(&variants(&report, scene), &robust[..1]), robust);
        let built = [
            &format!("{first} fast high"),
            "2",
            "12.3 (11.1 to 13.5)",
            "4.56",
            "-",
        ];
        assert_eq!(row(&builds(&report, scene), &built[..1]), built);
        let whole = ["whole sample", "500", "100.0 %"];
        let overhead = overhead(&report, scene.overhead.as_ref().expect("it has one"));
        assert_eq!(row(&overhead, &whole[..1]), whole);
        assert!(
            overhead.caption.contains("takes 4.00 (3.60 to 4.40) times"),
            "{}",
            overhead.caption
        );
        let agreement = agreement(scene);
        assert_eq!(
            agreement.rows[0][2..],
            ["1 000", "990", "6", "3", "1", "DIFFER"]
        );
        assert!(
            agreement.caption.contains("origin 0 0 0"),
            "{}",
            agreement.caption
        );
    }
}
