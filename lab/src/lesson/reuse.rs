//! Lesson on path reuse: sixteen pixels that take the light of each other's paths.
//!
//! Measure: irradiance, and distances in heights of the ceiling.
//! Range: the floor of `shared_floor.rs`.
//! Source: Bekaert, Sbert and Halton 2002, "Accelerating Path Tracing by Re-Using Paths". Tested in
//! `lab/tests/reports/lesson.rs`.

use super::number::{MeasuredTechnique, Number};
use super::page::{Figure, Finding, Formula, Page};
use super::shared_floor::{Counted, PIXELS, PixelRow, WALL, irradiance};
use super::topic::{GroupedSamples, Lesson, Topic};
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use etendue::Result;
use etendue::internals::image::Image;
use etendue::internals::math::rgb::Rgb;

pub const TOPIC: Topic = Topic {
    name: "reuse",
    title: "One path, many pixels",
    summary: "Neighbours take the light of each other's paths: what the weights have to count, \
              and what correlated noise costs.",
    weight: 2.0,
    run,
};

/// The distance between pixels in the numbers.
const SPACING: f64 = 0.05;

/// The pixels of the numbers, to the left and to the right of the wall.
const SHOWN: [usize; 2] = [4, 11];

/// Samples for each number.
const SAMPLES: usize = 1 << 18;

/// The distances between pixels in the plot.
const SPACINGS: [f64; 7] = [0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0];

/// The floor beside the wall, with groups of this size.
fn beside_wall(group: usize) -> PixelRow {
    PixelRow::new(0.0, SPACING, group, WALL)
}

fn name(group: usize) -> String {
    match group {
        1 => "alone".to_owned(),
        _ => format!("{group} share"),
    }
}

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    Ok(Page {
        claim: "Neighbouring pixels see nearly the same part of the scene, and each asks anew what \
                light comes from there. A path that pixel j has begun arrives at a surface, and \
                follows the light from it at some cost; the same light would reach pixel i, and one \
                shadow ray tells whether it does. So sixteen pixels with one path each may take \
                sixteen samples each. The point could have been found by the path of any of them, \
                and multiple importance sampling counts all of these ways: those that could have \
                found it, and no others. Then nothing is biased, and near surfaces cause no bright \
                points. The price is that neighbours share their errors: noise becomes coarser."
            .to_owned(),
        formulas: vec![
            Formula::new(
                r"g_k(y) = p_k(x_k \to y)\,\frac{|\cos\theta_y|}{|y - x_k|^2}\,V(x_k, y)",
                "The density by which the path of pixel k finds the point y. Where something is \
                 between, it is zero.",
            ),
            Formula::new(
                r"\langle I_i \rangle = \sum_j \frac{f_i(y_j)\,L(y_j)}{\sum_k g_k(y_j)}, \qquad
                  E[\langle I_i \rangle] = \int f_i\,L\,\frac{\sum_j g_j}{\sum_k g_k} = \int f_i\,L",
                "The estimator: each point y_j serves all pixels i, with the balance heuristic over \
                 the pixels that may find it. The weights sum to one wherever any pixel finds y.",
            ),
            Formula::new(
                r"V[\langle I_i \rangle] = \int \frac{f_i^2\,L^2}{\sum_k g_k} - \sum_j m_{ij}^2,
                  \qquad m_{ij} = \int \frac{f_i\,g_j\,L}{\sum_k g_k}",
                "Its variance. With n pixels at one place it is that of n paths; far from each other \
                 it is that of one.",
            ),
            Formula::new(
                r"\frac{1}{n} \sum_i \langle I_i \rangle = \frac{1}{n} \sum_j L(y_j) \qquad (f_i =
                  g_i)",
                "The mean over the group is the same number as without sharing: as a whole, the group \
                 knows no more than before. Its light is spread over its pixels.",
            ),
        ],
        experiment: format!(
            "In two dimensions: a floor, a ceiling at height 1 that shines to the right of t = 0, and a \
             wall of height {WALL} at x = 0. Sixteen pixels, {SPACING} apart, lie on both sides of \
             the wall, and each sends one cosine-weighted path to the ceiling. The renderer's own \
             estimator (`--reuse 16`) is this one, with a second surface in place of the ceiling."
        ),
        findings: findings(lesson),
    })
}

