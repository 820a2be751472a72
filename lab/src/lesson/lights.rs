//! Lesson on choosing among lights: uniformly, by power, and by what each would contribute.
//!
//! Measure: irradiance on a floor at z = 0 under point lights; costs in seconds.
//! Range: lamps that cast no shadows, so that all variance is that of the choice.
//! Source: Shirley, Wang and Zimmerman 1996 for the choice by power; Conty Estevez and Kulla 2018 for the tree. Tested in
//! `lab/tests/reports/lesson.rs`.

use super::number::{MeasuredTechnique, Number};
use super::page::{Figure, Finding, Formula, Page};
use super::topic::{Lesson, Topic};
use super::uniform::Uniform;
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use etendue::Result;
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::image::Image;
use etendue::internals::light::Light;
use etendue::internals::light::point::PointLight;
use etendue::internals::light::select::Lights;
use etendue::internals::light::types::{LightChoice, LightSampling, Receiver};
use etendue::internals::math::measure::Pmf;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{Vec2, Vec3};

pub const TOPIC: Topic = Topic {
    name: "lights",
    title: "Choosing among lights",
    summary: "One lamp of many for a shadow ray: uniformly, by power, or by what each would \
              contribute at the point.",
    weight: 3.0,
    run,
};

/// Samples for each number.
const SAMPLES: usize = 1 << 18;

/// The number of lamps of the numbers: as many as are children of one node, so that each has its own estimate.
const FEW_LAMPS: usize = 16;

/// The numbers of lamps of the plot.
const LAMP_COUNTS: [usize; 5] = [FEW_LAMPS, 64, 256, 1024, 4096];

/// The least noise that is shown.
const MIN_NOISE: f64 = 1e-3;

/// The pixels of a side of the images.
const PIXELS: u32 = 160;

/// The rules for choosing a lamp.
const RULES: [Rule; 3] = [Rule::Uniform, Rule::Power, Rule::Contribution];

/// A rule for choosing a lamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rule {
    Uniform,
    Power,
    Contribution,
}

impl Rule {
    fn name(self) -> &'static str {
        match self {
            Self::Uniform => "uniformly",
            Self::Power => "by power",
            Self::Contribution => "by contribution",
        }
    }
}

/// Lamps over a square floor.
struct Lamps {
    positions: Vec<Vec3>,
    lights: Lights,
    /// The lamps with equal powers, so that each has the same probability.
    alike: Lights,
}

impl Lamps {
    /// Places lamps at random over the floor from 0 to 1, of powers over four decades.
    fn new(lesson: &Lesson<'_>, count: usize) -> Self {
        let mut uniform = lesson.uniform("lamps", count);
        let spacing = 1.0 / (count as f32).sqrt();
        let mut positions = Vec::new();
        let lamps: Vec<Light> = (0..count)
            .map(|_| {
                let [x, y, z, power] = [(); 4].map(|()| uniform.double() as f32);
                let position = Vec3::new(x, y, spacing * (0.2 + z));
                positions.push(position);
                let intensity = 1e-4_f32.powf(power);
                Light::Point(PointLight::new(position, Rgb::grey(intensity)))
            })
            .collect();
        let powers: Vec<f64> = lamps.iter().map(|lamp| lamp.power(1.0)).collect();
        Self {
            positions,
            alike: Lights::new(lamps.clone(), &vec![1.0; count]),
            lights: Lights::new(lamps, &powers),
        }
    }

    fn irradiance_of(&self, light: u32, at: &Receiver) -> f64 {
        let rules = LightSampling::default();
        let choice = (light, Pmf(1.0));
        let sample = self
            .lights
            .sample::<Everything>(choice, rules, at.p, 0.0, Vec2::ZERO);
        sample.map_or(0.0, |sample| {
            f64::from(sample.radiance.luminance() * sample.wi.dot(at.normal).max(0.0))
        })
    }

    /// The irradiance of all lamps, one after the other.
    fn irradiance(&self, at: &Receiver) -> f64 {
        let lamps = 0..self.positions.len() as u32;
        lamps.map(|lamp| self.irradiance_of(lamp, at)).sum()
    }

