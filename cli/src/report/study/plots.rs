//! The plots of a study.
//!
//! Measure: stated on each axis; errors are roots of relMSE, in percent.
//! Range: any findings; non-finite or non-positive values are not drawn.
//! Source: none needed. Tested in `cli/tests/command/study.rs`.

use super::Findings;
use super::wording::short_answer;
use etendue_lab::plot::{AspectRatio, Axis, Label, Mark, Plot, Series};
use etendue_lab::study::answer::Answer;
use etendue_lab::study::bars::{BINS, Coverage, MAX_Z};
use etendue_lab::study::summary::Summary;
use statrs::distribution::{Continuous, Normal};

/// The number of bins of the histogram of p-values.
const P_BINS: usize = 20;

/// The marked values of the axis of errors, in percent.
const ERRORS: [f64; 12] = [
    0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0,
];

/// The marked values of the axis of times, in seconds, and their names.
const SECONDS: [(f64, &str); 14] = [
    (1e-3, "1 ms"),
    (1e-2, "10 ms"),
    (1e-1, "0.1 s"),
    (1.0, "1 s"),
    (10.0, "10 s"),
    (60.0, "1 min"),
    (600.0, "10 min"),
    (3600.0, "1 h"),
    (36_000.0, "10 h"),
    (345_600.0, "4 days"),
    (3_456_000.0, "40 days"),
    (31_557_600.0, "1 year"),
    (315_576_000.0, "10 years"),
    (3_155_760_000.0, "100 years"),
];

/// The factor from the longest time to the end of its axis.
const ROOM: f64 = 50.0;

/// Number of segments of a law: it is straight except for the start.
const SEGMENTS: u32 = 16;

/// Returns the plot of what accuracy costs: error against time at the scene's own size, with the times to each error.
pub fn price(findings: &Findings<'_>) -> Plot {
    let mut series = Vec::new();
    for (index, summary) in &findings.summaries {
        let at = |spp: f64| summary.own_time.at(spp);
        let levels = || summary.levels.iter();
        let own = |rel_mse: f64| error(summary.own_error * rel_mse);
        let points = levels().map(|it| [at(it.spp as f64), own(it.rel_mse.value)]);
        let ribbon = levels().map(|it| {
            // On a logarithmic axis an interval that reaches 0 has no lower end.
            let low = it.rel_mse.low.max(0.05 * it.rel_mse.value);
            [at(it.spp as f64), own(low), own(it.rel_mse.high)]
        });
        series.extend(law(*index, summary));
        let labels = summary.answers.iter().filter_map(|(target, it)| {
            let is_crossing = matches!(it, Answer::Measured(_) | Answer::Law(_));
            let point = [it.seconds().filter(|_| is_crossing)?, 100.0 * target];
            Some(Label {
                point,
                text: short_answer(it)?,
            })
        });
        series.push(
            Series::new(&summary.name, Mark::Marks, *index, points.collect())
                .within(ribbon.collect())
                .labelled(labels.collect()),
        );
    }
    let times = series
        .iter()
        .flat_map(|it| &it.points)
        .map(|point| point[0]);
    let around = |[low, high]: [f64; 2], x: f64| [low.min(x), high.max(x)];
    let [start, end] = times
        .filter(|time| time.is_finite() && *time > 0.0)
        .fold([f64::INFINITY, f64::NEG_INFINITY], around);
    let axis = Axis::log("rendering time");
    // Room for the last label.
    let axis = match start <= end {
        true => axis.over(0.7 * start, ROOM * end),
        false => axis,
    };
    Plot {
        title: "Error against time".to_owned(),
        reading: "The error of the image against the time that it renders, at the scene's own size; the lower and the farther left, the better. Marks were measured, with bands of 95 %; dashes continue them by the law of the error so far. The times are those to errors of 10, 3, 1, 0.3 and 0.1 %: `≈` is beyond what was measured. A line that flattens is biased."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: axis.marked(SECONDS.map(|(s, text)| (s, text.to_owned())).to_vec()),
        y: Axis::log("error, %").marked(ERRORS.map(|it| (it, format!("{it}"))).to_vec()),
        series,
    }
}

