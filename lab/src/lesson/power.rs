//! Lesson on the power function as a density, sampled in two ways.
//!
//! Measure: densities per unit of x in [0, 1].
//! Range: integer exponents.
//! Source: E = (n + 1) / (n + 2), V = (n + 1) / ((n + 2)^2 (n + 3)). Tested in `lab/tests/reports/lesson.rs`.

use super::number::{MeasuredTechnique, Number};
use super::page::{Finding, Formula, Page};
use super::topic::{GroupedSamples, Lesson, Topic};
use super::uniform::Uniform;
use crate::course::power::{pdf_power, sample_power, sample_power_as_maximum};
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use etendue::Result;

pub const TOPIC: Topic = Topic {
    name: "power-function",
    title: "The power function",
    summary: "p(x) = (n + 1) xⁿ, by inversion and as the maximum of n + 1 uniform numbers.",
    weight: 1.0,
    run,
};

/// Samples for each number.
const SAMPLES: usize = 1 << 20;

const EXPONENTS: [u32; 3] = [1, 4, 15];

fn by_inversion(n: u32, uniform: &mut Uniform) -> f64 {
    sample_power(uniform.double(), f64::from(n))
}

fn as_maximum(n: u32, uniform: &mut Uniform) -> f64 {
    let numbers = (0..=n).map(|_| uniform.double());
    sample_power_as_maximum(numbers).expect("there is at least one number")
}

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    Ok(Page {
        claim: "The density of the power function can be sampled by inversion, at the cost of a \
                root. It can also be sampled without one: the maximum of n + 1 uniform numbers has \
                the same density, as it is at most x if and only if all of them are."
            .to_owned(),
        formulas: vec![
            Formula::new(
                r"p(x) = (n+1)\,x^n, \qquad P(x) = x^{n+1}, \qquad X = P^{-1}(U) =
                  U^{\frac{1}{n+1}}",
                "Density, distribution function and its inverse, on the interval from 0 to 1.",
            ),
            Formula::new(
                r"\mathrm{P}\{\max(U_1,\dots,U_{n+1}) \le x\} = \prod_{i=1}^{n+1} \mathrm{P}\{U_i
                  \le x\} = x^{n+1}",
                "Independent probabilities multiply, so the maximum has the same distribution \
                 function.",
            ),
            Formula::new(
                r"E[X] = \frac{n+1}{n+2}, \qquad V[X] = \frac{n+1}{(n+2)^2 (n+3)}",
                "The exact moments for both.",
            ),
        ],
        experiment: "For n = 1, 4 and 15 a million numbers are drawn by each technique. Expected \
                     values and variances are compared with the exact ones, histograms with the \
                     density, and the times of both techniques with each other."
            .to_owned(),
        findings: findings(lesson),
    })
}

fn findings(lesson: &Lesson<'_>) -> Vec<Finding> {
    let mut numbers = Vec::new();
    let mut techniques = Vec::new();
    for n in EXPONENTS {
        let m = f64::from(n);
        let expected = (m + 1.0) / (m + 2.0);
        let variance = (m + 1.0) / ((m + 2.0).powi(2) * (m + 3.0));
        let ways: [(&str, GroupedSamples); 2] = [
            (
                "inversion",
                lesson.sample(&format!("inversion {n}"), SAMPLES, |u| by_inversion(n, u)),
            ),
            (
                "maximum",
                lesson.sample(&format!("maximum {n}"), SAMPLES, |u| as_maximum(n, u)),
            ),
        ];
        for (way, samples) in ways {
            let name = |what: &str| format!("{what}, n = {n}, by {way}");
            numbers.push(Number::mean(name("E[X]"), expected, &samples.all(), 2e-3));
            numbers.push(Number::mean(
                name("V[X]"),
                variance,
                &samples.variances(),
                1e-2,
            ));
            let name = format!("n = {n}, by {way}");
            techniques.push(
                MeasuredTechnique::new(name, &samples.all(), samples.cost()).exactly(variance),
            );
        }
    }
    vec![
        Finding::Numbers {
            reading: "Both techniques have the moments of the density.".to_owned(),
            numbers,
        },
        Finding::Techniques {
            reading: "The variance is that of the density for both: efficiency 1/(V·T) here \
                      compares times alone. The maximum takes time in proportion to n + 1, the \
                      root takes the same for any n."
                .to_owned(),
            techniques,
        },
        Finding::Plots {
            plots: vec![densities(lesson)],
        },
    ]
}

fn densities(lesson: &Lesson<'_>) -> Plot {
    const BINS: usize = 40;
    let count = lesson.samples(400_000);
    let series = EXPONENTS.into_iter().enumerate().flat_map(|(hue, n)| {
        let exact = Series::curve(format!("n = {n}"), Mark::Line, hue, [0.0, 1.0], |x| {
            pdf_power(x, f64::from(n))
        });
        let mut uniform = lesson.uniform("histogram", n as usize);
        let mut bins = [0_u32; BINS];
        for _ in 0..count {
            let x = as_maximum(n, &mut uniform);
            bins[((x * BINS as f64) as usize).min(BINS - 1)] += 1;
        }
        let dot = |(index, &bin): (usize, &u32)| {
            let x = (index as f64 + 0.5) / BINS as f64;
            [x, f64::from(bin) / count as f64 * BINS as f64]
        };
        let dots = bins.iter().enumerate().map(dot).collect();
        [exact, Series::new("", Mark::Dots, hue, dots)]
    });
    Plot {
        title: "Densities, and histograms of maxima".to_owned(),
        reading: "Lines are (n + 1) xⁿ, dots the shares of maxima in 40 bins. The more numbers \
                  there are, the closer to 1 is their maximum."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::linear("x").over(0.0, 1.0),
        y: Axis::linear("density").over(0.0, 16.0),
        series: series.collect(),
    }
}
