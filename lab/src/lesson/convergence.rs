//! Lesson on convergence: variance falls as 1/N, and the error as 1/sqrt N.
//!
//! Measure: the integral of e^x / (e - 1) over [0, 1], which is 1.
//! Range: up to 4096 samples an estimate.
//! Source: variances of independent variables add up; the central limit theorem. Tested in `lab/tests/reports/lesson.rs`.

use super::error_curve::{ErrorCurve, powers_of_two};
use super::number::{MeasuredTechnique, Number};
use super::page::{Finding, Formula, Page};
use super::topic::{GroupedSamples, Lesson, Topic};
use super::uniform::Uniform;
use crate::course::integrands::Integrand;
use crate::course::monte_carlo::integrate_plain;
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use etendue::Result;
use etendue::internals::math::stats::Moments;
use etendue::internals::sampler::{Decision, Sampler, Sobol};
use std::f64::consts::TAU;

pub const TOPIC: Topic = Topic {
    name: "convergence",
    title: "Variance falls as 1/N, the error as 1/√N",
    summary: "Four times the samples for half the error, and the coverage of error bars.",
    weight: 3.0,
    run,
};

const INTEGRAND: Integrand = Integrand::Exponential;

/// Numbers of samples of the estimates in the tables.
const SIZES: [usize; 3] = [1, 16, 256];

/// Runs for each number of samples; the relative standard error of a variance is about the root of 2 / RUNS.
const RUNS: usize = 4096;

fn estimate(samples: usize, uniform: &mut Uniform) -> f64 {
    integrate_plain(|x| INTEGRAND.eval(x), 1, samples, &mut || uniform.double()).mean()
}

/// An estimate with the first Sobol' points, scrambled anew each time.
fn estimate_evenly(samples: usize, uniform: &mut Uniform) -> f64 {
    let mut sampler = Sobol::new(uniform.double().to_bits());
    let values = (0..samples).map(|index| {
        sampler.start([0, 0], index as u64);
        let [u] = sampler.draw(Decision::Time);
        INTEGRAND.eval(&[f64::from(u)])
    });
    values.sum::<f64>() / samples as f64
}

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    Ok(Page {
        claim:
            "The mean of N samples of f/p is an unbiased estimate of the integral. Its variance \
                is that of one sample divided by N, and the root of it, the standard error, falls \
                as one over the root of N: one more digit takes a hundred times the samples, in \
                any dimension. By the central limit theorem the errors are approximately \
                normally distributed, so that 68 of 100 are within one standard error, and 95 within two."
                .to_owned(),
        formulas: vec![
            Formula::new(
                r"\langle I\rangle_N = \frac{1}{N}\sum_{i=1}^{N}\frac{f(x_i)}{p(x_i)}, \qquad
                  E\big[\langle I\rangle_N\big] = \int f(x)\,\mathrm{d}x = I",
                "The estimator, which is unbiased.",
            ),
            Formula::new(
                r"V\big[\langle I\rangle_N\big] = \frac{1}{N}\,V\Big[\frac{f(X)}{p(X)}\Big] =
                  \frac{1}{N}\left(\int\frac{f^2(x)}{p(x)}\,\mathrm{d}x - I^2\right), \qquad
                  \sigma_N = \frac{\sigma}{\sqrt{N}}",
                "Its variance, and its standard error.",
            ),
            Formula::new(
                r"f(x) = \frac{e^x}{e-1}, \quad p(x) = 1: \qquad I = 1, \qquad V =
                  \frac{e+1}{2(e-1)} - 1 = 0.0820",
                "The integrand.",
            ),
            Formula::new(
                r"\epsilon = \frac{1}{V\,T}",
                "Efficiency: one over the variance times the time T that it took. As V falls with \
                 1/N while T grows with N, it does not depend on N, and can be compared between \
                 techniques.",
            ),
        ],
        experiment: format!(
            "The integral is estimated by N samples, {RUNS} times with new random numbers for each \
             of N = 1, 4, 16 … 4096. The spread of these estimates is the variance, and the root \
             of their mean squared distance from 1 the error."
        ),
        findings: findings(lesson),
    })
}

