//! The frame of a plot, which places points.
//!
//! Measure: the units of the axes; positions in units of the frame, from its upper left corner.
//! Range: any plot.
//! Source: none needed. Tested in `mod.rs`.

use super::scale::Ruler;
use etendue_lab::plot::{AspectRatio, Mark, Plot};

/// The frame of a plot: its inner size and its axes.
pub struct PlotFrame {
    pub width: f64,
    pub height: f64,
    pub x: Ruler,
    pub y: Ruler,
}

impl PlotFrame {
    /// Creates the frame of a plot.
    pub fn new(plot: &Plot) -> Self {
        let (width, height) = match plot.shape {
            AspectRatio::Wide => (482.0, 260.0),
            AspectRatio::Square => (300.0, 300.0),
        };
        let points = || plot.series.iter().flat_map(|series| &series.points);
        let ribbons = || plot.series.iter().flat_map(|series| &series.ribbon);
        let floor = plot.series.iter().any(|series| series.mark == Mark::Bars);
        let xs = points().map(|p| p[0]).chain(ribbons().map(|r| r[0]));
        let ys = points().map(|p| p[1]);
        let ys = ys
            .chain(ribbons().flat_map(|r| [r[1], r[2]]))
            .chain(floor.then_some(0.0));
        Self {
            width,
            height,
            x: Ruler::new(&plot.x, false, xs),
            y: Ruler::new(&plot.y, floor, ys),
        }
    }

    /// Returns the position of a point; `None` if it has none.
    pub fn at(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let (x, y) = (self.x.place(x)?, self.y.place(y)?);
        Some([x * self.width, (1.0 - y) * self.height])
    }
}

/// Rounds to a tenth of a unit, which is below visibility.
pub fn round(x: f64) -> f64 {
    (x * 10.0).round() / 10.0
}
