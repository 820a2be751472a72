//! Lesson on light paths: three ways to find the light of a pixel, under one weight.
//!
//! Measure: irradiance over that under a sky of radiance 1.
//! Range: the floor beside a mirror of `mirrored_lamp.rs`.
//! Source: Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering". Tested in
//! `lab/tests/reports/lesson.rs`.

use super::mirrored_lamp::{LampStrategy, Pixel};
use super::number::{MeasuredTechnique, Number};
use super::page::{Figure, Finding, Formula, Page};
use super::topic::{GroupedSamples, Lesson, Topic};
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use etendue::Result;
use etendue::internals::image::Image;
use etendue::internals::math::rgb::Rgb;

pub const TOPIC: Topic = Topic {
    name: "light-paths",
    title: "Three ways to find a light",
    summary: "A caustic is found by scattering, rarely, or by paths from the lamp: why both \
              together are better than either.",
    weight: 2.0,
    run,
};

/// The width of the lamp in the numbers.
const LAMP: f64 = 0.02;

/// The widths of the lamp in the plots.
const LAMPS: [f64; 6] = [0.003, 0.01, 0.03, 0.1, 0.3, 1.0];

/// The pixels of the floor, which goes from this point to the mirror.
const PIXELS: usize = 192;
const LEFT: f64 = -1.5;
const WIDTH: f64 = (1.0 - LEFT) / PIXELS as f64;

/// Light paths for each camera path of a pixel.
const SHARE: f64 = 0.25;

/// The pixels of the numbers: outside of the caustic, and in it.
const SHOWN: [usize; 2] = [70, 160];

/// Samples for each number.
const SAMPLES: usize = 1 << 18;

/// The strategies of each technique, with its name.
fn techniques() -> [(&'static str, Vec<LampStrategy>); 4] {
    let [scattering, light_sampling, light_path] = LampStrategy::ALL;
    [
        ("scattering alone", vec![scattering]),
        ("with light sampling", vec![scattering, light_sampling]),
        ("light paths alone", vec![light_path]),
        ("all three", LampStrategy::ALL.to_vec()),
    ]
}

fn pixel(index: usize, lamp: f64, used: &[LampStrategy]) -> Pixel {
    // Every pixel's share of the light paths may arrive at this one.
    let light_paths = (SHARE * PIXELS as f64) as usize;
    Pixel {
        left: LEFT + WIDTH * index as f64,
        width: WIDTH,
        lamp,
        used: used.to_vec(),
        light_paths,
        weighted_as: light_paths,
    }
}

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    Ok(Page {
        claim: "Next event estimation finds a lamp wherever it is seen, but not by way of a mirror \
                or through glass. There a camera path has to meet the lamp by chance, and the \
                smaller the lamp, the rarer and the brighter are these paths: fireflies. A path that \
                begins at the lamp meets the mirror as easily as anything else, and what it lights \
                then is seen by some pixel. The same path may be found in all three ways, and \
                multiple importance sampling weights each by its density. What one strategy finds \
                badly, another finds well."
            .to_owned(),
        formulas: vec![
            Formula::new(
                r"\langle I \rangle = \sum_i \sum_{j=1}^{n_i} w_i(z_{ij})\,\frac{f(z_{ij})}{n_i\,p_i(z_{ij})},
                  \qquad w_i = \frac{(n_i p_i)^2}{\sum_k (n_k p_k)^2}",
                "The estimator over the strategies i: scattering (s = 0), light sampling (s = 1), light \
                 paths (t = 1). The weights of a path z sum to one.",
            ),
            Formula::new(
                r"n_0 p_0 = \frac{g}{|P|}, \qquad n_1 p_1 = \frac{1}{|P|\,|A|}\;\text{(direct)},\; 0\;
                  \text{(mirrored)}, \qquad n_2 p_2 = \frac{n_2\,g}{|A|}",
                "The densities of a path from a point of the lamp A to a point of the pixel P, with g the \
                 density by which a direction from one arrives at the other. All light paths of the image \
                 count in the last one, as each may arrive at any pixel.",
            ),
            Formula::new(
                r"V = \sum_i \left[ \int \frac{w_i^2 f^2}{n_i\,p_i} - \frac{1}{n_i} \Big( \int w_i f
                  \Big)^2 \right]",
                "The variance. For scattering alone it is I (1/|A| − I): without bound as the lamp \
                 shrinks. For light paths alone it is I (1/|P| − I) / n, which does not depend on the \
                 lamp, but on the size of the pixel.",
            ),
        ],
        experiment: format!(
            "In two dimensions: a floor with {PIXELS} pixels from x = {LEFT} to 1, a small lamp at height 1 \
             above x = 0, and a mirror at x = 1 that sends a part of its light to the floor from x = 0 on. \
             Each pixel has one camera path, and there is one light path for every four. Here each \
             strategy draws its own points, so that variances add up. In the renderer \
             (`--light-paths 1/4`) light paths have further surfaces, all of them connected to the lens, \
             and some begin towards mirrors and glass; a mirror that the camera sees is still for camera \
             paths alone."
        ),
        findings: findings(lesson),
    })
}