fn findings(lesson: &Lesson<'_>) -> Vec<Finding> {
    let runs = lesson.samples(RUNS).max(1024);
    let spread = |n: usize| lesson.sample(&format!("spread {n}"), 4 * runs, |u| estimate(n, u));
    let spreads = SIZES.map(|n| (n, spread(n)));
    let curve = ErrorCurve::measure(
        lesson,
        "errors",
        runs,
        &powers_of_two(0, 12, 2),
        1.0,
        |u, n| Some((estimate(n, u), n)),
    );
    let evenly = ErrorCurve::measure(
        lesson,
        "evenly",
        runs / 4,
        &powers_of_two(2, 12, 2),
        1.0,
        |u, n| Some((estimate_evenly(n, u), n)),
    );
    let shares = Shares::measure(lesson, runs);
    let techniques = spreads.iter().map(|(n, spread)| {
        let technique = MeasuredTechnique::new(format!("N = {n}"), &spread.all(), spread.cost());
        technique.exactly(variance(*n))
    });
    vec![
        Finding::Numbers {
            reading: "Estimates with more samples have the same mean and less variance.".to_owned(),
            numbers: numbers(&spreads, [&curve, &evenly], &shares),
        },
        Finding::Plots {
            plots: vec![errors(&curve, &evenly), shares.plot()],
        },
        Finding::Techniques {
            reading: "One estimate of N samples as a technique: its variance falls as its time \
                      grows, and the efficiency stays, except for the cost of starting an \
                      estimate."
                .to_owned(),
            techniques: techniques.collect(),
        },
    ]
}

/// The exact variance of an estimate of `samples` samples.
fn variance(samples: usize) -> f64 {
    INTEGRAND.variance(1) / samples as f64
}

fn numbers(
    spreads: &[(usize, GroupedSamples)],
    [curve, evenly]: [&ErrorCurve; 2],
    shares: &Shares,
) -> Vec<Number> {
    let mut numbers = Vec::new();
    for (n, spread) in spreads {
        let named = |what: &str| format!("{what} of estimates of N = {n}");
        numbers.push(Number::mean(named("E"), 1.0, &spread.all(), 1e-2));
        numbers.push(Number::mean(
            named("V"),
            variance(*n),
            &spread.variances(),
            4e-2,
        ));
    }
    let [slope, error] = curve.slope();
    numbers.push(Number::new(
        "slope of the error, log-log",
        -0.5,
        slope,
        error,
        0.02,
    ));
    let [slope, error] = evenly.slope();
    numbers.push(Number::new(
        "slope of the error of Sobol' points",
        -1.5,
        slope,
        error,
        0.02,
    ));
    for (sigmas, exact) in [(1, 0.682_689), (2, 0.954_500)] {
        let within = shares.within(f64::from(sigmas));
        let name = format!("share of errors within {sigmas} σ, N = 64");
        numbers.push(Number::mean(name, exact, &within, 2e-2));
    }
    numbers
}

fn errors(curve: &ErrorCurve, evenly: &ErrorCurve) -> Plot {
    let guide = |n: usize| [n as f64, variance(n).sqrt()];
    Plot {
        title: "Root mean square error".to_owned(),
        reading: "A power of N is a straight line on logarithmic axes, and its exponent is the \
                  slope: the error loses one power of ten while N gains two. The band is two \
                  standard errors wide to each side. Low-discrepancy points are not independent, \
                  and on a function as smooth as this one their error falls three times as \
                  steeply: this is the purpose of the sampler `sobol`."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("samples N"),
        y: Axis::log("error"),
        series: vec![
            Series::new("σ/√N", Mark::Guide, 1, vec![guide(1), guide(4096)]),
            curve.series("independent numbers", Mark::Marks, 0),
            evenly.series("Sobol' points", Mark::Marks, 2),
        ],
    }
}

/// Errors of many estimates, in standard errors.
struct Shares {
    errors: Vec<f64>,
}

impl Shares {
    fn measure(lesson: &Lesson<'_>, runs: usize) -> Self {
        const N: usize = 64;
        let sigma = variance(N).sqrt();
        let errors = lesson.repeat("shares", 4 * runs, |u| (estimate(N, u) - 1.0) / sigma);
        Self { errors }
    }

    fn within(&self, sigmas: f64) -> Moments {
        let inside = |error: &f64| f64::from(u8::from(error.abs() <= sigmas));
        Moments::of(self.errors.iter().map(inside))
    }

    fn plot(&self) -> Plot {
        const WIDTH: f64 = 0.2;
        let half = 20_i32;
        let bars = (-half..half).map(|bin| {
            let start = f64::from(bin) * WIDTH;
            let inside = |error: &&f64| (start..start + WIDTH).contains(*error);
            let count = self.errors.iter().filter(inside).count();
            [
                start + 0.5 * WIDTH,
                count as f64 / self.errors.len() as f64 / WIDTH,
            ]
        });
        let bell = |x: f64| (-0.5 * x * x).exp() / TAU.sqrt();
        Plot {
            title: "Errors of estimates of 64 samples".to_owned(),
            reading:
                "In units of the standard error. The samples themselves follow an exponential \
                      curve; their means follow the normal distribution."
                    .to_owned(),
            shape: AspectRatio::Wide,
            x: Axis::linear("error / σ").over(-4.0, 4.0),
            y: Axis::linear("density"),
            series: vec![
                Series::new("measured", Mark::Bars, 0, bars.collect()),
                Series::curve("normal distribution", Mark::Line, 1, [-4.0, 4.0], bell),
            ],
        }
    }
}
