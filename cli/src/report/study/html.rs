//! A study as a page: one sentence and one plot that answer, what errors look like, then the parts of the protocol.
//!
//! Measure: that of the tables and plots.
//! Range: any findings; parts that were not measured are left out. The page is self-contained.
//! Source: docs/accuracy.md, "The study". Tested in `cli/tests/command/study.rs`.

use super::tables::path_class;
use super::wording::percent;
use super::{Findings, answers, conclusions, images, plots, tables};
use crate::report::chart::{self, Bar, Group};
use crate::report::page::styled_page;
use crate::report::plot;
use crate::report::prose::prose;
use crate::report::table::Table;
use maud::{Markup, html};

/// Builds the page.
pub fn of_findings(findings: &Findings<'_>) -> String {
    let report = findings.report;
    let sentences = conclusions::of_findings(findings);
    let body = html! {
        h1 { "What accuracy costs: " code { (report.scene) } }
        @if !report.complete {
            p.warning { "The study was interrupted: what was not measured is left out." }
        }
        p.headline { @if let Some(first) = sentences.first() { (prose(first)) } }
        p.caption {
            "The error is the typical difference of a pixel from the exact image, relative to its brightness ("
            a href="#again" { "root of relMSE" } "). What 10, 3 and 1 % look like is shown below."
        }
        @if !findings.summaries.is_empty() { (plot::figure(&plots::price(findings))) }
        (images::examples(findings))
        (contents())
        section #images { h2 { "1. Images after equal times" } (images::images(findings)) }
        section #verdict {
            h2 { "2. Verdict" }
            ul.conclusions { @for sentence in sentences.iter().skip(1) { li { (prose(sentence)) } } }
            (tabled(&answers::side_by_side(findings)))
            @if let Some(table) = answers::for_threads(findings) { (tabled(&table)) }
            (tabled(&tables::efficiency(findings)))
            (tabled(&tables::bias(findings)))
        }
        @if !findings.summaries.is_empty() {
            section #errors {
                h2 { "3. Error against samples" }
                (plot::figures(&plots::errors(findings)))
            }
        }
        section #trust {
            h2 { "4. Reliability of error bars and images" }
            (plot::figures(&plots::trust(findings)))
            @for text in reference_shares(findings) { p.caption { (prose(&text)) } }
        }
        section #cost_sources {
            h2 { "5. Breakdown of time and variance" }
            (path_charts(findings))
            (tabled(&tables::bounces(findings)))
            (tabled(&tables::effects(findings)))
        }
        section #better { h2 { "6. Cost of a smaller error" } (tabled(&tables::tenth(findings))) }
        section #again {
            h2 { "7. How to reproduce it" }
            p { code { (findings.command) } }
            p.caption { "The same seed gives the same images; times and what follows from them differ." }
            (tabled(&tables::environment(findings)))
            (tabled(&tables::warnings(findings)))
        }
    };
    styled_page(&format!("Study of {}", report.scene), STYLE, &body)
}

fn contents() -> Markup {
    let parts = [
        ("images", "Images"),
        ("verdict", "Verdict"),
        ("errors", "Error against samples"),
        ("trust", "Reliability"),
        ("cost_sources", "Time and variance"),
        ("better", "Cost of a smaller error"),
        ("again", "How to reproduce it"),
    ];
    html! { nav { @for (id, name) in parts { a href={ "#" (id) } { (name) } " " } } }
}

fn tabled(table: &Table) -> Markup {
    html! {
        @if !table.rows.is_empty() { h3 { (table.title) } p.caption { (prose(&table.caption)) } (table.html()) }
    }
}

fn reference_shares(findings: &Findings<'_>) -> Vec<String> {
    let shares = findings.report.variants.iter().filter_map(|study| {
        let bars = study.bars.as_ref()?;
        Some(format!(
            "`{}`: {} (with {} samples per pixel)",
            study.variant.name,
            percent(bars.reference_share),
            bars.spp
        ))
    });
    let shares: Vec<String> = shares.collect();
    if shares.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "The error bars do not include the noise of the reference. Its variance over theirs: {}. With much more than a few percent, bars seem too narrow.",
        shares.join(", ")
    )]
}

/// Builds bars of the shares of the variance, with the title and the caption of their table.
fn path_charts(findings: &Findings<'_>) -> Markup {
    let table = tables::paths(findings);
    let groups = findings.report.variants.iter().filter_map(|study| {
        let paths = study.paths.as_ref()?;
        let bar = |class: &etendue_lab::study::variance::ClassShare| Bar {
            label: path_class(class.bounces, class.found),
            value: class.variance,
            range: class
                .variance_error
                .is_finite()
                .then(|| [-2.0, 2.0].map(|s| (class.variance + s * class.variance_error).max(0.0))),
            text: format!(
                "{}, of the light {}",
                percent(class.variance),
                percent(class.energy)
            ),
            hue: class.found as usize,
        };
        Some(Group {
            name: study.variant.name.clone(),
            bars: paths
                .classes
                .iter()
                .filter(|class| tables::matters(class))
                .map(bar)
                .collect(),
        })
    });
    let groups: Vec<Group> = groups.collect();
    html! {
        @if !groups.is_empty() {
            h3 { (table.title) }
            p.caption { (prose(&table.caption)) }
            (chart::bars(&groups))
        }
    }
}

/// The additional styles of studies.
const STYLE: &str = "
.conclusions { padding-left: 1.2rem; } .conclusions li { margin: .3rem 0; }
.crops { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 9rem), 15rem)); gap: 1rem; margin: .8rem 0; }
@media (max-width: 40rem) { .crops { grid-template-columns: repeat(3, 1fr); gap: .4rem; } .figure { font-size: .8rem; } }
.pairs { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 26rem), 1fr)); gap: 1rem 2rem; margin: .8rem 0; }
.pair { display: grid; grid-template-columns: 1fr 1fr; gap: .6rem; break-inside: avoid; }
td:first-child { min-width: 6.5rem; }
@media (max-width: 40rem) { table { font-size: .8rem; } th, td { padding-right: .5rem; } }
";
