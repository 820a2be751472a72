//! A benchmark as a page: a summary of which backend is faster and by how much, then each scene.
//!
//! Measure: that of the tables, which are below their charts.
//! Range: any report; parts that are not measured yet are left out.
//! Source: none needed. Tested in `cli/tests/command/bench.rs` and below.

use super::compare::{self, Contender, Mean};
use super::wording::{digits, ratio, spread, way};
use super::{scene_tables, tables};
use crate::report::chart::{self, Bar, Group};
use crate::report::page::page;
use crate::report::prose::prose;
use crate::report::table::Table;
use etendue::internals::accel::Backend;
use etendue::internals::integrator::observer::RayKind;
use etendue::internals::math::stats::Spread;
use etendue_lab::bench::parts::SamplePart;
use etendue_lab::bench::report::{BenchReport, OverheadReport, SceneReport};
use maud::{Markup, html};

/// Builds the page of a report, with the command that measured it.
pub fn of_report(report: &BenchReport, command: &str) -> String {
    let summary = tables::summary(report);
    let leaks = tables::leaks(report);
    let body = html! {
        h1 { "Embree and obvhs, ray by ray" }
        (headline(report))
        @if !report.complete {
            p.warning { "This bench was interrupted: what was not measured is left out." }
        }
        @if !summary.rows.is_empty() {
            p.caption { (prose(&summary.caption)) }
            (summary_chart(report))
            (folded(&summary))
        }
        (how_to_read(report, command))
        nav {
            @for (index, scene) in report.scenes.iter().enumerate() {
                a href={ "#scene-" (index) } { (scene.name) }
            }
            @if !leaks.rows.is_empty() { a href="#leaks" { "leaks" } }
        }
        @for (index, scene) in report.scenes.iter().enumerate() { (of_scene(report, scene, index)) }
        @if !leaks.rows.is_empty() {
            section id="leaks" { h2 { (leaks.title) } p.caption { (prose(&leaks.caption)) } (leaks.html()) }
        }
    };
    page("etendue bench", &body)
}

/// Builds the headline: a line for each backend.
fn headline(report: &BenchReport) -> Markup {
    let means = compare::overall(report);
    html! {
        @if let [reference, others @ ..] = means.as_slice() {
            ul.headline {
                @for other in others {
                    @if let Some(times) = other.times_reference {
                        li { (comparison(&other.contender.name(), times, &reference.contender.name())) }
                    }
                }
            }
        }
    }
}

/// Describes which of two backends is faster, and by how much.
fn comparison(one: &str, times: f64, reference: &str) -> String {
    if times >= 1.0 {
        format!("{reference} is {times:.2} times as fast as {one}")
    } else {
        format!("{one} is {:.2} times as fast as {reference}", 1.0 / times)
    }
}

fn summary_chart(report: &BenchReport) -> Markup {
    let group = |name: &str, means: &[Mean]| Group {
        name: name.to_owned(),
        bars: means.iter().filter_map(bar_of_mean).collect(),
    };
    let measured = report
        .scenes
        .iter()
        .filter(|scene| !scene.traces.is_empty());
    let mut groups: Vec<Group> = measured
        .map(|scene| group(&scene.name, &compare::means(scene)))
        .collect();
    if groups.len() > 1 {
        groups.insert(0, group("all scenes", &compare::overall(report)));
    }
    chart::bars(&groups)
}

fn bar_of_mean(mean: &Mean) -> Option<Bar> {
    Some(Bar {
        label: mean.contender.name(),
        value: mean.times_reference?,
        range: None,
        text: ratio(mean.times_reference),
        hue: hue(mean.contender.backend),
    })
}

