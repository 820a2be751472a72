//! The power function p(x) = (n + 1) x^n on [0, 1], sampled in two ways: by inversion, and as the maximum of n + 1
//! numbers.
//!
//! Measure: densities per unit of x.
//! Range: n from 0; u in [0, 1). Both maps use 1 - u, which is as uniform as u and never 0, so that no sample has
//! density 0. Outside [0, 1] the density is 0.
//! Source: inversion of P(x) = x^(n + 1); and P(max <= x) = x^(n + 1) for the maximum of n + 1 independent numbers,
//! each at most x with probability x. Tested in `lab/tests/course/inversion.rs`.

/// Samples by inversion: x = (1 - u)^(1 / (n + 1)).
pub fn sample_power(u: f64, n: f64) -> f64 {
    (1.0 - u).powf(1.0 / (n + 1.0))
}

/// Samples as the maximum of n + 1 uniform numbers, each taken as 1 - u. There is no inverse: many u lead to the same
/// x.
///
/// `None` if there are no numbers.
pub fn sample_power_as_maximum(u: impl IntoIterator<Item = f64>) -> Option<f64> {
    u.into_iter().map(|u| 1.0 - u).reduce(f64::max)
}

/// The density of [`sample_power`], and for an integer n of [`sample_power_as_maximum`].
pub fn pdf_power(x: f64, n: f64) -> f64 {
    if (0.0..=1.0).contains(&x) {
        (n + 1.0) * x.powf(n)
    } else {
        0.0
    }
}

/// The u that [`sample_power`] maps to `x`: 1 - x^(n + 1), without cancellation near x = 1.
pub fn invert_power(x: f64, n: f64) -> f64 {
    -((n + 1.0) * x.ln()).exp_m1()
}
