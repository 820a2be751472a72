//! A comparison as tables: the whole image, its channels, its worst tiles.
//!
//! Measure: stated in the tables.
//! Range: any report.
//! Source: docs/accuracy.md, "Comparing two images". Tested in `cli/tests/command/compare.rs`.

use super::json::CompareReport;
use crate::output::format_percent;
use crate::report::lesson::significant;
use crate::report::table::{Table, numbers, words};
use etendue_lab::study::bias_test::{BiasTest, ChannelTest, POWER, SIGNIFICANCE};

/// The number of worst tiles that are listed.
const WORST_TILES: usize = 5;

const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// Returns all tables as Markdown.
pub fn markdown(report: &CompareReport) -> String {
    let mut tables = vec![whole(report), channels(report)];
    if !report.metrics.tiles.is_empty() {
        tables.push(worst_tiles(report));
    }
    tables.iter().map(|table| table.markdown(3)).collect()
}

fn whole(report: &CompareReport) -> Table {
    let metrics = &report.metrics;
    let row =
        |name: &str, value: String, meaning: &str| vec![name.to_owned(), value, meaning.to_owned()];
    let trimmed = metrics.trimmed_rel_mse;
    let mut rows = vec![
        row(
            "rel-rmse",
            format_percent(metrics.rel_rmse),
            "root of relMSE, as in `render --error`",
        ),
        row(
            "trimmed-rel-rmse",
            format_percent(trimmed.sqrt()),
            "without the worst 0.1 % of the pixels",
        ),
        row(
            "relMSE",
            significant(metrics.rel_mse, 5),
            "mean of (x - r)^2 / (r^2 + eps)",
        ),
        row(
            "trimmed relMSE",
            significant(trimmed, 5),
            "without the worst 0.1 % of the pixels",
        ),
        row(
            "rmse",
            significant(metrics.rmse, 5),
            "in units of the pixels",
        ),
        row("MSE", significant(metrics.mse, 5), "its square"),
    ];
    if let Some(noise) = metrics.reference_noise {
        let meaning = "its part of rel-rmse: squares add up";
        let noise = format_percent(noise.sqrt());
        rows.push(row("noise of the reference", noise, meaning));
    }
    if let Some(flip) = report.flip {
        let meaning = "perceived difference, from 0 to 1";
        rows.push(row("flip", significant(flip, 4), meaning));
    }
    Table {
        title: format!("{} against {}", report.image, report.reference),
        caption: format!(
            "{} x {} pixels. Lower is better.",
            report.width, report.height
        ),
        head: vec![words("error"), numbers("value"), words("meaning")],
        rows,
    }
}

fn channels(report: &CompareReport) -> Table {
    let bias = report.bias.as_ref();
    let rows = CHANNELS.iter().enumerate().map(|(c, name)| {
        let difference = format_percent(report.metrics.mean_differences[c]);
        let mut row = vec![(*name).to_owned(), difference];
        if let Some(bias) = bias {
            row.extend(test_cells(&bias.channels[c]));
        }
        row
    });
    let mut head = vec![words("channel"), numbers("difference")];
    if bias.is_some() {
        let tested = ["tested", "standard error", "p", "detectable"];
        head.extend(tested.map(numbers));
    }
    Table {
        title: "Means".to_owned(),
        caption: bias.map_or_else(without_test, describe_bias),
        head,
        rows: rows.collect(),
    }
}

/// Returns the table cells of a bias test: difference of the means, its standard error, p and the detectable
/// difference.
fn test_cells(channel: &ChannelTest) -> [String; 4] {
    let means = &channel.means;
    [
        format_percent(means.relative()),
        format_percent(means.relative_error()),
        significant(means.p, 2),
        format_percent(channel.detectable),
    ]
}

fn without_test() -> String {
    "Relative to those of the reference. They are not tested for bias: that requires standard errors that are not \
     flagged, from `etendue render --layers`."
        .to_owned()
}

fn describe_bias(bias: &BiasTest) -> String {
    let found = if bias.is_found() {
        "**The images converge to different limits**"
    } else {
        "No bias was found"
    };
    let tile = &bias.worst_tile;
    format!(
        "{found}: p = {} for the three means, and p = {} for {} means over tiles, of which the worst is {} at {}, {} \
         ({} +- {}). The {} of the pixels that are not flagged are tested. The last column is the difference that \
         such a test detects with a probability of {} (in half of the tiles: {}); its false positive rate is {}.",
        significant(bias.p, 2),
        significant(bias.tiles_p, 2),
        bias.tile_tests,
        CHANNELS[tile.channel],
        tile.tile.x,
        tile.tile.y,
        format_percent(tile.means.relative()),
        format_percent(tile.means.relative_error()),
        format_percent(bias.tested),
        format_percent(POWER),
        format_percent(bias.tiles_detectable),
        format_percent(SIGNIFICANCE),
    )
}

fn worst_tiles(report: &CompareReport) -> Table {
    let tiles = report.metrics.tiles.iter().take(WORST_TILES);
    let rows = tiles.map(|error| {
        let tile = error.tile;
        vec![
            tile.x.to_string(),
            tile.y.to_string(),
            format!("{} x {}", tile.width, tile.height),
            format_percent(error.share),
            format_percent(error.root_mean),
        ]
    });
    let even = 1.0 / report.metrics.tiles.len() as f64;
    Table {
        title: "Worst tiles".to_owned(),
        caption: format!(
            "By their share of relMSE, of {} tiles; the mean share is {}.",
            report.metrics.tiles.len(),
            format_percent(even)
        ),
        head: ["x", "y", "pixels", "share", "rel-rmse"]
            .map(numbers)
            .into(),
        rows: rows.collect(),
    }
}
