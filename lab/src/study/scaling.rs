//! The time on another number of processors, by the measured gain from one thread to all of this machine.
//!
//! With a share s of the time that is not divided among threads, p of them take t(p) = t(1) (s + (1 - s) / p).
//!
//! Measure: shares of the time of one thread; the predicted time over that of this machine, without unit.
//! Range: machines of two threads or more, with processors like this one's; memory that limits many threads is not
//! included. The interval of s has a confidence of 95 %; s is in [0, 1].
//! Source: Amdahl 1967. Tested below.

use super::bootstrap::Ranged;
use etendue::internals::math::stats::{Moments, student_quantile_of};
use serde::Serialize;

/// The time on another number of threads.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Scaling {
    /// Number of threads that were measured, besides one.
    pub measured: usize,
    /// Number of threads for which times are predicted.
    pub threads: usize,
    /// The share of the time that is not divided among threads.
    pub serial: Ranged,
    /// The time with `threads` over that with `measured` threads.
    pub factor: Ranged,
}

impl Scaling {
    /// The prediction from the times of `measured` threads over those of one.
    pub fn of(measured: usize, threads: usize, ratios: &[f64]) -> Option<Self> {
        let n = 1.0 / measured as f64;
        let serial = Moments::of(ratios.iter().map(|ratio| (ratio - n) / (1.0 - n)));
        let error = serial.standard_error()?;
        let margin = student_quantile_of(serial.count() as f64 - 1.0, 0.975) * error;
        let [value, low, high] =
            [0.0, -1.0, 1.0].map(|side| (serial.mean() + side * margin).clamp(0.0, 1.0));
        let serial = Ranged { value, low, high };
        let time = |s: f64, p: f64| s + (1.0 - s) / p;
        let factor = |s: f64| time(s, threads as f64) / time(s, measured as f64);
        let [at_low, at_high] = [factor(low), factor(high)];
        Some(Self {
            measured,
            threads,
            serial,
            factor: Ranged {
                value: factor(value),
                low: at_low.min(at_high),
                high: at_low.max(at_high),
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn predicted_times_follow_amdahls_law() {
        // A tenth of the time is serial: two threads take 0.55 of the time of one, 64 take 0.1140625.
        let ratios = [0.54, 0.55, 0.56, 0.55];
        let scaling = Scaling::of(2, 64, &ratios).expect("several");
        assert!((scaling.serial.value - 0.1).abs() < 1e-12);
        assert!((scaling.factor.value - 0.114_062_5 / 0.55).abs() < 1e-12);
        assert!(scaling.factor.low < scaling.factor.value);
        assert!(scaling.factor.high > scaling.factor.value);
    }

    #[test]
    fn perfect_scaling_gives_zero_serial_fraction() {
        let scaling = Scaling::of(2, 64, &[0.49, 0.5, 0.49, 0.5]).expect("several");
        assert_eq!((scaling.serial.value, scaling.serial.low), (0.0, 0.0));
        assert!(
            (scaling.factor.low - 2.0 / 64.0).abs() < 1e-12,
            "{scaling:?}"
        );
        assert_eq!(Scaling::of(2, 64, &[0.5]), None);
    }
}
