//! Lesson on Russian roulette: random termination without bias.
//!
//! Measure: the sum 1 + R + R^2 + ..., which is 1 / (1 - R): the light in a closed box of albedo R that emits 1.
//! Range: R = 0.5, and continuation probabilities q above R^2, below which the variance is infinite.
//! Source: E[S^2] = (1 + 2R/(1 - R)) / (1 - R^2/q). Tested in `lab/tests/reports/lesson.rs`.

use super::number::{MeasuredTechnique, Number};
use super::page::{Finding, Formula, Page};
use super::topic::{GroupedSamples, Lesson, Topic};
use super::uniform::Uniform;
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use etendue::Result;
use etendue::internals::math::stats::Moments;

pub const TOPIC: Topic = Topic {
    name: "roulette",
    title: "Russian roulette",
    summary: "The course's example with R = 0.5: paths end at random, and the estimate stays \
              unbiased.",
    weight: 1.0,
    run,
};

/// The reflectance of the box.
const R: f64 = 0.5;

/// The continuation probabilities of the numbers; the first is the course's.
const SHOWN: [f64; 2] = [R, 0.8];

/// All continuation probabilities that are measured.
const CHANCES: [f64; 6] = [R, 0.4, 0.6, 0.7, 0.8, 0.9];

/// Samples for each number.
const SAMPLES: usize = 1 << 21;

/// A path that continues with probability `q` after each bounce: the radiance that it collects, and its number of
/// bounces.
fn path(q: f64, uniform: &mut Uniform) -> (f64, u32) {
    let (mut sum, mut beta, mut bounces) = (1.0, 1.0, 0);
    while uniform.double() < q {
        beta *= R / q;
        sum += beta;
        bounces += 1;
    }
    (sum, bounces)
}

/// The exact variance of the radiance collected by a path.
fn variance(q: f64) -> f64 {
    (1.0 + 2.0 * R / (1.0 - R)) / (1.0 - R * R / q) - (1.0 - R).powi(-2)
}

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    Ok(Page {
        claim: "Light bounces for ever, a program cannot. To stop after a fixed number of bounces \
                loses light: a bias that more samples do not remove. Russian roulette stops at \
                random. With probability q the path continues, and its contribution is divided by \
                q; else it ends. The expected value is unchanged. The variance grows, but the time \
                saved pays for more paths."
            .to_owned(),
        formulas: vec![
            Formula::new(
                r"F_{\text{RR}} = \frac{F}{q} \;\text{ with probability } q, \quad F_{\text{RR}} =
                  0 \;\text{ else:} \qquad E[F_{\text{RR}}] = q\,\frac{E[F]}{q} = E[F]",
                "Roulette does not change the expected value.",
            ),
            Formula::new(
                r"V[F_{\text{RR}}] = \frac{V[F] + E[F]^2}{q} - E[F]^2 \;\ge\; V[F]",
                "It never lowers the variance of a sample; what it lowers is the cost.",
            ),
            Formula::new(
                r"L = L_e + R\,L \;\Rightarrow\; L = L_e \sum_{k=0}^{\infty} R^k = \frac{L_e}{1-R}
                  = 2 \qquad (L_e = 1,\; R = 0.5)",
                "The example: a closed box whose walls emit 1 and reflect one half.",
            ),
            Formula::new(
                r"V = \frac{1 + \frac{2R}{1-R}}{1 - R^2/q} - \frac{1}{(1-R)^2}, \qquad q = R:\; V
                  = \frac{R}{(1-R)^2} = 2, \quad E[\text{bounces}] = \frac{q}{1-q} = 1",
                "Variance and length of paths that continue with probability q. Below q = R² = 1/4 \
                 the variance is infinite.",
            ),
        ],
        experiment:
            "Two million paths are traced in the box for each of several q. With q = R the \
                     throughput stays 1: every bounce counts 1, and the result is the mean number \
                     of surfaces on a path. A second experiment applies roulette, q = 1/2, to the \
                     samples of a plain integral, ∫ 3x² dx = 1."
                .to_owned(),
        findings: findings(lesson),
    })
}

