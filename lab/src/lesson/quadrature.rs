//! Lesson on quadrature against Monte Carlo, as the dimension grows.
//!
//! Measure: integrals over the unit cube of d dimensions; cost in calls of the integrand.
//! Range: d from 1 to 12, up to 65536 calls.
//! Source: errors of order N^(-2/d) and N^(-4/d) against N^(-1/2). Tested in `lab/tests/reports/lesson.rs`.

use super::error_curve::{ErrorCurve, powers_of_two};
use super::number::{MeasuredTechnique, Number};
use super::page::{Finding, Formula, Page};
use super::topic::{Lesson, Topic};
use super::uniform::Uniform;
use crate::course::integrands::Integrand;
use crate::course::monte_carlo::{integrate_plain, integrate_stratified};
use crate::course::quadrature::QuadratureRule;
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use etendue::Result;
use etendue::internals::math::stats::Moments;

pub const TOPIC: Topic = Topic {
    name: "quadrature",
    title: "Quadrature against Monte Carlo",
    summary: "Quadrature rules win in one dimension, Monte Carlo in many: where the one overtakes \
              the other.",
    weight: 12.0,
    run,
};

const SMOOTH: Integrand = Integrand::Exponential;
const EDGE: Integrand = Integrand::HalfSpace;

/// The maximum number of calls of one estimate, as an exponent of two.
const MAX_CALLS: u32 = 16;

/// The number of calls at which dimensions are compared.
const CALLS: usize = 4097;

const RULES: [(QuadratureRule, &str); 2] = [
    (QuadratureRule::Trapezoid, "trapezoid"),
    (QuadratureRule::Simpson, "Simpson"),
];

fn plain(integrand: Integrand, d: u32, calls: usize, uniform: &mut Uniform) -> f64 {
    integrate_plain(|x| integrand.eval(x), d, calls, &mut || uniform.double()).mean()
}

fn stratified(
    integrand: Integrand,
    d: u32,
    calls: usize,
    uniform: &mut Uniform,
) -> Option<(f64, usize)> {
    let mut draw = || uniform.double();
    let estimate = integrate_stratified(|x| integrand.eval(x), d, calls, &mut draw)?;
    Some((estimate.value, estimate.calls))
}

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    Ok(Page {
        claim: "A rule such as the trapezoidal one places its nodes on a grid. With N calls in d \
                dimensions a grid has only N^(1/d) nodes along each axis: at d = 12, four thousand \
                calls are two nodes per axis. The convergence rate of Monte Carlo does not depend \
                on d. So rules win by far in one dimension, and Monte Carlo wins in many; for an \
                integrand with an edge, where rules lose their order, it wins earlier. Light \
                transport has two dimensions for every bounce, and edges everywhere."
            .to_owned(),
        formulas: vec![
            Formula::new(
                r"\int_{[0,1]^d} f \;\approx\; \sum_{i_1=1}^{m}\cdots\sum_{i_d=1}^{m}
                  w_{i_1}\cdots w_{i_d}\, f(x_{i_1},\dots,x_{i_d}), \qquad N = m^d",
                "A rule in d dimensions, as a tensor product: m nodes along each axis cost m to \
                 the power d calls.",
            ),
            Formula::new(
                r"\text{trapezoid: } O(N^{-2/d}), \qquad \text{Simpson: } O(N^{-4/d}), \qquad
                  \text{Monte Carlo: } \sigma\,N^{-1/2}",
                "Convergence rates for smooth integrands. By order alone Monte Carlo overtakes the \
                 trapezoid from d = 4 on, Simpson from d = 8 on.",
            ),
            Formula::new(
                r"f(x) = \prod_{i=1}^{d} \frac{e^{x_i}}{e-1}, \qquad g(x) = 1 \;\text{ where }\;
                  x_1 + \dots + x_d < \frac{d}{2} + \frac{1}{4}, \;\text{ else } 0",
                "A smooth integrand and one with an edge, both with exact integrals for every d.",
            ),
        ],
        experiment: format!(
            "Both integrands are integrated by two rules, by plain and by stratified Monte Carlo, \
             with up to {} calls in 1, 2, 4 and 8 dimensions. Stratified means jittered where the \
             calls suffice for a grid, else a Latin hypercube. For Monte Carlo the root mean \
             square error of many runs is shown, for rules the error itself, which is \
             deterministic. Then the calls are fixed at {CALLS}, and d runs from 1 to 12.",
            1 << MAX_CALLS
        ),
        findings: findings(lesson),
    })
}