    /// An estimate of the irradiance from one lamp.
    fn estimate(&self, rule: Rule, at: &Receiver, uniform: &mut Uniform) -> f64 {
        let u = [(); 2].map(|()| uniform.single());
        let choice = match rule {
            Rule::Uniform => self.alike.choose_by_power::<Everything>(u),
            Rule::Power => self.lights.choose_by_power::<Everything>(u),
            Rule::Contribution => {
                self.lights
                    .choose::<Everything>(LightChoice::Contribution, at, u)
            }
        };
        choice.map_or(0.0, |(lamp, Pmf(pmf))| {
            self.irradiance_of(lamp, at) / f64::from(pmf)
        })
    }

    /// The exact variance of an estimate.
    fn variance(&self, rule: Rule, at: &Receiver) -> f64 {
        let mean = self.irradiance(at);
        let lamps = 0..self.positions.len() as u32;
        let squares = lamps.map(|lamp| {
            let Pmf(pmf) = match rule {
                Rule::Uniform => self.alike.pmf_by_power(lamp),
                Rule::Power => self.lights.pmf_by_power(lamp),
                Rule::Contribution => {
                    let choice = LightChoice::Contribution;
                    self.lights.pmf::<Everything>(lamp, choice, at)
                }
            };
            self.irradiance_of(lamp, at).powi(2) / f64::from(pmf)
        });
        (squares.sum::<f64>() - mean * mean).max(0.0)
    }
}

/// The point of the floor at these fractions of its sides.
fn floor(x: f32, y: f32) -> Receiver {
    Receiver {
        p: Vec3::new(x, y, 0.0),
        normal: Vec3::Z,
    }
}

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    Ok(Page {
        claim:
            "A scene may have ten thousand lamps, but a surface can afford one shadow ray. So one \
                lamp is chosen at random, and its light is divided by the probability of that. The \
                estimate is unbiased if every lamp that shines may be chosen; how noisy it is \
                depends on the probabilities. The best are in proportion to what each lamp \
                contributes at this point: then the quotient is the same for all, and the choice \
                adds no variance. Power says nothing about distance; an estimate from distance and \
                angle does, and a tree of bounds makes it affordable."
                .to_owned(),
        formulas: vec![
            Formula::new(
                r"\langle E \rangle = \frac{E_i}{p_i} \;\text{ with probability } p_i, \qquad
                  E[\langle E \rangle] = \sum_i p_i \frac{E_i}{p_i} = E",
                "One lamp for all of them.",
            ),
            Formula::new(
                r"V = \sum_i \frac{E_i^2}{p_i} - E^2, \qquad p_i = \frac{E_i}{E} \;\Rightarrow\; V
                  = 0",
                "The variance of the choice; in proportion to the contributions it is zero.",
            ),
            Formula::new(
                r"E_i = \frac{I_i \cos\theta_i}{d_i^2}, \qquad \hat{E} = \frac{I\,\overline{\cos
                  \theta}\,\overline{\cos\theta'}}{d^2 + r^2/2}",
                "The irradiance of a point light, and the estimate for a group of lights in a \
                 sphere of radius r with bounds of the cosines. A tree is descended from the root, \
                 each time to a child in proportion to its estimate.",
            ),
            Formula::new(
                r"p_i = \prod_{\text{nodes above } i} \frac{\hat{E}_{\text{child}}}{\sum
                  \hat{E}_{\text{children}}}",
                "The probability of a lamp, in time proportional to the height of the tree; \
                 multiple importance sampling needs it where a scattered ray hits a lamp.",
            ),
        ],
        experiment: format!(
            "{FEW_LAMPS} point lights of powers over four decades hang at random places over a \
             floor; below, up to {}. The irradiance of a point of the floor is estimated from one \
             lamp, chosen by three rules of the renderer (`--light-choice`).",
            LAMP_COUNTS[LAMP_COUNTS.len() - 1]
        ),
        findings: findings(lesson),
    })
}

