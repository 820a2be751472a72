//! Times of several machines as those of one of their mean pace.
//!
//! Every shard renders the same tasks. Its pace is the time of all of them over the geometric mean of those of all shards;
//! its times are divided by it. Ratios of variants thus compare renders of one machine, and times of a level differ between
//! shards by what the pace does not explain.
//!
//! Measure: seconds.
//! Range: at least one shard; all with the same tasks.
//! Source: a two-way layout without interaction, machines by tasks. Tested below.

use super::super::report::StudyReport;
use super::super::summary::time_law;
use super::part::StudyPart;

/// The ratio of the slowest to the quickest machine above which the reader is told.
const MENTIONED: f64 = 1.1;

/// Divides the times of each shard by its pace; returns a warning where paces differ.
pub fn to_mean_pace(parts: &mut [StudyPart]) -> Option<String> {
    let time = |part: &StudyPart| part.renders.iter().map(|render| render.seconds.wall).sum();
    let paces = paces(&parts.iter().map(time).collect::<Vec<f64>>());
    for (part, pace) in parts.iter_mut().zip(&paces) {
        let renders = part.renders.iter_mut().map(|render| &mut render.seconds);
        for seconds in renders.chain(&mut part.references.seconds) {
            seconds.wall /= pace;
            seconds.cpu /= pace;
        }
    }
    let slowest = paces.iter().copied().fold(0.0, f64::max);
    let quickest = paces.iter().copied().fold(f64::INFINITY, f64::min);
    let ratio = slowest / quickest;
    (ratio > MENTIONED).then(|| {
        format!(
            "the slowest of the machines took {ratio:.2} times as long as the quickest: times are those of a machine of their mean pace, and ratios compare renders of one machine"
        )
    })
}

/// Times over their geometric mean.
fn paces(seconds: &[f64]) -> Vec<f64> {
    let mean = mean(seconds.iter().map(|seconds| seconds.ln())).exp();
    seconds.iter().map(|seconds| seconds / mean).collect()
}

/// Converts the times at the scene's own size, which the machine that planned the study measured, by the pace of all variants
/// in the renders over that in the plan.
pub fn own_size_to_mean_pace(report: &mut StudyReport) {
    let ratios = report.variants.iter().filter_map(|study| {
        let law = time_law(&study.levels)?;
        let ratio = (law.sample / study.warm_up.sample).ln();
        ratio.is_finite().then_some(ratio)
    });
    let ratios: Vec<f64> = ratios.collect();
    if ratios.is_empty() {
        return;
    }
    let ratio = mean(ratios.into_iter()).exp();
    let own = report
        .variants
        .iter_mut()
        .filter_map(|study| study.own_size.as_mut());
    for own in own {
        own.law.start *= ratio;
        own.law.sample *= ratio;
    }
}

fn mean(numbers: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = numbers.len() as f64;
    numbers.sum::<f64>() / count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paces_are_times_over_their_geometric_mean() {
        let found = paces(&[1.0, 4.0, 2.0]);
        for (pace, expected) in found.iter().zip([0.5, 2.0, 1.0]) {
            assert!((pace - expected).abs() < 1e-12, "{found:?}");
        }
        assert!((paces(&[3.0])[0] - 1.0).abs() < 1e-12);
    }
}
