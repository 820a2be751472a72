//! Statistics of the renders of a variant: the time to given errors, its efficiency and its bias.
//!
//! Measure: seconds, relMSE and its root, stated at each field.
//! Range: at least two levels with two renders each.
//! Source: docs/accuracy.md, "The study". Tested below and in `lab/tests/reports/study.rs`.

use super::answer::{Answer, AnswerInput};
use super::bias::Bias;
use super::bootstrap::{Dealer, Ranged};
use super::efficiency::Efficiency;
use super::fit::{Curve, ErrorLevel, Slope, TimeLaw};
use super::gram::Estimate;
use super::law::Law;
use super::own_size::OwnError;
use super::report::{LevelReport, StudyReport, VariantStudy};
use etendue::internals::math::stats::{Moments, student_quantile};
use serde::Serialize;

/// Roots of relMSE for which the time is reported.
pub const TARGETS: [f64; 5] = [0.1, 0.03, 0.01, 0.003, 0.001];

/// The statistics of the renders of a variant.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// Its name.
    pub name: String,
    /// Seconds by samples per pixel, at the size of the study.
    pub time: TimeLaw,
    /// Seconds by samples per pixel, at the scene's own size.
    pub own_time: TimeLaw,
    /// The factor of relMSE at the scene's own size, relative to the size of the study.
    pub own_error: f64,
    /// Number of processors in use, on average.
    pub processors: f64,
    /// Levels from few samples to many.
    pub levels: Vec<LevelSummary>,
    /// The decrease of its error with time; `None` for one level.
    pub slope: Option<Slope>,
    /// The law by which its error falls; `None` if there is none.
    pub law: Option<Law>,
    /// The time to each of [`TARGETS`] at the scene's own size.
    pub answers: Vec<(f64, Answer)>,
    /// 1 / (relMSE x seconds) of its longest renders.
    pub efficiency: Ranged,
    /// The efficiency over that of the variant that others are compared with.
    pub ratio: Ranged,
    /// Whether the others are compared with this one: the first in which no bias was found, or else the first.
    pub is_base: bool,
    /// The test of its bias.
    pub bias: Bias,
    /// The time to a tenth of the error of the longest renders, at the scene's own size.
    pub tenth: Answer,
}

impl Summary {
    /// Whether its image has no noise, so that its efficiency is not known.
    pub fn is_exact(&self) -> bool {
        matches!(self.answers.first(), Some((_, Answer::Exact(_))))
    }
}

/// The statistics of one level.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct LevelSummary {
    /// Samples per pixel.
    pub spp: u64,
    /// Number of renders.
    pub runs: usize,
    /// Seconds of one render, on average.
    pub seconds: f64,
    /// relMSE.
    pub rel_mse: Ranged,
    /// relMSE without the largest 0.1 % of the pixels.
    pub trimmed: f64,
    /// The variance: the part of relMSE that changes with the random numbers.
    pub variance: Estimate,
    /// The squared bias: the part that does not.
    pub squared_bias: Estimate,
}

/// Summaries of all variants that have enough renders, with their index.
pub fn summaries(report: &StudyReport) -> Vec<(usize, Summary)> {
    let Some(reference) = &report.reference else {
        return Vec::new();
    };
    let mut dealer = Dealer::new(report.seed);
    let [one, two] = reference.luminances;
    // The error is computed from many differences, so it is taken as certain.
    let luminance = [0.5 * (one + two), reference.luminance_error];
    let mut all = Vec::new();
    let mut efficiencies = Vec::new();
    for (index, study) in report.variants.iter().enumerate() {
        let shared = reference.noise.product_deviation;
        let sizes = [report.size, report.full_size];
        let seed = dealer.below(usize::MAX) as u64;
        let Some((summary, efficiency)) = summary(study, luminance, shared, sizes, seed) else {
            continue;
        };
        all.push((index, summary));
        efficiencies.push(efficiency);
    }
    // The efficiency of a biased variant compares with nothing: it converges to another image.
    let unbiased = all.iter().position(|(_, summary)| !summary.bias.is_found);
    let base = unbiased.unwrap_or(0);
    for (place, (_, summary)) in all.iter_mut().enumerate() {
        summary.is_base = place == base;
        summary.ratio = match summary.is_base {
            true => Ranged {
                value: 1.0,
                low: 1.0,
                high: 1.0,
            },
            false => efficiencies[place].over(&efficiencies[base]).ranged(),
        };
    }
    all
}

