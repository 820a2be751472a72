//! Lesson on path tracers: six estimators of the same image, each a step better than the one before.
//!
//! Measure: variance of a sample of a pixel, the mean over pixels and channels; efficiency 1 / (variance x seconds).
//! Range: the Cornell box, independent random numbers, the same kernel for all.
//! Source: Kajiya 1986, "The Rendering Equation"; Veach 1997. Tested in `lab/tests/reports/lesson.rs`.

use super::lesson_scene::{LessonLight, LessonScene};
use super::number::{MeasuredTechnique, Number};
use super::page::{Figure, Finding, Formula, Page};
use super::topic::{Lesson, Topic};
use crate::bench::cornell_box::cornell_box;
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use etendue::Result;
use etendue::internals::image::Image;
use etendue::internals::image::metrics::mse;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::math::stats::{Moments, Spread};
use etendue::internals::render::settings::Budget;
use std::time::Duration;

pub const TOPIC: Topic = Topic {
    name: "ladder",
    title: "The ladder of path tracers",
    summary: "From the naive path tracer to next event estimation with MIS, at equal time on the \
              Cornell box.",
    weight: 70.0,
    run,
};

const SIZE: (u32, u32) = (128, 128);

/// Samples per pixel of the measured renders.
const SPP: [usize; 3] = [2, 8, 32];

/// Number of independent seeds of each measured render.
const SEEDS: usize = 8;

/// Samples per pixel of each of the reference's renders.
const REFERENCE_SPP: usize = 96;

/// Number of renders whose mean is the reference.
const REFERENCES: usize = 8;

/// Rendering time of the images, in seconds.
const SECONDS: f64 = 3.0;

/// The integrators, each with a text on its difference from the one before.
const RUNGS: [(IntegratorKind, &str); 6] = [
    (
        IntegratorKind::Naive,
        "at every surface, at random, its emission or a uniform direction",
    ),
    (
        IntegratorKind::EmitOrReflect,
        "the probability depends on whether the surface emits",
    ),
    (IntegratorKind::Bsdf, "no such choice, and BSDF sampling"),
    (
        IntegratorKind::LightOrRest,
        "a shadow ray to the lamp, and a uniform direction for the rest",
    ),
    (
        IntegratorKind::NextEvent,
        "a shadow ray to the lamp at every surface, BSDF sampling",
    ),
    (
        IntegratorKind::Path,
        "light and BSDF sampling, combined by MIS",
    ),
];

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    Ok(Page {
        claim: "The light in a pixel is one integral over all paths. Every path tracer here \
                estimates it without bias, so that all converge to the same image; they differ in \
                the variance of one path, and in its cost. Each step of the ladder uses something \
                that is known: where light is emitted, how surfaces reflect, where the lamps are. \
                The measure is efficiency, one over variance times time: a technique that halves \
                the variance and takes twice the time gains nothing."
            .to_owned(),
        formulas: vec![
            Formula::new(
                r"L(x,\omega_o) = L_e(x,\omega_o) + \int_{H}
                  f_r(\omega_i,\omega_o)\,L(y,-\omega_i)\cos\theta_i\,\mathrm{d}\omega_i",
                "The rendering equation: the radiance that leaves x is emitted there, or \
                 reflected.",
            ),
            Formula::new(
                r"\text{naive:}\quad \langle L\rangle = \frac{L_e}{q} \;\text{ with probability }
                  q, \qquad \langle L\rangle = \frac{2\pi f_r \cos\theta}{1-q}\,\langle
                  L(y)\rangle \;\text{ else}",
                "The first path tracer samples it directly: it chooses one term at random, a uniform \
                 direction the point y.",
            ),
            Formula::new(
                r"\text{next event:}\quad L_r = \int_{A} f_r\, L_e\,
                  V\,\frac{\cos\theta\cos\theta'}{r^2}\,\mathrm{d}A + \int_{H} f_r\,
                  L_r(y)\cos\theta\,\mathrm{d}\omega",
                "The reflected light in two parts: direct and indirect.",
            ),
            Formula::new(
                r"w_i = \frac{p_i^2}{\sum_k p_k^2}, \qquad \epsilon = \frac{1}{V\,T}",
                "Two techniques for the same light are weighted by the power heuristic; estimators \
                 are compared by their efficiency.",
            ),
        ],
        experiment: format!(
            "The Cornell box in {} × {} pixels is rendered by all six, compiled alike and with \
             independent random numbers. Each renders it with {}, {} and {} samples per pixel, \
             {SEEDS} times with different seeds, and is compared with a reference of {} samples \
             per pixel by the last of them. Finally, each renders for {SECONDS} seconds.",
            SIZE.0,
            SIZE.1,
            SPP[0],
            SPP[1],
            SPP[2],
            REFERENCES * REFERENCE_SPP
        ),
        findings: findings(lesson)?,
    })
}

