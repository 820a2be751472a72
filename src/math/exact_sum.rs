//! Sums that do not depend on the order of their terms: two doubles, of which the second holds the rounding error of
//! the first.
//!
//! Measure: that of the terms.
//! Range: finite terms. While every term is an `f32`, and the smallest of them that is not 0 and the largest sum of any of
//! them span less than a factor of 2^80, the sum is exact, so that it has the same bits for any order and any division
//! into parts. Beyond, an error of 2^-105 of the largest sum is possible, which changes the first double with a
//! probability of about 2^-50.
//! Source: Dekker 1971, "A Floating-Point Technique for Extending the Available Precision"; Knuth, "Seminumerical
//! Algorithms", section 4.2.2. Tested below, in `film/pixel.rs` and `film/splats.rs`.

use crate::planted::planted;

/// A sum in twice the precision of a double.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ExactSum {
    high: f64,
    low: f64,
}

impl ExactSum {
    /// Adds a number and the rounding error of the sum (Dekker), in the form that does not depend on which number is
    /// larger (Knuth).
    #[inline(always)]
    pub fn add(&mut self, x: f64) {
        let sum = self.high + x;
        let of_x = sum - self.high;
        let lost = (self.high - (sum - of_x)) + (x - of_x);
        let low = planted!("sums-lose-digits", 0.0, self.low + lost);
        self.high = sum + low;
        self.low = low - (self.high - sum);
    }

    /// The sum, rounded to a double.
    #[inline]
    pub fn value(self) -> f64 {
        self.high
    }

    /// The two doubles, whose sum it is: another sum to which both are added has all of its terms.
    pub fn parts(self) -> [f64; 2] {
        [self.high, self.low]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Terms over 2^70, which a double rounds differently in every order.
    fn terms() -> Vec<f64> {
        let term = |i: u64| {
            let bits = i.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let exponent = (i % 47) as i32 - 23;
            f64::from((bits >> 40) as f32 * 2.0_f32.powi(exponent))
        };
        (0..1000).map(term).collect()
    }

    fn sum(terms: &[f64]) -> ExactSum {
        let mut sum = ExactSum::default();
        terms.iter().for_each(|&x| sum.add(x));
        sum
    }

    #[test]
    fn no_order_and_no_division_changes_a_bit() {
        let mut terms = terms();
        let whole = sum(&terms);
        for parts in [2, 7, 64] {
            let mut merged = ExactSum::default();
            let parts = terms.chunks(terms.len().div_ceil(parts));
            for part in parts.rev() {
                for double in sum(part).parts() {
                    merged.add(double);
                }
            }
            assert_eq!(merged, whole);
        }
        terms.reverse();
        assert_eq!(sum(&terms), whole);
        let plain: f64 = terms.iter().sum();
        let backwards: f64 = terms.iter().rev().sum();
        assert_ne!(plain, backwards, "the terms are too easy");
    }
}
