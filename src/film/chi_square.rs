//! Moments of standard deviations whose squares have a chi-square or a scaled inverse chi-square distribution, which
//! `error_bars.rs` fits to those of pixels.
//!
//! Measure: ratios of moments, without unit.
//! Range: degrees of freedom above 0, and from 2.05 to 10,000 for the inverse distribution; ratios beyond its table give
//! its ends.
//! Source: the moments of both distributions. Tested below.

use crate::math::functions::{exp, powf};
use statrs::function::gamma::ln_gamma;
use std::sync::LazyLock;

/// The mean of sqrt(X / d), with X chi-square distributed with d degrees of freedom.
pub fn mean_root_of_chi_square(freedom: f32) -> f32 {
    let d = f64::from(freedom);
    let ratio = ln_gamma(0.5 * (d + 1.0)) - ln_gamma(0.5 * d);
    ((2.0 / d).sqrt() * exp(ratio)) as f32
}

/// A table of E(sigma)^2 / E(sigma^2) for variances sigma^2 from a scaled inverse chi-square distribution, by degrees
/// of freedom.
pub struct InverseChiSquare {
    /// Pairs of degrees of freedom and ratio, both increasing.
    table: Vec<[f32; 2]>,
}

/// The table, computed when it is first needed.
pub static INVERSE_CHI_SQUARE: LazyLock<InverseChiSquare> = LazyLock::new(InverseChiSquare::new);

impl InverseChiSquare {
    /// Builds the table for degrees of freedom from 2.05 to 10,000.
    fn new() -> Self {
        const STEPS: u32 = 256;
        let (min, max) = (0.05_f64, 1e4_f64);
        let table = (0..=STEPS).map(|step| {
            let d = 2.0 + min * powf(max / min, f64::from(step) / f64::from(STEPS));
            [d as f32, Self::ratio(d) as f32]
        });
        Self {
            table: table.collect(),
        }
    }

    /// The ratio for d degrees of freedom, (d - 2) / 2 (Gamma((d - 1) / 2) / Gamma(d / 2))^2.
    fn ratio(d: f64) -> f64 {
        let roots = ln_gamma(0.5 * (d - 1.0)) - ln_gamma(0.5 * d);
        0.5 * (d - 2.0) * exp(2.0 * roots)
    }

    /// Returns the degrees of freedom with this ratio, linearly interpolated.
    pub fn freedom(&self, ratio: f32) -> f32 {
        let above = self.table.partition_point(|entry| entry[1] < ratio);
        if above == 0 {
            return self.table[0][0];
        }
        let Some(&[d1, r1]) = self.table.get(above) else {
            return self.table[above - 1][0];
        };
        let [d0, r0] = self.table[above - 1];
        d0 + (d1 - d0) * (ratio - r0) / (r1 - r0).max(f32::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_of_freedom_are_recovered_from_the_moment_ratio() {
        for d in [2.1, 3.0, 4.0, 10.0, 200.0] {
            let back = f64::from(INVERSE_CHI_SQUARE.freedom(InverseChiSquare::ratio(d) as f32));
            assert!((back / d - 1.0).abs() < 0.01, "{d}: {back}");
        }
        // Gamma(1) / Gamma(3/2) squared, times a half; and the mean of |x| of a normal number.
        let four_over_pi = 4.0 / std::f64::consts::PI;
        assert!((InverseChiSquare::ratio(3.0) - 0.5 * four_over_pi).abs() < 1e-9);
        let normal = f64::from(mean_root_of_chi_square(1.0));
        assert!((normal - (2.0 / std::f64::consts::PI).sqrt()).abs() < 1e-6);
        let [min, max] = [0.0, 2.0].map(|ratio| INVERSE_CHI_SQUARE.freedom(ratio));
        assert!((min - 2.05).abs() < 1e-4 && (max / 1e4 - 1.0).abs() < 1e-3);
    }
}