/// Fits the time law to all renders of a variant.
pub fn time_law(levels: &[LevelReport]) -> Option<TimeLaw> {
    let points = levels.iter().flat_map(|level| {
        let of_run = move |run: &super::report::RunReport| [level.spp as f64, run.seconds.wall];
        level.runs.iter().map(of_run)
    });
    TimeLaw::of(&points.collect::<Vec<_>>())
}

/// The errors of a variant by level.
pub fn curve(levels: &[LevelReport], seed: u64) -> Curve {
    let level = |level: &LevelReport| ErrorLevel {
        spp: level.spp as f64,
        errors: level.gram.squared_errors(),
    };
    Curve::new(&levels.iter().map(level).collect::<Vec<_>>(), seed)
}

fn summary(
    study: &VariantStudy,
    reference: [f64; 2],
    shared: f64,
    sizes: [(u32, u32); 2],
    seed: u64,
) -> Option<(Summary, Efficiency)> {
    let levels: Vec<LevelReport> = study
        .levels
        .iter()
        .filter(|level| level.runs.len() > 1)
        .cloned()
        .collect();
    let last = levels.last()?;
    let time = time_law(&levels)?;
    let curve = curve(&levels, seed);
    let bias = Bias::of(&levels, reference, shared)?;
    let efficiency = Efficiency::of(last)?;
    let slope = curve.slope();
    let ranges = curve.levels();
    let level = |(level, (_, rel_mse)): (&LevelReport, &(f64, Ranged))| {
        Some(LevelSummary {
            spp: level.spp,
            runs: level.runs.len(),
            seconds: mean(level, |run| run.seconds.wall),
            rel_mse: *rel_mse,
            trimmed: mean(level, |run| run.trimmed),
            variance: level.gram.variance()?,
            squared_bias: level.gram.squared_bias()?,
        })
    };
    let (mut wall, mut cpu) = (0.0, 0.0);
    for run in levels.iter().flat_map(|level| &level.runs) {
        wall += run.seconds.wall;
        cpu += run.seconds.cpu;
    }
    let [pixels, own_pixels] = sizes.map(|(width, height)| f64::from(width) * f64::from(height));
    let converted = TimeLaw {
        sample: time.sample * own_pixels / pixels,
        ..time
    };
    let own_size = study.own_size.filter(|_| pixels != own_pixels);
    let (own_time, own_margin) = own_size.map_or((converted, 0.0), |own| (own.law, own.margin));
    // A bias is a part of the error at either size.
    let own_error = own_size.filter(|_| !bias.is_square_found);
    let own_error = own_error.map_or(OwnError::SAME, |own| own.error);
    let own_margin = own_margin.hypot(own_error.margin);
    let law = curve.law();
    let facts = AnswerInput {
        curve: &curve,
        law,
        bias: &bias,
        is_biased: !study.variant.bias.is_empty(),
        variance: variance_of_sample(last)?,
        time: own_time,
        pace_margin: pace_margin(last).hypot(own_margin),
        error_record: study.error_record,
        pixels: own_pixels as u64,
        error_factor: own_error.factor.sqrt(),
    };
    let answers = TARGETS.map(|target| (target, facts.answer(target)));
    let last_error = last.gram.mse()?.value.max(0.0).sqrt();
    let tenth = facts.answer(0.1 * facts.error_factor * last_error);
    let summary = Summary {
        name: study.variant.name.clone(),
        time,
        own_time,
        own_error: own_error.factor,
        processors: cpu / wall,
        levels: levels.iter().zip(&ranges).filter_map(level).collect(),
        slope,
        law: law.ok(),
        answers: answers.to_vec(),
        efficiency: efficiency.ranged(),
        ratio: efficiency.ranged(),
        is_base: false,
        bias,
        tenth,
    };
    Some((summary, efficiency))
}

