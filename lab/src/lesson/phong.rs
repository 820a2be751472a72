//! Lesson on Phong's lobe, sampled with three densities.
//!
//! Measure: the albedo of a lobe of exponent n seen along the normal, (n + 2) / (2 pi) times the integral of cos^(n +
//! 1), which is 1.
//! Range: exponents from 1 to 1000.
//! Source: moments of powers of the cosine. Tested in `lab/tests/reports/lesson.rs`.

use super::number::{MeasuredTechnique, Number};
use super::page::{Finding, Formula, Page};
use super::topic::{Lesson, Topic};
use super::uniform::Uniform;
use crate::course::direction::{PDF_HEMISPHERE_UNIFORM, sample_hemisphere_uniform};
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use etendue::Result;
use etendue::internals::math::vec::Vec3;
use etendue::internals::sampling::cosine_power::{
    cosine_power, one_minus_cos, pdf_cosine_power, sample_cosine_power,
};
use etendue::internals::sampling::warp::{pdf_hemisphere_cosine, sample_hemisphere_cosine};
use std::f64::consts::TAU;

pub const TOPIC: Topic = Topic {
    name: "phong",
    title: "Phong's lobe",
    summary: "The narrower a highlight, the more it matters that its own shape is sampled.",
    weight: 2.0,
    run,
};

/// Samples for each number.
const SAMPLES: usize = 1 << 20;

const EXPONENTS: [f32; 7] = [1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0];

/// The exponent in the table of techniques.
const SHOWN: f32 = 50.0;

/// A density of directions, with its sampling method.
#[derive(Clone, Copy)]
struct Density {
    name: &'static str,
    draw: fn(&mut Uniform, f32) -> Vec3,
    pdf: fn(Vec3, f32) -> f32,
    /// The variance of the albedo, for an exponent.
    variance: fn(f64) -> f64,
}

const DENSITIES: [Density; 3] = [
    Density {
        name: "uniform",
        draw: |u, _| sample_hemisphere_uniform(u.pair()),
        pdf: |_, _| PDF_HEMISPHERE_UNIFORM,
        variance: |n| (n + 2.0).powi(2) / (2.0 * n + 3.0) - 1.0,
    },
    Density {
        name: "by the cosine",
        draw: |u, _| sample_hemisphere_cosine(u.pair()),
        pdf: |w, _| pdf_hemisphere_cosine(w.z),
        variance: |n| n * n / (4.0 * (n + 1.0)),
    },
    Density {
        name: "by the lobe",
        draw: |u, n| sample_cosine_power(u.pair(), n),
        pdf: |w, n| pdf_cosine_power(one_minus_cos(w, Vec3::Z), n),
        variance: |n| 1.0 / ((n + 1.0) * (n + 3.0)),
    },
];

impl Density {
    /// f cos / p for one direction.
    fn estimate(self, n: f32, uniform: &mut Uniform) -> f64 {
        let w = (self.draw)(uniform, n);
        let f = (f64::from(n) + 2.0) / TAU * f64::from(cosine_power(one_minus_cos(w, Vec3::Z), n));
        let pdf = f64::from((self.pdf)(w, n));
        // Far from a narrow lobe both may underflow to 0.
        if f == 0.0 {
            0.0
        } else {
            f * f64::from(w.z) / pdf
        }
    }
}

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    Ok(Page {
        claim: "A glossy surface reflects into a lobe that is the narrower, the higher its \
                exponent n. Directions sampled without regard to it rarely hit it, and when they \
                do, the value is high: their variance grows in proportion to n. With the lobe's \
                own density only the factor outside the lobe remains, here the cosine, and that \
                varies the less, the narrower the lobe."
            .to_owned(),
        formulas: vec![
            Formula::new(
                r"\rho = \int_{H} \frac{n+2}{2\pi}(\cos\theta)^n\,\cos\theta\,\mathrm{d}\omega = 1",
                "The quantity: the albedo of the lobe, seen along the normal.",
            ),
            Formula::new(
                r"p(\omega) = \frac{n+1}{2\pi}(\cos\theta)^n: \qquad \cos\theta =
                  (1-U_1)^{\frac{1}{n+1}}, \qquad \varphi = 2\pi U_2",
                "The lobe by inversion.",
            ),
            Formula::new(
                r"V_{\text{uniform}} = \frac{(n+2)^2}{2n+3} - 1, \qquad V_{\cos} =
                  \frac{n^2}{4(n+1)}, \qquad V_{\text{lobe}} = \frac{1}{(n+1)(n+3)}",
                "The variances of one sample, in closed form.",
            ),
        ],
        experiment: "The albedo, which is 1, is estimated by each of the three densities for \
                     exponents from 1 to 1000, with a million samples each."
            .to_owned(),
        findings: findings(lesson),
    })
}