fn findings(lesson: &Lesson<'_>) -> Vec<Finding> {
    let mut numbers = numbers(lesson);
    let mut plots = Vec::new();
    for d in [1, 2, 4, 8] {
        let (curve, plot) = by_calls(lesson, SMOOTH, d);
        let [slope, error] = curve.slope();
        let name = format!("slope of the error of Monte Carlo, d = {d}");
        numbers.push(Number::new(name, -0.5, slope, error, 0.05));
        plots.push(plot);
        lesson.progress(0.1 * f64::from(d));
    }
    vec![
        Finding::Plots {
            plots: vec![
                by_dimension(lesson, SMOOTH, "Smooth integrand"),
                by_dimension(lesson, EDGE, "Integrand with an edge"),
            ],
        },
        Finding::Plots { plots },
        Finding::Plots {
            plots: [1, 4].map(|d| by_calls(lesson, EDGE, d).1).to_vec(),
        },
        Finding::Numbers {
            reading: "The slope of Monte Carlo's error is −1/2 in every dimension.".to_owned(),
            numbers,
        },
        Finding::Techniques {
            reading: format!(
                "One estimate of the smooth integral from {CALLS} calls, in two and in eight \
                 dimensions. Where a grid is fine, strata are worth many times the samples; where \
                 it is coarse they help little."
            ),
            techniques: techniques(lesson),
        },
    ]
}

fn numbers(lesson: &Lesson<'_>) -> Vec<Number> {
    let simpson = |d, nodes| rule(QuadratureRule::Simpson, SMOOTH, d, nodes);
    let mut numbers = vec![
        Number::certain("Simpson, d = 1, 1025 nodes, smooth", 1.0, simpson(1, 1025)),
        Number::certain(
            "Simpson, d = 2, 65 × 65 nodes, smooth",
            1.0,
            simpson(2, 65 * 65),
        ),
    ];
    for d in [1, 4, 12] {
        for (integrand, name) in [(SMOOTH, "smooth"), (EDGE, "edge")] {
            let experiment = format!("mean {d} {name}");
            let samples = lesson.sample(&experiment, 1 << 19, |u| plain(integrand, d, 1, u));
            let exact = integrand.integral(d);
            let title = format!("Monte Carlo, d = {d}, {name}");
            numbers.push(Number::mean(title, exact, &samples.all(), 1e-2));
            let (exact, title) = (
                integrand.variance(d),
                format!("its variance, d = {d}, {name}"),
            );
            numbers.push(Number::mean(title, exact, &samples.variances(), 3e-2));
        }
    }
    numbers
}

fn rule(rule: QuadratureRule, integrand: Integrand, d: u32, calls: usize) -> f64 {
    let estimate = rule.integrate_cube(|x| integrand.eval(x), d, calls);
    estimate.map_or(f64::NAN, |estimate| estimate.value)
}

/// Plots the error over the number of calls, and returns the error curve of plain Monte Carlo as well.
fn by_calls(lesson: &Lesson<'_>, integrand: Integrand, d: u32) -> (ErrorCurve, Plot) {
    let exact = integrand.integral(d);
    // One more than a power: a grid whose cell borders coincide with the edge would have no error at all.
    let calls: Vec<usize> = powers_of_two(2, MAX_CALLS, 2)
        .iter()
        .map(|n| n + 1)
        .collect();
    let runs = lesson.samples(300).max(100);
    let f = |x: &[f64]| integrand.eval(x);
    let mut series: Vec<Series> = Vec::new();
    for (hue, (rule, name)) in RULES.into_iter().enumerate() {
        let estimates = calls.iter().filter_map(|&n| rule.integrate_cube(f, d, n));
        let mut points: Vec<[f64; 2]> = estimates
            .map(|estimate| [estimate.calls as f64, (estimate.value - exact).abs()])
            // Smaller errors are rounding.
            .filter(|point| point[1] > 1e-14)
            .collect();
        points.dedup_by_key(|point| point[0]);
        series.push(Series::new(name, Mark::Marks, hue + 1, points));
    }
    let experiment = |name: &str| format!("{name} {d} {integrand:?}");
    let plain = ErrorCurve::measure(lesson, &experiment("plain"), runs, &calls, exact, |u, n| {
        Some((plain(integrand, d, n, u), n))
    });
    let strata = experiment("stratified");
    let strata = ErrorCurve::measure(lesson, &strata, runs, &calls, exact, |u, n| {
        stratified(integrand, d, n, u)
    });
    series.push(plain.series("Monte Carlo", Mark::Marks, 0));
    series.push(strata.series("stratified", Mark::Marks, 3));
    let kind = if integrand.is_smooth() {
        "smooth"
    } else {
        "with an edge"
    };
    let plot = Plot {
        title: format!("d = {d}, {kind}"),
        reading: reading(integrand.is_smooth(), d).to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("calls N"),
        y: Axis::log("error"),
        series,
    };
    (plain, plot)
}

