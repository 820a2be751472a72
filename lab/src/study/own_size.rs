//! The time and the error of renders at the scene's own size, of a study of a smaller image.
//!
//! Only a few renders of the own size fit into the time before the study, and one disturbed render among them changes the
//! pace of its variant by half. The pace of all variants is therefore taken to change by one factor, the median of theirs,
//! and that factor is trusted half: the pace lies in the middle between the measured one and that of as many pixels of
//! the smaller image, on a logarithmic scale, and its interval holds both.
//!
//! The error changes with the size, too: a smaller image has a larger share of pixels at edges. Its factor is the ratio of
//! both sizes' estimates after equally many samples, a few of each pixel, drawn towards 1 as far as it is uncertain.
//!
//! Measure: seconds, relMSE; margins are half widths of intervals of the logarithm.
//! Range: measured factors of the pace beyond 1/2 and 2 are those of a disturbed machine, and count as 1/2 and 2.
//! Source: docs/accuracy.md, "The study". Tested below.

use super::fit::TimeLaw;
use etendue::internals::math::stats::normal_quantile;
use etendue::internals::render::convergence::ErrorRecord;
use serde::{Deserialize, Serialize};

/// The largest factor between the pace at the own size and that of as many pixels of a smaller image.
const MAX_FACTOR: f64 = 2.0;

/// The standard deviation of the logarithm of the factor of relMSE, before anything is measured.
const PRIOR: f64 = 0.35;

/// The standard deviation of the logarithm by which the factor differs between few samples and many.
const DRIFT: f64 = 0.1;

/// The time and the error at the scene's own size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OwnSize {
    /// Seconds by samples per pixel.
    pub law: TimeLaw,
    /// The half width of the interval of the logarithm of the pace.
    pub margin: f64,
    /// The error.
    pub error: OwnError,
}

/// The error at the scene's own size, relative to that of the smaller image after as many samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OwnError {
    /// The factor of relMSE.
    pub factor: f64,
    /// The half width of the interval of its logarithm.
    pub margin: f64,
}

impl OwnError {
    /// The error of an image of the scene's own size.
    pub const SAME: Self = Self {
        factor: 1.0,
        margin: 0.0,
    };

    /// The factor by estimates of the error at the own size and at the smaller one.
    pub fn of(own: &[ErrorRecord], small: &[ErrorRecord]) -> Self {
        let pairs = own.iter().filter_map(|own| {
            let small = small.iter().find(|it| it.samples == own.samples)?;
            let ratio = 2.0 * (own.rel_rmse / small.rel_rmse).ln();
            let variance = own.uncertainty.powi(2) + small.uncertainty.powi(2) + DRIFT * DRIFT;
            (ratio.is_finite() && variance.is_finite()).then_some((own.samples, ratio, variance))
        });
        let last = pairs.max_by(|a, b| a.0.total_cmp(&b.0));
        let (_, ratio, variance) = last.unwrap_or((0.0, 0.0, f64::INFINITY));
        // The posterior of a normal distribution.
        let weight = PRIOR * PRIOR / (PRIOR * PRIOR + variance);
        let deviation = PRIOR * (1.0 - weight).sqrt();
        Self {
            factor: (weight * ratio).exp(),
            margin: normal_quantile(0.975) * deviation,
        }
    }
}

/// The times of all variants, with the errors of the smaller image, from (samples, seconds) of renders at the own size,
/// the laws of the smaller image, and the number of pixels over that of the smaller image.
pub fn own_times(own: &[Vec<[f64; 2]>], small: &[TimeLaw], share: f64) -> Vec<OwnSize> {
    // A start that does not grow with the image, such as that of threads, may not exceed what was measured.
    let expected = |(points, law): (&Vec<[f64; 2]>, &TimeLaw)| {
        let seconds = points.iter().map(|[_, seconds]| *seconds);
        let shortest = seconds.fold(f64::INFINITY, f64::min);
        TimeLaw {
            start: (share * law.start).min(0.5 * shortest),
            sample: share * law.sample,
        }
    };
    let expected: Vec<TimeLaw> = own.iter().zip(small).map(expected).collect();
    let factors = own.iter().zip(&expected).map(|(points, expected)| {
        let pace = TimeLaw::after(expected.start, points);
        let factor = (pace / expected.sample).ln();
        // Without a measured pace nothing speaks against that of the smaller image.
        let factor = if factor.is_nan() { 0.0 } else { factor };
        factor.clamp(-MAX_FACTOR.ln(), MAX_FACTOR.ln())
    });
    let mut factors: Vec<f64> = factors.collect();
    factors.sort_by(f64::total_cmp);
    let middle = 0.5 * median(&factors);
    let margin = factors
        .iter()
        .chain(&[0.0])
        .fold(0.0_f64, |most, factor| most.max((factor - middle).abs()));
    let of_variant = |law: &TimeLaw| OwnSize {
        law: TimeLaw {
            sample: law.sample * middle.exp(),
            ..*law
        },
        margin,
        error: OwnError::SAME,
    };
    expected.iter().map(of_variant).collect()
}

