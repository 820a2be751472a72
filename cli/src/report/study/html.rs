//! A study as a page: the conclusions in a few sentences, then the seven parts of the protocol.
//!
//! Measure: that of the tables and plots.
//! Range: any findings; parts that were not measured are left out. The page is self-contained.
//! Source: docs/accuracy.md, "The study". Tested in `cli/tests/command/study.rs`.

use super::tables::path_class;
use super::wording::{percent, round_up, samples, seconds};
use super::{Findings, conclusions, plots, tables};
use crate::report::chart::{self, Bar, Group};
use crate::report::false_colour::{map, sequential, signed};
use crate::report::page::{picture, styled_page};
use crate::report::plot;
use crate::report::prose::prose;
use crate::report::table::Table;
use etendue::internals::image::Image;
use etendue_lab::study::pictures::Shown;
use maud::{Markup, html};

/// Builds the page.
pub fn of_findings(findings: &Findings<'_>) -> String {
    let report = findings.report;
    let body = html! {
        h1 { "Error against time: " code { (report.scene) } }
        @if !report.complete {
            p.warning { "The study was interrupted: what was not measured is left out." }
        }
        ul.headline { @for sentence in conclusions::of_findings(findings) { li { (prose(&sentence)) } } }
        (contents())
        section #verdict {
            h2 { "1. Verdict" }
            (tabled(&tables::times(findings)))
            (tabled(&tables::efficiency(findings)))
            (tabled(&tables::bias(findings)))
        }
        @if !findings.summaries.is_empty() {
            section #errors {
                h2 { "2. Error against time" }
                (plot::figures(&plots::errors(findings)))
            }
        }
        section #pictures { h2 { "3. Pictures" } (pictures(findings)) }
        section #trust {
            h2 { "4. Reliability of error bars and images" }
            (plot::figures(&plots::trust(findings)))
            @for text in reference_shares(findings) { p.says { (prose(&text)) } }
        }
        section #anatomy {
            h2 { "5. Breakdown of time and variance" }
            (path_charts(findings))
            (tabled(&tables::bounces(findings)))
            (tabled(&tables::effects(findings)))
        }
        section #better { h2 { "6. Cost of a smaller error" } (tabled(&tables::tenth(findings))) }
        section #again {
            h2 { "7. How to reproduce it" }
            p { code { (findings.command) } }
            p.says { "The same seed gives the same pictures; times and what follows from them differ." }
            (tabled(&tables::environment(findings)))
            (tabled(&tables::warnings(findings)))
        }
    };
    styled_page(&format!("Study of {}", report.scene), STYLE, &body)
}

fn contents() -> Markup {
    let parts = [
        ("verdict", "Verdict"),
        ("errors", "Error against time"),
        ("pictures", "Pictures"),
        ("trust", "Reliability"),
        ("anatomy", "Time and variance"),
        ("better", "Cost of a smaller error"),
        ("again", "How to reproduce it"),
    ];
    html! { nav { @for (id, name) in parts { a href={ "#" (id) } { (name) } " " } } }
}

fn tabled(table: &Table) -> Markup {
    html! {
        @if !table.rows.is_empty() { h3 { (table.title) } p.says { (prose(&table.says)) } (table.html()) }
    }
}

/// Builds the images: the reference, and the variants at equal time and at equal error.
fn pictures(findings: &Findings<'_>) -> Markup {
    let all = &findings.report.pictures;
    let Some(reference) = &all.reference else {
        return html! { p.says { "No reference was rendered." } };
    };
    let shown = || all.equal_time.iter().chain(&all.equal_error);
    let mut errors: Vec<f64> = shown().map(|shown| shown.rel_mse.max(0.0).sqrt()).collect();
    errors.sort_by(f64::total_cmp);
    // All error maps share one scale, which is chosen so that typical errors of the median image have visible colour.
    let middle = errors.get(errors.len() / 2).copied().unwrap_or(1.0);
    let end = round_up(2.0 * middle).min(1.0);
    let ends = percent(end);
    html! {
        div.pictures { (picture("reference", "mean of both renders", reference)) }
        @for (title, reading, shown) in [
            ("At equal time", "Each variant in the time of the longest renders of the fastest variant.", &all.equal_time),
            ("At equal error", "Each variant with the samples that it needs for an error that all of them reached, or with one sample if its error is smaller: only the time differs.", &all.equal_error),
        ] {
            @if !shown.is_empty() {
                h3 { (title) }
                p.says { (reading) " Beside each picture its relative error: blue is too dark, red too bright, full colour is "
                    (ends) " or more of the pixel's value." }
                div.pairs { @for shown in shown { (pair(findings, shown, end)) } }
            }
        }
        (standard_errors(findings, reference))
    }
}

fn pair(findings: &Findings<'_>, shown: &Shown, end: f64) -> Markup {
    let name = &findings.report.variants[shown.variant].variant.name;
    let says = format!(
        "{} per pixel, {}, error {}",
        samples(shown.spp),
        seconds(shown.seconds),
        percent(shown.rel_mse.max(0.0).sqrt())
    );
    let size = (shown.image.width(), shown.image.height());
    let errors = map(&shown.errors, size, end, signed);
    html! {
        div.pair {
            (picture(name, &says, &shown.image))
            (picture(&format!("{name}: error"), "", &errors))
        }
    }
}

fn standard_errors(findings: &Findings<'_>, reference: &Image) -> Markup {
    let all = &findings.report.pictures.standard_errors;
    let mut largest: Vec<f64> = all.iter().flat_map(|(_, errors)| errors).copied().collect();
    largest.sort_by(f64::total_cmp);
    // The scale ends at the 90 % quantile of the standard errors.
    let end = largest.get(largest.len() * 9 / 10).copied().unwrap_or(1.0);
    let end = round_up(end);
    let size = (reference.width(), reference.height());
    html! {
        @if !all.is_empty() {
            h3 { "Noise of each pixel" }
            p.says { "The standard error of each pixel, as estimated by the renderer: dark is none, yellow "
                (percent(end)) " or more of the pixel's value." }
            div.pictures {
                @for (index, errors) in all {
                    @let study = &findings.report.variants[*index];
                    @let says = study.bars.as_ref().map_or(String::new(), |bars| {
                        format!("{} per pixel; {} of the pixels are flagged", samples(bars.spp), percent(bars.flagged))
                    });
                    (picture(&study.variant.name, &says, &map(errors, size, end, sequential)))
                }
            }
        }
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
            range: Some([-2.0, 2.0].map(|s| (class.variance + s * class.variance_error).max(0.0))),
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
            p.says { (prose(&table.says)) }
            (chart::bars(&groups))
        }
    }
}

/// The additional styles of studies.
const STYLE: &str = "
.headline li { margin: .3rem 0; font-size: 1.1rem; }
.pairs { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 26rem), 1fr)); gap: 1rem 2rem; margin: .8rem 0; }
.pair { display: grid; grid-template-columns: 1fr 1fr; gap: .6rem; break-inside: avoid; }
td:first-child { min-width: 6.5rem; }
@media (max-width: 40rem) { table { font-size: .8rem; } th, td { padding-right: .5rem; } }
";
