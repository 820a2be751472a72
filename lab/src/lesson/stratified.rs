//! Lesson on stratified sampling: one sample per cell.
//!
//! Measure: integrals over the unit interval and square.
//! Range: grids of up to 4096 cells.
//! Source: for f = 2x, V = 1 / (3 N^3); for f = x + y, V = 1 / (6 N^2). Tested in `lab/tests/reports/lesson.rs`.

use super::error_curve::{ErrorCurve, powers_of_two};
use super::number::{MeasuredTechnique, Number};
use super::page::{Finding, Formula, Page};
use super::topic::{Lesson, Topic};
use super::uniform::Uniform;
use crate::course::integrands::Integrand;
use crate::course::monte_carlo::{integrate_jittered, integrate_latin_hypercube, integrate_plain};
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use etendue::Result;
use std::cell::RefCell;

pub const TOPIC: Topic = Topic {
    name: "stratified",
    title: "Stratified sampling",
    summary: "One sample in each cell: the variance falls faster, the smoother the integrand and \
              the fewer the dimensions.",
    weight: 4.0,
    run,
};

/// A method of placing samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum IntegralEstimator {
    Plain,
    Jittered,
    LatinHypercube,
}

impl IntegralEstimator {
    const ALL: [Self; 3] = [Self::Plain, Self::Jittered, Self::LatinHypercube];

    fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Jittered => "jittered",
            Self::LatinHypercube => "Latin hypercube",
        }
    }

    /// Estimates an integral with at most `samples` samples; returns the estimate and the number of samples used.
    fn estimate(
        self,
        f: impl Fn(&[f64]) -> f64,
        dimension: u32,
        samples: usize,
        uniform: &mut Uniform,
    ) -> Option<(f64, usize)> {
        let mut draw = || uniform.double();
        let estimate = match self {
            Self::Plain => {
                let moments = integrate_plain(f, dimension, samples, &mut draw);
                return Some((moments.mean(), samples));
            }
            Self::Jittered => integrate_jittered(f, dimension, samples, &mut draw),
            Self::LatinHypercube => integrate_latin_hypercube(f, dimension, samples, &mut draw),
        };
        estimate.map(|estimate| (estimate.value, estimate.calls))
    }

    /// The value of the estimate alone; NaN if there is none.
    fn value(
        self,
        f: impl Fn(&[f64]) -> f64,
        dimension: u32,
        samples: usize,
        uniform: &mut Uniform,
    ) -> f64 {
        let estimate = self.estimate(f, dimension, samples, uniform);
        estimate.map_or(f64::NAN, |(value, _)| value)
    }
}

/// A ramp along the interval; its integral is 1.
fn ramp(x: &[f64]) -> f64 {
    2.0 * x[0]
}

/// A ramp along both axes; its integral is 1.
fn slope(x: &[f64]) -> f64 {
    x[0] + x[1]
}

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    Ok(Page {
        claim: "Independent samples leave gaps and clusters. If the domain is cut into N cells of \
                equal size with one sample in each, only the variance within the cells remains; \
                that between them is removed. It is never worse than plain sampling. How much \
                better it is depends on the integrand: within small cells a smooth one is almost \
                constant, one with an edge is not where the edge runs through. And it depends on \
                the dimension d, as N cells are only N^(1/d) along each axis."
            .to_owned(),
        formulas: vec![
            Formula::new(
                r"\langle I\rangle = \frac{1}{N}\sum_{j=1}^{N} f(x_j), \quad x_j \in S_j, \qquad
                  V_{\text{strat}} = \frac{1}{N^2}\sum_{j=1}^{N} V_j \;\le\; V_{\text{plain}}",
                "One sample x in each stratum S; only the variances within the strata remain.",
            ),
            Formula::new(
                r"V \sim N^{-1-2/d} \;\text{(smooth)}, \qquad V \sim N^{-1-1/d}
                  \;\text{(with an edge)}, \qquad V \sim N^{-1} \;\text{(plain)}",
                "Convergence of the variance. The error is its root.",
            ),
            Formula::new(
                r"f = 2x:\; V = \frac{1}{3N^3}, \qquad f = x + y:\; V = \frac{1}{6N^2}",
                "Two examples in closed form, in one and two dimensions.",
            ),
        ],
        experiment: "Ramps and a quarter of a disk are integrated by plain samples, by jittered \
                     ones (one in each cell of a grid), and by a Latin hypercube (one in each row \
                     and one in each column, for any N), each many times."
            .to_owned(),
        findings: findings(lesson),
    })
}

