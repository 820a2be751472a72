//! Lesson on importance sampling: good, perfect and bad densities for the same integral.
//!
//! Measure: the integral of 5 x^4 over [0, 1], which is 1; densities (k + 1) x^k.
//! Range: exponents k from 0 to 12; from 9 on the variance is infinite.
//! Source: V = 25 / ((k + 1) (9 - k)) - 1. Tested in `lab/tests/reports/lesson.rs`.

use super::number::{MeasuredTechnique, Number};
use super::page::{Finding, Formula, Page};
use super::topic::{Lesson, Topic};
use super::uniform::Uniform;
use crate::course::monte_carlo::integrate_importance;
use crate::course::power::{pdf_power, sample_power};
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use etendue::Result;

pub const TOPIC: Topic = Topic {
    name: "importance",
    title: "Importance sampling",
    summary: "A density like the integrand helps, the right one is perfect, a wrong one has \
              infinite variance.",
    weight: 3.0,
    run,
};

/// Samples for each number.
const SAMPLES: usize = 1 << 21;

fn f(x: f64) -> f64 {
    5.0 * x.powi(4)
}

/// The mean of f / p over samples of (k + 1) x^k.
fn estimate(k: f64, samples: usize, uniform: &mut Uniform) -> f64 {
    let draw = || {
        let x = sample_power(uniform.double(), k);
        (x, pdf_power(x, k))
    };
    integrate_importance(|x| f(*x), samples, draw).mean()
}

/// The exact variance of one sample.
fn variance(k: f64) -> f64 {
    if k < 9.0 {
        25.0 / ((k + 1.0) * (9.0 - k)) - 1.0
    } else {
        f64::INFINITY
    }
}

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    Ok(Page {
        claim: "Any density that is positive where the integrand is not zero estimates the \
                integral without bias. The variance is in the ratio f/p: a density that follows f \
                makes it nearly constant, and one in proportion to f makes it constant, so that a \
                single sample is exact. A density that goes to zero faster than f does lets the \
                ratio grow without limit, rare as that may be, and the variance can be infinite. \
                Such an estimate looks right most of the time, which is what makes it dangerous."
            .to_owned(),
        formulas: vec![
            Formula::new(
                r"\langle I\rangle_N = \frac{1}{N}\sum_{i=1}^{N}\frac{f(x_i)}{p(x_i)}, \qquad V =
                  \int\frac{f^2(x)}{p(x)}\,\mathrm{d}x - I^2, \qquad p = \frac{f}{I}
                  \;\Rightarrow\; V = 0",
                "The perfect density needs the integral itself as its normalisation; practical \
                 ones are close to f.",
            ),
            Formula::new(
                r"f(x) = 5x^4, \quad p_k(x) = (k+1)\,x^k: \qquad V_k = \frac{25}{(k+1)(9-k)} - 1
                  \;\;(k < 9), \qquad V_k = \infty \;\;(k \ge 9)",
                "One integrand, a family of densities: too flat below k = 4, too steep above.",
            ),
        ],
        experiment: "The integral of 5x⁴, which is 1, is estimated with densities from k = 0, \
                     plain Monte Carlo, to k = 12. For the steep ones the root mean square error \
                     has no meaning, so the mean absolute error is plotted, over 400 runs."
            .to_owned(),
        findings: findings(lesson),
    })
}

fn findings(lesson: &Lesson<'_>) -> Vec<Finding> {
    let mut numbers = Vec::new();
    let mut measured = Vec::new();
    for k in [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0] {
        let samples = lesson.sample(&format!("k = {k}"), SAMPLES, |u| estimate(k, 1, u));
        // Above 5 the variance is finite, but the variance of its estimate is not.
        if k <= 5.0 {
            numbers.push(Number::mean(
                format!("E of f/p, k = {k}"),
                1.0,
                &samples.all(),
                2e-3,
            ));
            numbers.push(if k == 4.0 {
                Number::certain("V of f/p, k = 4", 0.0, samples.variances().mean())
            } else {
                Number::mean(
                    format!("V of f/p, k = {k}"),
                    variance(k),
                    &samples.variances(),
                    3e-2,
                )
            });
        }
        measured.push([k, samples.variances().mean()]);
    }
    let technique = |k: f64| {
        let samples = lesson.sample(&format!("cost {k}"), SAMPLES, |u| estimate(k, 1, u));
        let name = match k as i32 {
            0 => "k = 0: uniform",
            2 => "k = 2: good",
            4 => "k = 4: perfect",
            6 => "k = 6: steep",
            _ => "k = 12: bad",
        };
        MeasuredTechnique::new(name, &samples.all(), samples.cost()).exactly(variance(k))
    };
    vec![
        Finding::Numbers {
            reading: "Every density has the same expected value. At k = 4 each single sample is \
                      the integral."
                .to_owned(),
            numbers,
        },
        Finding::Plots {
            plots: vec![shapes(), variances(measured)],
        },
        Finding::Plots {
            plots: vec![errors(lesson), runs(lesson)],
        },
        Finding::Techniques {
            reading: "At k = 12 the measured variance is finite, as that of any finite number of \
                      samples is; it differs with another seed, and does not converge."
                .to_owned(),
            techniques: [0.0, 2.0, 4.0, 6.0, 12.0].map(technique).to_vec(),
        },
    ]
}

