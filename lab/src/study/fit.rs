//! Lines fitted to measured points: time by samples, error by samples, and the samples at which the error falls below a
//! limit.
//!
//! Measure: seconds, samples per pixel, relMSE.
//! Range: at least two levels of samples for a line, three for a test of its fit. `law.rs` extrapolates.
//! Source: weighted least squares; intervals by the bootstrap over renders within each level. Tested below.

use super::bootstrap::{Dealer, REPLICAS, Ranged};
use super::gram::Estimate;
use etendue::internals::math::stats::{Moments, normal_quantile, student_quantile_of};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// The law t(N) = start + sample N.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TimeLaw {
    /// Seconds before the first sample.
    pub start: f64,
    /// Seconds for one sample in every pixel.
    pub sample: f64,
}

impl TimeLaw {
    /// Fits the law to (samples, seconds); `None` without points. Standard deviations are taken as proportional to the
    /// seconds. The seconds for a sample are above 0: where longer renders took less time, as on a busy machine, there is no
    /// line, and all of the time is that of the samples.
    pub fn of(points: &[[f64; 2]]) -> Option<Self> {
        let mut sums = [0.0; 5];
        for &[n, t] in points.iter().filter(|[_, t]| *t > 0.0) {
            let w = 1.0 / (t * t);
            for (sum, x) in sums.iter_mut().zip([1.0, n, n * n, t, n * t]) {
                *sum += w * x;
            }
        }
        let [w, wn, wnn, wt, wnt] = sums;
        let determinant = w * wnn - wn * wn;
        let rises = w * wnt > wn * wt;
        let is_line = rises && determinant > f64::EPSILON * w * wnn;
        let start = if is_line {
            ((wnn * wt - wn * wnt) / determinant).max(0.0)
        } else {
            0.0
        };
        (wnn > 0.0).then(|| Self {
            start,
            // The rest of the time is that of the samples; if no line can be fitted, all of it.
            sample: (wnt - start * wn) / wnn,
        })
    }

    /// The seconds for a sample by (samples, seconds) of few renders, if their start is known; NaN without points. A start is
    /// at most half of the time of the shortest render.
    pub fn after(start: f64, points: &[[f64; 2]]) -> f64 {
        let shortest = points.iter().map(|[_, t]| *t).fold(f64::INFINITY, f64::min);
        let start = start.min(0.5 * shortest);
        let (mut wnt, mut wnn) = (0.0, 0.0);
        for &[n, t] in points.iter().filter(|[_, t]| *t > 0.0) {
            let w = 1.0 / (t * t);
            wnt += w * n * (t - start);
            wnn += w * n * n;
        }
        wnt / wnn
    }

    /// Seconds for `samples` samples per pixel.
    pub fn at(&self, samples: f64) -> f64 {
        self.start + self.sample * samples
    }
}

/// The relMSE of independent renders with equal samples per pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorLevel {
    /// Samples per pixel.
    pub spp: f64,
    /// One for each render; some may be negative by chance.
    pub errors: Vec<f64>,
}

/// The line log MSE = a - b log t.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Slope {
    /// The exponent b.
    pub b: Ranged,
    /// The intercept a, for t in samples per pixel.
    pub a: f64,
    /// The p-value of the lack-of-fit test: the probability of points as far from the line if it is a line; `None` for
    /// two levels.
    pub lack_of_fit: Option<f64>,
}

/// Error levels, with bootstrap replicas of their mean errors.
#[derive(Debug, Clone)]
pub struct Curve {
    pub(super) spp: Vec<f64>,
    pub(super) groups: Vec<Vec<f64>>,
    pub(super) means: Vec<f64>,
    pub(super) replicas: Vec<Vec<f64>>,
}

impl Curve {
    /// The curve of levels sorted by samples; those of less than two renders are left out.
    pub fn new(levels: &[ErrorLevel], seed: u64) -> Self {
        let used = levels.iter().filter(|level| level.errors.len() > 1);
        let (spp, groups): (Vec<f64>, Vec<Vec<f64>>) =
            used.map(|level| (level.spp, level.errors.clone())).unzip();
        let means = groups
            .iter()
            .map(|group| Moments::of(group.iter().copied()).mean())
            .collect();
        let mut dealer = Dealer::new(seed);
        let replicas = (0..REPLICAS).map(|_| dealer.means(&groups)).collect();
        Self {
            spp,
            groups,
            means,
            replicas,
        }
    }

    /// The mean error of each level, with its interval.
    pub fn levels(&self) -> Vec<(f64, Ranged)> {
        let level = |index: usize| {
            let replicas = self.replicas.iter().map(|means| means[index]);
            let range = Ranged::of(self.means[index], replicas);
            (self.spp[index], self.widened(range, &[(index, 1.0)]))
        };
        (0..self.spp.len()).map(level).collect()
    }