fn findings(lesson: &Lesson<'_>) -> Vec<Finding> {
    let sampled = techniques().map(|(name, used)| {
        let samples = SHOWN.map(|index| {
            let pixel = pixel(index, LAMP, &used);
            lesson.sample(&format!("{name} {index}"), SAMPLES, |u| pixel.estimate(u))
        });
        (name, used, samples)
    });
    let technique = |(name, used, samples): &(&str, Vec<LampStrategy>, [GroupedSamples; 2])| {
        let technique = MeasuredTechnique::new(*name, &samples[1].all(), samples[1].cost());
        technique.exactly(pixel(SHOWN[1], LAMP, used).variance())
    };
    vec![
        Finding::Numbers {
            reading: "Each set of strategies finds the same light, outside of the caustic (x = −0.58) and in \
                      it (x = 0.59), and each strategy the part that its weight gives it. Weights that take \
                      all light paths for a single one still sum to one: the mean is right, the variance is \
                      not the least."
                .to_owned(),
            numbers: numbers(lesson, &sampled),
        },
        Finding::Techniques {
            reading: "The pixel in the caustic; the cost of light paths is that of all that may arrive at \
                      it, which serve the other pixels, too."
                .to_owned(),
            techniques: sampled.iter().map(technique).collect(),
        },
        Finding::Figures {
            title: "One camera path per pixel".to_owned(),
            reading: "The floor from x = −1.5 to the mirror; each row of the image is another run. To the \
                      right is the caustic, which scattering finds in few bright pixels."
                .to_owned(),
            figures: figures(lesson),
        },
        Finding::Plots {
            plots: vec![variances(lesson), shares()],
        },
    ]
}