/// Returns the law of a variant from its longest renders to the smallest of the errors; `None` if it has none.
fn law(index: usize, summary: &Summary) -> Option<Series> {
    let law = summary.law.filter(|_| !summary.bias.is_square_found)?;
    let last = summary.levels.last()?.spp as f64;
    let (target, _) = summary.answers.last()?;
    let rel_mse = target * target / summary.own_error;
    let end = ((law.a - rel_mse.ln()) / law.b).exp();
    if end <= last {
        return None;
    }
    let at = |step: u32| {
        let spp = last * (end / last).powf(f64::from(step) / f64::from(SEGMENTS));
        let rel_mse = summary.own_error * law.at(spp);
        [summary.own_time.at(spp), error(rel_mse)]
    };
    let points = (0..=SEGMENTS).map(at).collect();
    Some(Series::new("", Mark::Guide, index, points))
}

/// Returns the plots of error against samples, and of the residuals of the power law.
pub fn errors(findings: &Findings<'_>) -> Vec<Plot> {
    let samples = Plot {
        title: "Error against samples".to_owned(),
        reading: "The error by samples per pixel, whatever the cost of a sample. The thin dashes have the slope of independent samples. The dashed horizontal line is the error of one reference alone; smaller errors can be measured because there are two."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("samples per pixel"),
        y: Axis::log("error, %"),
        series: by_samples(findings),
    };
    vec![samples, residuals(findings)]
}

fn error(rel_mse: f64) -> f64 {
    100.0 * rel_mse.sqrt()
}

fn by_samples(findings: &Findings<'_>) -> Vec<Series> {
    let curves: Vec<Series> = findings
        .summaries
        .iter()
        .map(|(index, summary)| {
            let points = summary.levels.iter();
            let points = points.map(|level| [level.spp as f64, error(level.rel_mse.value)]);
            let ribbon = summary.levels.iter().map(|level| {
                let low = level.rel_mse.low.max(0.05 * level.rel_mse.value);
                [level.spp as f64, error(low), error(level.rel_mse.high)]
            });
            Series::new(&summary.name, Mark::Marks, *index, points.collect())
                .within(ribbon.collect())
        })
        .collect();
    let points = || curves.iter().flat_map(|series| &series.points);
    let around = |[low, high]: [f64; 2], x: f64| [low.min(x), high.max(x)];
    let xs = points()
        .map(|p| p[0])
        .fold([f64::INFINITY, f64::NEG_INFINITY], around);
    let mut all = Vec::new();
    if let Some(reference) = &findings.report.reference {
        let floor = error(reference.noise.rel_mse);
        let ends = xs.map(|x| [x, floor]).to_vec();
        all.push(Series::new("one reference", Mark::Guide, 6, ends));
    }
    if let Some(first) = curves.first().and_then(|series| series.points.first()) {
        let end = first[1] * (first[0] / xs[1]).sqrt();
        let ends = vec![*first, [xs[1], end]];
        all.push(Series::new("independent samples", Mark::Guide, 5, ends));
    }
    all.extend(curves);
    all
}

/// Returns the plot of the residuals of the levels with respect to the power law.
fn residuals(findings: &Findings<'_>) -> Plot {
    let series = findings.summaries.iter().filter_map(|(index, summary)| {
        let slope = summary.slope?;
        let off = |spp: u64, rel_mse: f64| {
            let law = (slope.a - slope.b.value * (spp as f64).ln()).exp();
            rel_mse / law
        };
        let points = summary.levels.iter();
        let points = points.map(|level| [level.spp as f64, off(level.spp, level.rel_mse.value)]);
        let ribbon = summary.levels.iter().map(|level| {
            let [low, high] = [level.rel_mse.low, level.rel_mse.high];
            [level.spp as f64, off(level.spp, low), off(level.spp, high)]
        });
        Some(
            Series::new(&summary.name, Mark::Marks, *index, points.collect())
                .within(ribbon.collect()),
        )
    });
    Plot {
        title: "Residuals of the power law".to_owned(),
        reading: "relMSE over the fitted law 1 / tᵇ. Where a line bends, the slope changes with time, and that in the table is a mean."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("samples per pixel"),
        y: Axis::linear("measured / law"),
        series: series.collect(),
    }
}

/// Returns the plots of the reliability of error bars and of bias.
pub fn trust(findings: &Findings<'_>) -> Vec<Plot> {
    let mut plots = reliability(findings);
    plots.extend(bias(findings));
    plots
}