fn how_to_read(report: &BenchReport, command: &str) -> Markup {
    let machine = tables::machine(report);
    let example = Group {
        name: String::new(),
        bars: vec![bar(
            "a backend".to_owned(),
            &Spread {
                median: 60.0,
                min: 52.0,
                max: 75.0,
            },
            "ns",
            0,
        )],
    };
    html! {
        section {
            h2 { "What was measured, and how to read it" }
            p { "Each scene is rendered, and the rays of that render are recorded by kind: from the camera, to the \
                 lights, and after each scattering event. Every backend then traces the same rays in each of its \
                 configurations. A bar ends at the median of " (report.rounds) " interleaved runs; its whisker spans the \
                 minimum to the maximum. Shorter bars are better throughout." }
            (chart::bars(&[example]))
            p { "Measured by " code { (command) } "." }
            p.caption { (prose(&machine.caption)) }
            (machine.html())
        }
    }
}

fn of_scene(report: &BenchReport, scene: &SceneReport, index: usize) -> Markup {
    let head = scene_tables::scene(scene);
    html! {
        section id={ "scene-" (index) } {
            h2 { (head.title) }
            p.caption { (prose(&head.caption)) }
            @if !head.rows.is_empty() { (folded(&head)) }
            (charted(&scene_tables::rays(report, scene), &chart::bars(&rays(scene))))
            (charted(&scene_tables::builds(report, scene), &chart::bars(&builds(scene))))
            (variants(report, scene))
            (plain(&scene_tables::obvhs_itself(report, scene)))
            (plain(&scene_tables::agreement(scene)))
            @if let Some(overhead) = &scene.overhead {
                (charted(&scene_tables::overhead(report, overhead), &chart::stack(&parts(overhead))))
            }
        }
    }
}

/// Builds a chart with its table in a collapsed element.
fn charted(table: &Table, chart: &Markup) -> Markup {
    html! {
        @if !table.rows.is_empty() {
            h3 { (table.title) }
            p.caption { (prose(&table.caption)) }
            (chart)
            (folded(table))
        }
    }
}

fn folded(table: &Table) -> Markup {
    html! { details { summary { "the numbers" } (table.html()) } }
}

fn plain(table: &Table) -> Markup {
    html! {
        @if !table.rows.is_empty() {
            h3 { (table.title) }
            p.caption { (prose(&table.caption)) }
            (table.html())
        }
    }
}

/// Builds the table of all configurations, with their charts in a collapsed element, as there are many bars.
fn variants(report: &BenchReport, scene: &SceneReport) -> Markup {
    let table = scene_tables::variants(report, scene);
    html! {
        @if !table.rows.is_empty() {
            (plain(&table))
            details { summary { "as bars" } (chart::bars(&all_ways(scene))) }
        }
    }
}

fn hue(backend: Backend) -> usize {
    let place = Backend::ALL.iter().position(|known| *known == backend);
    place.expect("every backend is in the list of all")
}

fn bar(label: String, times: &Spread, unit: &str, hue: usize) -> Bar {
    Bar {
        label,
        value: times.median,
        range: Some([times.min, times.max]),
        text: format!("{} {unit}", spread(times, 1.0)),
        hue,
    }
}

/// Returns a group for each kind of ray, with a bar for each backend.
fn rays(scene: &SceneReport) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for fastest in compare::fastest(scene) {
        let name = fastest.trace.kind.name();
        if groups.last().is_none_or(|group| group.name != name) {
            groups.push(Group {
                name: name.to_owned(),
                bars: Vec::new(),
            });
        }
        let Contender { backend, .. } = fastest.contender;
        let label = format!("{} ({})", backend.name(), way(&fastest.trace.variant));
        let bar = bar(label, &fastest.trace.nanoseconds, "ns", hue(backend));
        groups.last_mut().expect("one was pushed").bars.push(bar);
    }
    groups
}

/// Returns a group for each kind of ray, with a bar for each configuration of the reference backend.
fn all_ways(scene: &SceneReport) -> Vec<Group> {
    let backend = compare::backends([scene]).first().copied();
    let ways = scene_tables::ways(scene, backend);
    let group = |kind: RayKind| Group {
        name: kind.name().to_owned(),
        bars: ways
            .iter()
            .filter_map(|&variant| scene_tables::trace_of(scene, kind, variant))
            .map(|trace| {
                let hue = trace.variant.packets.width as usize;
                bar(way(&trace.variant), &trace.nanoseconds, "ns", hue)
            })
            .collect(),
    };
    scene.rays.iter().map(|rays| group(rays.kind)).collect()
}

