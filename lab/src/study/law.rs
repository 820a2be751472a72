//! The law by which an error falls with the samples, and the samples that an error needs: between two levels where it was
//! reached, beyond them by the law.
//!
//! log MSE = a - b log N is fitted to the last levels that follow it. b is 1 where its interval holds 1.
//!
//! Measure: samples per pixel, relMSE.
//! Range: at least three levels. No law is fitted where even the last three levels do not follow one, or where the error
//! falls more slowly than b = 1/2.
//! Source: docs/accuracy.md, "The study". Tested below.

use super::bootstrap::Ranged;
use super::fit::Curve;
use serde::Serialize;

/// The p-value of the lack-of-fit test below which levels do not follow a law.
const NO_FIT: f64 = 1e-3;

/// The minimum number of levels of a law.
const LEVELS: usize = 3;

/// The least exponent: an error that falls more slowly hides rare bright paths, or a bias.
const MIN_EXPONENT: f64 = 0.5;

/// The law MSE = e^a N^-b.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Law {
    /// The logarithm of the squared error of one sample.
    pub a: f64,
    /// The exponent that is used.
    pub b: f64,
    /// The fitted exponent.
    pub fitted: Ranged,
    /// The first level that it is fitted to, of those from few samples to many.
    pub first: usize,
}

/// The reason why there is no law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoLaw {
    /// Too few levels.
    FewLevels,
    /// The error does not fall as a power of the samples.
    NoFit,
    /// The error falls too slowly.
    Slow,
}

impl NoLaw {
    /// The reason in words.
    pub fn why(self) -> &'static str {
        match self {
            Self::FewLevels => {
                "fewer than three sample counts were rendered: give a larger --budget"
            }
            Self::NoFit => {
                "the error does not fall as a power of the time yet: give a larger --budget"
            }
            Self::Slow => {
                "the error falls more slowly than noise does: rare bright paths, or a bias too small to find"
            }
        }
    }
}

impl Law {
    /// The squared error after `spp` samples per pixel.
    pub fn at(&self, spp: f64) -> f64 {
        (self.a - self.b * spp.ln()).exp()
    }

    fn samples_for(&self, rel_mse: f64) -> f64 {
        ((self.a - rel_mse.ln()) / self.b).exp()
    }
}

impl Curve {
    /// The law of the last levels.
    ///
    /// # Errors
    /// The reason why no law fits.
    pub fn law(&self) -> Result<Law, NoLaw> {
        let last = self.len().checked_sub(LEVELS).ok_or(NoLaw::FewLevels)?;
        let fits = |&first: &usize| {
            let line = self.line(&self.means, first)?;
            // Without noise within the levels there is no test.
            let p = self.lack_of_fit(line, first).unwrap_or(1.0);
            (p >= NO_FIT).then_some(first)
        };
        let first = (0..=last)
            .find_map(|first| fits(&first))
            .ok_or(NoLaw::NoFit)?;
        let [a, b] = self.line(&self.means, first).ok_or(NoLaw::NoFit)?;
        let slopes = self.replicas.iter();
        let slopes = slopes.filter_map(|means| self.line(means, first).map(|[_, b]| b));
        let fitted = Ranged::of(b, slopes);
        if fitted.holds(1.0) {
            let a = self.intercept(&self.means, first, 1.0);
            return Ok(Law {
                a,
                b: 1.0,
                fitted,
                first,
            });
        }
        if b < MIN_EXPONENT {
            return Err(NoLaw::Slow);
        }
        Ok(Law {
            a,
            b,
            fitted,
            first,
        })
    }

    /// The samples after which the error is `rel_mse`, by a law.
    pub fn beyond(&self, law: &Law, rel_mse: f64) -> Ranged {
        let value = law.samples_for(rel_mse);
        let replicas = self.replicas.iter().map(|means| {
            self.law_of(means, law)
                .map_or(f64::NAN, |law| law.samples_for(rel_mse))
        });
        let range = self.widened(Ranged::of(value, replicas), &self.shares(law.first));
        if law.b == 1.0 {
            return range;
        }
        // A slope that is not that of independent samples need not stay so: one end of the interval has it.
        let independent = self.spp[self.len() - 1] * law.at(self.spp[self.len() - 1]) / rel_mse;
        Ranged {
            low: range.low.min(independent),
            high: range.high.max(independent),
            ..range
        }
    }

    /// The samples after which the error is `rel_mse` if it was reached: the last crossing between two levels. Where
    /// replicas have not reached it, the law, if there is one, completes the interval.
    pub fn between(&self, law: Option<&Law>, rel_mse: f64) -> Option<Ranged> {
        let value = self.crossing(&self.means, rel_mse);
        let replicas = self.replicas.iter().map(|means| {
            let measured = self.crossing(means, rel_mse);
            match law.filter(|_| measured.is_infinite()) {
                Some(law) => self
                    .law_of(means, law)
                    .map_or(measured, |law| law.samples_for(rel_mse)),
                None => measured,
            }
        });
        if !value.is_finite() {
            return None;
        }
        let range = Ranged::of(value, replicas);
        let above = self.means.iter().rposition(|&mean| mean >= rel_mse);
        Some(above.map_or(range, |above| {
            let [from, to] = [above, above + 1].map(|level| self.spp[level].ln());
            let share = ((value.ln() - from) / (to - from)).clamp(0.0, 1.0);
            self.widened(range, &[(above, 1.0 - share), (above + 1, share)])
        }))
    }

