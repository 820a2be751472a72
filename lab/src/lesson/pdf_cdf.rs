//! Lesson on the density and the distribution function, and on sampling by inversion.
//!
//! Measure: densities per unit of x in [0, 1].
//! Range: a piecewise linear density, which is inverted exactly.
//! Source: P(X) is uniform for X with the continuous distribution function P. Tested in `lab/tests/reports/lesson.rs`.

use super::number::Number;
use super::page::{Finding, Formula, Page};
use super::topic::{Lesson, Topic};
use crate::course::piecewise_linear::PiecewiseLinear;
use crate::course::quadrature::QuadratureRule;
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use etendue::Result;
use etendue::internals::math::stats::Moments;

pub const TOPIC: Topic = Topic {
    name: "pdf-cdf",
    title: "Density and distribution function",
    summary: "From a density to its distribution function, and back from uniform numbers by \
              inversion.",
    weight: 1.0,
    run,
};

/// The values of the density at its nodes, up to a factor.
const VALUES: [f64; 6] = [0.3, 2.2, 0.8, 0.6, 1.9, 0.0];

/// Samples for each number.
const SAMPLES: usize = 1 << 21;

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    let density = PiecewiseLinear::new([0.0, 1.0], &VALUES).expect("positive values");
    Ok(Page {
        claim: "A density p says how likely numbers are, relative to each other; it may exceed 1, \
                but its integral is 1. The distribution function P(x) is the probability of a \
                number up to x. It climbs from 0 to 1, steeply where the density is high. Uniform \
                numbers between 0 and 1, mapped by the inverse of P, are therefore dense where the \
                density is high: they have exactly this density."
            .to_owned(),
        formulas: vec![
            Formula::new(
                r"P(x) = \mathrm{P}\{X \le x\} = \int_{0}^{x} p(t)\,\mathrm{d}t, \qquad p(x) =
                  \frac{\mathrm{d}P(x)}{\mathrm{d}x}",
                "The distribution function (CDF) is the integral of the density (PDF).",
            ),
            Formula::new(
                r"X = P^{-1}(U), \qquad \mathrm{P}\{X \le x\} = \mathrm{P}\{U \le P(x)\} = P(x)",
                "Inversion: a uniform U, mapped by the inverse of P, has the distribution \
                 function P.",
            ),
            Formula::new(
                r"E[X] = \int_{0}^{1} x\,p(x)\,\mathrm{d}x, \qquad V[X] = \int_{0}^{1} x^2
                  p(x)\,\mathrm{d}x - E[X]^2",
                "Expected value and variance, now with a density in place of single \
                 probabilities.",
            ),
        ],
        experiment: format!(
            "A density of five straight lines is tabulated, as a renderer tabulates a measured \
             one. {} million uniform numbers are mapped by its inverse. Expected value and \
             variance are compared with exact integrals, and the histogram with the density. Then \
             the numbers are mapped by P again: the results have to be uniform, with E = 1/2 and V \
             = 1/12.",
            SAMPLES >> 20
        ),
        findings: vec![
            numbers(lesson, &density),
            Finding::Plots {
                plots: vec![histogram(lesson, &density), inversion(&density)],
            },
        ],
    })
}

fn numbers(lesson: &Lesson<'_>, density: &PiecewiseLinear) -> Finding {
    // Simpson's rule is exact for polynomials up to degree three between its nodes, and each linear piece has three
    // nodes.
    let nodes = 2 * (VALUES.len() - 1) + 1;
    let moment = |power: i32| {
        let f = |x: f64| x.powi(power) * density.pdf(x);
        let integral = QuadratureRule::Simpson.integrate(f, [0.0, 1.0], nodes);
        integral.expect("an odd number of nodes")
    };
    let x = lesson.sample("x", SAMPLES, |uniform| density.sample(uniform.double()));
    let back = lesson.sample("back", SAMPLES, |uniform| {
        density.invert(density.sample(uniform.double()))
    });
    let half = lesson.sample("half", SAMPLES, |uniform| {
        f64::from(u8::from(density.sample(uniform.double()) <= 0.5))
    });
    let below_half = density.invert(0.5);
    Finding::Numbers {
        reading: "The numbers have the moments of the density, and mapped by P they are uniform."
            .to_owned(),
        numbers: vec![
            Number::certain("∫ p(x) dx", 1.0, moment(0)),
            Number::mean("E[X]", moment(1), &x.all(), 2e-3),
            Number::mean("V[X]", moment(2) - moment(1).powi(2), &x.variances(), 2e-3),
            Number::mean("P(1/2)", below_half, &half.all(), 2e-3),
            Number::mean("E[P(X)]", 0.5, &back.all(), 2e-3),
            Number::mean("V[P(X)]", 1.0 / 12.0, &back.variances(), 2e-3),
        ],
    }
}

fn histogram(lesson: &Lesson<'_>, density: &PiecewiseLinear) -> Plot {
    const BINS: usize = 40;
    const SHOWN: usize = 20_000;
    let mut uniform = lesson.uniform("histogram", 0);
    let mut bins = [Moments::default(); BINS];
    for _ in 0..SHOWN {
        let x = density.sample(uniform.double());
        let bin = ((x * BINS as f64) as usize).min(BINS - 1);
        bins[bin].push(x);
    }
    let bar = |(index, bin): (usize, &Moments)| {
        let height = bin.count() as f64 / SHOWN as f64 * BINS as f64;
        [(index as f64 + 0.5) / BINS as f64, height]
    };
    let bars = bins.iter().enumerate().map(bar).collect();
    Plot {
        title: "Density p, and a histogram".to_owned(),
        reading: format!(
            "{SHOWN} samples in {BINS} bins follow the density. Where p exceeds 1 numbers are more \
             frequent than uniform ones."
        ),
        shape: AspectRatio::Wide,
        x: Axis::linear("x").over(0.0, 1.0),
        y: Axis::linear("density"),
        series: vec![
            Series::new("samples", Mark::Bars, 0, bars),
            Series::curve("p(x)", Mark::Line, 1, [0.0, 1.0], |x| density.pdf(x)),
        ],
    }
}

fn inversion(density: &PiecewiseLinear) -> Plot {
    const ARROWS: u32 = 16;
    let arrow = |index: u32| {
        let u = (f64::from(index) + 0.5) / f64::from(ARROWS);
        let x = density.sample(u);
        let name = if index == 0 { "from u to x" } else { "" };
        Series::new(name, Mark::Guide, 0, vec![[0.0, u], [x, u], [x, 0.0]])
    };
    let curve = Series::curve("P(x)", Mark::Line, 1, [0.0, 1.0], |x| density.invert(x));
    Plot {
        title: "Distribution function P, and its inverse".to_owned(),
        reading: "Sixteen evenly spaced u on the ordinate are mapped by the inverse of P. On the \
                  abscissa they are dense where P is steep, that is, where p is high."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::linear("x").over(0.0, 1.0),
        y: Axis::linear("u").over(0.0, 1.0),
        series: (0..ARROWS).map(arrow).chain([curve]).collect(),
    }
}