fn numbers(
    lesson: &Lesson<'_>,
    sampled: &[(&'static str, Vec<LampStrategy>, [GroupedSamples; 2])],
) -> Vec<Number> {
    let mut numbers = Vec::new();
    for (name, used, samples) in sampled {
        for (index, samples) in SHOWN.into_iter().zip(samples) {
            let pixel = pixel(index, LAMP, used);
            let place = pixel.left + 0.5 * WIDTH;
            let named = |what: &str| format!("{what} at x = {place:.2}, {name}");
            numbers.push(Number::mean(
                named("E"),
                pixel.light(),
                &samples.all(),
                5e-2,
            ));
            numbers.push(Number::mean(
                named("V"),
                pixel.variance(),
                &samples.variances(),
                1e-1,
            ));
        }
    }
    let caustic = pixel(SHOWN[1], LAMP, &LampStrategy::ALL);
    for strategy in LampStrategy::ALL {
        let samples = lesson.sample(strategy.name(), SAMPLES, |u| {
            caustic.estimate_by(strategy, u)
        });
        let name = format!("E by {}, all three weighted", strategy.name());
        numbers.push(Number::mean(
            name,
            caustic.mean_by(strategy),
            &samples.all(),
            5e-2,
        ));
    }
    let miscounted = Pixel {
        weighted_as: 1,
        ..caustic
    };
    let samples = lesson.sample("miscounted", SAMPLES, |u| miscounted.estimate(u));
    numbers.push(Number::mean(
        "V, weights that count one light path",
        miscounted.variance(),
        &samples.variances(),
        1e-1,
    ));
    numbers
}

/// Rows of the floor from one camera path per pixel, and the exact light.
fn figures(lesson: &Lesson<'_>) -> Vec<Figure> {
    const HEIGHT: usize = 96;
    let figure = |name: &str, caption: &str, values: Vec<f64>| {
        let pixels = values.into_iter().map(|e| Rgb::grey(1.4 * e as f32));
        Figure {
            name: name.to_owned(),
            caption: caption.to_owned(),
            image: Image::new(PIXELS as u32, HEIGHT as u32, pixels.collect()),
        }
    };
    let mut figures = Vec::new();
    for (name, used) in techniques() {
        let row = (0..PIXELS).map(|index| pixel(index, LAMP, &used));
        let row: Vec<Pixel> = row.collect();
        let rows = lesson.repeat(&format!("picture {name}"), HEIGHT, |u| {
            row.iter()
                .map(|pixel| pixel.estimate(u))
                .collect::<Vec<f64>>()
        });
        let mut values = rows.concat();
        // A cancelled lesson has fewer rows, and is discarded.
        values.resize(PIXELS * HEIGHT, 0.0);
        figures.push(figure(name, "one camera path per pixel", values));
    }
    let row = (0..PIXELS).map(|index| pixel(index, LAMP, &LampStrategy::ALL).light());
    let row: Vec<f64> = row.collect();
    figures.push(figure("exact", "by quadrature", row.repeat(HEIGHT)));
    figures
}

/// The variance in the caustic over the width of the lamp.
fn variances(lesson: &Lesson<'_>) -> Plot {
    let mut series = Vec::new();
    for (hue, (name, used)) in techniques().into_iter().enumerate() {
        let of_lamp = |lamp: f64| pixel(SHOWN[1], lamp, &used);
        let lamps = (0..=20).map(|i| 3e-3 * 333_f64.powf(f64::from(i) / 20.0));
        let curve = lamps.map(|lamp| [lamp, of_lamp(lamp).variance()]);
        series.push(Series::new(name, Mark::Line, hue, curve.collect()));
        let measured = LAMPS.map(|lamp| {
            let pixel = of_lamp(lamp);
            let samples = lesson.sample(&format!("lamp {name} {lamp}"), SAMPLES / 4, |u| {
                pixel.estimate(u)
            });
            [lamp, samples.variances().mean()]
        });
        let title = format!("measured, {name}");
        series.push(Series::new(title, Mark::Dots, hue, measured.to_vec()));
    }
    Plot {
        title: "Variance of a pixel in the caustic".to_owned(),
        reading: "The smaller the lamp, the rarer it is met: the variance of `path` grows as one over its \
                  width, since light sampling does not find it in the mirror. That of light paths stays. \
                  All three together are the best for every lamp."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("width of the lamp"),
        y: Axis::log("variance of a sample"),
        series,
    }
}

/// The share of the light that each strategy finds.
fn shares() -> Plot {
    let curve = |strategy: LampStrategy| {
        let lamps = (0..=20).map(|i| 3e-3 * 333_f64.powf(f64::from(i) / 20.0));
        let share = |lamp: f64| {
            let pixel = pixel(SHOWN[1], lamp, &LampStrategy::ALL);
            [lamp, pixel.mean_by(strategy) / pixel.light()]
        };
        lamps.map(share).collect()
    };
    let series = LampStrategy::ALL.into_iter().enumerate();
    Plot {
        title: "Share of the light by strategy".to_owned(),
        reading: "By the weights: of a small lamp, light sampling finds the direct light and light paths \
                  find the caustic; a large lamp is met by scattering."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("width of the lamp"),
        y: Axis::linear("share of the light").over(0.0, 1.0),
        series: series
            .map(|(hue, it)| Series::new(it.name(), Mark::Line, hue, curve(it)))
            .collect(),
    }
}