fn shapes() -> Plot {
    let range = [0.0, 1.0];
    let density = |k: f64, name: &str, hue| {
        Series::curve(name, Mark::Line, hue, range, move |x| pdf_power(x, k))
    };
    Plot {
        title: "The integrand and densities".to_owned(),
        reading: "A density below f undersamples it, and one above it wastes samples. At the left \
                  p₁₂ is far below f, and f/p goes to infinity."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::linear("x").over(0.0, 1.0),
        y: Axis::linear("density").over(0.0, 6.0),
        series: vec![
            density(0.0, "k = 0", 0),
            density(2.0, "k = 2", 2),
            density(12.0, "k = 12", 1),
            Series::curve("f = p for k = 4", Mark::Guide, 3, range, f),
        ],
    }
}

fn variances(measured: Vec<[f64; 2]>) -> Plot {
    Plot {
        title: "Variance of one sample".to_owned(),
        reading: "It is zero at k = 4 and rises to both sides, but not equally: to the left it \
                  ends at that of plain Monte Carlo, to the right it is infinite from k = 9. Too \
                  flat is safe, too steep is not."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::linear("exponent k").over(0.0, 9.2),
        y: Axis::linear("variance").over(0.0, 3.0),
        series: vec![
            Series::curve("exact", Mark::Line, 0, [0.0, 8.99], variance),
            Series::new("measured", Mark::Dots, 1, measured),
            Series::new("k = 9", Mark::Guide, 6, vec![[9.0, 0.0], [9.0, 3.0]]),
        ],
    }
}

fn errors(lesson: &Lesson<'_>) -> Plot {
    let runs = lesson.samples(400);
    let series = [(0.0, 0), (2.0, 2), (12.0, 1)].map(|(k, hue)| {
        let point = |power: i32| {
            let n = 1_usize << power;
            let all = lesson.repeat(&format!("error {k} {n}"), runs, |u| {
                (estimate(k, n, u) - 1.0).abs()
            });
            [n as f64, all.iter().sum::<f64>() / all.len().max(1) as f64]
        };
        let points = (0..=14).step_by(2).map(point).collect();
        Series::new(format!("k = {k}"), Mark::Marks, hue, points)
    });
    let first = variance(0.0).sqrt();
    let guide = Series::new(
        "1/√N",
        Mark::Guide,
        6,
        vec![[1.0, first], [16384.0, first / 128.0]],
    );
    Plot {
        title: "Mean absolute error".to_owned(),
        reading: "Without a variance there is no law of 1/√N: the error of k = 12 falls more \
                  slowly, as about N to the power −0.38. For few samples it looks no worse than \
                  the others."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("samples N"),
        y: Axis::log("mean absolute error"),
        series: [guide].into_iter().chain(series).collect(),
    }
}

fn runs(lesson: &Lesson<'_>) -> Plot {
    let steps: Vec<u32> = (0..=160)
        .map(|step| 10.0_f64.powf(f64::from(step) / 40.0) as u32)
        .collect();
    let run = |k: f64, hue: usize, index: usize| {
        let mut uniform = lesson.uniform(&format!("run {k}"), index);
        let (mut count, mut sum) = (0, 0.0);
        let points = steps.iter().map(|&n| {
            while count < n {
                sum += estimate(k, 1, &mut uniform);
                count += 1;
            }
            [f64::from(n), sum / f64::from(n)]
        });
        let name = if index == 0 {
            format!("k = {k}")
        } else {
            String::new()
        };
        Series::new(name, Mark::Line, hue, points.collect())
    };
    let all = (0..4).flat_map(|index| [run(12.0, 1, index), run(2.0, 2, index)]);
    Plot {
        title: "Eight single runs".to_owned(),
        reading: "Most runs of k = 12 settle below 1, because the rare large ratios have not \
                  occurred yet; when one occurs, the mean jumps. An error bar from the same \
                  samples would not have shown the error."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("samples N"),
        y: Axis::linear("mean so far").over(0.4, 1.6),
        series: all.collect(),
    }
}