fn reading(smooth: bool, d: u32) -> &'static str {
    match (smooth, d) {
        (true, 1) => {
            "A few hundred nodes bring Simpson's rule to the limit of double precision. By 65 \
             thousand samples Monte Carlo has three digits."
        }
        (true, 2) => {
            "Rules still win, but each digit takes twice as many powers of ten in calls as before."
        }
        (true, 4) => {
            "The trapezoid's error falls as fast as that of Monte Carlo now, and is close to it; \
             Simpson's still falls faster."
        }
        (true, _) => {
            "A grid of 65536 calls has four nodes per axis: the trapezoid is far behind, and the \
             calls suffice for only one grid of Simpson's rule."
        }
        (false, 1) => {
            "With an edge, all but plain Monte Carlo have an error of about 1/N: that of the one \
             cell or interval with the edge in it."
        }
        (false, _) => {
            "The errors of rules vary irregularly: a small error on one grid says nothing about \
             the next, and no error estimate shows it."
        }
    }
}

/// Plots the error over the dimension, at a fixed number of calls.
fn by_dimension(lesson: &Lesson<'_>, integrand: Integrand, title: &str) -> Plot {
    let runs = lesson.samples(300).max(100);
    let dimensions = || 1..=12_u32;
    let f = |x: &[f64]| integrand.eval(x);
    // Relative to the spread of the integrand, which differs between dimensions.
    let relative = |d: u32, error: f64| [f64::from(d), error / integrand.variance(d).sqrt()];
    let mut series = vec![Series::new(
        "σ/√N",
        Mark::Guide,
        6,
        [1.0, 12.0].map(|d| [d, (CALLS as f64).powf(-0.5)]).to_vec(),
    )];
    for (hue, (rule, name)) in RULES.into_iter().enumerate() {
        let points = dimensions().filter_map(|d| {
            let estimate = rule.integrate_cube(f, d, CALLS)?;
            Some(relative(d, (estimate.value - integrand.integral(d)).abs()))
        });
        series.push(Series::new(name, Mark::Marks, hue + 1, points.collect()));
    }
    let chance = |name: &str, hue: usize, estimate: fn(Integrand, u32, &mut Uniform) -> f64| {
        let points = dimensions().map(|d| {
            let exact = integrand.integral(d);
            let experiment = format!("by dimension {name} {d} {integrand:?}");
            let squares = lesson.repeat(&experiment, runs, |u| {
                (estimate(integrand, d, u) - exact).powi(2)
            });
            relative(d, Moments::of(squares).mean().sqrt())
        });
        Series::new(name, Mark::Marks, hue, points.collect())
    };
    series.push(chance("Monte Carlo", 0, |integrand, d, u| {
        plain(integrand, d, CALLS, u)
    }));
    series.push(chance("stratified", 3, |integrand, d, u| {
        stratified(integrand, d, CALLS, u).map_or(f64::NAN, |(value, _)| value)
    }));
    Plot {
        title: title.to_owned(),
        reading: "The error in standard deviations of the integrand. Monte Carlo is a horizontal \
                  line. A rule's line ends where the calls do not suffice for its smallest grid, \
                  two or three nodes per axis."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::linear("dimension d").over(0.5, 12.5),
        y: Axis::log("error / σ"),
        series,
    }
}

fn techniques(lesson: &Lesson<'_>) -> Vec<MeasuredTechnique> {
    let estimates = lesson.samples(1000);
    let mut techniques = Vec::new();
    for d in [2, 8] {
        let samples = lesson.sample(&format!("technique plain {d}"), estimates, |u| {
            plain(SMOOTH, d, CALLS, u)
        });
        let technique =
            MeasuredTechnique::new(format!("plain, d = {d}"), &samples.all(), samples.cost());
        techniques.push(technique.exactly(SMOOTH.variance(d) / CALLS as f64));
        let samples = lesson.sample(&format!("technique stratified {d}"), estimates, |u| {
            stratified(SMOOTH, d, CALLS, u).map_or(f64::NAN, |(value, _)| value)
        });
        let name = format!("stratified, d = {d}");
        techniques.push(MeasuredTechnique::new(name, &samples.all(), samples.cost()));
    }
    techniques
}
