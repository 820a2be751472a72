//! Plots for HTML pages: lines, dots, bars and ribbons on two axes, as SVG that follows the page's light or dark
//! scheme.
//!
//! SVG is written directly, because plotters 0.3.7 is unsuitable: it rounds positions to whole pixels, so that enlarged
//! curves have kinks; it clamps points outside an axis to its edge, where they look measured; its labels overlap the
//! axis's name; and its legend covers the data.
//!
//! Measure: that of the axes; lengths in units of the frame, which scales to the available width.
//! Range: any plot; points without a position on an axis are left out, parts outside the frame are clipped.
//! Source: SVG 2. Colours as in `chart.rs`; marks also differ in shape and guides are dashed, so that colour is never
//! needed to tell series apart. Tested below.

mod frame;
mod labels;
mod scale;

use super::chart::HUES;
use super::prose::prose;
use etendue_lab::plot::{AspectRatio, Mark, Plot, Series};
use frame::{PlotFrame, round};
use maud::{Markup, html};
pub use scale::superscript;
use std::fmt::Write;

/// The margins for labels around the frame, in its units.
const LEFT: f64 = 60.0;
const RIGHT: f64 = 18.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 56.0;

/// Half of the width of a digit of a label on a phone, where letters are largest.
const HALF_OF_A_DIGIT: f64 = 4.2;

/// The number of dots above which they are drawn small.
const MAX_LARGE_DOTS: usize = 200;

/// Builds a plot with its title, its legend and its caption.
pub fn figure(plot: &Plot) -> Markup {
    let named = plot.series.iter().filter(|series| !series.name.is_empty());
    let class = match plot.shape {
        AspectRatio::Wide => "plot",
        AspectRatio::Square => "plot square",
    };
    html! {
        figure class=(class) {
            figcaption { strong { (prose(&plot.title)) } }
            ul.keys { @for series in named { li { (key(series)) (series.name) } } }
            (svg(plot))
            p.caption { (prose(&plot.reading)) }
        }
    }
}

/// Builds several plots, side by side if there is room.
pub fn figures(plots: &[Plot]) -> Markup {
    let squares = plots.iter().all(|plot| plot.shape == AspectRatio::Square);
    let class = if squares { "plots squares" } else { "plots" };
    html! { div class=(class) { @for plot in plots { (figure(plot)) } } }
}

fn svg(plot: &Plot) -> Markup {
    let frame = PlotFrame::new(plot);
    let (width, height) = (frame.width + LEFT + RIGHT, frame.height + TOP + BOTTOM);
    let bottom = TOP + frame.height;
    html! {
        svg viewBox=(format!("0 0 {width} {height}")) role="img" aria-label=(plot.title) {
            @for tick in frame.y.ticks() {
                @let y = bottom - tick.place * frame.height;
                line.grid x1=(LEFT) x2=(LEFT + frame.width) y1=(round(y)) y2=(round(y)) {}
                text.up x=(LEFT - 8.0) y=(round(y)) { (tick.label) }
            }
            @for tick in frame.x.ticks() {
                @let x = LEFT + tick.place * frame.width;
                line.grid x1=(round(x)) x2=(round(x)) y1=(TOP) y2=(bottom) {}
                // A long label at the end of the axis would be cut.
                @let middle = x.min(width - HALF_OF_A_DIGIT * tick.label.chars().count() as f64);
                text.along x=(round(middle)) y=(bottom + 20.0) { (tick.label) }
            }
            text.name x="2" y="16" { (plot.y.label) }
            text.name.end x=(LEFT + frame.width) y=(height - 8.0) { (plot.x.label) }
            svg x=(LEFT) y=(TOP) width=(frame.width) height=(frame.height) {
                @for series in &plot.series { (drawn(series, &frame)) }
                (labels::drawn(&plot.series, &frame))
            }
            path.axes d=(format!("M{LEFT} {TOP}V{bottom}H{}", LEFT + frame.width)) {}
        }
    }
}

fn drawn(series: &Series, frame: &PlotFrame) -> Markup {
    let class = format!("series-{}", series.hue % HUES);
    html! {
        g class=(class) {
            @if !series.ribbon.is_empty() { path.ribbon d=(ribbon(series, frame)) {} }
            @match series.mark {
                Mark::Line => { path.line d=(line(series, frame)) {} }
                Mark::Guide => { path.line.guide d=(line(series, frame)) {} }
                Mark::Marks => {
                    path.line d=(line(series, frame)) {}
                    path.mark d=(marks(series, frame)) {}
                }
                Mark::Dots if series.points.len() > MAX_LARGE_DOTS => { path.dot.small d=(dots(series, frame)) {} }
                Mark::Dots => { path.dot d=(dots(series, frame)) {} }
                Mark::Bars => { path.bars d=(bars(series, frame)) {} }
            }
        }
    }
}

