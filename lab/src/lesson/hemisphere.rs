//! Lesson on directions over the hemisphere: uniform and cosine-weighted.
//!
//! Measure: densities per steradian; irradiance for a sky of radiance cos(theta).
//! Range: the hemisphere about z.
//! Source: E = integral of cos^2 = 2 pi / 3; variances 16 pi^2 / 45 and pi^2 / 18. Tested in `lab/tests/reports/lesson.rs`.

use super::number::{MeasuredTechnique, Number};
use super::page::{Finding, Formula, Page};
use super::topic::{GroupedSamples, Lesson, Topic};
use super::uniform::Uniform;
use crate::course::direction::{
    BALL_IN_CUBE, PDF_HEMISPHERE_UNIFORM, sample_hemisphere_by_rejection,
    sample_hemisphere_cosine_by_inversion, sample_hemisphere_uniform,
};
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use etendue::Result;
use etendue::internals::math::vec::Vec3;
use etendue::internals::sampling::warp::{pdf_hemisphere_cosine, sample_hemisphere_cosine};
use std::f64::consts::PI;

pub const TOPIC: Topic = Topic {
    name: "hemisphere",
    title: "Directions over the hemisphere",
    summary: "Uniform and cosine-weighted directions, by rejection and by inversion.",
    weight: 1.0,
    run,
};

/// Samples for each number.
const SAMPLES: usize = 1 << 20;

/// A method of sampling directions.
#[derive(Clone, Copy)]
struct HemisphereSampling {
    name: &'static str,
    draw: fn(&mut Uniform) -> Vec3,
    pdf: fn(f32) -> f32,
    is_cosine: bool,
}

const ESTIMATORS: [HemisphereSampling; 4] = [
    HemisphereSampling {
        name: "uniform, rejection and flip",
        draw: |u| {
            let drawn = sample_hemisphere_by_rejection(&mut || u.single());
            drawn.map_or(Vec3::NAN, |drawn| drawn.value)
        },
        pdf: |_| PDF_HEMISPHERE_UNIFORM,
        is_cosine: false,
    },
    HemisphereSampling {
        name: "uniform, inversion",
        draw: |u| sample_hemisphere_uniform(u.pair()),
        pdf: |_| PDF_HEMISPHERE_UNIFORM,
        is_cosine: false,
    },
    HemisphereSampling {
        name: "cosine, inversion",
        draw: |u| sample_hemisphere_cosine_by_inversion(u.pair()),
        pdf: pdf_hemisphere_cosine,
        is_cosine: true,
    },
    HemisphereSampling {
        name: "cosine, Malley's lifted disk",
        draw: |u| sample_hemisphere_cosine(u.pair()),
        pdf: pdf_hemisphere_cosine,
        is_cosine: true,
    },
];

impl HemisphereSampling {
    /// The variance of an estimate for a sky of radiance cos(theta).
    fn variance(self) -> f64 {
        PI * PI
            * if self.is_cosine {
                1.0 / 18.0
            } else {
                16.0 / 45.0
            }
    }

    /// L cos / p for a sky of radiance cos^`power`.
    fn estimate(self, power: i32, uniform: &mut Uniform) -> f64 {
        let cos = (self.draw)(uniform).z;
        f64::from(cos).powi(power + 1) / f64::from((self.pdf)(cos))
    }
}

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    Ok(Page {
        claim: "A surface receives light from all directions above it, each weighted by its \
                cosine. Half of all uniform directions are within 30 degrees of the horizon, where \
                the cosine is small. Directions whose density is proportional to the cosine avoid \
                that: only the radiance is averaged. Under a constant sky not even that varies, \
                and a single sample is exact."
            .to_owned(),
        formulas: vec![
            Formula::new(
                r"E = \int_{H} L(\omega)\cos\theta\,\mathrm{d}\omega \;\approx\;
                  \frac{1}{N}\sum_{i=1}^{N} \frac{L(\omega_i)\cos\theta_i}{p(\omega_i)}",
                "Irradiance, and its estimate from directions with density p per steradian.",
            ),
            Formula::new(
                r"p(\omega) = \frac{1}{2\pi}: \quad \cos\theta = 1 - U_1, \qquad\quad p(\omega) =
                  \frac{\cos\theta}{\pi}: \quad \theta = \arccos\sqrt{1 - U_1}, \qquad \varphi =
                  2\pi U_2",
                "Both by inversion: the area of a cap grows evenly with its height (Archimedes), \
                 its projection on the ground as the squared sine.",
            ),
            Formula::new(
                r"L = \cos\theta: \qquad E = \frac{2\pi}{3}, \qquad V_{\text{uniform}} =
                  \frac{16\pi^2}{45}, \qquad V_{\cos} = \frac{\pi^2}{18}",
                "A sky that is brightest overhead, in closed form: the cosine divides the \
                 variance by 6.4.",
            ),
        ],
        experiment: "Two skies light a surface: a constant one, with E = π, and one of radiance \
                     cos θ, with E = 2π/3. A million directions are drawn by each of four \
                     techniques. Malley's method projects uniform points of the disk up to the \
                     hemisphere, which makes their density proportional to the cosine."
            .to_owned(),
        findings: findings(lesson),
    })
}