fn findings(lesson: &Lesson<'_>) -> Vec<Finding> {
    let smooth = curves(lesson, "smooth", slope, 1.0);
    let edge = curves(
        lesson,
        "edge",
        |x| Integrand::Ball.eval(x),
        Integrand::Ball.integral(2),
    );
    let readings = [
        "Jittered samples gain half a power of N. The Latin hypercube gains a whole one here, \
         since x + y is a sum of functions of one coordinate each; this is a special case.",
        "The share of a square in a quarter of a disk. Cells that the edge runs through keep \
         their variance, but these are only about √N of them: the error falls as N to the power \
         −0.75. A Latin hypercube does not see a curved edge.",
    ];
    vec![
        Finding::Numbers {
            reading: "Measured over many estimates. The slopes are those of the error, half of \
                      the variance's."
                .to_owned(),
            numbers: [variances(lesson), slopes(&smooth, &edge)].concat(),
        },
        Finding::Plots {
            plots: IntegralEstimator::ALL
                .map(|it| scatter(lesson, it))
                .to_vec(),
        },
        Finding::Plots {
            plots: vec![
                plot("Error for x + y", readings[0], &smooth),
                plot("Error for a disk's edge", readings[1], &edge),
            ],
        },
        Finding::Techniques {
            reading: "One estimate of the quarter disk from 256 samples as a technique. This \
                      integrand costs next to nothing, so that the time to place the samples \
                      matters; compared with a traced path it would not."
                .to_owned(),
            techniques: IntegralEstimator::ALL
                .map(|it| technique(lesson, it))
                .to_vec(),
        },
    ]
}

/// Variances with a closed form.
fn variances(lesson: &Lesson<'_>) -> Vec<Number> {
    let runs = lesson.samples(20_000).max(8192);
    let of_ramp = |name: &str, samples: usize, estimator: IntegralEstimator, exact: f64| {
        let all = lesson.sample(name, runs, |u| estimator.value(ramp, 1, samples, u));
        Number::mean(name, exact, &all.variances(), 5e-2)
    };
    let of_slope = |name: &str, estimator: IntegralEstimator, exact: f64| {
        let all = lesson.sample(name, runs, |u| estimator.value(slope, 2, 64, u));
        Number::mean(name, exact, &all.variances(), 5e-2)
    };
    vec![
        of_ramp(
            "V for 2x, 16 plain samples: 1/(3N)",
            16,
            IntegralEstimator::Plain,
            1.0 / 48.0,
        ),
        of_ramp(
            "V for 2x, 16 strata: 1/(3N³)",
            16,
            IntegralEstimator::Jittered,
            1.0 / 12_288.0,
        ),
        of_ramp(
            "V for 2x, 64 strata",
            64,
            IntegralEstimator::Jittered,
            1.0 / 786_432.0,
        ),
        of_slope(
            "V for x + y, 64 plain samples: 1/(6N)",
            IntegralEstimator::Plain,
            1.0 / 384.0,
        ),
        of_slope(
            "V for x + y, 8 × 8 strata: 1/(6N²)",
            IntegralEstimator::Jittered,
            1.0 / 24_576.0,
        ),
        of_slope(
            "V for x + y, Latin hypercube: 1/(6N³)",
            IntegralEstimator::LatinHypercube,
            1.0 / 1_572_864.0,
        ),
    ]
}