fn findings(lesson: &Lesson<'_>) -> Vec<Finding> {
    let paths = CHANCES.map(|q| {
        (
            q,
            lesson.sample(&format!("sum {q}"), SAMPLES, |u| path(q, u).0),
        )
    });
    let technique = |(q, sums): &(f64, GroupedSamples)| {
        let technique = MeasuredTechnique::new(format!("q = {q}"), &sums.all(), sums.cost());
        technique.exactly(variance(*q))
    };
    let mut measured: Vec<[f64; 2]> = paths
        .iter()
        .map(|(q, sums)| [*q, sums.variances().mean()])
        .collect();
    measured.sort_by(|a, b| a[0].total_cmp(&b[0]));
    vec![
        Finding::Numbers {
            reading: "The radiance is 2, whatever the probability of continuing.".to_owned(),
            numbers: [of_paths(lesson, &paths), of_samples(lesson)].concat(),
        },
        Finding::Techniques {
            reading:
                "Here all bounces of a path contribute equally: the longer the path, the more \
                      efficient. In an image, continuing a dim path contributes less than a new \
                      path, so that q follows the path throughput."
                    .to_owned(),
            techniques: paths.iter().map(technique).collect(),
        },
        Finding::Plots {
            plots: vec![variances(measured), truncated(lesson)],
        },
    ]
}

fn of_paths(lesson: &Lesson<'_>, paths: &[(f64, GroupedSamples)]) -> Vec<Number> {
    let mut numbers = Vec::new();
    for (q, sums) in paths.iter().filter(|(q, _)| SHOWN.contains(q)) {
        let bounces = lesson.sample(&format!("bounces {q}"), SAMPLES, |u| {
            f64::from(path(*q, u).1)
        });
        let named = |what: &str| format!("{what}, q = {q}");
        numbers.push(Number::mean(named("L"), 1.0 / (1.0 - R), &sums.all(), 2e-3));
        numbers.push(Number::mean(
            named("V"),
            variance(*q),
            &sums.variances(),
            2e-2,
        ));
        numbers.push(Number::mean(
            named("bounces"),
            q / (1.0 - q),
            &bounces.all(),
            1e-2,
        ));
    }
    numbers
}

/// Roulette applied to the samples of a plain integral.
fn of_samples(lesson: &Lesson<'_>) -> Vec<Number> {
    let f = |x: f64| 3.0 * x * x;
    let plain = lesson.sample("plain", SAMPLES, |u| f(u.double()));
    let with = lesson.sample("with roulette", SAMPLES, |u| {
        if u.double() < 0.5 {
            f(u.double()) / 0.5
        } else {
            0.0
        }
    });
    vec![
        Number::mean(
            "∫ 3x² dx, V without roulette",
            0.8,
            &plain.variances(),
            1e-2,
        ),
        Number::mean("∫ 3x² dx with roulette", 1.0, &with.all(), 3e-3),
        Number::mean(
            "V with roulette, (0.8 + 1)/0.5 − 1",
            2.6,
            &with.variances(),
            1e-2,
        ),
    ]
}

fn variances(measured: Vec<[f64; 2]>) -> Plot {
    Plot {
        title: "Variance of a path, R = 0.5".to_owned(),
        reading: "Dots are measured. Below q = R the variance rises steeply; below q = 1/4 it is \
                  infinite, as the division by q raises the throughput faster than paths end."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::linear("probability q of continuing").over(0.2, 1.0),
        y: Axis::linear("variance").over(0.0, 10.0),
        series: vec![
            Series::curve("exact", Mark::Line, 0, [0.251, 1.0], variance),
            Series::new("measured", Mark::Dots, 1, measured),
            Series::new("q = R²", Mark::Guide, 6, vec![[0.25, 0.0], [0.25, 10.0]]),
        ],
    }
}

/// Termination after a fixed number of bounces, compared with roulette.
fn truncated(lesson: &Lesson<'_>) -> Plot {
    const PATHS: [u32; 13] = [1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096];
    let runs = lesson.samples(400);
    let point = |&paths: &u32| {
        let squares = lesson.repeat(&format!("error {paths}"), runs, |u| {
            let sum: f64 = (0..paths).map(|_| path(R, u).0).sum();
            (sum / f64::from(paths) - 2.0).powi(2)
        });
        [f64::from(paths), Moments::of(squares).mean().sqrt()]
    };
    let bias = |bounces: i32, hue: usize| {
        let left = R.powi(bounces) / (1.0 - R) * R;
        let name = format!("stop after {bounces} bounces");
        Series::new(name, Mark::Guide, hue, vec![[1.0, left], [4096.0, left]])
    };
    Plot {
        title: "Roulette against a bounce limit".to_owned(),
        reading: "A bounce limit costs no variance here, but its error remains. That of roulette \
                  falls below any limit with enough paths."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("paths N"),
        y: Axis::log("error of L"),
        series: vec![
            Series::new(
                "roulette, q = R",
                Mark::Marks,
                0,
                PATHS.iter().map(point).collect(),
            ),
            bias(1, 1),
            bias(3, 2),
            bias(5, 3),
        ],
    }
}
