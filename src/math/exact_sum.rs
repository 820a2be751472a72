//! Sums that do not depend on the order of their terms: each is two doubles, of which the second holds the rounding
//! error of the first.
//!
//! Measure: that of the terms.
//! Range: finite terms. While every term is an `f32`, and the smallest of them that is not 0 and the largest sum of any of
//! them span less than a factor of 2^80, the sum is exact, so that it has the same bits for any order and any division
//! into parts. Beyond, an error of 2^-105 of the largest sum is possible, which changes the first double with a
//! probability of about 2^-50.
//! Source: Dekker 1971, "A Floating-Point Technique for Extending the Available Precision"; Knuth, "Seminumerical
//! Algorithms", section 4.2.2. Tested below, in `film/pixel.rs` and `film/splats.rs`.

use crate::planted::planted;

/// Sums in twice the precision of a double, side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExactSums<const N: usize> {
    high: [f64; N],
    low: [f64; N],
}

impl<const N: usize> Default for ExactSums<N> {
    fn default() -> Self {
        Self {
            high: [0.0; N],
            low: [0.0; N],
        }
    }
}

impl<const N: usize> ExactSums<N> {
    /// Adds a number to each sum.
    #[inline(always)]
    pub fn add(&mut self, terms: [f64; N]) {
        for (i, x) in terms.into_iter().enumerate() {
            self.add_to(i, x);
        }
    }

    /// Adds a number to one sum, and the rounding error (Dekker), in the form that does not depend on which number is
    /// larger (Knuth).
    #[inline(always)]
    pub fn add_to(&mut self, i: usize, x: f64) {
        let sum = self.high[i] + x;
        let of_x = sum - self.high[i];
        let lost = (self.high[i] - (sum - of_x)) + (x - of_x);
        let low = planted!("sums-lose-digits", 0.0, self.low[i] + lost);
        self.high[i] = sum + low;
        self.low[i] = low - (self.high[i] - sum);
    }

    /// Adds the terms of other sums.
    pub fn add_sums(&mut self, other: &Self) {
        for terms in other.parts() {
            self.add(terms);
        }
    }

    /// The sums, rounded to doubles.
    #[inline]
    pub fn values(&self) -> [f64; N] {
        self.high
    }

    /// The two doubles of each sum, which add up to it: another sum to which both are added has all of its terms.
    pub fn parts(&self) -> [[f64; N]; 2] {
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

    fn sum(terms: &[f64]) -> ExactSums<2> {
        let mut sums = ExactSums::default();
        terms.iter().for_each(|&x| sums.add([x, 3.0 * x]));
        sums
    }

    #[test]
    fn exact_sums_are_independent_of_order_and_grouping() {
        let mut terms = terms();
        let whole = sum(&terms);
        for parts in [2, 7, 64] {
            let mut merged = ExactSums::default();
            let parts = terms.chunks(terms.len().div_ceil(parts));
            parts.rev().for_each(|part| merged.add_sums(&sum(part)));
            assert_eq!(merged, whole);
        }
        terms.reverse();
        assert_eq!(sum(&terms), whole);
        let plain: f64 = terms.iter().sum();
        let backwards: f64 = terms.iter().rev().sum();
        assert_ne!(plain, backwards, "the terms are too easy");
    }
}