fn slopes(
    smooth: &[(IntegralEstimator, ErrorCurve)],
    edge: &[(IntegralEstimator, ErrorCurve)],
) -> Vec<Number> {
    let fallen = |name: &str, curve: &ErrorCurve, exact: f64| {
        let [slope, error] = curve.slope();
        Number::new(name, exact, slope, error, 0.03)
    };
    vec![
        fallen("slope of the error, x + y, plain", &smooth[0].1, -0.5),
        fallen("slope of the error, x + y, jittered", &smooth[1].1, -1.0),
        fallen("slope of the error, edge, plain", &edge[0].1, -0.5),
    ]
}

fn curves(
    lesson: &Lesson<'_>,
    experiment: &str,
    f: fn(&[f64]) -> f64,
    exact: f64,
) -> Vec<(IntegralEstimator, ErrorCurve)> {
    let runs = lesson.samples(2000).max(1000);
    let curve = |estimator: IntegralEstimator| {
        let experiment = format!("{experiment} {}", estimator.name());
        let calls = powers_of_two(2, 12, 2);
        let curve = ErrorCurve::measure(lesson, &experiment, runs, &calls, exact, |u, n| {
            estimator.estimate(f, 2, n, u)
        });
        (estimator, curve)
    };
    IntegralEstimator::ALL.map(curve).to_vec()
}

fn plot(title: &str, reading: &str, curves: &[(IntegralEstimator, ErrorCurve)]) -> Plot {
    let series = curves.iter().enumerate();
    Plot {
        title: title.to_owned(),
        reading: reading.to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("samples N"),
        y: Axis::log("root mean square error"),
        series: series
            .map(|(hue, (estimator, curve))| curve.series(estimator.name(), Mark::Marks, hue))
            .collect(),
    }
}

fn technique(lesson: &Lesson<'_>, estimator: IntegralEstimator) -> MeasuredTechnique {
    let runs = lesson.samples(20_000);
    let experiment = format!("technique {}", estimator.name());
    let all = lesson.sample(&experiment, runs, |u| {
        estimator.value(|x| Integrand::Ball.eval(x), 2, 256, u)
    });
    let technique = MeasuredTechnique::new(estimator.name(), &all.all(), all.cost());
    match estimator {
        IntegralEstimator::Plain => technique.exactly(Integrand::Ball.variance(2) / 256.0),
        _ => technique,
    }
}

/// Plots the positions of 64 samples, recorded in the integrand.
fn scatter(lesson: &Lesson<'_>, estimator: IntegralEstimator) -> Plot {
    let points = RefCell::new(Vec::new());
    let note = |x: &[f64]| {
        points.borrow_mut().push([x[0], x[1]]);
        0.0
    };
    let mut uniform = lesson.uniform("scatter", estimator as usize);
    estimator.estimate(note, 2, 64, &mut uniform);
    let lines = (1..8).flat_map(|cell| {
        let at = f64::from(cell) / 8.0;
        let gap = [f64::NAN; 2];
        [[at, 0.0], [at, 1.0], gap, [0.0, at], [1.0, at], gap]
    });
    let cells = Series::new("", Mark::Guide, 6, lines.collect());
    let samples = Series::new("", Mark::Dots, estimator as usize, points.into_inner());
    let strata = (estimator == IntegralEstimator::Jittered).then_some(cells);
    Plot {
        title: format!("64 samples, {}", estimator.name()),
        reading: match estimator {
            IntegralEstimator::Plain => "Clusters and gaps.",
            IntegralEstimator::Jittered => "One in each of 8 × 8 cells.",
            IntegralEstimator::LatinHypercube => "One in each of 64 rows and 64 columns.",
        }
        .to_owned(),
        shape: AspectRatio::Square,
        x: Axis::linear("x").over(0.0, 1.0),
        y: Axis::linear("y").over(0.0, 1.0),
        series: strata.into_iter().chain([samples]).collect(),
    }
}
