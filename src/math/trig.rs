//! Sine, cosine and arc tangent in single precision over the ranges that sampling needs, without a branch.
//!
//! Measure: radians, or turns of 2 pi.
//! Range: as each function states, with a relative error below 3e-7; outside it the polynomials diverge.
//! Source: interpolation of sin(x)/x, cos(x) and atan(x)/x in x^2 at Chebyshev's nodes; angles in turns are reduced
//! exactly to an eighth, which is not possible in radians. Tested below.

use std::f32::consts::FRAC_PI_4;

/// Coefficients of sin(x) / x in powers of x^2.
const SIN: [f32; 4] = [1.0, -0.166_666_5, 0.008_332_036, -0.000_195_039_04];
/// Coefficients of cos(x) in powers of x^2.
const COS: [f32; 5] = [1.0, -0.5, 0.041_666_616, -0.001_388_661_7, 0.000_024_379_83];
/// Coefficients of atan(x) / x in powers of x^2.
const ATAN: [f32; 9] = [
    1.0,
    -0.333_330_36,
    0.199_918_72,
    -0.141_977_98,
    0.106_183_71,
    -0.074_568_55,
    0.042_137_623,
    -0.015_731_25,
    0.002_766_283_5,
];

/// Sine and cosine of an angle from -pi / 4 to pi / 4.
#[inline(always)]
pub fn sin_cos_eighth(x: f32) -> (f32, f32) {
    let x2 = x * x;
    (x * polynomial(&SIN, x2), polynomial(&COS, x2))
}

/// Sine and cosine of `u` turns, 2 pi u; u in [0, 1]. The error is below 2e-7; multiples of a quarter turn are exact.
#[inline]
pub fn sin_cos_turns(u: f32) -> (f32, f32) {
    // The nearest quarter, and the eighths from it, without rounding error.
    let quarter = (4.0 * u + 0.5) as i32;
    let (s, c) = sin_cos_eighth(FRAC_PI_4 * (8.0 * u - 2.0 * quarter as f32));
    let (sin, cos) = if quarter & 1 == 0 { (s, c) } else { (c, s) };
    // In the second half of the turn, counted from where each is 0, the sign changes.
    let signed = |x: f32, quarter: i32| f32::from_bits(x.to_bits() ^ ((quarter as u32 & 2) << 30));
    (signed(sin, quarter), signed(cos, quarter + 1))
}

/// The arc tangent of a number from 0 to 1.
#[inline(always)]
pub fn atan_unit(x: f32) -> f32 {
    x * polynomial(&ATAN, x * x)
}

/// Evaluates a polynomial, even and odd powers separately: two short dependency chains instead of a long one.
#[inline(always)]
fn polynomial<const N: usize>(coefficients: &[f32; N], x: f32) -> f32 {
    let x2 = x * x;
    let mut sums = [0.0; 2];
    for (i, c) in coefficients.iter().enumerate().rev() {
        sums[i % 2] = sums[i % 2] * x2 + c;
    }
    sums[0] + x * sums[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// The largest relative error over every float from `end` down to where a function is its first term.
    fn worst(end: f32, fast: impl Fn(f32) -> f32, exact: impl Fn(f64) -> f64) -> f64 {
        // Steps of 37 units in the last place cover all residues that matter, at a fraction of the cost.
        let floats = (1e-6_f32.to_bits()..=end.to_bits()).step_by(37);
        let error = |x: f32| (f64::from(fast(x)) / exact(f64::from(x)) - 1.0).abs();
        let worst = floats.map(f32::from_bits).map(error).fold(0.0, f64::max);
        worst.max(error(end))
    }

    #[test]
    fn sin_cos_and_atan_relative_errors_are_below_3e_7() {
        let eighth = std::f32::consts::FRAC_PI_4;
        let sin = worst(eighth, |x| sin_cos_eighth(x).0, f64::sin);
        let cos = worst(eighth, |x| sin_cos_eighth(x).1, f64::cos);
        let atan = worst(1.0, atan_unit, f64::atan);
        println!("relative errors: sin {sin:.1e}, cos {cos:.1e}, atan {atan:.1e}");
        assert!(sin < 3e-7 && cos < 3e-7 && atan < 3e-7);
        assert_eq!((sin_cos_eighth(0.0), atan_unit(0.0)), ((0.0, 1.0), 0.0));
    }
    #[test]
    fn sin_cos_turns_absolute_error_is_below_2e_7() {
        let mut worst = 0.0_f64;
        for i in 0..=1_u32 << 20 {
            let u = i as f32 / (1 << 20) as f32;
            let (sin, cos) = sin_cos_turns(u);
            let (exact_sin, exact_cos) = (TAU * f64::from(u)).sin_cos();
            worst = worst.max((f64::from(sin) - exact_sin).abs());
            worst = worst.max((f64::from(cos) - exact_cos).abs());
        }
        println!("within {worst:.1e}");
        assert!(worst < 2e-7, "{worst:e}");
    }

    #[test]
    fn sin_cos_turns_is_exact_at_quarter_turns() {
        let quarters = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 1.0)];
        for (i, expected) in quarters.into_iter().enumerate() {
            assert_eq!(sin_cos_turns(0.25 * i as f32), expected);
        }
    }
}
