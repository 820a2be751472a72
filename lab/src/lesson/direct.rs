//! Lesson on direct light, by sampling directions and by sampling points on the light.
//!
//! Measure: radiance of a floor of reflectance 0.8 below the centre of a disk of radius a at height 1 that emits 1:
//! 0.8 a^2 / (1 + a^2).
//! Range: a from 0.1 to 10.
//! Source: E = pi L sin^2 of the disk's half angle; second moments by integration. Tested in `lab/tests/reports/lesson.rs`.

use super::lesson_scene::{LessonLight, LessonScene};
use super::number::{MeasuredTechnique, Number};
use super::page::{Figure, Finding, Formula, Page};
use super::topic::{Lesson, Topic};
use crate::bench::cornell_box::cornell_box;
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use crate::scene_builder::{emitting, matte, named_shape, scene};
use etendue::Result;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::stats::Moments;
use etendue::internals::math::vec::DVec3;
use etendue::internals::render::settings::Budget;
use etendue::internals::scene::description::{GeometryDescription, SceneDescription};
use std::time::Duration;

pub const TOPIC: Topic = Topic {
    name: "direct",
    title: "Directional against area sampling",
    summary: "Direct light by directions over the hemisphere, or by points on the lamp: each is \
              efficient where the other is not.",
    weight: 16.0,
    run,
};

const REFLECTANCE: f64 = 0.8;

const RADII: [f64; 7] = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0];

/// The radii shown in the tables.
const SHOWN: [f64; 3] = [0.1, 1.0, 10.0];

/// The film of a measurement: all its pixels look at the same point.
const SIZE: (u32, u32) = (64, 64);

/// Samples per pixel of a measurement.
const SPP: usize = 256;

/// The minimum number of samples per pixel that resolves the light of the smallest lamp.
const MIN_SPP: usize = 64;

/// Rendering time of each image, in seconds.
const SECONDS: f64 = 2.0;

/// An estimator of direct light.
struct DirectLightEstimator {
    integrator: IntegratorKind,
    name: &'static str,
    /// The second moment of a sample for a lamp of radius a at height 1, with a reflectance and an emitted radiance of
    /// 1.
    second_moment: fn(f64) -> f64,
}

const ESTIMATORS: [DirectLightEstimator; 2] = [
    DirectLightEstimator {
        integrator: IntegratorKind::DirectDirectional,
        name: "directional",
        second_moment: |a| 4.0 / 3.0 * (1.0 - (1.0 + a * a).powf(-1.5)),
    },
    DirectLightEstimator {
        integrator: IntegratorKind::DirectArea,
        name: "area",
        second_moment: |a| a * a / 3.0 * (1.0 - (1.0 + a * a).powi(-3)),
    },
];

/// The exact radiance of a floor of reflectance 1.
fn exact(a: f64) -> f64 {
    a * a / (1.0 + a * a)
}

impl DirectLightEstimator {
    /// The variance of one sample relative to the squared expected value.
    fn relative_variance(&self, a: f64) -> f64 {
        (self.second_moment)(a) / exact(a).powi(2) - 1.0
    }