fn mean(level: &LevelReport, f: impl Fn(&super::report::RunReport) -> f64) -> f64 {
    Moments::of(level.runs.iter().map(f)).mean()
}

/// The variance of one sample: that of the longest renders times their samples. Of evenly distributed samples that of shorter
/// ones is larger.
fn variance_of_sample(last: &LevelReport) -> Option<Estimate> {
    Some(Estimate::sum(&[(last.spp as f64, last.gram.variance()?)]))
}

/// The half width of the interval of the logarithm of the time of a render, with a confidence of 95 %.
fn pace_margin(level: &LevelReport) -> f64 {
    let seconds = Moments::of(level.runs.iter().map(|run| run.seconds.wall));
    seconds.standard_error().map_or(0.0, |error| {
        student_quantile(seconds.count(), 0.95) * error / seconds.mean()
    })
}

#[cfg(test)]
mod tests {
    use super::super::clock::Seconds;
    use super::super::gram::Gram;
    use super::super::reference::ReferenceNoise;
    use super::super::report::ReferenceReport;
    use super::super::synthetic::{self, SyntheticRender};
    use super::super::variant::VariantReport;
    use super::*;

    /// Renders whose squared errors deviate by shares that `noise` returns, and whose seconds do, too.
    fn level(spp: u64, bias: f64, pace: f64, mut noise: impl FnMut() -> f64) -> LevelReport {
        synthetic::level(spp, |seed| SyntheticRender {
            rel_mse: (bias + 0.01 / spp as f64) * (1.0 + noise()),
            product: bias * (1.0 + 1e-3 * seed as f64),
            seconds: pace * spp as f64 * (1.0 + noise()),
            luminance: 0.5,
        })
    }

    fn study(name: &str, bias: f64, pace: f64) -> VariantStudy {
        let mut step = 0;
        let mut noise = || {
            step += 1;
            0.01 * f64::from(step % 3 - 1)
        };
        let level = |spp: u64| level(spp, bias, pace, &mut noise);
        VariantStudy {
            variant: VariantReport {
                name: name.to_owned(),
                integrator: "path",
                sampler: "sobol",
                backend: "",
                precision: "robust",
                light_paths: "off",
                reuse: "off",
                kernel: None,
                max_bounces: None,
                bias: Vec::new(),
            },
            warm_up: TimeLaw {
                start: 0.0,
                sample: pace,
            },
            own_size: None,
            build: 0.0,
            levels: [1, 2, 4, 8].map(level).to_vec(),
            repeated: 0,
            disturbed: 0,
            error_record: None,
            bars: None,
            tile_p_values: Vec::new(),
            paths: None,
            bounces: Vec::new(),
        }
    }

    fn report(variants: Vec<VariantStudy>) -> StudyReport {
        StudyReport {
            size: (16, 16),
            full_size: (16, 16),
            reference: Some(ReferenceReport {
                integrator: "path",
                sampler: "sobol",
                spp: 64,
                seconds: [Seconds::default(); 2],
                seeds: [1, 2],
                luminances: [0.5; 2],
                luminance_error: 1e-3,
                noise: ReferenceNoise {
                    rel_mse: 1e-6,
                    product_deviation: 1e-7,
                },
            }),
            variants,
            ..StudyReport::default()
        }
    }

