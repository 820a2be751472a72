//! Lesson on dice: expected value and variance of a throw, and of the mean of many throws.
//!
//! Measure: pips.
//! Range: a fair die of six faces.
//! Source: E = sum i / 6 = 7 / 2, V = sum i^2 / 6 - E^2 = 35 / 12. Tested in `lab/tests/reports/lesson.rs`.

use super::number::Number;
use super::page::{Finding, Formula, Page};
use super::topic::{Lesson, Topic};
use super::uniform::Uniform;
use crate::plot::{AspectRatio, Axis, Mark, Plot, Series};
use etendue::Result;
use etendue::internals::math::stats::Moments;
use etendue::internals::sampling::piecewise::Piecewise1d;

pub const TOPIC: Topic = Topic {
    name: "dice",
    title: "Throwing dice",
    summary: "Expected value 3.5 and variance 35/12 of a die, and of the mean of many throws.",
    weight: 2.0,
    run,
};

const FACES: usize = 6;
const EXPECTED: f64 = 3.5;
const VARIANCE: f64 = 35.0 / 12.0;

/// Throws for each number.
const THROWS: usize = 4 << 20;

struct Die(Piecewise1d);

impl Die {
    fn new() -> Self {
        Self(Piecewise1d::new(&[1.0; FACES]).expect("six equal weights"))
    }

    fn throw(&self, uniform: &mut Uniform) -> f64 {
        1.0 + self.0.sample(uniform.double()).piece as f64
    }

    fn mean_of(&self, throws: usize, uniform: &mut Uniform) -> f64 {
        (0..throws).map(|_| self.throw(uniform)).sum::<f64>() / throws as f64
    }
}

fn run(lesson: &Lesson<'_>) -> Result<Page> {
    let die = Die::new();
    Ok(Page {
        claim: "The mean of N independent throws is itself a random variable. Its expected value \
                is that of one throw, E[X] = 3.5, however large N is; its variance is that of one \
                throw, V[X] = 35/12, divided by N. So means concentrate around 3.5, and as N grows \
                their distribution approaches the normal one, although that of a single throw is \
                flat."
            .to_owned(),
        formulas: vec![
            Formula::new(
                r"E[X] = \sum_{i=1}^{6} p_i\, x_i = \frac{1+2+3+4+5+6}{6} = \frac{7}{2}",
                "The expected value: every value that can occur, weighed by its probability.",
            ),
            Formula::new(
                r"V[X] = E\big[(X - E[X])^2\big] = E[X^2] - E[X]^2 = \frac{91}{6} - \frac{49}{4} =
                  \frac{35}{12}",
                "The variance: the expected squared distance from the expected value. Its root is \
                 the standard deviation σ, here 1.71 pips.",
            ),
            Formula::new(
                r"V\Big[\frac{1}{N}\sum_{i=1}^{N} X_i\Big] = \frac{1}{N^2}\sum_{i=1}^{N} V[X_i] =
                  \frac{V[X]}{N}",
                "Variances of independent variables add up, and a factor leaves a variance \
                 squared.",
            ),
        ],
        experiment: format!(
            "A die is thrown {} million times, by uniform numbers that are mapped to six faces of \
             equal probability. Then means of 2, 5 and 20 throws are taken many times, and their \
             histogram is compared with the exact probabilities, which follow from those of one \
             die by convolution. Last, twelve people throw 10 000 times each and write down the \
             mean after every throw.",
            THROWS >> 20
        ),
        findings: vec![
            numbers(lesson, &die),
            Finding::Plots {
                plots: vec![faces(lesson, &die), bells(lesson, &die)],
            },
            Finding::Plots {
                plots: vec![running_means(lesson, &die)],
            },
        ],
    })
}

fn numbers(lesson: &Lesson<'_>, die: &Die) -> Finding {
    let throws = lesson.sample("throws", THROWS, |uniform| die.throw(uniform));
    let means = lesson.sample("means of ten", THROWS / 4, |uniform| {
        die.mean_of(10, uniform)
    });
    let sixes = lesson.sample("sixes", THROWS, |uniform| {
        f64::from(u8::from(die.throw(uniform) == 6.0))
    });
    Finding::Numbers {
        reading: "Each number is listed with its exact value and its standard error. It passes if \
                  both are within 5.2 standard errors, and these are below a limit."
            .to_owned(),
        numbers: vec![
            Number::mean(
                "E[X], the expected value of a throw",
                EXPECTED,
                &throws.all(),
                1e-3,
            ),
            Number::mean("V[X], its variance", VARIANCE, &throws.variances(), 1e-3),
            Number::mean(
                "P{X = 6}, how often a six comes",
                1.0 / 6.0,
                &sixes.all(),
                2e-3,
            ),
            Number::mean("E of the mean of ten throws", EXPECTED, &means.all(), 1e-3),
            Number::mean(
                "V of the mean of ten throws",
                VARIANCE / 10.0,
                &means.variances(),
                3e-3,
            ),
        ],
    }
}

