//! Texts at points of a plot, where there is room for them.
//!
//! Measure: units of the frame.
//! Range: any labels; one that would cover another or leave the frame in every place is left out. The places are the four corners
//! of the point, then those farther aside; one that no line runs through is preferred.
//! Source: none needed. Tested below.

use super::frame::{PlotFrame, round};
use crate::report::chart::HUES;
use etendue_lab::plot::Series;
use maud::{Markup, html};

/// The height of a text, and the width of one bold character, at the font size of narrow pages.
const HEIGHT: f64 = 16.0;
const WIDTH: f64 = 9.7;

/// The distances between a point and its text, to the side and up or down.
const AWAY: [f64; 2] = [7.0, 2.0];

/// The places at each corner: their number, and the distance from one to the next.
const PLACES: u32 = 24;
const STEP: f64 = 8.0;

/// A placed text.
struct PlacedLabel<'a> {
    text: &'a str,
    hue: usize,
    /// The left end of its base line.
    at: [f64; 2],
    /// Left, top, right, bottom.
    area: [f64; 4],
}

/// Draws the labels of all series.
pub fn drawn(series: &[Series], frame: &PlotFrame) -> Markup {
    html! {
        @for placed in placed(series, frame) {
            g class=(format!("series-{}", placed.hue % HUES)) {
                text.label x=(round(placed.at[0])) y=(round(placed.at[1])) { (placed.text) }
            }
        }
    }
}

fn placed<'a>(series: &'a [Series], frame: &PlotFrame) -> Vec<PlacedLabel<'a>> {
    let mut all: Vec<PlacedLabel<'a>> = Vec::new();
    let lines = lines(series, frame);
    for (hue, text, point) in from_left_to_right(series, frame) {
        let width = WIDTH * text.chars().count() as f64;
        let is_free = |area: &[f64; 4]| {
            let [left, top, right, bottom] = *area;
            let is_inside =
                left >= 0.0 && top >= 0.0 && right <= frame.width && bottom <= frame.height;
            is_inside && all.iter().all(|other| !overlap(area, &other.area))
        };
        let free: Vec<[f64; 4]> = areas(point, width).filter(is_free).collect();
        let is_beside_lines = |area: &&[f64; 4]| !lines.iter().any(|line| meets(line, area));
        let area = free.iter().find(is_beside_lines).or(free.first()).copied();
        all.extend(area.map(|area| PlacedLabel {
            text,
            hue,
            at: [area[0], area[3] - 0.25 * HEIGHT],
            area,
        }));
    }
    all
}

/// The areas for a text of this width at a point: the preferred one first.
fn areas([x, y]: [f64; 2], width: f64) -> impl Iterator<Item = [f64; 4]> {
    (0..PLACES).flat_map(move |place| {
        let aside = AWAY[0] + f64::from(place) * STEP;
        let (left, right) = (x - aside - width, x + aside);
        let (above, below) = (y - AWAY[1] - HEIGHT, y + AWAY[1]);
        let corners = [(right, above), (left, below), (right, below), (left, above)];
        corners.map(|(left, top)| [left, top, left + width, top + HEIGHT])
    })
}

/// The hue, text and point of each label, by x: beside lines that cross one level, labels then have the order of the lines.
fn from_left_to_right<'a>(
    series: &'a [Series],
    frame: &PlotFrame,
) -> Vec<(usize, &'a str, [f64; 2])> {
    let labels = series
        .iter()
        .flat_map(|series| series.labels.iter().map(|label| (series.hue, label)));
    let placed = labels.filter_map(|(hue, label)| {
        let point = frame.at(label.point[0], label.point[1])?;
        Some((hue, label.text.as_str(), point))
    });
    let mut sorted: Vec<_> = placed.collect();
    sorted.sort_by(|(.., a), (.., b)| a[0].total_cmp(&b[0]));
    sorted
}

/// The lines between the points of all series.
fn lines(series: &[Series], frame: &PlotFrame) -> Vec<[[f64; 2]; 2]> {
    let pairs = series.iter().flat_map(|series| series.points.windows(2));
    let ends = pairs.map(|pair| pair.iter().map(|p| frame.at(p[0], p[1])).collect());
    let ends = ends.filter_map(|ends: Option<Vec<_>>| ends?.try_into().ok());
    ends.collect()
}