fn findings(lesson: &Lesson<'_>) -> Vec<Finding> {
    let groups = [1, 4, PIXELS];
    let sampled = groups.map(|group| {
        let floor = beside_wall(group);
        let samples = |pixel: usize| {
            let what = format!("{group} {pixel}");
            lesson.sample(&what, SAMPLES, |u| {
                floor.estimates(Counted::Seeing, u)[pixel]
            })
        };
        (group, SHOWN.map(samples))
    });
    let technique = |(group, samples): &(usize, [GroupedSamples; 2])| {
        let technique = MeasuredTechnique::new(name(*group), &samples[0].all(), samples[0].cost());
        technique.exactly(beside_wall(*group).variance(SHOWN[0]))
    };
    vec![
        Finding::Numbers {
            reading: "Whatever is shared, the mean is the closed form, also beside the wall, which \
                      hides much of the light from half of the pixels. If pixels are counted that \
                      cannot see a point, light is missing. The mean over the group has the same \
                      variance with and without sharing."
                .to_owned(),
            numbers: numbers(lesson, &sampled),
        },
        Finding::Techniques {
            reading: format!(
                "The pixel at x = {:.3}, behind the wall; the cost is that of all sixteen pixels. \
                 Here a shadow ray costs as much as a path. In a scene a path goes on for several \
                 surfaces, and sharing costs less.",
                beside_wall(1).positions[SHOWN[0]]
            ),
            techniques: sampled.iter().map(technique).collect(),
        },
        Finding::Figures {
            title: "One path per pixel".to_owned(),
            reading: "The floor from x = −3 to 3; each row of the image is another run. The noise of \
                      a group is alike: it is less, but coarser. The renderer interleaves groups, so \
                      that adjacent pixels belong to different ones."
                .to_owned(),
            figures: figures(lesson),
        },
        Finding::Plots {
            plots: vec![gains(lesson), means()],
        },
    ]
}

fn numbers(lesson: &Lesson<'_>, sampled: &[(usize, [GroupedSamples; 2])]) -> Vec<Number> {
    let mut numbers = Vec::new();
    for (group, samples) in sampled {
        let floor = beside_wall(*group);
        for (pixel, samples) in SHOWN.into_iter().zip(samples) {
            let x = floor.positions[pixel];
            let named = |what: &str| format!("{what} at x = {x:.3}, {}", name(*group));
            let mean = irradiance(x);
            numbers.push(Number::mean(named("E"), mean, &samples.all(), 2e-2));
            let variance = floor.variance(pixel);
            numbers.push(Number::mean(
                named("V"),
                variance,
                &samples.variances(),
                5e-2,
            ));
        }
        let means = lesson.sample(&format!("mean {group}"), SAMPLES, |u| {
            floor.estimates(Counted::Seeing, u).iter().sum::<f64>() / PIXELS as f64
        });
        let variance = beside_wall(1).variance_of_mean(PIXELS);
        numbers.push(Number::mean(
            format!("V of the group's mean, {}", name(*group)),
            variance,
            &means.variances(),
            5e-2,
        ));
    }
    let floor = beside_wall(PIXELS);
    let wrong = lesson.sample("wrong", SAMPLES, |u| {
        floor.estimates(Counted::All, u)[SHOWN[1]]
    });
    numbers.push(Number::mean(
        format!(
            "E at x = {:.3}, 16 share, without visibility in the denominator (biased)",
            floor.positions[SHOWN[1]]
        ),
        floor.mean(SHOWN[1], Counted::All),
        &wrong.all(),
        2e-2,
    ));
    numbers
}