    /// The relative standard deviation of one sample, for all radii.
    fn curve(&self, hue: usize) -> Series {
        let at = |step: i32| {
            let a = 10.0_f64.powf(f64::from(step) / 30.0);
            [a, self.relative_variance(a).sqrt()]
        };
        Series::new(self.name, Mark::Line, hue, (-30..=30).map(at).collect())
    }
}

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    Ok(Page {
        claim: "The light that a point reflects is an integral over directions. It can also be \
                written over the points of the lamp: a distant or tilted area covers little solid \
                angle. Both integrals are the same, their estimators are not. Directions rarely \
                hit a small lamp, and the variance grows without bound as it shrinks. Points on \
                the lamp always do, but near a large lamp 1/r² varies without bound, and most \
                points are far away. Neither is best: this is why a renderer combines them, or \
                samples the solid angle of the lamp itself."
            .to_owned(),
        formulas: vec![
            Formula::new(
                r"L_o = \int_{H} f_r\, L_i(\omega)\cos\theta\,\mathrm{d}\omega, \quad p(\omega) =
                  \frac{1}{2\pi}: \quad \langle L_o\rangle = 2\pi\, f_r\, L_i(\omega)\cos\theta",
                "Directional: over the hemisphere.",
            ),
            Formula::new(
                r"L_o = \int_{A} f_r\,
                  L_e(y)\,V(x,y)\,\frac{\cos\theta\cos\theta'}{r^2}\,\mathrm{d}A, \quad p(y) =
                  \frac{1}{A}: \quad \langle L_o\rangle = A\, f_r\, L_e\,
                  V\,\frac{\cos\theta\cos\theta'}{r^2}",
                "Area: over the lamp, as dω = cos θ′ dA / r². V is 1 if x sees y, else 0.",
            ),
            Formula::new(
                r"L_o = \rho\,L_e\,\frac{a^2}{1+a^2}",
                "Below the centre of a disk of radius a at height 1, in closed form.",
            ),
            Formula::new(
                r"E\big[\langle L_o\rangle_\omega^2\big] = \frac{4}{3}\Big(1 -
                  (1+a^2)^{-3/2}\Big)(\rho L_e)^2, \qquad E\big[\langle L_o\rangle_A^2\big] =
                  \frac{a^2}{3}\Big(1 - (1+a^2)^{-3}\Big)(\rho L_e)^2",
                "The second moments of both estimators there; the variance is their excess over \
                 the square of the radiance.",
            ),
        ],
        experiment: format!(
            "The renderer looks at one point of a matte floor, ρ = {REFLECTANCE}, below a disk \
             that emits 1, by both estimators and for seven radii: {SPP} samples in each of {} \
             pixels. Then both render the Cornell box, its direct light only, each for the same \
             time.",
            SIZE.0 * SIZE.1
        ),
        findings: findings(lesson)?,
    })
}

/// A floor below a disk, seen from the side.
fn below_disk(a: f64) -> SceneDescription {
    let mut scene = scene("floor", DVec3::new(0.0, 0.5, 2.0), DVec3::ZERO, 1e-3);
    scene.materials = vec![
        matte("floor", Rgb::grey(REFLECTANCE as f32)),
        matte("black", Rgb::BLACK),
    ];
    let floor = GeometryDescription::Rectangle {
        corner: DVec3::new(-1.0, 0.0, 1.0),
        edge_u: DVec3::new(2.0, 0.0, 0.0),
        edge_v: DVec3::new(0.0, 0.0, -2.0),
    };
    let disk = GeometryDescription::Disk {
        center: DVec3::Y,
        normal: -DVec3::Y,
        radius: a,
    };
    scene.shapes = vec![
        named_shape("floor", 0, floor),
        emitting(named_shape("disk", 1, disk), Rgb::WHITE),
    ];
    scene
}

/// The measurements of one estimator at one radius.
struct Measured {
    mean: Moments,
    /// The variances of one sample, each from a row of pixels.
    variances: Moments,
    cost: f64,
}

impl Measured {
    fn numbers(&self, name: &str, expected: f64, variance: f64) -> [Number; 2] {
        [
            Number::mean(format!("L, {name}"), expected, &self.mean, 0.03),
            // 4096 pixels give a variance to a few percent.
            Number::mean(format!("V, {name}"), variance, &self.variances, 0.06),
        ]
    }

    fn technique(&self, name: &str) -> MeasuredTechnique {
        let variance = self.variances.mean();
        let technique = MeasuredTechnique::new(name, &self.mean, self.cost);
        MeasuredTechnique {
            variance,
            efficiency: 1.0 / (variance * self.cost),
            ..technique
        }
    }
}

fn measure(lesson: &Lesson<'_>, estimator: &DirectLightEstimator, a: f64) -> Result<Measured> {
    let scene = LessonScene::new(lesson, below_disk(a), SIZE)?;
    let spp = lesson.samples(SPP).max(MIN_SPP) as u64;
    let budget = Budget::samples(spp);
    let seed = lesson.seed(estimator.name, (10.0 * a) as usize);
    let rendered = scene.render(estimator.integrator, budget, seed, LessonLight::Direct)?;
    let image = rendered.film.develop();
    let pixels: Vec<f64> = image
        .pixels()
        .iter()
        .map(|pixel| f64::from(pixel.luminance()))
        .collect();
    let rows = pixels.chunks(SIZE.0 as usize);
    let of_row = |row: &[f64]| Moments::of(row.iter().copied()).variance();
    let samples = rendered.film.sample_count() as f64;
    Ok(Measured {
        variances: Moments::of(rows.filter_map(of_row).map(|v| v * spp as f64)),
        mean: Moments::of(pixels.iter().copied()),
        cost: rendered.elapsed.as_secs_f64() / samples,
    })
}