fn findings(lesson: &Lesson<'_>) -> Vec<Finding> {
    let mut numbers = Vec::new();
    let mut series = Vec::new();
    for (hue, density) in DENSITIES.into_iter().enumerate() {
        let mut measured = Vec::new();
        for n in EXPONENTS {
            let experiment = format!("{} {n}", density.name);
            let samples = lesson.sample(&experiment, SAMPLES, |u| density.estimate(n, u));
            if [1.0, 30.0, 1000.0].contains(&n) {
                let name = format!("ρ for n = {n}, {}", density.name);
                numbers.push(Number::mean(name, 1.0, &samples.all(), 0.03));
            }
            measured.push([f64::from(n), samples.variances().mean().sqrt()]);
        }
        let exact = |log: f64| {
            let n = 10.0_f64.powf(log);
            [n, (density.variance)(n).sqrt()]
        };
        let curve = (0..=60).map(|step| exact(0.05 * f64::from(step))).collect();
        series.push(Series::new(density.name, Mark::Line, hue, curve));
        series.push(Series::new("", Mark::Dots, hue, measured));
    }
    let techniques = DENSITIES.map(|density| {
        let samples = lesson.sample(density.name, SAMPLES, |u| density.estimate(SHOWN, u));
        let technique = MeasuredTechnique::new(density.name, &samples.all(), samples.cost());
        let variance = (density.variance)(f64::from(SHOWN));
        let name = format!("V for n = {SHOWN}, {}", density.name);
        numbers.push(Number::mean(name, variance, &samples.variances(), 0.02));
        technique.exactly(variance)
    });
    let plot = Plot {
        title: "Standard deviation of one sample".to_owned(),
        reading: "Lines are exact, dots measured. To halve an error takes four times the samples: \
                  at n = 1000 the lobe's own density saves a factor of half a billion over \
                  uniform directions."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("exponent n"),
        y: Axis::log("standard deviation σ"),
        series,
    };
    vec![
        Finding::Numbers {
            reading: "All three are unbiased, whatever they cost.".to_owned(),
            numbers,
        },
        Finding::Plots { plots: vec![plot] },
        Finding::Plots {
            plots: [1.0, 10.0, 100.0].map(|n| lobe(lesson, n)).to_vec(),
        },
        Finding::Techniques {
            reading: format!(
                "For the exponent {SHOWN}. A sample of the lobe costs a logarithm and an \
                 exponential more, and is worth it."
            ),
            techniques: techniques.to_vec(),
        },
    ]
}

fn lobe(lesson: &Lesson<'_>, n: f32) -> Plot {
    let mut uniform = lesson.uniform("lobe", n as usize);
    let points = (0..1000).map(|_| {
        let w = sample_cosine_power(uniform.pair(), n);
        [f64::from(w.x), f64::from(w.y)]
    });
    Plot {
        title: format!("1000 directions, n = {n}"),
        reading: "Seen from above.".to_owned(),
        shape: AspectRatio::Square,
        x: Axis::linear("x").over(-1.05, 1.05),
        y: Axis::linear("y").over(-1.05, 1.05),
        series: vec![Series::new("", Mark::Dots, 2, points.collect())],
    }
}
