//! A lesson as a page: the claim, its formulas, the experiment and the results.
//!
//! Measure: that of the numbers.
//! Range: any page. It is self-contained: formulas are MathML, plots are SVG, images are embedded.
//! Source: MathML Core. Tested in `cli/tests/command/lesson.rs`.

use super::wording::{number_table, technique_table};
use super::{Done, command};
use crate::report::page::{self, styled_page};
use crate::report::plot;
use crate::report::prose::prose;
use etendue_lab::lesson::page::{Figure, Finding, Formula, Page};
use etendue_lab::lesson::topic::Topic;
use maud::{Markup, PreEscaped, html};
use pulldown_latex::config::{DisplayMode, RenderConfig};
use pulldown_latex::{Parser, Storage};

/// Builds the page of a topic, with the command that reproduces it and links to its neighbours, if there are any.
pub fn of_page(topic: &Topic, lesson: &Page, neighbours: &[Topic], command: &str) -> String {
    let body = html! {
        (way(topic, neighbours))
        h1 { (topic.title) }
        p.headline { (prose(topic.summary)) }
        section {
            h2 { "The claim" }
            p.text { (prose(&lesson.claim)) }
            @for formula in &lesson.formulas { (set(formula)) }
        }
        section {
            h2 { "The experiment" }
            p.text { (prose(&lesson.experiment)) }
        }
        section {
            h2 { "The results" }
            @for finding in &lesson.findings { (found(finding)) }
        }
        (foot(command))
        (way(topic, neighbours))
    };
    let title = format!("{} - etendue lesson", topic.title);
    styled_page(&title, STYLE, &body)
}

/// Builds the index of all topics, with links to the pages of finished topics.
pub fn index(done: &[Done], topics: &[Topic], seed: u64) -> String {
    let is_done = |topic: &Topic| done.iter().any(|done| done.topic.name == topic.name);
    let body = html! {
        h1 { "Monte Carlo integration, by experiment" }
        p.text { "Each page states a claim, tests it, and compares the results with their exact \
                  values. All random numbers, distributions and images come from the renderer \
                  itself." }
        ol.contents {
            @for topic in topics {
                li {
                    @if is_done(topic) { a href=(link(topic)) { (topic.title) } } @else { (topic.title) }
                    p.caption { (prose(topic.summary)) }
                }
            }
        }
        (foot(&command("--all", seed)))
    };
    styled_page("Monte Carlo integration - etendue lesson", STYLE, &body)
}

fn link(topic: &Topic) -> String {
    format!("{}.html", topic.name)
}

/// Builds links to the previous page, the contents and the next page.
fn way(topic: &Topic, all: &[Topic]) -> Markup {
    let here = all.iter().position(|other| other.name == topic.name);
    let before = here
        .and_then(|here| here.checked_sub(1))
        .map(|index| &all[index]);
    let after = here.and_then(|here| all.get(here + 1));
    html! {
        @if here.is_some() {
            nav.way {
                span { @if let Some(topic) = before { a href=(link(topic)) { "← " (topic.title) } } }
                a href="index.html" { "contents" }
                span { @if let Some(topic) = after { a href=(link(topic)) { (topic.title) " →" } } }
            }
        }
    }
}

fn foot(command: &str) -> Markup {
    html! {
        p.caption.foot {
            "Made by " code { (command) } " with etendue " (env!("CARGO_PKG_VERSION")) ". The same \
                                                                                        seed gives \
                                                                                        the same \
                                                                                        numbers, \
                                                                                        except for \
                                                                                        times and \
                                                                                        what \
                                                                                        follows \
                                                                                        from \
                                                                                        them."
        }
    }
}

fn set(formula: &Formula) -> Markup {
    html! {
        div.formula {
            div.math { (PreEscaped(mathml(&formula.latex))) }
            p.caption { (prose(&formula.caption)) }
        }
    }
}

/// Converts a formula to MathML; a malformed formula is replaced by its error message.
fn mathml(latex: &str) -> String {
    let storage = Storage::new();
    let config = RenderConfig {
        display_mode: DisplayMode::Block,
        ..RenderConfig::default()
    };
    let mut text = String::new();
    pulldown_latex::push_mathml(&mut text, Parser::new(latex, &storage), config)
        .expect("writing to a string cannot fail");
    text
}

fn found(finding: &Finding) -> Markup {
    match finding {
        Finding::Numbers { reading, numbers } => tabled(&number_table(reading, numbers)),
        Finding::Techniques {
            reading,
            techniques,
        } => tabled(&technique_table(reading, techniques)),
        Finding::Plots { plots } => plot::figures(plots),
        Finding::Figures {
            title,
            reading,
            figures,
        } => html! {
            h3 { (title) }
            p.caption { (prose(reading)) }
            div.figures { @for figure in figures { (shown(figure)) } }
        },
    }
}

fn tabled(table: &crate::report::table::Table) -> Markup {
    html! { h3 { (table.title) } p.caption { (prose(&table.caption)) } (table.html()) }
}

fn shown(figure: &Figure) -> Markup {
    page::figure(&figure.name, &figure.caption, &figure.image)
}

/// The additional styles of lessons.
const STYLE: &str = "
.text { max-width: 44rem; } .formula { margin: 1rem 0; max-width: 48rem; }
.math { overflow-x: auto; overflow-y: hidden; font-size: 1.2rem; padding: .2rem 0; }
math { font-family: 'Latin Modern Math', 'STIX Two Math', 'Cambria Math', math; }
.math > math { margin: 0 auto; }
.way { display: flex; flex-wrap: wrap; justify-content: space-between; gap: .2rem 1rem; font-size: .9rem; }
.way a { margin: 0; } .foot { margin-top: 2.5rem; border-top: 1px solid var(--line); padding-top: .8rem; }
.contents li { margin: .5rem 0; } td:first-child { min-width: 6.5rem; }
@media (max-width: 40rem) { table { font-size: .8rem; } th, td { padding-right: .5rem; } .math { font-size: 1rem; } }
";
