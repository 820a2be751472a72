//! A plot as data: series of points on two axes. How it looks is for whoever draws it.
//!
//! Measure: that of each axis, which its label names.
//! Range: any numbers; those that are not finite, or not positive on a logarithmic axis, are not drawn.
//! Source: none needed. Drawn by `cli/src/report/plot/`, where it is tested.

use serde::Serialize;

/// Series of points on two axes, with what to read from them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plot {
    /// What is shown.
    pub title: String,
    /// How to read it.
    pub reading: String,
    /// The shape of its frame.
    pub shape: Shape,
    /// The axis to the right.
    pub x: Axis,
    /// The axis upwards.
    pub y: Axis,
    /// What is drawn, the first one below the others.
    pub series: Vec<Series>,
}

/// The shape of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Shape {
    /// Wider than high: curves.
    Wide,
    /// As wide as high: points of a plane.
    Square,
}

/// How an axis is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By powers of ten.
    Log,
}

/// An axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    /// What it measures, with its unit.
    pub label: String,
    /// How it is divided.
    pub scale: Scale,
    /// From where to where it runs; `None` runs over all points.
    pub range: Option<[f64; 2]>,
}

impl Axis {
    /// An axis that is divided evenly.
    pub fn linear(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            scale: Scale::Linear,
            range: None,
        }
    }

    /// An axis that is divided by powers of ten.
    pub fn log(label: impl Into<String>) -> Self {
        Self {
            scale: Scale::Log,
            ..Self::linear(label)
        }
    }

    /// The same axis from `start` to `end`.
    pub fn over(self, start: f64, end: f64) -> Self {
        Self {
            range: Some([start, end]),
            ..self
        }
    }
}

/// How the points of a series are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Mark {
    /// A line through them.
    Line,
    /// A line through them, and a mark on each.
    Marks,
    /// A dashed line through them: theory beside what was measured.
    Guide,
    /// A dot on each.
    Dots,
    /// A bar from zero up to each; they are evenly spaced.
    Bars,
}

/// Points that belong together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Series {
    /// What they are.
    pub name: String,
    /// How they are drawn.
    pub mark: Mark,
    /// Its colour; series of one hue belong together.
    pub hue: usize,
    /// The points (x, y), by x where a line joins them.
    pub points: Vec<[f64; 2]>,
    /// Around them, (x, low, high): how far they can be trusted.
    pub ribbon: Vec<[f64; 3]>,
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
        }
    }

    /// The same series with a ribbon.
    pub fn within(self, ribbon: Vec<[f64; 3]>) -> Self {
        Self { ribbon, ..self }
    }

    /// A function at evenly spaced places from `start` to `end`.
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

/// Pieces of a curve: short enough to look smooth.
const CURVE_STEPS: u32 = 240;