/// The median of sorted numbers; 0 without any.
fn median(sorted: &[f64]) -> f64 {
    match sorted.len() {
        0 => 0.0,
        n => 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHARE: f64 = 25.0;

    fn small(sample: f64) -> TimeLaw {
        TimeLaw {
            start: 0.002,
            sample,
        }
    }

    /// Renders at the own size, whose samples take `factor` times as long as expected of a pace of 0.01.
    fn points(factor: f64) -> Vec<[f64; 2]> {
        let time = |n: f64| [n, 0.05 + factor * 0.25 * n];
        [1.0, 2.0].map(time).to_vec()
    }

    /// The pace over that of as many pixels of the smaller image, and the interval of the pace.
    fn pace(own: &OwnSize, small: &TimeLaw) -> [f64; 3] {
        let value = own.law.sample / (SHARE * small.sample);
        [value, value * (-own.margin).exp(), value * own.margin.exp()]
    }

    #[test]
    fn pace_interval_holds_the_measured_and_the_expected_pace() {
        let law = small(0.01);
        for factor in [0.7, 1.0, 1.5] {
            let own = own_times(&[points(factor)], &[law], SHARE);
            let [value, low, high] = pace(&own[0], &law);
            assert!((value - factor.sqrt()).abs() < 1e-9, "{factor}: {value}");
            let held = |pace: f64| low <= pace * 1.0001 && pace <= high * 1.0001;
            assert!(held(1.0) && held(factor), "{factor}: {low} {high}");
            assert!((own[0].law.start - SHARE * law.start).abs() < 1e-12);
        }
    }

    fn error_record(samples: f64, rel_rmse: f64, uncertainty: f64) -> ErrorRecord {
        ErrorRecord {
            samples,
            rel_rmse,
            uncertainty,
            bias: 0.0,
            largest_sample: 0.0,
            largest_pixel: 0.0,
        }
    }

    #[test]
    fn error_factor_is_measured_where_it_is_certain() {
        let small = [
            error_record(4.0, 0.4, 0.05),
            error_record(8.0, 0.2, 0.05),
            error_record(16.0, 0.1, 0.05),
        ];
        let own = |uncertainty: f64| {
            [
                error_record(4.0, 0.3, 0.01),
                error_record(8.0, 0.1, uncertainty),
            ]
        };
        // Half of the error is a quarter of relMSE.
        let certain = OwnError::of(&own(0.01), &small);
        assert!((0.25..0.32).contains(&certain.factor), "{certain:?}");
        let [low, high] = [-1.0, 1.0].map(|side| certain.factor * (side * certain.margin).exp());
        assert!(low < 0.25 && high < 0.4, "{certain:?}");
        let rough = OwnError::of(&own(1.0), &small);
        assert!(
            rough.factor > 0.8 && rough.margin > 2.0 * certain.margin,
            "{rough:?}"
        );
        // Without two estimates after as many samples, little is known.
        for own in [&[][..], &[error_record(2.0, 0.1, 0.01)]] {
            let unknown = OwnError::of(own, &small);
            assert!(
                unknown.factor == 1.0 && unknown.margin > rough.margin,
                "{unknown:?}"
            );
        }
    }

    #[test]
    fn variants_share_the_factor_of_the_own_size() {
        let laws = [small(0.01); 3];
        let own = own_times(&[points(1.2), points(1.2), points(1.6)], &laws, SHARE);
        let paces: Vec<[f64; 3]> = own.iter().map(|own| pace(own, &laws[0])).collect();
        // The comparison of variants does not change by the time that one of them alone took longer.
        assert_eq!(paces[0], paces[2]);
        let [value, low, high] = paces[0];
        assert!((value - 1.2_f64.sqrt()).abs() < 1e-9, "{value}");
        assert!(low < 1.0 && (high - 1.6).abs() < 1e-6, "{low} {high}");
    }

    #[test]
    fn disturbed_renders_change_the_pace_by_a_bounded_factor() {
        let law = small(0.01);
        // The first of them took longer than the second, or the second much longer than both samples.
        for points in [vec![[1.0, 0.9], [2.0, 0.8]], vec![[1.0, 0.3], [2.0, 9.0]]] {
            let own = own_times(&[points], &[law], SHARE);
            let [value, low, high] = pace(&own[0], &law);
            assert!((0.7..1.42).contains(&value), "{value}");
            assert!(low < 1.0001 && high > 0.9999, "{low} {high}");
        }
        // A single render, and none.
        for points in [vec![[1.0, 0.3]], vec![]] {
            let own = own_times(&[points], &[law], SHARE);
            assert!((pace(&own[0], &law)[0] - 1.0).abs() < 1e-9, "{own:?}");
        }
    }
}
