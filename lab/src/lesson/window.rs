//! Lesson on Russian roulette by a weight window: how dim a path should become before it may end.
//!
//! Measure: the light in a closed box of albedo R that emits 1, where the light of each surface is a random number of mean 1
//! and variance 1, as one shadow ray gives it. Cost is counted in surfaces.
//! Range: windows w in (0, 1]; a path survives with probability min(1, beta / w).
//! Source: Booth and Hendricks 1984 for weight windows; the sums are geometric series. Tested in
//! `lab/tests/reports/lesson.rs`.

use super::number::{MeasuredTechnique, Number};
use super::page::{Finding, Formula, Page};
use super::topic::{GroupedSamples, Lesson, Topic};
use super::uniform::Uniform;
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use etendue::Result;

pub const TOPIC: Topic = Topic {
    name: "window",
    title: "Roulette by a weight window",
    summary: "The throughput below which a path may end: smaller windows make longer, less noisy \
              paths, and there is a best one.",
    weight: 2.0,
    run,
};

/// The reflectance of the box in the numbers.
const R: f64 = 0.7;

/// The windows of the numbers; with the first, the throughput is the probability of surviving.
const WINDOWS: [f64; 6] = [1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125];

/// The reflectances of the plot.
const REFLECTANCES: [f64; 3] = [0.3, 0.5, R];

/// The variance of the light of a surface.
const NOISE: f64 = 1.0;

/// Samples for each number.
const SAMPLES: usize = 1 << 20;

/// A path in a box of reflectance `r` that ends by a window: the radiance that it collects, and its number of surfaces.
fn path(r: f64, window: f64, uniform: &mut Uniform) -> (f64, u32) {
    let (mut sum, mut beta, mut surfaces) = (0.0, 1.0, 0);
    loop {
        // The light of a surface, which a shadow ray finds half of the time.
        sum += if uniform.double() < 0.5 {
            2.0 * beta
        } else {
            0.0
        };
        surfaces += 1;
        beta *= r;
        if beta < window {
            if uniform.double() >= beta / window {
                return (sum, surfaces);
            }
            beta = window;
        }
    }
}

/// The exact variance of the radiance of a path, and its mean number of surfaces.
fn exact(r: f64, window: f64) -> [f64; 2] {
    let mut beta = 1.0;
    let (mut variance, mut surfaces) = (0.0, 0.0);
    while beta >= window {
        variance += NOISE * beta * beta;
        surfaces += 1.0;
        beta *= r;
    }
    // The number N of surfaces with beta = w: none, or 1 + G, where G is geometric.
    let first = beta / window;
    let (mean, variance_of_more) = (r / (1.0 - r), r / (1.0 - r).powi(2));
    let count = first * (1.0 + mean);
    let count_squared = first * ((1.0 + mean).powi(2) + variance_of_more);
    variance += window * window * (NOISE * count + count_squared - count * count);
    [variance, surfaces + count]
}

/// Variance times surfaces: one over the efficiency.
fn work(r: f64, window: f64) -> f64 {
    let [variance, surfaces] = exact(r, window);
    variance * surfaces
}

/// The best window for a reflectance, of those on a fine grid.
fn best(r: f64) -> f64 {
    let windows = (0..1000).map(|i| (-f64::from(i) / 200.0).exp());
    let better = |a: f64, b: f64| if work(r, b) < work(r, a) { b } else { a };
    windows.fold(1.0, better)
}

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    Ok(Page {
        claim:
            "Roulette has to decide how dim a path becomes before it may end. A weight window w \
                is one number for that: a path whose throughput β is at least w always continues; \
                below, it survives with probability β/w, and then continues with w. The division \
                by the probability is what keeps the mean. A large window ends paths early, and \
                the surviving ones are bright and rare: noise. A small window makes paths long, \
                and their last bounces cost time for little light. Between the two is a best \
                window, the smaller the more light the surfaces reflect."
                .to_owned(),
        formulas: vec![
            Formula::new(
                r"q = \min\left(1, \frac{\beta}{w}\right), \qquad \beta \leftarrow
                  \frac{\beta}{q} = \max(\beta, w)",
                "The window. With w = 1 the throughput itself is the probability of surviving.",
            ),
            Formula::new(
                r"S = \sum_k \beta_k X_k, \qquad E[X] = 1,\; V[X] = s^2, \qquad E[S] =
                  \frac{1}{1-R}",
                "The example: a box of albedo R whose surfaces emit 1. Each adds its light X, \
                 found by one shadow ray, and so a random number itself.",
            ),
            Formula::new(
                r"V = s^2 \sum_{k=0}^{n} R^{2k} + w^2 \left( s^2 E[N] + V[N] \right), \qquad T = n
                  + 1 + E[N]",
                "Variance and surfaces: n bounces without roulette, then N with the throughput w. \
                 Smaller windows reduce the second term as w², and increase T as −log w.",
            ),
            Formula::new(
                r"w^* = \arg\min_w V(w)\,T(w)",
                "The best window has the least variance times cost.",
            ),
        ],
        experiment: format!(
            "Paths are traced in a box of albedo R = {R} with six windows; a surface's light is 0 or \
             2, each half of the time, so that s² = 1. (The renderer's own window, \
             `--roulette window=1/2`, was chosen by measurements of images.)"
        ),
        findings: findings(lesson),
    })
}