fn findings(lesson: &Lesson<'_>) -> Vec<Finding> {
    let bright = ESTIMATORS.map(|it| lesson.sample(it.name, SAMPLES, |u| it.estimate(1, u)));
    let technique = |(estimator, samples): (HemisphereSampling, &GroupedSamples)| {
        let technique = MeasuredTechnique::new(estimator.name, &samples.all(), samples.cost());
        technique.exactly(estimator.variance())
    };
    vec![
        Finding::Numbers {
            reading: "All techniques have the same expected value; their variance depends on the \
                      density alone. Under a constant sky cosine-weighted directions have none but \
                      that of rounding."
                .to_owned(),
            numbers: numbers(lesson, &bright),
        },
        Finding::Plots {
            plots: vec![
                from_above(lesson, "Uniform, from above", ESTIMATORS[1]),
                from_above(lesson, "By the cosine, from above", ESTIMATORS[3]),
            ],
        },
        Finding::Plots {
            plots: vec![cosines(lesson)],
        },
        Finding::Techniques {
            reading: "Irradiance under the sky of radiance cos θ. A better density gains a factor \
                      of 6.4; a faster program for the same density gains the ratio of the times."
                .to_owned(),
            techniques: ESTIMATORS.into_iter().zip(&bright).map(technique).collect(),
        },
    ]
}

/// `bright` are the samples of each estimator under the sky of radiance cos(theta).
fn numbers(lesson: &Lesson<'_>, bright: &[GroupedSamples]) -> Vec<Number> {
    let mut numbers = Vec::new();
    for (estimator, sky) in ESTIMATORS.into_iter().zip(bright) {
        let named = |what: &str| format!("{what}: {}", estimator.name);
        numbers.push(Number::mean(
            named("E under L = cos θ"),
            2.0 * PI / 3.0,
            &sky.all(),
            2e-3,
        ));
        numbers.push(Number::mean(
            named("its variance"),
            estimator.variance(),
            &sky.variances(),
            5e-3,
        ));
    }
    let even = lesson.sample("even sky", SAMPLES, |u| ESTIMATORS[1].estimate(0, u));
    let even_by_cosine = lesson.sample("even sky by cosine", SAMPLES, |u| {
        ESTIMATORS[3].estimate(0, u)
    });
    let trials = lesson.sample("trials", SAMPLES, |u| {
        let drawn = sample_hemisphere_by_rejection(&mut || u.single());
        drawn.map_or(f64::NAN, |drawn| f64::from(drawn.trials))
    });
    let of_even = PI * PI / 3.0;
    numbers.extend([
        Number::mean("E under L = 1: uniform", PI, &even.all(), 2e-3),
        Number::mean("its variance, π²/3", of_even, &even.variances(), 5e-3),
        Number::mean(
            "E under L = 1: cosine, each sample",
            PI,
            &even_by_cosine.all(),
            1e-6,
        ),
        Number::mean(
            "trials of rejection, 6/π",
            1.0 / BALL_IN_CUBE,
            &trials.all(),
            2e-3,
        ),
    ]);
    numbers
}

fn from_above(lesson: &Lesson<'_>, title: &str, estimator: HemisphereSampling) -> Plot {
    const SHOWN: usize = 1500;
    let mut uniform = lesson.uniform("from above", 0);
    let points = (0..SHOWN).map(|_| {
        let w = (estimator.draw)(&mut uniform);
        [f64::from(w.x), f64::from(w.y)]
    });
    Plot {
        title: title.to_owned(),
        reading: if estimator.is_cosine {
            "The projections fill the disk evenly: that is Malley's method in reverse."
        } else {
            "Uniform on the sphere, the projections are dense at the rim, where the sphere is steep."
        }
        .to_owned(),
        shape: AspectRatio::Square,
        x: Axis::linear("x").over(-1.05, 1.05),
        y: Axis::linear("y").over(-1.05, 1.05),
        series: vec![Series::new(
            "",
            Mark::Dots,
            usize::from(estimator.is_cosine),
            points.collect(),
        )],
    }
}

fn cosines(lesson: &Lesson<'_>) -> Plot {
    const BINS: usize = 30;
    let count = lesson.samples(300_000);
    let histogram = |estimator: HemisphereSampling, hue: usize| {
        let mut uniform = lesson.uniform("cosines", hue);
        let mut bins = [0_u32; BINS];
        for _ in 0..count {
            let cos = (estimator.draw)(&mut uniform).z;
            bins[((cos * BINS as f32) as usize).min(BINS - 1)] += 1;
        }
        let dot = |(index, &bin): (usize, &u32)| {
            let x = (index as f64 + 0.5) / BINS as f64;
            [x, f64::from(bin) / count as f64 * BINS as f64]
        };
        Series::new(
            "",
            Mark::Dots,
            hue,
            bins.iter().enumerate().map(dot).collect(),
        )
    };
    let range = [0.0, 1.0];
    Plot {
        title: "Histogram of the cosines".to_owned(),
        reading: "Lines are exact, dots are measured. For uniform directions all cosines are \
                  equally likely; for cosine-weighted ones their density is proportional to the \
                  cosine."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::linear("cos θ").over(0.0, 1.0),
        y: Axis::linear("density").over(0.0, 2.1),
        series: vec![
            Series::curve("uniform: 1", Mark::Line, 0, range, |_| 1.0),
            Series::curve("by the cosine: 2 cos θ", Mark::Line, 1, range, |cos| {
                2.0 * cos
            }),
            histogram(ESTIMATORS[1], 0),
            histogram(ESTIMATORS[3], 1),
        ],
    }
}
