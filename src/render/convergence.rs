//! Convergence: how the error of a render falls with its samples, by records of it during the render, and the samples
//! that a smaller error needs.
//!
//! The root of relMSE falls as a power of the samples, 1/2 for independent ones and more where points are evenly
//! distributed. Two records far enough apart determine the power. Between two powers of two of samples, the error of
//! Sobol' points falls only as that of independent samples from the first: the gain comes at the second.
//!
//! Measure: roots of relMSE; samples per pixel, where they differ the evenly distributed ones that they are equivalent to.
//! Range: powers from 1/2 to 3/2. Without two records, or where they do not distinguish it from 1/2, the power is 1/2.
//! Source: docs/accuracy.md, "The error that is printed". Tested below and in `cli/tests/command/layers.rs`.

use crate::film::{Allowances, Doubt, ErrorEstimate};
use crate::math::functions::{hypot, ln, log2, powf};
use serde::{Deserialize, Serialize};

/// The least ratio of the samples of two records that determine the power: nearer ones differ by their noise.
const MIN_RECORD_RATIO: f64 = 4.0;

/// The least samples per pixel of a record that determines the power: with fewer, the estimate of the error is biased too
/// much.
pub const MIN_RECORD_SAMPLES: u64 = 16;

/// The smallest power: an error falls at least as the root of the samples does.
const MIN_POWER: f64 = 0.5;
/// The largest power: an error hardly falls faster than this power of the samples.
const MAX_POWER: f64 = 1.5;

/// The number of standard errors from which a difference is significant.
const SIGMAS: f64 = 2.0;

/// The number of standard errors for the alarm that an error rises, which keeps the render from ending.
const RISE_SIGMAS: f64 = 3.0;

/// An estimate of a render's error after a number of samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorRecord {
    /// Samples per pixel.
    pub samples: f64,
    /// The root of relMSE.
    pub rel_rmse: f64,
    /// The relative standard error of the squared error.
    pub uncertainty: f64,
    /// The bias that the noise of the denominators may have left in the squared error, over the squared error.
    pub bias: f64,
    /// The largest term that a single sample may have in the squared error, over the squared error.
    pub largest_sample: f64,
    /// The largest term of a pixel, with those that share its samples, in the squared error, over the squared error. States of
    /// earlier versions lack it; a forecast from them is lower until the next estimate.
    #[serde(default)]
    pub largest_pixel: f64,
}

impl ErrorRecord {
    /// The record after `samples` samples per pixel.
    pub fn new(samples: f64, error: &ErrorEstimate) -> Self {
        Self {
            samples,
            rel_rmse: error.rel_rmse,
            uncertainty: error.uncertainty,
            bias: error.bias,
            largest_sample: error.largest_sample,
            largest_pixel: error.largest_pixel,
        }
    }

    /// The squared error of one sample per pixel, if samples are independent.
    fn of_sample(&self) -> f64 {
        self.samples * self.rel_rmse * self.rel_rmse
    }

    /// Whether the error of a later record is at most as large as independent samples make it, within the uncertainty of
    /// both records.
    pub fn is_consistent_with(&self, later: &Self) -> bool {
        let chance = RISE_SIGMAS * hypot(self.uncertainty, later.uncertainty);
        later.of_sample() <= self.of_sample() * (1.0 + chance)
    }
}

/// Returns an estimated error, without an upper bound if it is larger than the earlier estimates allow.
pub fn without_bound_if_rising(
    error: ErrorEstimate,
    samples: f64,
    error_records: &[ErrorRecord],
) -> ErrorEstimate {
    let now = ErrorRecord::new(samples, &error);
    let before = error_records
        .iter()
        .rfind(|record| 2.0 * record.samples <= samples);
    match before {
        Some(before) if error.doubt.is_none() && !before.is_consistent_with(&now) => {
            ErrorEstimate {
                upper_bound: f64::INFINITY,
                doubt: Some(Doubt::Rising {
                    at_least: error.rel_rmse * (1.0 - SIGMAS * error.uncertainty).max(0.0).sqrt(),
                    samples: before.samples,
                    rel_rmse: before.rel_rmse,
                }),
                ..error
            }
        }
        _ => error,
    }
}

/// The power of the samples with which the error falls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerLaw {
    /// The likely power.
    pub power: f64,
    /// The least and the greatest power that the records allow.
    pub range: [f64; 2],
}

