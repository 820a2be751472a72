//! The sRGB transfer function, both ways.
//!
//! Measure: linear light and codes, both in [0, 1].
//! Range: outside of [0, 1] the same formulas go on; a negative value stays on the linear part.
//! Source: IEC 61966-2-1. Tested below.

/// The code of a linear value.
pub fn encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// The linear value of a code.
pub fn decode(code: f32) -> f32 {
    if code <= 0.040_45 {
        code / 12.92
    } else {
        ((code + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_comes_back() {
        for code in 0..=255_u16 {
            let there = decode(f32::from(code) / 255.0);
            assert_eq!((encode(there) * 255.0).round() as u16, code);
        }
        // The published middle grey.
        assert!((encode(0.214_041_14) - 0.5).abs() < 1e-5);
    }
}
