//! Whether error bars hold what they say: how often the reference is within them.
//!
//! Measure: shares of the channels of pixels; z as normal scores of errors over standard errors.
//! Range: a film with four samples a pixel at least; pixels without noise are left out. The reference has noise of its own, a share of the bars'
//! variance that is told: it should be small.
//! Source: intervals of shares by Wilson 1927, for as many trials as pixels, since channels go together. Tested below.

use super::reference::References;
use etendue::internals::film::Film;
use etendue::internals::image::Image;
use etendue::internals::math::stats::{normal_quantile, normal_score};
use serde::Serialize;

/// Confidences that are tried.
const CONFIDENCES: [f64; 5] = [0.5, 0.8, 0.9, 0.95, 0.99];

/// Bins of the histogram of z, from -5 to 5; what is farther out is in the first or the last.
pub const BINS: usize = 40;
/// Normal scores at the ends of it.
pub const FARTHEST: f64 = 5.0;

/// A standard error below this share of the value is rounding: samples that are all alike.
const ROUNDING: f64 = 1e-6;

/// What came of the bars of one render.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BarsReport {
    /// Samples per pixel.
    pub spp: u64,
    /// The share of pixels whose bars say themselves that they are not to be trusted.
    pub flagged: f64,
    /// The variance of the reference over that of the bars, on average.
    pub reference_share: f64,
    /// How often bars held the reference.
    pub coverage: Vec<Coverage>,
    /// Of trusted pixels, how many channels were so far off: errors over standard errors, as normal scores.
    pub z: Vec<u64>,
    /// The same of flagged pixels.
    pub z_flagged: Vec<u64>,
}

/// How often bars of a confidence held the reference.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Coverage {
    /// How often they should.
    pub confidence: f64,
    /// Of the trusted.
    pub trusted: Share,
    /// Of the flagged.
    pub flagged: Share,
}

/// How many of how many.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Share {
    /// Channels of pixels that were held.
    pub held: u64,
    /// Of so many.
    pub count: u64,
}

impl Share {
    /// The share itself; not a number of nothing.
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

/// Holds the error bars of a film against the reference; with them, the standard error of each pixel. `None` before every
/// pixel has four samples.
pub fn reliability(film: &Film, spp: u64, references: &References) -> Option<(BarsReport, Image)> {
    let bars = film.has_all_batches().then(|| film.error_bars())?;
    let picture = film.develop();
    let mut coverage = CONFIDENCES.map(|confidence| Coverage {
        confidence,
        trusted: Share::default(),
        flagged: Share::default(),
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
    let place = (z / FARTHEST + 1.0) * 0.5 * BINS as f64;
    (place.max(0.0) as usize).min(BINS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_wilsons() {
        // 8 of 10: [0.4902, 0.9433].
        let share = Share {
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
    fn bins_take_everything_in() {
        let bins = [-9.0, -5.0, -0.1, 0.1, 4.99, 9.0].map(bin);
        assert_eq!(bins, [0, 0, 19, 20, 39, 39]);
    }
}