fn findings(lesson: &Lesson<'_>) -> Result<Vec<Finding>> {
    let mut numbers = Vec::new();
    let mut series = Vec::new();
    let mut techniques = SHOWN.map(|_| Vec::new());
    for (hue, estimator) in ESTIMATORS.iter().enumerate() {
        let mut dots = Vec::new();
        for (index, a) in RADII.into_iter().enumerate() {
            let measured = measure(lesson, estimator, a)?;
            let expected = REFLECTANCE * exact(a);
            dots.push([a, measured.variances.mean().sqrt() / expected]);
            if let Some(place) = SHOWN.iter().position(|&shown| shown == a) {
                let variance = estimator.relative_variance(a) * expected * expected;
                numbers.extend(measured.numbers(
                    &format!("a = {a}, {}", estimator.name),
                    expected,
                    variance,
                ));
                techniques[place].push(measured.technique(estimator.name).exactly(variance));
            }
            lesson.progress(0.3 * (hue as f64 + (index as f64 + 1.0) / 7.0));
        }
        let curve = estimator.curve(hue);
        series.extend([curve, Series::new("", Mark::Dots, hue, dots)]);
    }
    let numbers = Finding::Numbers {
        reading: "Both estimate the same light, and their variances are those of the formulas."
            .to_owned(),
        numbers,
    };
    let plots = vec![deviations(series)];
    let readings = [
        "A small lamp, of a tenth of its height: few directions hit it.",
        "A lamp whose radius is its height.",
        "A large lamp, ten times as far to its rim as to its centre: most of its points contribute \
         almost nothing.",
    ];
    let tables = readings.into_iter().zip(techniques);
    let tables = tables.map(|(reading, techniques)| Finding::Techniques {
        reading: reading.to_owned(),
        techniques,
    });
    let before = [numbers, Finding::Plots { plots }];
    Ok(before
        .into_iter()
        .chain(tables)
        .chain([figures(lesson)?])
        .collect())
}

fn deviations(series: Vec<Series>) -> Plot {
    Plot {
        title: "Relative standard deviation of one sample".to_owned(),
        reading: "Lines are exact, dots rendered. Where the lamp's radius is about twice its \
                  height both are equal; area sampling is better below, directional sampling \
                  above."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("radius of the lamp / its height"),
        y: Axis::log("σ / L"),
        series,
    }
}

fn figures(lesson: &Lesson<'_>) -> Result<Finding> {
    let scene = LessonScene::new(lesson, cornell_box(), (160, 160))?;
    let seconds = (SECONDS * lesson.settings.effort).max(0.05);
    let budget = Budget::time(Duration::from_secs_f64(seconds));
    let all = [
        (IntegratorKind::DirectDirectional, "by directions"),
        (IntegratorKind::DirectArea, "by points on the lamp"),
        (IntegratorKind::Path, "both, weighted"),
    ];
    let mut figures = Vec::new();
    for (index, (integrator, name)) in all.into_iter().enumerate() {
        let rendered = scene.render(
            integrator,
            budget,
            lesson.seed("picture", index),
            LessonLight::Direct,
        )?;
        figures.push(Figure {
            name: name.to_owned(),
            caption: format!("`{}`, {} samples a pixel", integrator.name(), rendered.spp),
            image: rendered.film.develop(),
        });
        lesson.progress(0.6 + 0.13 * (index as f64 + 1.0));
    }
    Ok(Finding::Figures {
        title: "Direct light of the Cornell box, at equal time".to_owned(),
        reading: format!(
            "{seconds} seconds each. The lamp is small: only a few percent of all directions hit \
             it. The ceiling beside the lamp receives nothing, as the lamp emits downwards."
        ),
        figures,
    })
}