/// Returns the plots of the coverage of error bars and of the standardised errors.
fn reliability(findings: &Findings<'_>) -> Vec<Plot> {
    let bars = || {
        let variants = findings.report.variants.iter().enumerate();
        variants.filter_map(|(index, study)| Some((index, study, study.bars.as_ref()?)))
    };
    if bars().next().is_none() {
        return Vec::new();
    }
    let mut shares = vec![Series::new(
        "exact coverage",
        Mark::Guide,
        6,
        vec![[50.0, 50.0], [99.0, 99.0]],
    )];
    let law = Normal::standard();
    let mut z = vec![Series::curve(
        "normal",
        Mark::Guide,
        6,
        [-MAX_Z, MAX_Z],
        |z| law.pdf(z),
    )];
    for (index, study, bars) in bars() {
        // If no pixel is trusted, the flagged pixels are shown instead.
        let is_trusted = bars.z.iter().any(|&count| count > 0);
        let (name, counts) = match is_trusted {
            true => (study.variant.name.clone(), &bars.z),
            false => (
                format!("{} (all flagged)", study.variant.name),
                &bars.z_flagged,
            ),
        };
        let share = |c: &Coverage| if is_trusted { c.trusted } else { c.flagged };
        let tried = bars.coverage.iter().filter(|c| share(c).count > 0);
        let points = tried.clone();
        let points = points.map(|c| [100.0 * c.confidence, 100.0 * share(c).value()]);
        let ribbon = tried.map(|c| {
            let [low, high] = share(c).interval();
            [100.0 * c.confidence, 100.0 * low, 100.0 * high]
        });
        shares.push(
            Series::new(&name, Mark::Marks, index, points.collect()).within(ribbon.collect()),
        );
        let count: u64 = counts.iter().sum();
        if count > 0 {
            let width = 2.0 * MAX_Z / BINS as f64;
            let density = |(bin, &n): (usize, &u64)| {
                let middle = -MAX_Z + (bin as f64 + 0.5) * width;
                [middle, n as f64 / (count as f64 * width)]
            };
            let points = counts.iter().enumerate().map(density);
            z.push(Series::new(&name, Mark::Line, index, points.collect()));
        }
    }
    vec![
        Plot {
            title: "Coverage of error bars".to_owned(),
            reading: "The share of the bars of trusted pixels that contain the reference, over their confidence: on the dashed line they are correct, below it too narrow. Bands are Wilson's intervals of 95 %. Error bars do not include bias."
                .to_owned(),
            shape: AspectRatio::Wide,
            x: Axis::linear("confidence, %").over(45.0, 100.0),
            y: Axis::linear("contain the reference, %"),
            series: shares,
        },
        Plot {
            title: "Errors in standard errors".to_owned(),
            reading: "Errors of trusted pixels over their standard errors, converted to normal scores by the degrees of freedom of each: they follow the normal distribution if the bars are correct; errors beyond the ends are counted in the last bins."
                .to_owned(),
            shape: AspectRatio::Wide,
            x: Axis::linear("normal score of the error").over(-MAX_Z, MAX_Z),
            y: Axis::linear("density"),
            series: z,
        },
    ]
}

/// Returns the histogram of the p-values of tiles, which shows bias; `None` if there are no p-values.
fn bias(findings: &Findings<'_>) -> Option<Plot> {
    let mut series = Vec::new();
    for (index, study) in findings.report.variants.iter().enumerate() {
        let all = &study.tile_p_values;
        if all.is_empty() {
            continue;
        }
        let mut counts = [0_u32; P_BINS];
        for p in all {
            counts[((p * P_BINS as f64) as usize).min(P_BINS - 1)] += 1;
        }
        let share = |(bin, &n): (usize, &u32)| {
            let middle = (bin as f64 + 0.5) / P_BINS as f64;
            [middle, f64::from(n) * P_BINS as f64 / all.len() as f64]
        };
        let points = counts.iter().enumerate().map(share);
        series.push(Series::new(
            &study.variant.name,
            Mark::Line,
            index,
            points.collect(),
        ));
    }
    let even = Series::new("without bias", Mark::Guide, 6, vec![[0.0, 1.0], [1.0, 1.0]]);
    (!series.is_empty()).then(|| Plot {
        title: "Test of bias in tiles".to_owned(),
        reading: "For each tile of 8 × 8 pixels, the p-value of the difference of its mean from that of the references. Without bias p is uniformly distributed, and the lines are level; a peak at 0 is bias."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::linear("p of a tile").over(0.0, 1.0),
        y: Axis::linear("density"),
        series: [even].into_iter().chain(series).collect(),
    })
}