/// Builds the legend entry of a series.
fn key(series: &Series) -> Markup {
    let class = format!("series-{}", series.hue % HUES);
    let ribbon = !series.ribbon.is_empty();
    html! {
        svg.key-mark viewBox="0 0 28 14" aria-hidden="true" {
            g class=(class) {
                @if ribbon { path.ribbon d="M0 1H28V13H0Z" {} }
                @match series.mark {
                    Mark::Line => { path.line d="M0 7H28" {} }
                    Mark::Guide => { path.line.guide d="M0 7H28" {} }
                    Mark::Marks => {
                        path.line d="M0 7H28" {}
                        path.mark d=(mark(series.hue, [14.0, 7.0])) {}
                    }
                    Mark::Dots => { path.dot d="M14 7h0" {} }
                    Mark::Bars => { path.bars d="M8 1H20V13H8Z" {} }
                }
            }
        }
    }
}

fn line(series: &Series, frame: &PlotFrame) -> String {
    let mut path = String::new();
    let mut pen_down = false;
    for &[x, y] in &series.points {
        // A point without a position leaves a gap.
        let Some(point) = frame.at(x, y) else {
            pen_down = false;
            continue;
        };
        push(&mut path, if pen_down { 'L' } else { 'M' }, point);
        pen_down = true;
    }
    path
}

fn ribbon(series: &Series, frame: &PlotFrame) -> String {
    let there = series
        .ribbon
        .iter()
        .filter_map(|&[x, _, high]| frame.at(x, high));
    let back = series
        .ribbon
        .iter()
        .rev()
        .filter_map(|&[x, low, _]| frame.at(x, low));
    let mut path = String::new();
    for (index, point) in there.chain(back).enumerate() {
        push(&mut path, if index == 0 { 'M' } else { 'L' }, point);
    }
    path + "Z"
}

fn dots(series: &Series, frame: &PlotFrame) -> String {
    let mut path = String::new();
    for point in series.points.iter().filter_map(|&[x, y]| frame.at(x, y)) {
        push(&mut path, 'M', point);
        path += "h0";
    }
    path
}

fn marks(series: &Series, frame: &PlotFrame) -> String {
    let points = series.points.iter().filter_map(|&[x, y]| frame.at(x, y));
    points.map(|point| mark(series.hue, point)).collect()
}

/// Returns the path of a marker around a point: one of four shapes, by the hue.
fn mark(hue: usize, [x, y]: [f64; 2]) -> String {
    let (x, y) = (round(x), round(y));
    match hue % 4 {
        0 => format!("M{x} {y}m-3.5 0a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0 -7 0z"),
        1 => format!("M{x} {y}m-3.2 -3.2h6.4v6.4h-6.4z"),
        2 => format!("M{x} {y}m0 -4.6l4.4 7.6h-8.8z"),
        _ => format!("M{x} {y}m0 -4.6l4.6 4.6l-4.6 4.6l-4.6 -4.6z"),
    }
}

fn bars(series: &Series, frame: &PlotFrame) -> String {
    let step = match series.points.as_slice() {
        [first, second, ..] => second[0] - first[0],
        _ => 1.0,
    };
    // Few bars have gaps, as for discrete values; many bars touch, as in a histogram.
    let half = if series.points.len() > 12 { 0.5 } else { 0.35 } * step;
    let mut path = String::new();
    for &[x, y] in &series.points {
        if let (Some([left, top]), Some([right, floor])) =
            (frame.at(x - half, y), frame.at(x + half, 0.0))
        {
            let [left, top, right, floor] = [left, top, right, floor].map(round);
            write!(path, "M{left} {floor}V{top}H{right}V{floor}Z").expect(WRITES);
        }
    }
    path
}

const WRITES: &str = "writing to a string cannot fail";

fn push(path: &mut String, command: char, [x, y]: [f64; 2]) {
    write!(path, "{command}{} {}", round(x), round(y)).expect(WRITES);
}