    /// The slope over samples per pixel, to which time is proportional except for the start.
    pub fn slope(&self) -> Option<Slope> {
        let [a, b] = self.line(&self.means, 0)?;
        let slopes = self.replicas.iter().filter_map(|means| self.line(means, 0));
        Some(Slope {
            b: Ranged::of(b, slopes.map(|[_, b]| b)),
            a,
            lack_of_fit: self.lack_of_fit([a, b], 0),
        })
    }

    /// The bootstrap interval of a mean of levels, by (level, share in the logarithm), with the tails of Student's
    /// distribution: the replicas of few renders have its deviation, but not its tails. An interval that is not of positive
    /// numbers stays as it is.
    pub(super) fn widened(&self, range: Ranged, shares: &[(usize, f64)]) -> Ranged {
        // The renders of all levels are taken to spread alike, relative to their mean.
        let parts = shares.iter().map(|&(level, share)| {
            let count = self.groups[level].len() as f64;
            let estimate = Estimate {
                value: 0.0,
                standard_error: count.sqrt().recip(),
                freedom: count - 1.0,
            };
            (share, estimate)
        });
        let freedom = Estimate::sum(&parts.collect::<Vec<_>>()).freedom;
        let factor = student_quantile_of(freedom, 0.975) / normal_quantile(0.975);
        let has_logarithm = range.low > 0.0 && range.value.is_finite() && factor.is_finite();
        if has_logarithm {
            range.widened(factor)
        } else {
            range
        }
    }

    /// The levels from `first` on, each with its share in a mean weighted by renders.
    pub(super) fn shares(&self, first: usize) -> Vec<(usize, f64)> {
        let counts = self.groups[first..].iter().map(Vec::len);
        let all: usize = counts.clone().sum();
        let share = |(level, count)| (level, count as f64 / all as f64);
        (first..).zip(counts).map(share).collect()
    }

    /// Number of levels.
    pub fn len(&self) -> usize {
        self.spp.len()
    }

    /// Whether there are no levels.
    pub fn is_empty(&self) -> bool {
        self.spp.is_empty()
    }

    /// Fits a and b to the means of the levels from `first` on, weighted by their numbers of renders.
    pub(super) fn line(&self, means: &[f64], first: usize) -> Option<[f64; 2]> {
        let mut sums = [0.0; 5];
        let mut levels = 0;
        // A mean that is 0 or less by chance has no logarithm.
        for index in (first..self.len()).filter(|&index| means[index] > 0.0) {
            levels += 1;
            let weight = self.groups[index].len() as f64;
            let (w, x, y) = (weight, self.spp[index].ln(), means[index].ln());
            for (sum, term) in sums.iter_mut().zip([1.0, x, y, x * x, x * y]) {
                *sum += w * term;
            }
        }
        let [w, x, y, xx, xy] = sums;
        let b = -(w * xy - x * y) / (w * xx - x * x);
        (levels > 1).then_some([(y + b * x) / w, b])
    }

    /// The F-test of the distances from the line against the variance of renders within the levels.
    pub(super) fn lack_of_fit(&self, [a, b]: [f64; 2], first: usize) -> Option<f64> {
        let (mut off, mut within, mut freedom, mut levels) = (0.0, 0.0, 0.0, 0.0);
        for index in (first..self.len()).filter(|&index| self.means[index] > 0.0) {
            let (spp, group, mean) = (self.spp[index], &self.groups[index], self.means[index]);
            let moments = Moments::of(group.iter().copied());
            let count = group.len() as f64;
            off += count * (mean.ln() - a + b * spp.ln()).powi(2);
            within += (count - 1.0) * moments.variance()? / (mean * mean);
            freedom += count - 1.0;
            levels += 1.0;
        }
        let of_line = levels - 2.0;
        let f = (off / of_line) / (within / freedom);
        let law = FisherSnedecor::new(of_line, freedom).ok()?;
        f.is_finite().then(|| law.sf(f))
    }