    #[test]
    fn ratios_are_to_the_first_variant_without_a_found_bias() {
        let variants = vec![
            study("short", 0.2, 0.01),
            study("slow", 0.0, 0.02),
            study("fast", 0.0, 0.01),
        ];
        let all = summaries(&report(variants));
        let [short, slow, fast] = [0, 1, 2].map(|index| &all[index].1);
        assert!(short.bias.is_found && !slow.bias.is_found && !fast.bias.is_found);
        assert_eq!(
            [short, slow, fast].map(|it| it.is_base),
            [false, true, false]
        );
        assert_eq!((slow.ratio.value, slow.ratio.low), (1.0, 1.0));
        assert!((fast.ratio.value - 2.0).abs() < 0.05, "{:?}", fast.ratio);
        assert!(fast.ratio.low > 1.8 && fast.ratio.high < 2.2);
        // If all of them are biased, the first is the base.
        let all = summaries(&report(vec![
            study("one", 0.2, 0.01),
            study("two", 0.2, 0.01),
        ]));
        assert!(all[0].1.is_base && !all[1].1.is_base);
    }

    #[test]
    fn variance_of_a_sample_is_that_of_the_longest_renders() {
        // Of evenly distributed points, N Var falls.
        let mut steep = study("sobol", 0.0, 0.01);
        for (index, level) in steep.levels.iter_mut().enumerate() {
            let mut gram = Gram::default();
            for seed in 0..4_usize {
                let rel_mse = (0.1 + 1e-3 * seed as f64) / f64::from(1 << (2 * index));
                gram.push(vec![0.0; seed], &vec![0.0; seed], rel_mse);
            }
            level.gram = gram;
        }
        let last = steep.levels.last().expect("levels");
        let variance = variance_of_sample(last).expect("four renders").value;
        assert!(
            (variance / (8.0 * 0.1015 / 64.0) - 1.0).abs() < 1e-9,
            "{variance}"
        );
    }

    #[test]
    fn margin_of_the_own_size_widens_the_answers() {
        let mut study = study("path", 0.0, 0.01);
        let widths = [0.0, 0.5].map(|margin| {
            study.own_size = Some(super::super::own_size::OwnSize {
                law: TimeLaw {
                    start: 0.0,
                    sample: 0.04,
                },
                margin,
                error: OwnError::SAME,
            });
            let mut report = report(vec![study.clone()]);
            report.full_size = (32, 32);
            let summary = summaries(&report)[0].1.clone();
            assert_eq!(summary.own_time.sample, 0.04);
            match summary.answers[2].1 {
                Answer::Law(range) => (range.high / range.low).ln(),
                ref other => panic!("beyond the levels: {other:?}"),
            }
        });
        assert!(widths[1] > 0.95 && widths[0] < 0.5, "{widths:?}");
    }

    #[test]
    fn error_of_the_own_size_scales_the_answers() {
        let answers = [1.0, 0.5].map(|factor| {
            let mut study = study("path", 0.0, 0.01);
            study.own_size = Some(super::super::own_size::OwnSize {
                law: TimeLaw {
                    start: 0.0,
                    sample: 0.04,
                },
                margin: 0.0,
                error: OwnError {
                    factor,
                    margin: 0.0,
                },
            });
            let mut report = report(vec![study]);
            report.full_size = (32, 32);
            let summary = summaries(&report)[0].1.clone();
            assert_eq!(summary.own_error, factor);
            let seconds = summary
                .answers
                .iter()
                .filter_map(|(_, it)| it.seconds())
                .collect::<Vec<_>>();
            (seconds, summary.tenth.seconds().expect("a law"))
        });
        let [(whole, tenth), (half, tenth_of_half)] = answers;
        // Half of relMSE takes half as long, wherever the answer comes from.
        for (whole, half) in whole.iter().zip(&half).skip(1) {
            assert!((half / whole - 0.5).abs() < 0.02, "{whole} {half}");
        }
        // A tenth of the error of as many samples takes as long.
        assert!(
            (tenth_of_half / tenth - 1.0).abs() < 0.02,
            "{tenth} {tenth_of_half}"
        );
    }
}
