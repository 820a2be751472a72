//! A comparison as it is reported: the metrics, the verdict and notes.
//!
//! Measure: as in `study/comparison.rs`.
//! Range: any comparison; non-finite numbers are `null` in JSON.
//! Source: docs/accuracy.md, "Comparing two images". Tested in `cli/tests/command/compare.rs`.

use crate::args::{CompareArguments, Metric};
use crate::output::format_percent;
use crate::report::lesson::significant;
use etendue_lab::study::bias_test::BiasTest;
use etendue_lab::study::comparison::Metrics;
use serde::Serialize;

/// The complete report.
#[derive(Debug, Serialize)]
pub struct CompareReport {
    /// The image file.
    pub image: String,
    /// The reference file.
    pub reference: String,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The metrics of the whole image.
    #[serde(flatten)]
    pub metrics: Metrics,
    /// The mean of FLIP, in builds that have it.
    pub flip: Option<f64>,
    /// The bias test, if it could be made.
    pub bias: Option<BiasTest>,
    /// The map, if one was written.
    pub map: Option<MapReport>,
    /// Caveats about the numbers.
    pub notes: Vec<String>,
    /// The verdict, for scripts.
    pub verdict: JudgedMetric,
}

/// A map that was written.
#[derive(Debug, Serialize)]
pub struct MapReport {
    /// The file.
    pub file: String,
    /// The relative error that the full colours stand for.
    pub scale: f64,
}

/// The metric that a comparison is judged by, its value and its tolerance.
#[derive(Debug, Serialize)]
pub struct JudgedMetric {
    metric: &'static str,
    value: f64,
    tolerance: Option<f64>,
    passed: bool,
}

impl JudgedMetric {
    /// Judges a comparison.
    pub fn of(arguments: &CompareArguments, metrics: &Metrics, flip: Option<f64>) -> Self {
        let value = match arguments.metric {
            Metric::RelRmse => metrics.rel_rmse,
            Metric::TrimmedRelRmse => metrics.trimmed_rel_mse.sqrt(),
            Metric::Rmse => metrics.rmse,
            Metric::Flip => flip.unwrap_or(f64::NAN),
        };
        let tolerance = arguments.tolerance;
        Self {
            metric: arguments.metric.name(),
            value,
            tolerance,
            // A NaN error exceeds every tolerance.
            passed: tolerance.is_none_or(|tolerance| value <= tolerance),
        }
    }
}

impl CompareReport {
    /// Whether the error is within the tolerance.
    pub fn passed(&self) -> bool {
        self.verdict.passed
    }

    /// Returns the report as one JSON object.
    pub fn to_json(&self) -> String {
        let json = serde_json::to_string_pretty(self).expect("plain data always serialises");
        json + "\n"
    }

    /// Returns the lines that are printed besides the tables.
    pub fn notes(&self) -> Vec<String> {
        let notes = self.notes.iter().map(|note| format!("note: {note}"));
        let map = self.map.iter();
        let map = map.map(|map| format!("{}: {}", map.file, map.legend()));
        let verdict = &self.verdict;
        let judged = verdict.tolerance.map(|tolerance| {
            let is = if verdict.passed { "within" } else { "above" };
            let number = match verdict.metric {
                name if name == Metric::Rmse.name() => |x| significant(x, 5),
                _ => |x| format_percent(x),
            };
            format!(
                "{} {} is {is} the tolerance {}",
                verdict.metric,
                number(verdict.value),
                number(tolerance)
            )
        });
        notes.chain(map).chain(judged).collect()
    }
}

impl MapReport {
    /// Describes the colours of the map.
    pub fn legend(&self) -> String {
        let scale = significant(self.scale, 3);
        format!(
            "relative error, (x - r) / sqrt(r^2 + eps) over all channels, from -{scale} (blue, too dark) over 0 \
             (white) to {scale} (red, too bright)"
        )
    }
}
