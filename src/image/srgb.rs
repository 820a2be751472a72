//! The sRGB transfer functions.
//!
//! Measure: both sides relative to white: 0 is black, 1 is white.
//! Range: any number; above 1 the power law continues, below 0 the linear part.
//! Source: IEC 61966-2-1:1999. Tested below over all 256 codes.

use crate::math::functions::powf;

/// Decodes an sRGB value to a linear value.
pub fn to_linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        powf((encoded + 0.055) / 1.055, 2.4)
    }
}

/// Encodes a linear value as an sRGB value.
pub fn from_linear(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * powf(linear, 1.0 / 2.4) - 0.055
    }
}

/// The 8-bit code nearest to a linear value; values outside of [0, 1] are clamped, and a NaN is black.
pub fn to_code(linear: f64) -> u8 {
    // The conversion saturates.
    (255.0 * from_linear(linear)).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_codes_round_trip_also_through_single_precision() {
        for code in 0..=u8::MAX {
            let linear = to_linear(f64::from(code) / 255.0);
            assert_eq!(to_code(linear), code);
            assert_eq!(to_code(f64::from(linear as f32)), code);
        }
    }

    #[test]
    fn srgb_encoding_is_increasing_and_inverted_by_decoding() {
        let mut last = -1.0;
        for i in 0..=10_000 {
            let linear = f64::from(i) / 10_000.0;
            let encoded = from_linear(linear);
            assert!(encoded > last);
            // The two pieces of the standard differ by about 1e-8 where they join.
            assert!((to_linear(encoded) - linear).abs() < 1e-7);
            last = encoded;
        }
    }

    #[test]
    fn out_of_range_values_are_clamped_to_valid_codes() {
        assert_eq!(to_code(-1.0), 0);
        assert_eq!(to_code(1e30), 255);
        assert_eq!(to_code(f64::INFINITY), 255);
        assert_eq!(to_code(f64::NAN), 0);
    }
}