    /// The law of a replica, fitted as `law` is.
    fn law_of(&self, means: &[f64], law: &Law) -> Option<Law> {
        if law.b == 1.0 {
            let a = self.intercept(means, law.first, 1.0);
            return a.is_finite().then_some(Law { a, ..*law });
        }
        let [a, b] = self.line(means, law.first)?;
        Some(Law {
            a,
            b: b.max(0.5 * MIN_EXPONENT),
            ..*law
        })
    }

    /// The intercept of a line of this slope.
    fn intercept(&self, means: &[f64], first: usize, b: f64) -> f64 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for index in (first..self.len()).filter(|&index| means[index] > 0.0) {
            let weight = self.groups[index].len() as f64;
            sum += weight * (means[index].ln() + b * self.spp[index].ln());
            weights += weight;
        }
        sum / weights
    }
}

#[cfg(test)]
mod tests {
    use super::super::fit::ErrorLevel;
    use super::*;
    use crate::study::bootstrap::Dealer;
    use etendue::internals::math::stats::normal_quantile;

    /// Levels of 2^0 to 2^8 samples, fewer seeds for the longer ones.
    fn curve(dealer: &mut Dealer, error: impl Fn(f64) -> f64, spread: f64) -> Curve {
        let seeds = [16, 16, 16, 12, 8, 6, 4, 4, 4];
        let mut normal =
            || normal_quantile((dealer.below(1 << 40) as f64 + 0.5) / (1_u64 << 40) as f64);
        let levels = (0..).zip(seeds).map(|(power, seeds)| {
            let spp = f64::from(power).exp2();
            let errors = (0..seeds).map(|_| error(spp) * (1.0 + spread * normal()));
            ErrorLevel {
                spp,
                errors: errors.collect(),
            }
        });
        let levels: Vec<ErrorLevel> = levels.collect();
        Curve::new(&levels, 7)
    }

    #[test]
    fn inverse_law_extrapolation_is_accurate_and_covers_truth() {
        let mut dealer = Dealer::new(1);
        let mut held = 0;
        for _ in 0..60 {
            let curve = curve(&mut dealer, |n| 0.5 / n, 0.1);
            let law = curve.law().expect("it fits");
            if law.b != 1.0 {
                continue;
            }
            let samples = curve.beyond(&law, 1e-5);
            assert!((samples.value / 5e4 - 1.0).abs() < 0.1, "{samples:?}");
            held += u32::from(samples.holds(5e4));
        }
        // The interval of the slope holds 1 in about 95 %, that of the samples the truth in about 95 % of these.
        assert!((46..=60).contains(&held), "{held}");
    }

    #[test]
    fn steeper_law_is_used_with_a_conservative_upper_bound() {
        let curve = curve(&mut Dealer::new(2), |n| n.powf(-1.5), 0.05);
        let law = curve.law().expect("it fits");
        assert!((law.b - 1.5).abs() < 0.05, "{law:?}");
        let samples = curve.beyond(&law, 1e-6);
        // By the law 10^4 samples; by independent ones from the last level on, 256 * 256^-1.5 / 10^-6 = 62 500.
        assert!((samples.value / 1e4 - 1.0).abs() < 0.2, "{samples:?}");
        assert!(samples.holds(1e4) && samples.high > 5e4, "{samples:?}");
    }

    #[test]
    fn initial_levels_off_the_law_are_excluded_from_the_fit() {
        let bent = |n: f64| 0.5 / n + 0.3 * (-n).exp();
        let curve = curve(&mut Dealer::new(3), bent, 0.02);
        let law = curve.law().expect("the later levels fit");
        assert!(law.first >= 2 && law.b == 1.0, "{law:?}");
        let samples = curve.beyond(&law, 1e-4);
        assert!((samples.value / 5e3 - 1.0).abs() < 0.05, "{samples:?}");
    }

    #[test]
    fn slow_convergence_and_few_levels_give_no_law() {
        let slow = curve(&mut Dealer::new(4), |n| n.powf(-0.3), 0.02);
        assert_eq!(slow.law(), Err(NoLaw::Slow));
        let level = |spp: f64| ErrorLevel {
            spp,
            errors: vec![1.0 / spp, 1.1 / spp],
        };
        assert_eq!(
            Curve::new(&[level(1.0), level(2.0)], 0).law(),
            Err(NoLaw::FewLevels)
        );
    }

    #[test]
    fn measured_samples_of_few_renders_have_nominal_coverage() {
        let mut dealer = Dealer::new(7);
        let held = (0..200).filter(|_| {
            let curve = curve(&mut dealer, |n| 0.5 / n, 0.05);
            // At a level of four renders.
            let samples = curve.between(None, 0.5 / 128.0);
            samples.is_some_and(|samples| samples.holds(128.0))
        });
        // 188 are expected, with a standard deviation of 3.4; without Student's quantile 166.
        let held = held.count();
        assert!((178..=200).contains(&held), "{held}");
    }

    #[test]
    fn reached_errors_are_measured_with_a_finite_interval() {
        let curve = curve(&mut Dealer::new(5), |n| 0.5 / n, 0.2);
        let law = curve.law().expect("it fits");
        // Just before the last level: some replicas reach it only beyond.
        let samples = curve
            .between(Some(&law), 0.5 / 250.0)
            .or_else(|| curve.between(Some(&law), 0.5 / 200.0));
        let samples = samples.expect("one of them was reached");
        assert!(
            samples.high.is_finite() && samples.holds(samples.value),
            "{samples:?}"
        );
        assert_eq!(curve.between(Some(&law), 1e-5), None);
        assert_eq!(curve.between(None, 10.0).expect("at once").value, 0.0);
    }
}
