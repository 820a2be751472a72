//! Bar charts for HTML pages: groups of bars on one scale, and a stacked bar. Plain HTML and CSS, no script.
//!
//! Measure: the unit of the values, stated in the texts beside the bars; lengths are fractions of the longest bar.
//! Range: values from 0 up; a non-finite or negative value has length 0. `HUES` colours, which repeat.
//! Source: colours by Okabe and Ito 2008, distinguishable for colour-blind people, and lighter on a dark background;
//! every bar has a label, so that colour is never needed. Tested below.

use maud::{Markup, html};

/// The number of distinct colours.
pub const HUES: usize = 7;

/// The maximum width of a chart relative to its longest bar; whiskers beyond it are cut.
const MAX_WIDTH: f64 = 2.0;

/// A bar.
#[derive(Debug, Clone)]
pub struct Bar {
    /// The label before the bar.
    pub label: String,
    /// The value, which is its length.
    pub value: f64,
    /// The ends of its whisker.
    pub range: Option<[f64; 2]>,
    /// The text after the bar: the number with its unit.
    pub text: String,
    /// The colour.
    pub hue: usize,
}

/// A group of bars below a heading.
#[derive(Debug, Clone)]
pub struct Group {
    /// The heading; none if empty.
    pub name: String,
    /// The bars.
    pub bars: Vec<Bar>,
}

/// Builds groups of bars on one scale, which starts at 0.
pub fn bars(groups: &[Group]) -> Markup {
    let all = || groups.iter().flat_map(|group| &group.bars);
    let finite = |longest: f64, value: f64| {
        if value.is_finite() {
            longest.max(value)
        } else {
            longest
        }
    };
    let longest = all().map(|bar| bar.value).fold(0.0, finite);
    let farthest = all()
        .filter_map(|bar| bar.range)
        .map(|[_, end]| end)
        .fold(longest, finite);
    let scale = farthest.min(MAX_WIDTH * longest);
    html! {
        div.chart {
            @for group in groups {
                @if !group.name.is_empty() { div.group { (group.name) } }
                @for bar in &group.bars {
                    div.row {
                        div.label { (bar.label) }
                        div.track aria-hidden="true" {
                            div class=(hue("bar", bar.hue)) style=(width(share(bar.value, scale))) {}
                            @if let Some([start, end]) = bar.range { (whisker(share(start, scale), share(end, scale))) }
                        }
                        div.value { (bar.text) }
                    }
                }
            }
        }
    }
}

fn whisker(start: f64, end: f64) -> Markup {
    html! {
        div.whisker style={ "left:" (percent(start)) ";" (width((end - start).max(0.0))) } {}
    }
}

/// A part of a stacked bar.
#[derive(Debug, Clone)]
pub struct BarPart {
    /// The label.
    pub label: String,
    /// The value, which is its length.
    pub value: f64,
    /// The number with its unit.
    pub text: String,
    /// The colour.
    pub hue: usize,
}

/// Builds a stacked bar with its legend.
pub fn stack(parts: &[BarPart]) -> Markup {
    let whole: f64 = parts.iter().map(|part| part.value.max(0.0)).sum();
    html! {
        div.stack aria-hidden="true" {
            @for part in parts {
                div class=(hue("part", part.hue)) style=(width(share(part.value, whole))) {}
            }
        }
        ul.legend {
            @for part in parts {
                li {
                    span class=(hue("key", part.hue)) {} " "
                    (part.label) ": " span.value { (part.text) ", " (format!("{:.0} %", 100.0 * share(part.value, whole))) }
                }
            }
        }
    }
}

fn hue(class: &str, hue: usize) -> String {
    format!("{class} hue-{}", hue % HUES)
}

/// Returns `value / whole` clamped to `[0, 1]`; 0 if it is not finite.
fn share(value: f64, whole: f64) -> f64 {
    let share = value / whole;
    if share.is_finite() {
        share.clamp(0.0, 1.0)
    } else {
        0.0
    }
}

fn percent(share: f64) -> String {
    format!("{:.2}%", 100.0 * share)
}

fn width(share: f64) -> String {
    format!("width:{}", percent(share))
}