/// Returns a group for each number of threads, with a bar for each structure.
fn builds(scene: &SceneReport) -> Vec<Group> {
    let mut groups: Vec<(usize, Vec<Bar>)> = Vec::new();
    for build in &scene.builds {
        let milliseconds = Spread {
            median: build.seconds.median * 1e3,
            min: build.seconds.min * 1e3,
            max: build.seconds.max * 1e3,
        };
        let bar = bar(
            build.target.name(),
            &milliseconds,
            "ms",
            hue(build.target.backend),
        );
        match groups
            .iter_mut()
            .find(|(threads, _)| *threads == build.threads)
        {
            Some((_, bars)) => bars.push(bar),
            None => groups.push((build.threads, vec![bar])),
        }
    }
    let named = |(threads, bars)| Group {
        name: super::wording::of_things(threads, "thread", "threads"),
        bars,
    };
    groups.into_iter().map(named).collect()
}

/// Returns the parts of a sample: the floor, tracing beyond the floor, and everything else.
fn parts(overhead: &OverheadReport) -> Vec<chart::BarPart> {
    let traces = |name: &str| {
        SamplePart::ALL
            .iter()
            .any(|p| p.traces() && p.name() == name)
    };
    let tracing = overhead.parts.iter().filter(|part| traces(part.part));
    let tracing: f64 = tracing.map(|part| part.nanoseconds).sum();
    let floor = ("the floor", overhead.floor);
    let beyond = ("the rest of tracing", (tracing - overhead.floor).max(0.0));
    let others = overhead.parts.iter().filter(|part| !traces(part.part));
    let others = others.map(|part| (part.part, part.nanoseconds));
    let part = |(hue, (label, value)): (usize, (&str, f64))| chart::BarPart {
        label: label.to_owned(),
        value,
        text: format!("{} ns", digits(value)),
        hue,
    };
    [floor, beyond]
        .into_iter()
        .chain(others)
        .enumerate()
        .map(part)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::sample::report;
    use super::*;

    #[test]
    fn page_names_the_faster_backend_and_is_self_contained() {
        let mut report = report();
        let text = of_report(&report, "etendue bench box");
        let [first, second] = [Backend::ALL[0].name(), Backend::ALL[1].name()];
        for expected in [
            &format!("{first} is 1.00 times as fast as {second}"),
            "a &lt;box&gt;",
            "Abacus 9",
            "50.0 (45.0 to 55.0) ns",
            "DIFFER",
            "the rest of tracing: ",
            "100 ns, ",
        ] {
            assert!(text.contains(expected), "no `{expected}` in {text}");
        }
        for outside in [
            "http:", "https:", "src=", "@import", "url(", "<script", "a <box>",
        ] {
            assert!(!text.contains(outside), "`{outside}` in {text}");
        }
        assert!(!text.contains("interrupted"));
        report.complete = false;
        assert!(of_report(&report, "").contains("interrupted"));
    }

    #[test]
    fn incomplete_and_empty_reports_have_a_page() {
        let mut report = report();
        report.scenes[0].traces.clear();
        report.scenes[0].overhead = None;
        assert!(of_report(&report, "").contains("a &lt;box&gt;"));
        assert!(of_report(&BenchReport::default(), "").ends_with("</html>"));
    }

    #[test]
    fn comparison_names_the_faster_one_first() {
        assert_eq!(comparison("b", 2.0, "a"), "a is 2.00 times as fast as b");
        assert_eq!(comparison("b", 0.5, "a"), "b is 2.00 times as fast as a");
    }

    #[test]
    fn overhead_parts_split_tracing_into_floor_and_rest() {
        let overhead = report().scenes[0].overhead.clone().expect("it has one");
        let values: Vec<f64> = parts(&overhead).iter().map(|part| part.value).collect();
        assert_eq!(values, [150.0, 100.0, 250.0]);
    }
}