    /// The last crossing of `rel_mse`: 0 before the first level, infinite after the last; interpolated between two
    /// levels by a power law.
    pub(super) fn crossing(&self, means: &[f64], rel_mse: f64) -> f64 {
        let above = means.iter().rposition(|&mean| mean >= rel_mse);
        match above {
            None if means.is_empty() => f64::INFINITY,
            None => 0.0,
            Some(last) if last + 1 == means.len() => f64::INFINITY,
            Some(i) => {
                let [n0, n1] = [self.spp[i].ln(), self.spp[i + 1].ln()];
                // An error of 0 or less is replaced by the smallest positive number.
                let [e0, e1] = [means[i].ln(), means[i + 1].max(f64::MIN_POSITIVE).ln()];
                (n0 + (n1 - n0) * (e0 - rel_mse.ln()) / (e0 - e1)).exp()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue::internals::math::stats::normal_quantile;

    fn levels(dealer: &mut Dealer, b: f64, spread: f64) -> Vec<ErrorLevel> {
        let mut normal =
            || normal_quantile((dealer.below(1 << 40) as f64 + 0.5) / (1_u64 << 40) as f64);
        let mut level = |power: i32| {
            let spp = f64::from(power).exp2();
            let errors = (0..16).map(|_| spp.powf(-b) * (1.0 + spread * normal()));
            ErrorLevel {
                spp,
                errors: errors.collect(),
            }
        };
        (0..7).map(&mut level).collect()
    }

    #[test]
    fn time_law_fits_startup_and_per_sample_cost() {
        let points: Vec<[f64; 2]> = (0..8)
            .map(|i| f64::from(i).exp2())
            .map(|n| [n, 0.5 + 0.01 * n])
            .collect();
        let law = TimeLaw::of(&points).expect("several points");
        assert!(
            (law.start - 0.5).abs() < 1e-9 && (law.sample - 0.01).abs() < 1e-9,
            "{law:?}"
        );
        // Longer renders that took less time are noise, too.
        let law = TimeLaw::of(&[[1.0, 0.9], [2.0, 0.6], [4.0, 0.5]]).expect("three");
        assert!(law.start == 0.0 && law.sample > 0.0, "{law:?}");
        // A negative start is noise; a single level gives no start.
        let law = TimeLaw::of(&[[1.0, 0.9], [2.0, 2.1], [4.0, 4.3]]).expect("three");
        assert!(
            law.start == 0.0 && (law.sample - 1.0).abs() < 0.1,
            "{law:?}"
        );
        let law = TimeLaw::of(&[[4.0, 8.0], [4.0, 8.0]]).expect("two");
        assert_eq!(
            law,
            TimeLaw {
                start: 0.0,
                sample: 2.0
            }
        );
        assert_eq!(TimeLaw::of(&[]), None);
    }

    #[test]
    fn fitted_slopes_are_unbiased_with_nominal_coverage() {
        let mut dealer = Dealer::new(1);
        for b in [1.0, 1.5] {
            let mut held = 0;
            let mut slopes = Moments::default();
            for round in 0..120 {
                let curve = Curve::new(&levels(&mut dealer, b, 0.2), round);
                let slope = curve.slope().expect("seven levels").b;
                slopes.push(slope.value);
                held += u32::from(slope.holds(b));
            }
            let error = slopes.standard_error().expect("many");
            assert!(
                (slopes.mean() - b).abs() < 5.0 * error && error < 0.002,
                "{slopes:?}"
            );
            // 95 of 100 are expected; the lower limit is four standard deviations below, for 120 trials.
            assert!((104..=120).contains(&held), "{held}");
        }
    }

    #[test]
    fn level_intervals_of_few_renders_have_nominal_coverage() {
        let mut dealer = Dealer::new(3);
        let held = (0..200).filter(|&round| {
            let mut levels = levels(&mut dealer, 1.0, 0.05);
            levels[6].errors.truncate(4);
            let (_, mean) = Curve::new(&levels, round).levels()[6];
            mean.holds(1.0 / 64.0)
        });
        // 190 are expected, with a standard deviation of 3.1; without Student's quantile 170.
        let held = held.count();
        assert!((179..=200).contains(&held), "{held}");
    }

    #[test]
    fn lack_of_fit_detects_nonlinear_error_curves() {
        let mut dealer = Dealer::new(2);
        let p = |curve: &Curve| curve.slope().expect("levels").lack_of_fit.expect("several");
        let straight = Curve::new(&levels(&mut dealer, 1.0, 0.1), 0);
        let mut bent = levels(&mut dealer, 1.0, 0.1);
        for level in &mut bent {
            level.errors.iter_mut().for_each(|error| *error += 0.02);
        }
        let bent = Curve::new(&bent, 0);
        assert!(
            p(&straight) > 1e-3 && p(&bent) < 1e-6,
            "{} {}",
            p(&straight),
            p(&bent)
        );
        assert!(!bent.slope().expect("levels").b.holds(1.0));
    }

    #[test]
    fn error_crossings_interpolate_between_levels_in_log_log() {
        let level = |spp: f64, mean: f64| ErrorLevel {
            spp,
            errors: vec![mean * 0.9, mean, mean * 1.1],
        };
        let curve = Curve::new(&[level(1.0, 1e-1), level(4.0, 1e-2), level(16.0, 4e-3)], 1);
        let crossing = |curve: &Curve, rel_mse| curve.crossing(&curve.means, rel_mse);
        // Half way on logarithmic axes.
        assert!((crossing(&curve, 10_f64.powf(-1.5)) - 2.0).abs() < 1e-9);
        assert_eq!(crossing(&curve, 1e-3), f64::INFINITY);
        assert_eq!(crossing(&curve, 0.5), 0.0);
        // The last crossing counts: an error that rises again was low by chance.
        let rises = Curve::new(&[level(1.0, 1e-1), level(4.0, 1e-3), level(16.0, 4e-3)], 1);
        assert_eq!(crossing(&rises, 2e-3), f64::INFINITY);
    }
}
