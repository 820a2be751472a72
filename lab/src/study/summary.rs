//! Statistics of the renders of a variant: the time to given errors, its efficiency and its bias.
//!
//! Measure: seconds, relMSE and its root, stated at each field.
//! Range: at least two levels with two renders each.
//! Source: docs/accuracy.md, "The study". Tested below and in `lab/tests/reports/study.rs`.

use super::answer::{Answer, Facts};
use super::bias::Bias;
use super::bootstrap::{Dealer, REPLICAS, Ranged};
use super::fit::{Curve, ErrorLevel, Slope, TimeLaw};
use super::gram::Estimate;
use super::law::Law;
use super::report::{LevelReport, StudyReport, VariantStudy};
use etendue::internals::math::stats::Moments;
use serde::Serialize;

/// Roots of relMSE for which the time is reported.
pub const TARGETS: [f64; 5] = [0.1, 0.03, 0.01, 0.003, 0.001];

/// The statistics of the renders of a variant.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// Its name.
    pub name: String,
    /// Seconds by samples per pixel, at the size of the study ...
    pub time: TimeLaw,
    /// ... and at the scene's own size.
    pub own_time: TimeLaw,
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
    /// The efficiency over that of the first variant.
    pub ratio: Ranged,
    /// The test of its bias.
    pub bias: Bias,
    /// The time to a tenth of the error of the longest renders, at the scene's own size.
    pub tenth: Answer,
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
    // The error is computed from as many differences as there are pixels, so it is taken as certain.
    let luminance = [0.5 * (one + two), reference.luminance_error];
    let mut efficiencies: Vec<(usize, Vec<f64>)> = Vec::new();
    let mut all = Vec::new();
    for (index, study) in report.variants.iter().enumerate() {
        let shared = reference.noise.product_deviation;
        let sizes = [report.size, report.full_size];
        let Some((summary, replicas)) = summary(study, luminance, shared, sizes, &mut dealer)
        else {
            continue;
        };
        efficiencies.push((index, replicas));
        all.push((index, summary));
    }
    let Some(((_, first), (_, base))) = all.first().cloned().zip(efficiencies.first()) else {
        return all;
    };
    for ((_, summary), (index, replicas)) in all.iter_mut().zip(&efficiencies) {
        let ratio = summary.efficiency.value / first.efficiency.value;
        let pairs = replicas.iter().zip(base);
        summary.ratio = match index {
            0 => Ranged {
                value: 1.0,
                low: 1.0,
                high: 1.0,
            },
            _ => Ranged::of(ratio, pairs.map(|(own, base)| own / base)),
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
    dealer: &mut Dealer,
) -> Option<(Summary, Vec<f64>)> {
    let levels: Vec<LevelReport> = study
        .levels
        .iter()
        .filter(|level| level.runs.len() > 1)
        .cloned()
        .collect();
    let last = levels.last()?;
    let time = time_law(&levels)?;
    let curve = curve(&levels, dealer.below(usize::MAX) as u64);
    let bias = Bias::of(&levels, reference, shared)?;
    let (efficiency, replicas) = efficiency(last, dealer);
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
    let own_time = match study.own_size {
        Some(law) if pixels != own_pixels => law,
        _ => TimeLaw {
            sample: time.sample * own_pixels / pixels,
            ..time
        },
    };
    let law = curve.law();
    let facts = Facts {
        curve: &curve,
        law,
        bias: &bias,
        is_biased: !study.variant.bias.is_empty(),
        variance: variance_of_sample(&levels)?,
        time: own_time,
        pace_error: pace_error(last),
        look: study.look,
        pixels: own_pixels as u64,
    };
    let answers = TARGETS.map(|target| (target, facts.answer(target)));
    let last_error = last.gram.mse()?.value.max(0.0).sqrt();
    let tenth = facts.answer(0.1 * last_error);
    let summary = Summary {
        name: study.variant.name.clone(),
        time,
        own_time,
        processors: cpu / wall,
        levels: levels.iter().zip(&ranges).filter_map(level).collect(),
        slope,
        law: law.ok(),
        answers: answers.to_vec(),
        efficiency,
        ratio: efficiency,
        bias,
        tenth,
    };
    Some((summary, replicas))
}

fn mean(level: &LevelReport, f: impl Fn(&super::report::RunReport) -> f64) -> f64 {
    Moments::of(level.runs.iter().map(f)).mean()
}

/// 1 / (relMSE x seconds), with its replicas: errors and seconds are resampled separately.
fn efficiency(level: &LevelReport, dealer: &mut Dealer) -> (Ranged, Vec<f64>) {
    let seconds: Vec<f64> = level.runs.iter().map(|run| run.seconds.wall).collect();
    let groups = [level.gram.squared_errors(), seconds];
    let of_means = |means: &[f64]| 1.0 / (means[0] * means[1]);
    let means = groups.clone().map(|group| Moments::of(group).mean());
    let replicas: Vec<f64> = (0..REPLICAS)
        .map(|_| of_means(&dealer.means(&groups)))
        .collect();
    let ranged = Ranged::of(of_means(&means), replicas.iter().copied());
    (ranged, replicas)
}

/// The variance of one sample: that of each level times its samples, weighted by the number of renders.
fn variance_of_sample(levels: &[LevelReport]) -> Option<Estimate> {
    let total: f64 = levels.iter().map(|level| level.runs.len() as f64).sum();
    let part = |level: &LevelReport| {
        let weight = level.runs.len() as f64 * level.spp as f64 / total;
        Some((weight, level.gram.variance()?))
    };
    Some(Estimate::sum(
        &levels.iter().map(part).collect::<Option<Vec<_>>>()?,
    ))
}

/// The relative standard error of the time of a render.
fn pace_error(level: &LevelReport) -> f64 {
    let seconds = Moments::of(level.runs.iter().map(|run| run.seconds.wall));
    seconds.standard_error().unwrap_or(0.0) / seconds.mean()
}
