//! Lesson on points on the disk: the classic mistake, and three right ways.
//!
//! Measure: the unit disk; densities per unit of area.
//! Range: none.
//! Source: the fraction of a disk within r is r^2. Tested in `lab/tests/reports/lesson.rs`.

use super::number::{MeasuredTechnique, Number};
use super::page::{Finding, Formula, Page};
use super::topic::{GroupedSamples, Lesson, Topic};
use super::uniform::Uniform;
use crate::course::disk::{
    DISK_IN_SQUARE, sample_disk_by_rejection, sample_disk_crowded_at_the_centre, sample_disk_polar,
};
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use etendue::Result;
use etendue::internals::math::vec::Vec2;
use etendue::internals::sampling::warp::sample_disk_concentric;
use std::f64::consts::{FRAC_PI_4, PI};

pub const TOPIC: Topic = Topic {
    name: "disk",
    title: "Points on a disk",
    summary: "Why r = U oversamples the centre, r = √U does not, and the cost of rejection.",
    weight: 1.0,
    run,
};

/// Samples for each number.
const SAMPLES: usize = 1 << 21;

/// A sampling method with its name.
type DiskSampling = (&'static str, fn(&mut Uniform) -> Vec2);

const ESTIMATORS: [DiskSampling; 4] = [
    ("r = U, the mistake", |u| {
        sample_disk_crowded_at_the_centre(u.pair())
    }),
    ("r = √U", |u| sample_disk_polar(u.pair())),
    ("rejection", |u| {
        let drawn = sample_disk_by_rejection(&mut || u.single());
        drawn.map_or(Vec2::NAN, |drawn| drawn.value)
    }),
    ("concentric", |u| sample_disk_concentric(u.pair())),
];

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    Ok(Page {
        claim: "A uniform radius does not make uniform points. Half of all radii are below 1/2, \
                but the disk within 1/2 has only a quarter of the area: r = U oversamples the \
                centre. The share of the area within r is r², and its inverse is the root: r = √U. \
                Rejection needs no such derivation; it samples the square around the disk until a \
                point lies inside, and rejects with probability 1 − π/4."
            .to_owned(),
        formulas: vec![
            Formula::new(
                r"p(x, y) = \frac{1}{\pi} \;\Rightarrow\; p(r, \varphi) = \frac{r}{\pi}, \qquad
                  p(r) = 2r, \qquad P(r) = r^2, \qquad r = \sqrt{U_1}, \quad \varphi = 2\pi U_2",
                "A uniform density in the plane, in polar coordinates: the factor r is the \
                 Jacobian.",
            ),
            Formula::new(
                r"r = U_1 \;\Rightarrow\; p(x, y) = \frac{1}{2\pi r}",
                "The density of the mistake: infinite at the centre, too low at the rim.",
            ),
            Formula::new(
                r"\varepsilon = \frac{A_{\text{disk}}}{A_{\text{square}}} = \frac{\pi}{4}",
                "The efficiency of rejection; it takes 4/π = 1.27 trials on average.",
            ),
        ],
        experiment: "Two million points are drawn by each technique. They give the share within \
                     half of the radius, and the integral of x² over the disk, which is π/4. The \
                     mistake, treated as uniform, gives π/6."
            .to_owned(),
        findings: findings(lesson),
    })
}

fn findings(lesson: &Lesson<'_>) -> Vec<Finding> {
    // The integrand x^2 over the density 1 / pi.
    let term = |p: Vec2| PI * f64::from(p.x) * f64::from(p.x);
    let integrals = ESTIMATORS.map(|(name, draw)| lesson.sample(name, SAMPLES, |u| term(draw(u))));
    // E[x^4] = 1/8 on the disk.
    let variance = PI * PI * (1.0 / 8.0 - 1.0 / 16.0);
    let technique = |((name, _), samples): (DiskSampling, &GroupedSamples)| {
        MeasuredTechnique::new(name, &samples.all(), samples.cost()).exactly(variance)
    };
    let right = ESTIMATORS.into_iter().zip(&integrals).skip(1);
    vec![
        Finding::Numbers {
            reading: "The three correct techniques agree. The mistake does not, at any number of \
                      samples: an error that does not fall is a bias."
                .to_owned(),
            numbers: numbers(lesson, &integrals),
        },
        Finding::Plots {
            plots: [0, 1, 3].map(|i| scatter(lesson, ESTIMATORS[i])).to_vec(),
        },
        Finding::Techniques {
            reading:
                "The integral of x² by the correct techniques. Their density is the same, and \
                      so is their variance; only the time differs. Rejection wastes the rejected \
                      points, and each point takes a varying count of random numbers, which \
                      prevents stratification; the concentric map keeps neighbours in the square \
                      together on the disk."
                    .to_owned(),
            techniques: right.map(technique).collect(),
        },
    ]
}

fn numbers(lesson: &Lesson<'_>, integrals: &[GroupedSamples]) -> Vec<Number> {
    let mut numbers = Vec::new();
    for (index, ((name, draw), integral)) in ESTIMATORS.into_iter().zip(integrals).enumerate() {
        let (share, exact) = match index {
            0 => (0.5, PI / 6.0),
            _ => (0.25, FRAC_PI_4),
        };
        let within = lesson.sample(&format!("{name} within"), SAMPLES, |u| {
            f64::from(u8::from(draw(u).length_squared() <= 0.25))
        });
        let named = |what: &str| format!("{what}: {name}");
        numbers.push(Number::mean(
            named("share within r = 1/2"),
            share,
            &within.all(),
            5e-3,
        ));
        numbers.push(Number::mean(
            named("∫ x² dA, as if uniform"),
            exact,
            &integral.all(),
            3e-3,
        ));
    }
    let trials = lesson.sample("trials", SAMPLES, |u| {
        let drawn = sample_disk_by_rejection(&mut || u.single());
        drawn.map_or(f64::NAN, |drawn| f64::from(drawn.trials))
    });
    let exact = 1.0 / DISK_IN_SQUARE;
    numbers.push(Number::mean(
        "trials of rejection, 4/π",
        exact,
        &trials.all(),
        1e-3,
    ));
    numbers
}

fn scatter(lesson: &Lesson<'_>, (name, draw): DiskSampling) -> Plot {
    const SHOWN: usize = 1500;
    let mut uniform = lesson.uniform("scatter", 0);
    let points = (0..SHOWN).map(|_| {
        let p = draw(&mut uniform);
        [f64::from(p.x), f64::from(p.y)]
    });
    let points = points.collect();
    let circle = |step: u32| {
        let angle = 2.0 * PI * f64::from(step) / 120.0;
        [angle.cos(), angle.sin()]
    };
    Plot {
        title: name.to_owned(),
        reading: match name {
            "r = U, the mistake" => {
                "Rings of equal width get equally many points, however little area they have."
            }
            "r = √U" => "Equal areas get equally many points.",
            _ => "The square, bent into the disk ring by ring.",
        }
        .to_owned(),
        shape: AspectRatio::Square,
        x: Axis::linear("x").over(-1.05, 1.05),
        y: Axis::linear("y").over(-1.05, 1.05),
        series: vec![
            Series::new("", Mark::Line, 6, (0..=120).map(circle).collect()),
            Series::new("", Mark::Dots, 0, points),
        ],
    }
}