impl PowerLaw {
    /// The power law from the last record and the latest that is far enough before it.
    pub fn of(error_records: &[ErrorRecord]) -> Self {
        let measured = error_records.split_last().and_then(|(last, before)| {
            let mut reliable = before
                .iter()
                .filter(|record| record.samples >= MIN_RECORD_SAMPLES as f64);
            let first =
                reliable.rfind(|record| MIN_RECORD_RATIO * record.samples <= last.samples)?;
            let steps = ln(last.samples / first.samples);
            let power = ln(first.rel_rmse / last.rel_rmse) / steps;
            let error = 0.5 * hypot(first.uncertainty, last.uncertainty) / steps;
            (power + error).is_finite().then_some((power, error))
        });
        let (power, error) = measured.unwrap_or((MIN_POWER, 0.0));
        let range = [power - SIGMAS * error, power + SIGMAS * error];
        let within = |power: f64| power.clamp(MIN_POWER, MAX_POWER);
        Self {
            // A power that is not distinguishable from the smallest is the smallest.
            power: match range[0] <= MIN_POWER {
                true => MIN_POWER,
                false => within(power),
            },
            range: range.map(within),
        }
    }

    /// The factors by which the samples grow until the error has fallen by `factor`, at the likely power and at both
    /// ends of its range.
    pub fn samples_for(&self, factor: f64) -> [f64; 3] {
        let [slow, fast] = self.range;
        [fast, self.power, slow].map(|power| powf(factor, 1.0 / power))
    }
}

/// The forecast of an upper bound that holds an error with some confidence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forecast {
    error_record: ErrorRecord,
    power: f64,
    /// Whether the error falls in steps, at powers of two of the samples.
    in_steps: bool,
    /// The confidence of the bound.
    confidence: f64,
    /// The relative standard error that remains even with normally distributed samples.
    least_uncertainty: f64,
}

impl Forecast {
    /// The forecast from the records so far, for an image of `pixels` pixels. `None` before the first record.
    pub fn new(
        error_records: &[ErrorRecord],
        pixels: u64,
        confidence: f64,
        in_steps: bool,
    ) -> Option<Self> {
        /// The rule for normally distributed samples, with variances that differ between pixels as they do in a room.
        const OF_PIXELS: f64 = 8.0;
        Some(Self {
            error_record: *error_records.last()?,
            power: PowerLaw::of(error_records).power,
            in_steps,
            confidence,
            least_uncertainty: (OF_PIXELS / pixels as f64).sqrt(),
        })
    }

    /// The bound after `samples` samples per pixel, at least as many as at the last record.
    fn bound(&self, samples: f64) -> f64 {
        let record = self.error_record;
        let grown = samples / record.samples;
        // The uncertainty due to rare samples falls as that of any mean.
        let least = self.least_uncertainty.min(record.uncertainty);
        // A sample's term falls as N^-2, the bias at least as fast, the squared error as N^-1.
        let allowances = Allowances {
            uncertainty: (record.uncertainty / grown.sqrt()).max(least),
            bias: record.bias / grown,
            largest_sample: record.largest_sample / grown,
            largest_pixel: record.largest_pixel,
        };
        self.error(samples)
            * allowances
                .relative_bound(self.confidence, f64::INFINITY)
                .sqrt()
    }

    /// The root of relMSE after `samples` samples.
    fn error(&self, samples: f64) -> f64 {
        let ErrorRecord {
            samples: now,
            rel_rmse,
            ..
        } = self.error_record;
        let floor = |samples: f64| powf(2.0, log2(samples).floor());
        if self.in_steps && floor(samples) > now {
            // By the power law from one power of two to another, and from there as independent samples.
            let step = floor(samples);
            let at_step = rel_rmse * powf(step / now, -self.power);
            at_step * powf(samples / step, -MIN_POWER)
        } else if self.in_steps {
            rel_rmse * powf(samples / now, -MIN_POWER)
        } else {
            rel_rmse * powf(samples / now, -self.power)
        }
    }