/// Whether a line runs through an area (Liang and Barsky 1984).
fn meets([from, to]: &[[f64; 2]; 2], area: &[f64; 4]) -> bool {
    let (mut start, mut end) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let (first, last) = (area[axis] - from[axis], area[axis + 2] - from[axis]);
        let along = to[axis] - from[axis];
        if along == 0.0 {
            if first > 0.0 || last < 0.0 {
                return false;
            }
            continue;
        }
        let (enters, leaves) = (first / along, last / along);
        start = start.max(enters.min(leaves));
        end = end.min(enters.max(leaves));
    }
    start <= end
}

fn overlap(a: &[f64; 4], b: &[f64; 4]) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_lab::plot::{AspectRatio, Axis, Label, Mark, Plot};

    /// A plot of the unit square.
    fn square(series: Vec<Series>) -> Plot {
        Plot {
            title: String::new(),
            reading: String::new(),
            shape: AspectRatio::Square,
            x: Axis::linear("x").over(0.0, 1.0),
            y: Axis::linear("y").over(0.0, 1.0),
            series,
        }
    }

    fn labels(points: &[[f64; 2]]) -> Vec<[f64; 4]> {
        labels_beside(points, vec![])
    }

    /// The areas of labels at points, beside a line.
    fn labels_beside(points: &[[f64; 2]], line: Vec<[f64; 2]>) -> Vec<[f64; 4]> {
        let labels = points.iter().map(|&point| Label {
            point,
            text: "1 min".to_owned(),
        });
        let series = Series::new("s", Mark::Line, 0, line).labelled(labels.collect());
        let plot = square(vec![series]);
        let frame = PlotFrame::new(&plot);
        placed(&plot.series, &frame)
            .iter()
            .map(|it| it.area)
            .collect()
    }

    #[test]
    fn labels_do_not_overlap() {
        let areas = labels(&[[0.5, 0.5]; 6]);
        assert_eq!(areas.len(), 6);
        for (index, a) in areas.iter().enumerate() {
            assert!(areas[..index].iter().all(|b| !overlap(a, b)));
        }
    }

    #[test]
    fn labels_avoid_lines() {
        let rising = vec![[0.0, 0.0], [1.0, 1.0]];
        let free = labels_beside(&[[0.5, 0.5]], vec![])[0];
        let beside = labels_beside(&[[0.5, 0.5]], rising.clone())[0];
        let line = [[0.0, 300.0], [300.0, 0.0]];
        assert!(meets(&line, &free) && !meets(&line, &beside));
        // Better across a line than not at all.
        let crossed = vec![[0.0, 0.4], [1.0, 0.6], [1.0, 0.4], [0.0, 0.6]];
        assert_eq!(labels_beside(&[[0.5, 0.5]], crossed).len(), 1);
        assert!(!meets(&[[0.0, 0.0], [0.0, 9.0]], &[1.0, 0.0, 2.0, 9.0]));
    }

    #[test]
    fn labels_of_near_lines_are_beside_them_in_their_order() {
        let line = |start: f64| {
            let points = vec![[start, 1.0], [start + 0.8, 0.0]];
            let label = Label {
                point: [start + 0.4, 0.5],
                text: "1 s".to_owned(),
            };
            Series::new("s", Mark::Line, 0, points).labelled(vec![label])
        };
        // The order of the series is not that of their lines.
        let series = [0.1, 0.0, 0.05].map(line).to_vec();
        let frame = PlotFrame::new(&square(series.clone()));
        let areas: Vec<_> = placed(&series, &frame).iter().map(|it| it.area).collect();
        let lines = lines(&series, &frame);
        assert_eq!((areas.len(), lines.len()), (3, 3));
        for area in &areas {
            assert!(!lines.iter().any(|line| meets(line, area)), "{areas:?}");
        }
        assert!(areas.is_sorted_by(|a, b| a[0] < b[0]), "{areas:?}");
    }

    #[test]
    fn labels_stay_inside_the_frame() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        let areas = labels(&corners);
        assert_eq!(areas.len(), 4);
        let inside = |a: &[f64; 4]| a[0] >= 0.0 && a[1] >= 0.0 && a[2] <= 300.0 && a[3] <= 300.0;
        assert!(areas.iter().all(inside), "{areas:?}");
        assert!(labels(&[[f64::NAN, 0.5]]).is_empty());
    }
}