/// The style sheet of charts; it needs [`super::page::STYLE`], which defines the colours.
pub const STYLE: &str = "
.chart { display: grid; grid-template-columns: 17rem minmax(6rem, 1fr) max-content; align-items: center;
  gap: .4rem .75rem; margin: .75rem 0; }
.group { grid-column: 1 / -1; font-weight: 600; margin-top: .4rem; break-after: avoid; }
.row { display: contents; }
.row .track { position: relative; height: 1.1rem; background: var(--track); border-radius: 2px;
  overflow: hidden; }
.bar { height: 100%; border-radius: 2px; }
.whisker { position: absolute; top: 25%; height: 50%; box-sizing: border-box; min-width: 2px;
  border: solid var(--text); border-width: 0 1.5px; }
.whisker::before { content: \"\"; position: absolute; top: 50%; left: 0; right: 0; height: 1.5px; margin-top: -.75px;
  background: var(--text); }
.value { font-variant-numeric: tabular-nums; white-space: nowrap; }
.stack { display: flex; height: 1.8rem; margin: .75rem 0 .4rem; border-radius: 2px; overflow: hidden; }
.part { box-sizing: border-box; border-right: 1px solid var(--ground); }
.legend { list-style: none; display: flex; flex-wrap: wrap; gap: .2rem 1.5rem; padding: 0; margin: 0 0 .75rem; }
.key { display: inline-block; width: .8rem; height: .8rem; border-radius: 2px; }
.hue-0 { background: var(--hue-0); } .hue-1 { background: var(--hue-1); } .hue-2 { background: var(--hue-2); }
.hue-3 { background: var(--hue-3); } .hue-4 { background: var(--hue-4); } .hue-5 { background: var(--hue-5); }
.hue-6 { background: var(--hue-6); }
.bar, .part, .key, .track, .whisker { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
@media (max-width: 40rem) {
  .chart { display: block; }
  .row { display: flex; flex-wrap: wrap; align-items: center; gap: 0 .75rem; margin: .2rem 0 .4rem; break-inside: avoid; }
  .row .label { flex: 1 1 9rem; } .row .value { flex: 0 0 auto; } .row .track { flex: 1 0 100%; order: 1; }
}
";

#[cfg(test)]
mod tests {
    use super::*;

    fn bar(value: f64, range: Option<[f64; 2]>) -> Bar {
        Bar {
            label: "a<b".to_owned(),
            value,
            range,
            text: "7 ns".to_owned(),
            hue: HUES + 1,
        }
    }

    fn chart(bars_of_it: Vec<Bar>) -> String {
        let group = Group {
            name: "rays".to_owned(),
            bars: bars_of_it,
        };
        bars(&[group]).into_string()
    }

    #[test]
    fn bar_widths_are_relative_to_the_longest() {
        let html = chart(vec![bar(2.0, Some([1.0, 4.0])), bar(3.0, None)]);
        for expected in [
            "width:50.00%",
            "left:25.00%;width:75.00%",
            "width:75.00%",
            "bar hue-1",
            "a&lt;b",
            "7 ns",
            "rays",
        ] {
            assert!(html.contains(expected), "no {expected} in {html}");
        }
    }

    #[test]
    fn extreme_range_does_not_flatten_the_bars() {
        let html = chart(vec![bar(1.0, Some([1.0, 1000.0]))]);
        assert!(
            html.contains("width:50.00%") && html.contains("left:50.00%;width:50.00%"),
            "{html}"
        );
    }

    #[test]
    fn non_positive_and_non_finite_bars_have_zero_width() {
        for odd in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let html = chart(vec![bar(odd, Some([odd, odd]))]);
            assert!(
                html.contains("width:0.00%") && !html.contains("NaN"),
                "{html}"
            );
            assert!(!html.contains("inf"), "{html}");
        }
    }

    #[test]
    fn stacked_part_widths_are_shares_of_the_total() {
        let parts = [1.0, 3.0].map(|value| BarPart {
            label: "it".to_owned(),
            value,
            text: "1 ns".to_owned(),
            hue: 0,
        });
        let html = stack(&parts).into_string();
        for expected in ["width:25.00%", "width:75.00%", "1 ns, 75 %"] {
            assert!(html.contains(expected), "no {expected} in {html}");
        }
    }
}
