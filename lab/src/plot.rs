//! A plot as data: series of points on two axes. Its appearance is left to the code that draws it.
//!
//! Measure: the unit of each axis, given in its label.
//! Range: any numbers; values that are not finite, or not positive on a logarithmic axis, are not drawn.
//! Source: none needed. Drawn by `cli/src/report/plot/`, where it is tested.

use serde::Serialize;

/// A plot: series of points on two axes, with a title and a text on how to read it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plot {
    /// The title.
    pub title: String,
    /// Text on how to read the plot.
    pub reading: String,
    /// The shape of the frame.
    pub shape: AspectRatio,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The series in drawing order: the first one lies below the others.
    pub series: Vec<Series>,
}

/// The aspect ratio of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum AspectRatio {
    /// Wider than high, for curves.
    Wide,
    /// Square, for points of a plane.
    Square,
}

/// The scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// A logarithmic scale, marked at powers of ten.
    Log,
}

/// An axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    /// The quantity on the axis, with its unit.
    pub label: String,
    /// The scale of the axis.
    pub scale: Scale,
    /// Start and end of the axis; `None` fits all points.
    pub range: Option<[f64; 2]>,
    /// The marked values with their texts; empty for round numbers.
    pub ticks: Vec<(f64, String)>,
}

impl Axis {
    /// An axis with a linear scale.
    pub fn linear(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            scale: Scale::Linear,
            range: None,
            ticks: Vec::new(),
        }
    }

    /// An axis with a logarithmic scale (powers of ten).
    pub fn log(label: impl Into<String>) -> Self {
        Self {
            scale: Scale::Log,
            ..Self::linear(label)
        }
    }

    /// Marks these values, as far as they are within the axis's range.
    pub fn marked(self, ticks: Vec<(f64, String)>) -> Self {
        Self { ticks, ..self }
    }

    /// Restricts the axis to `start` to `end`.
    pub fn over(self, start: f64, end: f64) -> Self {
        Self {
            range: Some([start, end]),
            ..self
        }
    }
}

/// The way in which the points of a series are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Mark {
    /// A line through the points.
    Line,
    /// A line through the points, and a mark on each.
    Marks,
    /// A dashed line through the points: theory beside measurements.
    Guide,
    /// A dot on each point.
    Dots,
    /// A bar from zero up to each point; the points are evenly spaced.
    Bars,
}

/// A series of points.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Series {
    /// The name of the series.
    pub name: String,
    /// The way in which the points are drawn.
    pub mark: Mark,
    /// The index of the colour; related series have the same hue.
    pub hue: usize,
    /// The points (x, y), sorted by x if a line joins them.
    pub points: Vec<[f64; 2]>,
    /// The band of uncertainty around the points: (x, low, high).
    pub ribbon: Vec<[f64; 3]>,
    /// Texts at points, left out where there is no room.
    pub labels: Vec<Label>,
}

/// A text at a point.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Label {
    /// The point (x, y).
    pub point: [f64; 2],
    /// The text.
    pub text: String,
}

impl Series {
    /// A series without a ribbon.
    pub fn new(name: impl Into<String>, mark: Mark, hue: usize, points: Vec<[f64; 2]>) -> Self {
        Self {
            name: name.into(),
            mark,
            hue,
            points,
            ribbon: Vec::new(),
            labels: Vec::new(),
        }
    }

    /// Adds a ribbon.
    pub fn within(self, ribbon: Vec<[f64; 3]>) -> Self {
        Self { ribbon, ..self }
    }

    /// Adds labels.
    pub fn labelled(self, labels: Vec<Label>) -> Self {
        Self { labels, ..self }
    }

    /// Samples a function at evenly spaced places from `start` to `end`.
    pub fn curve(
        name: impl Into<String>,
        mark: Mark,
        hue: usize,
        [start, end]: [f64; 2],
        f: impl Fn(f64) -> f64,
    ) -> Self {
        let at = |step: u32| {
            let x = start + (end - start) * f64::from(step) / f64::from(CURVE_STEPS);
            [x, f(x)]
        };
        Self::new(name, mark, hue, (0..=CURVE_STEPS).map(at).collect())
    }
}

/// Number of segments of a curve: enough to look smooth.
const CURVE_STEPS: u32 = 240;