fn findings(lesson: &Lesson<'_>) -> Vec<Finding> {
    let paths: Vec<(f64, GroupedSamples)> = WINDOWS
        .iter()
        .map(|&w| {
            let samples = lesson.sample(&format!("sum {w}"), SAMPLES, |u| path(R, w, u).0);
            (w, samples)
        })
        .collect();
    let technique = |(w, sums): &(f64, GroupedSamples)| {
        let technique =
            MeasuredTechnique::new(format!("w = 1/{}", 1.0 / w), &sums.all(), sums.cost());
        technique.exactly(exact(R, *w)[0])
    };
    vec![
        Finding::Numbers {
            reading: format!(
                "The radiance is {:.3} with every window; variance falls and the number of surfaces \
                 grows as the window shrinks.",
                1.0 / (1.0 - R)
            ),
            numbers: numbers(lesson, &paths),
        },
        Finding::Techniques {
            reading: format!(
                "Measured in time, as a machine needs it: the best window is where variance times \
                 time is least. By the count of surfaces it is {:.2}.",
                best(R)
            ),
            techniques: paths.iter().map(technique).collect(),
        },
        Finding::Plots {
            plots: vec![works(lesson), parts()],
        },
    ]
}

fn numbers(lesson: &Lesson<'_>, paths: &[(f64, GroupedSamples)]) -> Vec<Number> {
    let mut numbers = Vec::new();
    for (w, sums) in paths {
        let [variance, surfaces] = exact(R, *w);
        let counts = lesson.sample(&format!("surfaces {w}"), SAMPLES, |u| {
            f64::from(path(R, *w, u).1)
        });
        let named = |what: &str| format!("{what}, w = 1/{}", 1.0 / w);
        numbers.push(Number::mean(named("L"), 1.0 / (1.0 - R), &sums.all(), 5e-3));
        numbers.push(Number::mean(named("V"), variance, &sums.variances(), 3e-2));
        numbers.push(Number::mean(
            named("surfaces"),
            surfaces,
            &counts.all(),
            1e-2,
        ));
    }
    numbers
}

/// Variance times surfaces over the window.
fn works(lesson: &Lesson<'_>) -> Plot {
    let mut series = Vec::new();
    for (hue, r) in REFLECTANCES.into_iter().enumerate() {
        let relative = |w: f64| work(r, w) / work(r, 1.0);
        let curve = (0..=400).map(|i| (-f64::from(i) / 100.0).exp());
        let curve = curve.map(|w| [w, relative(w)]).collect();
        series.push(Series::new(format!("R = {r}"), Mark::Line, hue, curve));
        let measured = WINDOWS.iter().map(|&w| {
            let sums = lesson.sample(&format!("work {r} {w}"), SAMPLES / 2, |u| path(r, w, u).0);
            let surfaces = exact(r, w)[1];
            [w, sums.variances().mean() * surfaces / work(r, 1.0)]
        });
        let name = format!("measured, R = {r}");
        series.push(Series::new(name, Mark::Dots, hue, measured.collect()));
    }
    let at = best(R);
    let line = vec![[at, 0.4], [at, 1.8]];
    series.push(Series::new(format!("best, R = {R}"), Mark::Guide, 6, line));
    Plot {
        title: "Variance × surfaces, relative to w = 1".to_owned(),
        reading: "Lower is better. Where little is reflected the window matters little; where much is \
                  reflected, the best window halves the work. The steps are at powers of R, where a \
                  path has one sure bounce more."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("window w"),
        y: Axis::linear("V · T, relative to w = 1").over(0.4, 1.8),
        series,
    }
}

/// The two factors of the work.
fn parts() -> Plot {
    let curve = |part: fn([f64; 2]) -> f64| {
        let windows = (0..=400).map(|i| (-f64::from(i) / 100.0).exp());
        let first = part(exact(R, 1.0));
        windows
            .map(|w| [w, part(exact(R, w)) / first])
            .collect::<Vec<_>>()
    };
    Plot {
        title: format!("Variance and path length by window, R = {R}"),
        reading:
            "The variance falls to that of the surfaces' own light, and no further; the length \
                  of paths grows by the same for each halving of the window."
                .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("window w"),
        y: Axis::linear("relative to w = 1"),
        series: vec![
            Series::new("variance V", Mark::Line, 0, curve(|[v, _]| v)),
            Series::new("surfaces T", Mark::Line, 1, curve(|[_, t]| t)),
        ],
    }
}