fn findings(lesson: &Lesson<'_>) -> Vec<Finding> {
    let (lamps, at) = (Lamps::new(lesson, FEW_LAMPS), floor(0.4, 0.55));
    let (mut numbers, mut techniques) = (Vec::new(), Vec::new());
    let mean = lamps.irradiance(&at);
    for rule in RULES {
        let samples = lesson.sample(rule.name(), SAMPLES, |u| lamps.estimate(rule, &at, u));
        let all = samples.all();
        let variance = lamps.variance(rule, &at);
        let name = format!("E, {}", rule.name());
        numbers.push(Number::mean(name, mean, &all, 2e-2));
        let technique = MeasuredTechnique::new(rule.name(), &all, samples.cost());
        techniques.push(technique.exactly(variance));
        // By contribution there is next to none, but for rounding.
        if rule != Rule::Contribution {
            let name = format!("V, {}", rule.name());
            numbers.push(Number::mean(name, variance, &samples.variances(), 8e-2));
        }
    }
    lesson.progress(0.3);
    vec![
        Finding::Numbers {
            reading:
                "The irradiance, estimated from one lamp of all, is that of all; the variance \
                      is that of the formula."
                    .to_owned(),
            numbers,
        },
        Finding::Techniques {
            reading: format!(
                "Among {FEW_LAMPS} lamps each has an estimate of its own, which is exact here: no \
                 lamp has a size, and nothing is in the way. What remains is rounding."
            ),
            techniques,
        },
        Finding::Figures {
            title: "One shadow ray per pixel".to_owned(),
            reading: format!(
                "A floor under {} lamps. Only the choice differs.",
                LAMP_COUNTS[2]
            ),
            figures: figures(lesson),
        },
        Finding::Plots {
            plots: vec![variances(lesson)],
        },
    ]
}

/// The floor under some lamps, from one lamp per pixel and from all.
fn figures(lesson: &Lesson<'_>) -> Vec<Figure> {
    let lamps = Lamps::new(lesson, LAMP_COUNTS[2]);
    let at = |i: usize| {
        let [x, y] = [i as u32 % PIXELS, i as u32 / PIXELS];
        let [x, y] = [x, PIXELS - 1 - y].map(|x| (x as f32 + 0.5) / PIXELS as f32);
        floor(x, y)
    };
    let count = (PIXELS * PIXELS) as usize;
    let exact: Vec<f64> = (0..count).map(|i| lamps.irradiance(&at(i))).collect();
    let exposure = 0.2 * count as f64 / exact.iter().sum::<f64>();
    let figure = |name: &str, caption: &str, values: &[f64]| {
        let pixels = values.iter().map(|e| Rgb::grey((exposure * e) as f32));
        Figure {
            name: name.to_owned(),
            caption: caption.to_owned(),
            image: Image::new(PIXELS, PIXELS, pixels.collect()),
        }
    };
    let mut figures = Vec::new();
    for rule in RULES {
        let mut uniform = lesson.uniform(&format!("picture {}", rule.name()), 0);
        let values: Vec<f64> = (0..count)
            .map(|i| lamps.estimate(rule, &at(i), &mut uniform))
            .collect();
        figures.push(figure(rule.name(), "one lamp per pixel", &values));
    }
    figures.push(figure("all", "the sum over all lamps", &exact));
    figures
}

/// The relative standard deviation of the choice over the number of lamps.
fn variances(lesson: &Lesson<'_>) -> Plot {
    let points = lesson.samples(400);
    let mut series = Vec::new();
    let all = LAMP_COUNTS.map(|count| (count, Lamps::new(lesson, count)));
    for (hue, rule) in RULES.into_iter().enumerate() {
        let values = all.iter().map(|(count, lamps)| {
            let squares = lesson.repeat(&format!("place {count}"), points, |u| {
                let at = floor(u.single(), u.single());
                lamps.variance(rule, &at) / lamps.irradiance(&at).powi(2)
            });
            let mean = squares.iter().sum::<f64>() / squares.len() as f64;
            [*count as f64, mean.sqrt()]
        });
        // Rounding has no place on the axis.
        let values: Vec<[f64; 2]> = values.filter(|[_, noise]| *noise > MIN_NOISE).collect();
        series.push(Series::new(rule.name(), Mark::Marks, hue, values));
    }
    Plot {
        title: "Noise of the choice".to_owned(),
        reading:
            "The relative standard deviation of one estimate, from the formula, averaged over \
                  the floor. Where the places of the lamps are ignored the noise grows with their \
                  number; with the tree it grows slowly. One node, for 16 lamps, leaves rounding \
                  alone, which is not shown."
                .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("lamps"),
        y: Axis::log("standard deviation / mean").over(0.1, 100.0),
        series,
    }
}