/// The results of one integrator.
struct Rung {
    kind: IntegratorKind,
    caption: &'static str,
    /// Mean luminances of the images, one for each seed.
    luminances: Moments,
    /// The mean seconds and the root of the mean squared error for each number of samples.
    errors: Vec<[f64; 2]>,
    /// Variance of one sample of a pixel, one for each seed.
    variances: Vec<f64>,
    /// Seconds per sample of a pixel.
    costs: Vec<f64>,
    figure: Image,
    figure_spp: u64,
}

struct Reference {
    image: Image,
    luminances: Moments,
}

fn reference(lesson: &Lesson<'_>, scene: &LessonScene<'_>) -> Result<Reference> {
    let mut sum = Image::filled(SIZE.0, SIZE.1, Default::default());
    let mut luminances = Moments::default();
    let share = 1.0 / REFERENCES as f32;
    let spp = lesson.samples(REFERENCE_SPP) as u64;
    for index in 0..REFERENCES {
        let seed = lesson.seed("reference", index);
        let rendered = scene.render(
            IntegratorKind::Path,
            Budget::samples(spp),
            seed,
            LessonLight::Whole,
        )?;
        let image = rendered.film.develop();
        luminances.push(luminance(&image));
        for (sum, pixel) in sum.pixels_mut().iter_mut().zip(image.pixels()) {
            *sum += share * *pixel;
        }
        lesson.progress(0.15 * (index as f64 + 1.0) / REFERENCES as f64);
    }
    Ok(Reference {
        image: sum,
        luminances,
    })
}

fn luminance(image: &Image) -> f64 {
    let [r, g, b] = image.mean().map(|x| x as f32);
    f64::from(etendue::internals::math::rgb::Rgb::new(r, g, b).luminance())
}