    /// The samples per pixel after which the bound is at most `bound`.
    pub fn samples_for(&self, bound: f64) -> f64 {
        let is_reached = |samples: f64| self.bound(samples) <= bound;
        let mut high = self.error_record.samples;
        while !is_reached(high) && high < u64::MAX as f64 {
            high *= 2.0;
        }
        let mut low = 0.5 * high;
        if low < self.error_record.samples {
            return high;
        }
        /// The number of bisections that leave a thousandth.
        const HALVINGS: u32 = 10;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if is_reached(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn convergence_power_is_fitted_or_falls_back_to_one_half() {
        let error_records =
            [64.0, 128.0, 256.0, 1024.0].map(|n: f64| error_record(n, n.powf(-0.75), 0.01));
        let law = PowerLaw::of(&error_records);
        assert!((law.power - 0.75).abs() < 1e-12, "{law:?}");
        assert!(law.range[0] > 0.73 && law.range[1] < 0.77, "{law:?}");
        // Ten times less error takes 10^(4/3) times as many samples.
        let [_, likely, _] = law.samples_for(10.0);
        assert!((likely / 21.544 - 1.0).abs() < 1e-3, "{likely}");
        let noisy = error_records.map(|it| error_record(it.samples, it.rel_rmse, 0.6));
        let law = PowerLaw::of(&noisy);
        assert_eq!((law.power, law.range[0]), (0.5, 0.5));
        assert!(law.range[1] > 0.75);
        assert_eq!(PowerLaw::of(&error_records[..2]).power, 0.5);
        assert_eq!(PowerLaw::of(&[]).range, [0.5, 0.5]);
    }

    #[test]
    fn stalled_error_has_an_infinite_upper_bound() {
        let error = |rel_rmse, uncertainty| ErrorEstimate {
            rel_rmse,
            uncertainty,
            bias: 0.0,
            largest_sample: 0.0,
            largest_pixel: 0.0,
            confidence: 0.95,
            upper_bound: 1.1 * rel_rmse,
            doubt: None,
        };
        let error_records = [error_record(64.0, 0.1, 0.1), error_record(256.0, 0.05, 0.1)];
        let fallen = without_bound_if_rising(error(0.025, 0.1), 1024.0, &error_records);
        assert_eq!(fallen, error(0.025, 0.1));
        let risen = without_bound_if_rising(error(0.05, 0.1), 1024.0, &error_records);
        assert!(risen.upper_bound.is_infinite());
        let Some(Doubt::Rising {
            at_least, samples, ..
        }) = risen.doubt
        else {
            panic!("{risen:?}");
        };
        assert!(samples == 256.0 && at_least < 0.05 && at_least > 0.04);
        // An uncertain difference may be chance; records that are too near say nothing.
        assert_eq!(
            without_bound_if_rising(error(0.05, 1.5), 1024.0, &error_records).doubt,
            None
        );
        assert_eq!(
            without_bound_if_rising(error(0.05, 0.1), 300.0, &error_records[1..]).doubt,
            None
        );
    }

    #[test]
    fn stepwise_forecast_matches_smooth_one_at_powers_of_two() {
        let error_records = [error_record(16.0, 1.0, 0.0), error_record(64.0, 0.25, 0.0)];
        let steps = Forecast::new(&error_records, 1 << 40, 0.5, true).expect("there are records");
        let smooth = Forecast::new(&error_records, 1 << 40, 0.5, false).expect("there are records");
        assert!((smooth.error(100.0) - 0.16).abs() < 1e-9);
        // At powers of two the errors agree, between them one falls as with independent samples.
        for n in [128.0, 256.0, 1024.0] {
            assert!((steps.error(n) - smooth.error(n)).abs() < 1e-12);
        }
        assert!((steps.error(192.0) - 0.125 / 1.5_f64.sqrt()).abs() < 1e-9);
        for forecast in [steps, smooth] {
            for target in [0.2, 0.05, 0.01] {
                let n = forecast.samples_for(target);
                assert!(forecast.bound(n) <= target && forecast.bound(0.99 * n) > 0.99 * target);
            }
        }
    }

    #[test]
    fn upper_bound_tightens_with_more_samples() {
        let error_records = [error_record(64.0, 0.1, 0.4)];
        let forecast = Forecast::new(&error_records, 8_000_000, 0.95, false).expect("a record");
        let least = Allowances::default().relative_bound(0.95, f64::INFINITY);
        let margin = |n: f64| (forecast.bound(n) / forecast.error(n)).powi(2) - least;
        assert!(margin(64.0) > 0.65 && margin(6400.0) < 0.07);
        // A single bright sample widens the bound, and less as others join it.
        let mut bright = error_records;
        bright[0].largest_sample = 2.0;
        let bright = Forecast::new(&bright, 8_000_000, 0.95, false).expect("a record");
        assert!(bright.bound(64.0) > 1.02 * forecast.bound(64.0));
        assert!(bright.bound(6400.0) < 1.001 * forecast.bound(6400.0));
        // The uncertainty at its least, with few pixels.
        let few = Forecast::new(&error_records, 200, 0.95, false).expect("a record");
        assert!(few.bound(1e9) / few.error(1e9) > 1.16);
    }
}
