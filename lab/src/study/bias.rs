//! The bias of a variant, from its renders and two references.
//!
//! Measure: relMSE and its root; relative brightness; stated at each field.
//! Range: levels of at least two renders each.
//! Source: docs/accuracy.md, "The study". Tested below, in `lab/tests/reports/study.rs` and
//! `gram.rs`.

use super::gram::Estimate;
use super::report::LevelReport;
use crate::verdict::ROUNDING;
use etendue::internals::math::stats::{Moments, student_p_value};
use serde::Serialize;

/// The p-value below which a bias is found.
const SIGNIFICANT: f64 = 1e-3;

/// Number of levels for the estimate of the squared bias: the last ones, with the least noise.
const BIAS_LEVELS: usize = 3;

/// The bias of a variant relative to the references.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Bias {
    /// The squared bias, relative, of the last levels together.
    pub squared: Estimate,
    /// The p-value of the bias, in the squares or in the light of the whole image.
    pub p: f64,
    /// Whether the p-value is significant.
    pub is_found: bool,
    /// Whether the squares alone are significant, so that the size of the bias is known; else it is found in the light.
    pub is_square_found: bool,
    /// An upper limit of the root of the squared bias, with a confidence of 95 %.
    pub at_most: f64,
    /// Mean luminance over that of the references - 1, and its margin with a confidence of 95 %.
    pub light: [f64; 2],
}

impl Bias {
    /// Estimates the bias. The squared bias does not depend on the number of samples, but its noise does: levels with less
    /// noise have more weight.
    pub fn of(levels: &[LevelReport], reference: [f64; 2], shared: f64) -> Option<Self> {
        let used = levels.iter().rev().take(BIAS_LEVELS);
        let weight = |level: &LevelReport| {
            let (n, spp) = (level.runs.len() as f64, level.spp as f64);
            n * (n - 1.0) * spp * spp
        };
        let total: f64 = used.clone().map(weight).sum();
        let parts = used.map(|level| Some((weight(level) / total, level.gram.squared_bias()?)));
        let mut squared = Estimate::sum(&parts.collect::<Option<Vec<_>>>()?);
        squared.standard_error = squared.standard_error.hypot(shared);
        let light = light(levels, reference)?;
        // Rounding makes the light of a scene without noise differ in the last digits.
        let beyond_rounding = (light.value.abs() - ROUNDING).max(0.0);
        let t = beyond_rounding / light.standard_error;
        let of_light = match t.is_nan() {
            true => 1.0,
            false => student_p_value(t, light.freedom),
        };
        let beyond_rounding = Estimate {
            value: squared.value - ROUNDING * ROUNDING,
            ..squared
        };
        let of_square = beyond_rounding.p_above_zero();
        // Bonferroni correction: either of two tests may find it.
        let p = (2.0 * of_square.min(of_light)).min(1.0);
        Some(Self {
            squared,
            p,
            is_found: p < SIGNIFICANT,
            is_square_found: 2.0 * of_square < SIGNIFICANT,
            // One-sided: the margin of 90 % has 5 % above it.
            at_most: (squared.value.max(0.0) + squared.margin(0.90)).sqrt(),
            light: [light.value, light.margin(0.95)],
        })
    }
}

/// The relative difference in brightness between the last levels, weighted by their samples, and the references.
fn light(levels: &[LevelReport], [reference, reference_error]: [f64; 2]) -> Option<Estimate> {
    let used = levels.iter().rev().take(BIAS_LEVELS);
    let weight = |level: &LevelReport| (level.runs.len() as u64 * level.spp) as f64;
    let total: f64 = used.clone().map(weight).sum();
    let part = |level: &LevelReport| {
        let light = Moments::of(level.runs.iter().map(|run| run.luminance));
        let estimate = Estimate {
            value: light.mean() / reference - 1.0,
            standard_error: light.standard_error()? / reference,
            freedom: light.count() as f64 - 1.0,
        };
        Some((weight(level) / total, estimate))
    };
    let mut light = Estimate::sum(&used.map(part).collect::<Option<Vec<_>>>()?);
    light.standard_error = light.standard_error.hypot(reference_error / reference);
    // If the renders have no noise, that of the references remains.
    light.freedom = if light.freedom > 0.0 {
        light.freedom
    } else {
        1.0
    };
    Some(light)
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::{self, SyntheticRender};
    use super::*;

    /// The bias of levels without noise, whose light is off by this much.
    fn bias(off: f64) -> Bias {
        let render = SyntheticRender {
            rel_mse: 0.0,
            product: 0.0,
            seconds: 0.0,
            luminance: 0.5 * (1.0 + off),
        };
        let level = |spp: u64| synthetic::level(spp, |_| render);
        Bias::of(&[1, 2, 4].map(level), [0.5, 0.0], 0.0).expect("four renders each")
    }

    #[test]
    fn rounding_of_noise_free_light_is_no_bias() {
        for off in [0.0, 1e-7, -3e-6] {
            assert!(!bias(off).is_found, "{off}: {:?}", bias(off));
        }
        for off in [1e-4, -1e-4] {
            assert!(bias(off).is_found, "{off}: {:?}", bias(off));
        }
    }
}