fn climb(
    lesson: &Lesson<'_>,
    scene: &LessonScene<'_>,
    reference: &Reference,
    (kind, caption): (IntegratorKind, &'static str),
) -> Result<Rung> {
    let mut luminances = Moments::default();
    let (mut errors, mut variances, mut costs) = (Vec::new(), Vec::new(), Vec::new());
    for full in SPP {
        let spp = ((full as f64 * lesson.settings.effort) as u64).max(1);
        let (mut seconds, mut squares) = (0.0, 0.0);
        for index in 0..SEEDS {
            let seed = lesson.seed(&format!("{} {full}", kind.name()), index);
            let rendered = scene.render(kind, Budget::samples(spp), seed, LessonLight::Whole)?;
            let image = rendered.film.develop();
            let square = mse(&image, &reference.image)?;
            let time = rendered.elapsed.as_secs_f64();
            seconds += time / SEEDS as f64;
            squares += square / SEEDS as f64;
            if full == SPP[SPP.len() - 1] {
                luminances.push(luminance(&image));
                variances.push(square * spp as f64);
                costs.push(time / rendered.film.sample_count().max(1) as f64);
            }
        }
        errors.push([seconds, squares.sqrt()]);
    }
    let seconds = (SECONDS * lesson.settings.effort).max(0.05);
    let time = Budget::time(Duration::from_secs_f64(seconds));
    let rendered = scene.render(kind, time, lesson.seed("picture", 0), LessonLight::Whole)?;
    Ok(Rung {
        kind,
        caption,
        luminances,
        errors,
        variances,
        costs,
        figure: rendered.film.develop(),
        figure_spp: rendered.spp,
    })
}

impl Rung {
    fn number(&self, reference: &Reference) -> Number {
        let both = [&self.luminances, &reference.luminances].map(Moments::standard_error);
        let [ours, of_reference] = both.map(|error| error.unwrap_or(f64::NAN));
        Number::new(
            format!("mean luminance, {}", self.kind.name()),
            reference.luminances.mean(),
            self.luminances.mean(),
            ours.hypot(of_reference),
            0.1,
        )
    }

    fn technique(&self) -> MeasuredTechnique {
        let efficiencies = self
            .variances
            .iter()
            .zip(&self.costs)
            .map(|(v, t)| 1.0 / (v * t));
        let spread = Spread::of(efficiencies.collect());
        let cost = Spread::of(self.costs.clone()).median;
        MeasuredTechnique {
            variance: Moments::of(self.variances.iter().copied()).mean(),
            efficiency: spread.median,
            efficiency_range: Some([spread.min, spread.max]),
            ..MeasuredTechnique::new(self.kind.name(), &self.luminances, cost)
        }
    }

    fn figure(&self) -> Figure {
        Figure {
            name: self.kind.name().to_owned(),
            caption: format!("{}; {} samples per pixel", self.caption, self.figure_spp),
            image: self.figure.clone(),
        }
    }
}

fn findings(lesson: &Lesson<'_>) -> Result<Vec<Finding>> {
    let scene = LessonScene::new(lesson, cornell_box(), SIZE)?;
    let reference = reference(lesson, &scene)?;
    let mut rungs = Vec::new();
    for (index, rung) in RUNGS.into_iter().enumerate() {
        rungs.push(climb(lesson, &scene, &reference, rung)?);
        lesson.progress(0.15 + 0.85 * (index as f64 + 1.0) / RUNGS.len() as f64);
    }
    let mut figures: Vec<Figure> = rungs.iter().map(Rung::figure).collect();
    figures.push(Figure {
        name: "reference".to_owned(),
        caption: format!(
            "{} samples per pixel by `path`",
            REFERENCES * lesson.samples(REFERENCE_SPP)
        ),
        image: reference.image.clone(),
    });
    let seconds = SECONDS * lesson.settings.effort;
    Ok(vec![
        Finding::Figures {
            title: "At equal time".to_owned(),
            reading: format!("{seconds} seconds each. They differ only in noise."),
            figures,
        },
        Finding::Techniques {
            reading: "Variance is that of one sample of a pixel, the mean over the image, of \
                      the squared distance from the reference; T is the time of such a sample. \
                      The efficiency is the median over the seeds, with the least and the \
                      greatest; it depends on the machine, its ratio to the first much less."
                .to_owned(),
            techniques: rungs.iter().map(Rung::technique).collect(),
        },
        Finding::Plots {
            plots: vec![against_time(&rungs)],
        },
        Finding::Numbers {
            reading: "The mean luminance of each, compared with that of the reference: all \
                      estimate the same image."
                .to_owned(),
            numbers: rungs.iter().map(|rung| rung.number(&reference)).collect(),
        },
    ])
}

fn against_time(rungs: &[Rung]) -> Plot {
    let series = rungs
        .iter()
        .enumerate()
        .map(|(hue, rung)| Series::new(rung.kind.name(), Mark::Marks, hue, rung.errors.clone()));
    Plot {
        title: "Error against time".to_owned(),
        reading: "All lines fall as one over the root of the time: no step changes the rate of \
                  convergence, each shifts the line. The horizontal distance between two lines is \
                  the ratio of their times to the same error."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("seconds"),
        y: Axis::log("root mean square error"),
        series: series.collect(),
    }
}