/// Rows of the floor from one path per pixel, and the closed form.
fn figures(lesson: &Lesson<'_>) -> Vec<Figure> {
    const WIDTH: usize = 12 * PIXELS;
    const HEIGHT: usize = 96;
    let spacing = 6.0 / WIDTH as f64;
    let centre = |group: usize| -3.0 + spacing * (PIXELS as f64 * (group as f64 + 0.5));
    let figure = |name: String, caption: &str, values: Vec<f64>| {
        let pixels = values.into_iter().map(|e| Rgb::grey(0.7 * e as f32));
        Figure {
            name,
            caption: caption.to_owned(),
            image: Image::new(WIDTH as u32, HEIGHT as u32, pixels.collect()),
        }
    };
    let mut figures = Vec::new();
    for group in [1, 4, PIXELS] {
        let floors =
            (0..WIDTH / PIXELS).map(|strip| PixelRow::new(centre(strip), spacing, group, WALL));
        let floors: Vec<PixelRow> = floors.collect();
        let mut uniform = lesson.uniform(&format!("picture {group}"), 0);
        let values = (0..HEIGHT).flat_map(|_| {
            let row = floors
                .iter()
                .flat_map(|floor| floor.estimates(Counted::Seeing, &mut uniform));
            row.collect::<Vec<f64>>()
        });
        figures.push(figure(name(group), "one path per pixel", values.collect()));
    }
    let row = (0..WIDTH).map(|x| irradiance(-3.0 + spacing * (x as f64 + 0.5)));
    let row: Vec<f64> = row.collect();
    figures.push(figure(
        "exact".to_owned(),
        "the closed form",
        row.repeat(HEIGHT),
    ));
    figures
}

/// The gain in variance over the distance between pixels, far from any wall.
fn gains(lesson: &Lesson<'_>) -> Plot {
    let mut series = Vec::new();
    let pixel = PIXELS / 2;
    for (hue, group) in [4, PIXELS].into_iter().enumerate() {
        let floor = |spacing: f64| PixelRow::new(0.0, spacing, group, 0.0);
        let alone = |spacing: f64| {
            let mean = irradiance(floor(spacing).positions[pixel]);
            mean * (1.0 - mean)
        };
        let curve = (0..=24).map(|i| 3e-3 * 1e3_f64.powf(f64::from(i) / 24.0));
        let curve = curve.map(|d| [d, alone(d) / floor(d).variance(pixel)]);
        let title = format!("{group} share");
        series.push(Series::new(title, Mark::Line, hue, curve.collect()));
        let measured = SPACINGS.map(|d| {
            let floor = floor(d);
            let samples = lesson.sample(&format!("gain {group} {d}"), SAMPLES / 4, |u| {
                floor.estimates(Counted::Seeing, u)[pixel]
            });
            [d, alone(d) / samples.variances().mean()]
        });
        let title = format!("measured, {group} share");
        series.push(Series::new(title, Mark::Dots, hue, measured.to_vec()));
    }
    Plot {
        title: "How much less variance a pixel has".to_owned(),
        reading:
            "Pixels that are near to each other, for their distance to the second surface, gain \
                  as much as there are of them. Pixels that see different things gain nothing, and \
                  lose nothing."
                .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("distance between pixels, in heights of the ceiling"),
        y: Axis::log("variance alone / shared").over(0.8, 20.0),
        series,
    }
}

/// The noise of the mean over neighbours.
fn means() -> Plot {
    let curve = |group: usize| {
        let floor = PixelRow::new(0.0, SPACING, group, 0.0);
        let counts = [1, 2, 4, 8, PIXELS];
        let point = |count: usize| [count as f64, floor.variance_of_mean(count).sqrt()];
        counts.map(point).to_vec()
    };
    Plot {
        title: "Noise of the mean over neighbouring pixels".to_owned(),
        reading:
            "Averaging neighbours removes independent noise. Shared noise stays, since it is the \
                  same; over the whole group both are equal. So an image seen from afar has gained \
                  nothing, and a noise filter less than the pixels have."
                .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("pixels averaged"),
        y: Axis::log("standard deviation").over(0.05, 1.0),
        series: vec![
            Series::new(name(1), Mark::Marks, 0, curve(1)),
            Series::new(name(PIXELS), Mark::Marks, 1, curve(PIXELS)),
        ],
    }
}