/// The style sheet of plots; it needs [`super::page::STYLE`], which defines the colours.
pub const STYLE: &str = "
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 21rem), 1fr)); gap: 0 2rem; }
.squares { grid-template-columns: repeat(auto-fit, minmax(min(100%, 15rem), 1fr)); } .plot.square { max-width: 22rem; }
.plot { margin: 1rem 0; max-width: 44rem; min-width: 0; container-type: inline-size; break-inside: avoid; }
.plot > svg { display: block; width: 100%; height: auto; }
.plot text { fill: var(--text); font: 15px system-ui, sans-serif; font-variant-numeric: tabular-nums; }
@container (min-width: 34rem) { .plot text { font-size: 12.5px; } }
.plot .up { text-anchor: end; dominant-baseline: central; } .plot .along { text-anchor: middle; }
.plot .name { fill: var(--faint); } .plot .end { text-anchor: end; }
.plot .grid { stroke: var(--line); stroke-width: .7; } .plot .axes { fill: none; stroke: var(--faint); stroke-width: 1.2; }
.plot .line { fill: none; stroke: currentColor; stroke-width: 2; stroke-linejoin: round; }
.plot .guide { stroke-dasharray: 6 4; stroke-width: 1.3; }
.plot .mark, .plot .bars { fill: currentColor; } .plot .bars { fill-opacity: .55; stroke: none; }
.plot .dot { fill: none; stroke: currentColor; stroke-width: 6; stroke-linecap: round; } .plot .small { stroke-width: 2.4; }
.plot .label { fill: currentColor; font-weight: 600; paint-order: stroke; stroke: var(--ground); stroke-width: 4; }
.plot .ribbon { fill: currentColor; fill-opacity: .16; stroke: none; }
.keys { list-style: none; display: flex; flex-wrap: wrap; gap: .1rem 1.2rem; padding: 0; margin: .2rem 0 .4rem; font-size: .9rem; }
.key-mark { width: 28px; height: 14px; margin-right: .4rem; vertical-align: -1px; }
.series-0 { color: var(--hue-0); } .series-1 { color: var(--hue-1); } .series-2 { color: var(--hue-2); }
.series-3 { color: var(--hue-3); } .series-4 { color: var(--hue-4); } .series-5 { color: var(--hue-5); }
.series-6 { color: var(--hue-6); }
";

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_lab::plot::Axis;

    fn plot(mark: Mark, points: Vec<[f64; 2]>) -> Plot {
        Plot {
            title: "a < b".to_owned(),
            reading: "Read `it`.".to_owned(),
            shape: AspectRatio::Square,
            x: Axis::linear("x").over(0.0, 1.0),
            y: Axis::log("y").over(1.0, 100.0),
            series: vec![Series::new("s & t", mark, HUES + 1, points)],
        }
    }

    #[test]
    fn points_map_to_axis_coordinates() {
        let html = figure(&plot(
            Mark::Line,
            vec![[0.0, 1.0], [0.5, 10.0], [1.0, 100.0]],
        ));
        let html = html.into_string();
        for expected in [
            "d=\"M0 300L150 150L300 0\"",
            "series-1",
            "a &lt; b",
            "s &amp; t",
            "<code>it</code>",
        ] {
            assert!(html.contains(expected), "no {expected} in {html}");
        }
    }

    #[test]
    fn labels_end_within_the_picture() {
        let mut plot = plot(Mark::Line, vec![[0.0, 1.0], [1.0, 100.0]]);
        plot.x.ticks = vec![(0.5, "10 years".to_owned()), (1.0, "100 years".to_owned())];
        let html = figure(&plot).into_string();
        let place = |label: &str| {
            let (before, _) = html.split_once(&format!(">{label}<")).expect("a label");
            let (_, x) = before.rsplit_once(" x=\"").expect("its place");
            let (x, _) = x.split_once('"').expect("a number");
            x.parse::<f64>().expect("a number")
        };
        assert_eq!(place("10 years"), LEFT + 150.0);
        let end = place("100 years") + 9.0 * HALF_OF_A_DIGIT;
        assert!(end <= LEFT + 300.0 + RIGHT + 0.1, "{end}");
    }

    #[test]
    fn undrawable_points_leave_a_gap_in_the_line() {
        let points = vec![[0.0, 1.0], [0.25, 0.0], [0.5, f64::NAN], [1.0, 100.0]];
        for mark in [Mark::Line, Mark::Marks, Mark::Guide, Mark::Dots, Mark::Bars] {
            let html = figure(&plot(mark, points.clone())).into_string();
            assert!(!html.contains("NaN") && !html.contains("inf"), "{html}");
        }
        let html = figure(&plot(Mark::Line, points)).into_string();
        assert!(html.contains("d=\"M0 300M300 0\""), "{html}");
    }

    #[test]
    fn points_outside_the_axes_are_not_clamped() {
        let html = figure(&plot(Mark::Line, vec![[0.5, 1.0], [2.0, 100.0]]));
        assert!(html.into_string().contains("d=\"M150 300L600 0\""));
    }

    #[test]
    fn ribbon_is_drawn_as_a_closed_path() {
        let mut plot = plot(Mark::Guide, vec![]);
        plot.series[0].ribbon = vec![[0.0, 1.0, 10.0], [1.0, 10.0, 100.0]];
        let html = figure(&plot).into_string();
        assert!(html.contains("M0 150L300 0L300 150L0 300Z"), "{html}");
    }
}
