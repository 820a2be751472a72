//! The reliability of error bars: how often they contain the reference.
//!
//! Measure: fractions of the channels of pixels; z as normal scores of errors over standard errors.
//! Range: a film with four samples a pixel at least; pixels without noise are left out. The reference has noise of its
//! own; its share of the bars' variance is reported and should be small.
//! Source: intervals of proportions by Wilson 1927, for as many trials as pixels, since the channels of a pixel are
//! correlated. Tested below.

use super::reference::References;
use etendue::internals::film::Film;
use etendue::internals::image::Image;
use etendue::internals::math::stats::{normal_quantile, normal_score};
use serde::Serialize;

/// Confidence levels that are tested.
const CONFIDENCES: [f64; 5] = [0.5, 0.8, 0.9, 0.95, 0.99];

/// Number of bins of the histogram of z, from -5 to 5; values beyond are counted in the first or the last.
pub const BINS: usize = 40;
/// Normal score at the ends of the histogram.
pub const MAX_Z: f64 = 5.0;

/// A standard error below this fraction of the value is rounding: all samples are equal.
const ROUNDING: f64 = 1e-6;

/// The reliability of the error bars of one render.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BarsReport {
    /// Samples per pixel.
    pub spp: u64,
    /// The fraction of pixels whose error bars are flagged as unreliable.
    pub flagged: f64,
    /// The variance of the reference over that of the bars, on average.
    pub reference_share: f64,
    /// Coverage of the reference, by confidence level.
    pub coverage: Vec<Coverage>,
    /// Histogram of the channels of trusted pixels by error over standard error, as normal scores.
    pub z: Vec<u64>,
    /// Histogram of the channels of flagged pixels.
    pub z_flagged: Vec<u64>,
}

/// The coverage of the reference by bars of one confidence level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Coverage {
    /// The confidence level, which is the expected coverage.
    pub confidence: f64,
    /// Coverage for trusted pixels.
    pub trusted: Proportion,
    /// Coverage for flagged pixels.
    pub flagged: Proportion,
}

/// A proportion of counts.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Proportion {
    /// Channels of pixels whose bars contain the reference.
    pub held: u64,
    /// All channels of pixels.
    pub count: u64,
}

impl Proportion {
    /// The proportion; NaN if the count is 0.
    pub fn value(&self) -> f64 {
        self.held as f64 / self.count as f64
    }

    /// Wilson's interval of 95 %, for a third as many trials.
    pub fn interval(&self) -> [f64; 2] {
        let (n, p) = (self.count as f64 / 3.0, self.value());
        let z = normal_quantile(0.975);
        let scale = 1.0 / (1.0 + z * z / n);
        let middle = scale * (p + 0.5 * z * z / n);
        let half = scale * z * (p * (1.0 - p) / n + 0.25 * z * z / (n * n)).sqrt();
        [middle - half, middle + half]
    }

    fn add(&mut self, is_held: bool) {
        self.held += u64::from(is_held);
        self.count += 1;
    }
}

/// Compares the error bars of a film with the reference; also returns the standard error of each pixel. `None` before
/// every pixel has four samples.
pub fn reliability(film: &Film, spp: u64, references: &References) -> Option<(BarsReport, Image)> {
    let bars = film.has_all_batches().then(|| film.error_bars())?;
    let picture = film.develop();
    let mut coverage = CONFIDENCES.map(|confidence| Coverage {
        confidence,
        trusted: Proportion::default(),
        flagged: Proportion::default(),
    });
    let mut z_counts = [vec![0; BINS], vec![0; BINS]];
    let (mut of_bars, mut of_reference) = (0.0, 0.0);
    let reference_variance = references.variance_of_mean();
    for (index, &flag) in bars.flags.iter().enumerate() {
        let quantiles = CONFIDENCES.map(|confidence| bars.quantile(index, confidence));
        let [x, r, error] = [&picture, references.mean(), &bars.standard_errors]
            .map(|image| image.pixels()[index].to_array().map(f64::from));
        for c in 0..3 {
            if error[c] <= ROUNDING * r[c].abs() {
                continue;
            }
            let z = (x[c] - r[c]) / error[c];
            for (coverage, quantile) in coverage.iter_mut().zip(quantiles) {
                let share = match flag {
                    true => &mut coverage.flagged,
                    false => &mut coverage.trusted,
                };
                share.add(z.abs() <= quantile);
            }
            let score = normal_score(z, bars.freedom[index].into());
            z_counts[usize::from(flag)][bin(score)] += 1;
            let weight = references.weights()[index][c];
            of_bars += weight * error[c] * error[c];
            of_reference += weight * reference_variance[index][c];
        }
    }
    let report = BarsReport {
        spp,
        flagged: bars.flagged_share(),
        reference_share: if of_bars > 0.0 {
            of_reference / of_bars
        } else {
            0.0
        },
        coverage: coverage.to_vec(),
        z: std::mem::take(&mut z_counts[0]),
        z_flagged: std::mem::take(&mut z_counts[1]),
    };
    Some((report, bars.standard_errors))
}

fn bin(z: f64) -> usize {
    let place = (z / MAX_Z + 1.0) * 0.5 * BINS as f64;
    (place.max(0.0) as usize).min(BINS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilson_interval_matches_reference_value() {
        // 8 of 10: [0.4902, 0.9433].
        let share = Proportion {
            held: 24,
            count: 30,
        };
        let [low, high] = share.interval();
        assert!(
            (low - 0.4902).abs() < 1e-4 && (high - 0.9433).abs() < 1e-4,
            "{low} {high}"
        );
    }

    #[test]
    fn bin_index_clamps_out_of_range_values() {
        let bins = [-9.0, -5.0, -0.1, 0.1, 4.99, 9.0].map(bin);
        assert_eq!(bins, [0, 0, 19, 20, 39, 39]);
    }
}