/// The frequency of each face.
fn faces(lesson: &Lesson<'_>, die: &Die) -> Plot {
    const SHOWN: usize = 600;
    let mut uniform = lesson.uniform("faces", 0);
    let mut counts = [0_usize; FACES];
    for _ in 0..SHOWN {
        counts[die.throw(&mut uniform) as usize - 1] += 1;
    }
    let share =
        |(index, &count): (usize, &usize)| [index as f64 + 1.0, count as f64 / SHOWN as f64];
    // Two standard deviations of a frequency.
    let p = 1.0 / FACES as f64;
    let spread = 2.0 * (p * (1.0 - p) / SHOWN as f64).sqrt();
    Plot {
        title: format!("{SHOWN} throws"),
        reading: "The bars are the shares of the faces, the dashed line is 1/6. The band holds \
                  about 95 of 100 such shares: all faces are equally likely, and the differences \
                  are noise."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::linear("pips").over(0.5, 6.5),
        y: Axis::linear("share of the throws"),
        series: vec![
            Series::new(
                "thrown",
                Mark::Bars,
                0,
                counts.iter().enumerate().map(share).collect(),
            ),
            Series::new("1/6, ± 2σ", Mark::Guide, 1, vec![[0.5, p], [6.5, p]]).within(vec![
                [0.5, p - spread, p + spread],
                [6.5, p - spread, p + spread],
            ]),
        ],
    }
}

/// The distribution of means of several throws: exact and measured.
fn bells(lesson: &Lesson<'_>, die: &Die) -> Plot {
    let means = lesson.samples(200_000);
    let series = [1, 2, 5, 20]
        .into_iter()
        .enumerate()
        .flat_map(|(hue, throws)| {
            let exact = probabilities(throws);
            let mut counts = vec![0_u32; exact.len()];
            let mut uniform = lesson.uniform("bells", throws);
            for _ in 0..means {
                let pips: f64 = (0..throws).map(|_| die.throw(&mut uniform)).sum();
                counts[pips as usize - throws] += 1;
            }
            // Shown as densities over the mean, whose steps are 1 / throws wide, so that all are comparable.
            let place = move |index: usize| (index + throws) as f64 / throws as f64;
            let density = move |p: f64| p * throws as f64;
            let line = exact
                .iter()
                .enumerate()
                .map(|(i, &p)| [place(i), density(p)]);
            let dots = counts.iter().enumerate();
            let dots = dots.map(|(i, &count)| [place(i), density(f64::from(count) / means as f64)]);
            let name = match throws {
                1 => "one throw, exact".to_owned(),
                _ => format!("mean of {throws}, exact"),
            };
            let dots = Series::new("", Mark::Dots, hue, dots.collect());
            [Series::new(name, Mark::Line, hue, line.collect()), dots]
        });
    Plot {
        title: "Means of more and more throws".to_owned(),
        reading: "Lines are exact, dots are measured. One throw is flat, the mean of two a \
                  triangle, that of twenty nearly normal: four times as many throws make it half \
                  as wide."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::linear("mean of the throws"),
        y: Axis::linear("probability density"),
        series: series.collect(),
    }
}

/// The probabilities of the sums from `throws` to 6 `throws`.
fn probabilities(throws: usize) -> Vec<f64> {
    let mut sums = vec![1.0];
    for _ in 0..throws {
        let mut next = vec![0.0; sums.len() + FACES - 1];
        for (sum, p) in sums.iter().enumerate() {
            for place in &mut next[sum..sum + FACES] {
                *place += p / FACES as f64;
            }
        }
        sums = next;
    }
    sums
}

/// Running means, within the confidence band given by theory.
fn running_means(lesson: &Lesson<'_>, die: &Die) -> Plot {
    const PEOPLE: usize = 12;
    const STEPS_PER_DECADE: f64 = 24.0;
    let places: Vec<u64> = (0..=(4.0 * STEPS_PER_DECADE) as u32)
        .map(|step| 10.0_f64.powf(f64::from(step) / STEPS_PER_DECADE).round() as u64)
        .collect();
    let runs = lesson.repeat("running means", PEOPLE, |uniform| {
        let mut thrown = Moments::default();
        let mean_at = |&place: &u64| {
            while thrown.count() < place {
                thrown.push(die.throw(uniform));
            }
            [place as f64, thrown.mean()]
        };
        places.iter().map(mean_at).collect::<Vec<_>>()
    });
    let people = runs.into_iter().enumerate().map(|(index, points)| {
        let name = if index == 0 { "twelve people" } else { "" };
        Series::new(name, Mark::Line, 0, points)
    });
    let ribbon = places.iter().map(|&n| {
        let spread = 2.0 * (VARIANCE / n as f64).sqrt();
        [n as f64, EXPECTED - spread, EXPECTED + spread]
    });
    let ends = [1.0, 1e4];
    let guide = Series::new(
        "3.5 ± 2σ/√N",
        Mark::Guide,
        1,
        ends.map(|n| [n, EXPECTED]).to_vec(),
    );
    Plot {
        title: "The mean after N throws".to_owned(),
        reading: "No line is pulled towards 3.5: each throw only has less weight than the one \
                  before. Almost all lines stay within two standard deviations of the mean, and \
                  this funnel narrows as one over the root of N."
            .to_owned(),
        shape: AspectRatio::Wide,
        x: Axis::log("throws N"),
        y: Axis::linear("mean so far").over(1.0, 6.0),
        series: people.chain([guide.within(ribbon.collect())]).collect(),
    }
}
